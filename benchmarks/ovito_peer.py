"""OVITO's renderers, where it is installed: the atoms of a file, as many.molecule() has them."""

import functools
import importlib.util
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

# Its arguments: words().
SCRIPT = """
import json, sys, time
import numpy as np
from ovito.data import DataCollection
from ovito.pipeline import Pipeline, StaticSource
from ovito.vis import OSPRayRenderer, TachyonRenderer, Viewport
data = np.load(sys.argv[1])
center, radius = data["center"], data["radius"]
collection = DataCollection()
particles = collection.create_particles(count=len(center))
particles.create_property("Position", data=center)
particles.create_property("Radius", data=radius)
particles.create_property("Color", data=np.full((len(center), 3), float(sys.argv[5])))
if "opacity" in data:
    particles.create_property("Transparency", data=1 - data["opacity"])
Pipeline(source=StaticSource(data=collection)).add_to_scene()
width, height, whole = map(int, sys.argv[6:])
fov = 2 * np.arctan(9 / 16 * height / whole)  # upright
viewport = Viewport(type=Viewport.Type.Perspective, fov=fov)
viewport.camera_pos, viewport.camera_dir = (0, 0, 1), (0, 0, -1)
kinds = {"Tachyon": TachyonRenderer, "OSPRay": OSPRayRenderer}
started = time.perf_counter()
viewport.render_image(
    size=(width, height), filename=sys.argv[2], background=(0, 0, 0),
    renderer=kinds[sys.argv[3]](**json.loads(sys.argv[4])),
)
print(time.perf_counter() - started)
"""

ONE_SAMPLE: dict[str, dict[str, Any]] = {
    "Tachyon": {"antialiasing": False, "ambient_occlusion": False},
    "OSPRay": {"samples_per_pixel": 1, "refinement_iterations": 1, "denoising_enabled": False},
}


def words(
    atoms: Path,
    picture: Path,
    renderer: str,
    options: dict[str, Any],
    size: tuple[int, int] = (1920, 1080),
    whole: int = 1080,
    albedo: float = 0.7,
) -> tuple[str, ...]:
    """A script and its arguments: the middle of a picture of `whole` rows.

    Args:
        atoms: .npz with `center` and `radius`, and `opacity` if some are seen through.
        renderer, options: a key of ONE_SAMPLE and keywords of OVITO's class of that name.
        size: of what is rendered, columns and rows.
        albedo: of all atoms, grey.
    """
    numbers = (albedo, *size, whole)
    return SCRIPT, str(atoms), str(picture), renderer, json.dumps(options), *map(str, numbers)


@functools.cache
def renderers() -> tuple[str, ...]:
    """Those of ONE_SAMPLE that draw one atom here. OSPRay wants Vulkan, for one."""
    if importlib.util.find_spec("ovito") is None:
        print("OVITO is not installed: pip install 'clrt[peers]'", file=sys.stderr)
        return ()
    found = []
    with tempfile.TemporaryDirectory() as folder:
        atoms, picture = Path(folder) / "one.npz", Path(folder) / "one.png"
        np.savez(atoms, center=[(0.0, 0.0, -1.0)], radius=[0.1])
        for name, options in ONE_SAMPLE.items():
            script = words(atoms, picture, name, options, (64, 36), 36)
            done = subprocess.run([sys.executable, "-c", *script], capture_output=True, text=True)
            if done.returncode == 0:
                found.append(name)
            else:
                print(f"OVITO's {name} does not work: {done.stderr[-300:]}", file=sys.stderr)
    return tuple(found)
