"""The same spheres, light and depth in POV-Ray. Not the same shading: its own Blinn highlight."""

import re
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from benchmarks import harness
from clrt.files import image
from clrt.scene.scene import Scene


def scene_text(scene: Scene) -> str:
    """The scene in POV-Ray's language, which is left-handed: z is turned round."""

    def vector(v: tuple[float, float, float], z: int = 1) -> str:
        return f"<{v[0]}, {v[1]}, {z * v[2]}>"

    camera = scene.camera
    parts = [
        "#version 3.7;\n"
        f"global_settings {{ assumed_gamma 1 max_trace_level {scene.max_depth} }}\n"
        f"camera {{ location {vector(camera.position, -1)} right x*image_width/image_height "
        f"angle {camera.fov} look_at {vector(camera.look_at, -1)} }}\n"
    ]
    parts += [
        f"light_source {{ {vector(light.position, -1)} rgb {vector(light.diffuse)} }}\n"
        for light in harness.point_lights(scene)
    ]
    for sphere in scene.spheres:
        m = scene.materials[sphere.material]
        parts.append(
            f"sphere {{ {vector(sphere.center, -1)}, {sphere.radius}\n"
            f"  pigment {{ rgb {vector(m.diffuse)} }}\n"
            f"  finish {{ ambient rgb {vector(m.ambient)} diffuse 1 specular 1 "
            f"roughness {4 / m.shininess} reflection {m.reflection} }} }}\n"
        )
    return "".join(parts)


def render(scene: Scene, width: int, height: int) -> tuple[NDArray[np.float32], float]:
    """The picture, and the seconds that POV-Ray says it traced for, on all cores."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.pov"
        path.write_text(scene_text(scene))
        words = ["povray", str(path), f"+W{width}", f"+H{height}", "-A", "-D", "File_Gamma=1.0",
                 f"+O{folder}/scene.png"]  # fmt: skip
        done = subprocess.run(words, capture_output=True, text=True, check=True)
        found = re.search(r"Trace Time:.*\(([\d.]+) seconds\)", done.stderr)
        if found is None:
            raise ValueError(f"POV-Ray printed no trace time:\n{done.stderr[-500:]}")
        return image.load(Path(folder) / "scene.png"), float(found[1])
