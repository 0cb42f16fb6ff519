"""The same spheres, light and mirrors in Mitsuba 3, one sample a pixel. Not the same shading: its
paths, whose mirrors are drawn at random, have no highlight of Blinn and Phong."""

from collections.abc import Callable
from typing import Any

import mitsuba
import numpy as np
from numpy.typing import NDArray

from benchmarks import harness
from clrt.scene.scene import Scene

VARIANT = "scalar_rgb"
"""Its tree is Embree's. Those compiled by LLVM ask for one newer than Debian 12 has."""


def rgb(color: tuple[float, ...]) -> dict[str, Any]:
    return {"type": "rgb", "value": list(color)}


def contender(scene: Scene, width: int, height: int) -> Callable[[], NDArray[np.float32]]:
    """What renders it, (height, width, 3), when the scene is loaded."""
    mitsuba.set_variant(VARIANT)
    camera = scene.camera
    eye, at, up = map(list, (camera.position, camera.look_at, camera.up))
    parts: dict[str, Any] = {
        "type": "scene",
        "integrator": {"type": "path", "max_depth": scene.max_depth + 1},  # it counts the light
        "sensor": {
            "type": "perspective",
            "fov": camera.fov,
            "fov_axis": "x",
            "to_world": mitsuba.ScalarTransform4f().look_at(origin=eye, target=at, up=up),
            "film": {
                "type": "hdrfilm",
                "width": width,
                "height": height,
                "rfilter": {"type": "box"},
            },
            "sampler": {"type": "independent", "sample_count": 1},
        },
    }
    for k, light in enumerate(harness.point_lights(scene)):
        parts[f"light{k}"] = {
            "type": "point",
            "position": list(light.position),
            "intensity": rgb((100.0, 100.0, 100.0)),
        }
    for k, sphere in enumerate(scene.spheres):
        m = scene.materials[sphere.material]
        matte = {"type": "diffuse", "reflectance": rgb(m.diffuse)}
        mirror = {"type": "conductor", "material": "none"}
        both = {"type": "blendbsdf", "weight": m.reflection, "0": matte, "1": mirror}
        parts[f"sphere{k}"] = {
            "type": "sphere",
            "center": list(sphere.center),
            "radius": sphere.radius,
            "bsdf": both if m.reflection > 0 else matte,
        }
    loaded = mitsuba.load_dict(parts)
    return lambda: np.array(mitsuba.render(loaded), np.float32)
