"""World: a scene as arrays of one dtype."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from clrt.scene.capsules import Capsules
from clrt.scene.scene import Scene
from clrt.scene.spheres import Spheres

Array: TypeAlias = NDArray[Any]


class World:
    """Everything that rays ask of a scene, and how many rays were cast."""

    def __init__(self, scene: Scene, exact: bool, dtype: np.dtype[Any]) -> None:
        self.dtype = dtype
        self.exact = exact
        self.bias = dtype.type(0 if self.exact else scene.shadow_bias)
        self.max_depth = scene.max_depth
        self.rays = 0
        self.camera = self.column(scene.camera.position)
        self.right, self.up, self.back = map(self.column, scene.camera.basis())
        self.orthographic = scene.camera.orthographic
        self.look_at = self.column(scene.camera.look_at)
        self.lights = scene.lights
        spheres = Spheres.of(scene.spheres)
        self.center = spheres.center.astype(dtype).T  # (3, spheres)
        self.radius = spheres.radius.astype(dtype)
        capsules = Capsules.of(scene.capsules)
        self.start = capsules.start.astype(dtype).T  # (3, capsules), as the following
        self.end = capsules.end.astype(dtype).T
        self.thickness = capsules.radius.astype(dtype)
        # What is hit, a sphere or after all of these a capsule, selects a material, and that a
        # column of (3, materials) or (materials,).
        places = {name: i for i, name in enumerate(scene.materials)}
        self.material = np.concatenate(
            [
                np.array([places[name] for name in many.names or ()], np.int64)[many.material_index]
                for many in (spheres, capsules)
            ]
        )
        materials = scene.materials.values()
        self.ambient = np.array([m.ambient for m in materials], dtype).reshape(-1, 3).T
        self.diffuse = np.array([m.diffuse for m in materials], dtype).reshape(-1, 3).T
        self.specular = np.array([m.specular for m in materials], dtype).reshape(-1, 3).T
        self.shininess = np.array([m.shininess for m in materials], dtype)
        self.phong = np.array([m.highlight == "phong" for m in materials], bool)
        self.reflection = np.array([m.reflection for m in materials], dtype)
        # Glass. The medium of a point is the smallest transparent sphere around it.
        self.transmission = np.array([m.transmission for m in materials], dtype)
        self.ior = np.array([m.ior for m in materials], dtype)
        self.fresnel = np.array([m.fresnel for m in materials], bool)
        # What goes straight on. Of what is not there nothing is met.
        self.opacity = np.array([m.opacity for m in materials], dtype)[self.material]
        if spheres.opacity is not None:
            self.opacity[: len(spheres)] *= spheres.opacity.astype(dtype)
        self.panes = np.flatnonzero(self.transmission[self.material] > 0)
        self.size = np.argsort(np.argsort(self.radius[self.panes], kind="stable"))
        self.background = self.column(scene.film.background)
        self.color = None
        if spheres.color is not None or capsules.color is not None:
            colors = [
                np.ones((len(many), 3)) if many.color is None else many.color
                for many in (spheres, capsules)
            ]
            self.color = np.concatenate(colors).astype(dtype).T

    def column(self, v: tuple[float, float, float]) -> Array:
        return np.array(v, self.dtype)[:, np.newaxis]
