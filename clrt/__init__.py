"""clrt: scenes of spheres, ray traced on a multicore CPU through OpenCL.

>>> import clrt
>>> image = clrt.render(clrt.load_scene("four-spheres"), width=1920, height=1080)
"""

import importlib
from typing import TYPE_CHECKING, Any

__version__: str

if TYPE_CHECKING:
    from clrt import reference
    from clrt.animation import animate
    from clrt.cluster import render_frame
    from clrt.errors import (
        ClrtError,
        DeviceError,
        DeviceWarning,
        OutputError,
        ParticleWarning,
        RequestError,
        SceneError,
        SceneWarning,
    )
    from clrt.files.image import save
    from clrt.files.particles.reader import read, read_frames
    from clrt.files.scenefile import builtin_scenes, load_scene
    from clrt.files.scenewriter import save_scene
    from clrt.light import AmbientLight, DirectionalLight, Light, PointLight, SpotLight
    from clrt.particlefile import ParticleFile
    from clrt.particles import Particles
    from clrt.picture import Picture, plot
    from clrt.renderer import Renderer, render
    from clrt.scene import Animation, Camera, Cell, Film, Key, LegendEntry, Material, Scene
    from clrt.spheres import Sphere, Spheres
    from clrt.viewer.notebook import show

# Where each public name comes from. It is imported when it is first used, for the command line
# needs little of it, and to import all takes as long as to render a 4K picture.
_HOMES = {
    "clrt.animation": ("animate",),
    "clrt.cluster": ("render_frame",),
    "clrt.errors": (
        "ClrtError",
        "DeviceError",
        "DeviceWarning",
        "OutputError",
        "ParticleWarning",
        "RequestError",
        "SceneError",
        "SceneWarning",
    ),
    "clrt.files.image": ("save",),
    "clrt.files.particles.reader": ("read", "read_frames"),
    "clrt.particlefile": ("ParticleFile",),
    "clrt.particles": ("Particles",),
    "clrt.picture": ("Picture", "plot"),
    "clrt.reference": ("reference",),
    "clrt.renderer": ("Renderer", "render"),
    "clrt.light": ("AmbientLight", "DirectionalLight", "Light", "PointLight", "SpotLight"),
    "clrt.scene": (
        "Animation",
        "Camera",
        "Cell",
        "Film",
        "Key",
        "LegendEntry",
        "Material",
        "Scene",
    ),
    "clrt.spheres": ("Sphere", "Spheres"),
    "clrt.viewer.notebook": ("show",),
    "clrt.files.scenefile": ("builtin_scenes", "load_scene"),
    "clrt.files.scenewriter": ("save_scene",),
}

__all__ = [
    "AmbientLight",
    "Animation",
    "Camera",
    "Cell",
    "ClrtError",
    "DeviceError",
    "DeviceWarning",
    "DirectionalLight",
    "Film",
    "Key",
    "LegendEntry",
    "Light",
    "Material",
    "OutputError",
    "ParticleFile",
    "ParticleWarning",
    "Particles",
    "Picture",
    "PointLight",
    "Renderer",
    "RequestError",
    "Scene",
    "SceneError",
    "SceneWarning",
    "Sphere",
    "Spheres",
    "SpotLight",
    "animate",
    "builtin_scenes",
    "load_scene",
    "plot",
    "read",
    "read_frames",
    "reference",
    "render",
    "render_frame",
    "save",
    "save_scene",
    "show",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return importlib.import_module("importlib.metadata").version("clrt")
    for home, names in _HOMES.items():
        if name in names:
            module = importlib.import_module(home)
            found = module if home == f"clrt.{name}" else getattr(module, name)
            globals()[name] = found
            return found
    raise AttributeError(f"module 'clrt' has no attribute {name!r}")
