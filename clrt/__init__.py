"""clrt: scenes of spheres, ray traced on a multicore CPU through OpenCL.

>>> import clrt
>>> image = clrt.render(clrt.load_scene("four-spheres"), width=1920, height=1080)
"""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from clrt import reference
from clrt.errors import ClrtError, DeviceError, OutputError, RequestError, SceneError
from clrt.renderer import Renderer
from clrt.scene import Camera, Light, Material, Scene, Sphere
from clrt.scenefile import builtin_scenes, load_scene

__all__ = [
    "Camera",
    "ClrtError",
    "DeviceError",
    "Light",
    "Material",
    "OutputError",
    "Renderer",
    "RequestError",
    "Scene",
    "SceneError",
    "Sphere",
    "builtin_scenes",
    "load_scene",
    "reference",
    "render",
]


def render(scene: Scene, width: int, height: int, **options: Any) -> NDArray[np.float32]:
    """Renders one picture: float32 (height, width, 3), linear, not clipped.

    options: as for Renderer. For more than one picture keep a Renderer, which compiles once.
    """
    with Renderer(**options) as renderer:
        return renderer.render(scene, width, height)
