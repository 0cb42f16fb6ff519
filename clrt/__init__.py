"""clrt: scenes of spheres, capsules and meshes, ray traced on a multicore CPU through OpenCL.

>>> import clrt
>>> image = clrt.render(clrt.load_scene("four-spheres"), width=1920, height=1080)
"""

import importlib
from typing import TYPE_CHECKING, Any

__version__: str

if TYPE_CHECKING:
    from clrt import figure as figure
    from clrt import reference
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
    from clrt.figure.plot import Picture, plot
    from clrt.figure.rendering import Renderer, render
    from clrt.files.image import save
    from clrt.files.meshes.reader import read_mesh
    from clrt.files.particles.reader import read, read_frames
    from clrt.files.scenefile import builtin_scenes, load_scene
    from clrt.files.scenewriter import save_scene
    from clrt.film import color as color
    from clrt.film import decor as decor
    from clrt.film import metrics as metrics
    from clrt.motion.animation import animate
    from clrt.motion.cluster import render_frame
    from clrt.particles import elements as elements
    from clrt.particles import palette as palette
    from clrt.particles.particlefile import ParticleFile
    from clrt.particles.particles import Particles
    from clrt.scene.animation import Animation, Key
    from clrt.scene.camera import Camera
    from clrt.scene.capsules import Capsule, Capsules
    from clrt.scene.film import Cell, Film, Label, LegendEntry
    from clrt.scene.light import AmbientLight, DirectionalLight, Light, PointLight, SpotLight
    from clrt.scene.material import Material
    from clrt.scene.mesh import Mesh
    from clrt.scene.scene import Scene
    from clrt.scene.spheres import Sphere, Spheres
    from clrt.viewer.notebook import show

# Where each public name comes from. It is imported when it is first used, for the command line
# needs little of it, and to import all takes as long as to render a 4K picture.
_HOMES = {
    "clrt.motion.animation": ("animate",),
    "clrt.motion.cluster": ("render_frame",),
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
    "clrt.files.meshes.reader": ("read_mesh",),
    "clrt.files.particles.reader": ("read", "read_frames"),
    "clrt.particles.particlefile": ("ParticleFile",),
    "clrt.particles.particles": ("Particles",),
    "clrt.figure.plot": ("Picture", "plot"),
    "clrt.figure.rendering": ("Renderer", "render"),
    "clrt.scene.light": ("AmbientLight", "DirectionalLight", "Light", "PointLight", "SpotLight"),
    "clrt.scene.animation": ("Animation", "Key"),
    "clrt.scene.camera": ("Camera",),
    "clrt.scene.capsules": ("Capsule", "Capsules"),
    "clrt.scene.film": ("Cell", "Film", "Label", "LegendEntry"),
    "clrt.scene.material": ("Material",),
    "clrt.scene.mesh": ("Mesh",),
    "clrt.scene.scene": ("Scene",),
    "clrt.scene.spheres": ("Sphere", "Spheres"),
    "clrt.viewer.notebook": ("show",),
    "clrt.files.scenefile": ("builtin_scenes", "load_scene"),
    "clrt.files.scenewriter": ("save_scene",),
}

# Modules that the documentation calls by these names.
_MODULES = {
    "color": "clrt.film.color",
    "decor": "clrt.film.decor",
    "elements": "clrt.particles.elements",
    "figure": "clrt.figure",
    "metrics": "clrt.film.metrics",
    "palette": "clrt.particles.palette",
    "reference": "clrt.reference",
}

__all__ = [
    "AmbientLight",
    "Animation",
    "Camera",
    "Capsule",
    "Capsules",
    "Cell",
    "ClrtError",
    "DeviceError",
    "DeviceWarning",
    "DirectionalLight",
    "Film",
    "Key",
    "Label",
    "LegendEntry",
    "Light",
    "Material",
    "Mesh",
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
    "read_mesh",
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
    if name in _MODULES:
        found = importlib.import_module(_MODULES[name])
        globals()[name] = found
        return found
    for home, names in _HOMES.items():
        if name in names:
            found = getattr(importlib.import_module(home), name)
            globals()[name] = found
            return found
    raise AttributeError(f"module 'clrt' has no attribute {name!r}")
