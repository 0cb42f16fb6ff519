"""World: a scene as arrays of one dtype."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from clrt.scene.capsules import Capsules
from clrt.scene.mesh import SHADINGS, Mesh, path_tokens
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
        self._take_faces(scene, len(spheres) + len(capsules))
        # What is hit, a sphere, after all of these a capsule or a face, selects a material, and
        # that a column of (3, materials) or (materials,).
        places = {name: i for i, name in enumerate(scene.materials)}
        of_rows = [
            np.array([places[name] for name in many.names or ()], np.int64)[many.material_index]
            for many in (spheres, capsules)
        ]
        of_faces = [np.full(len(mesh), places[mesh.material]) for mesh in scene.meshes]
        self.material = np.concatenate([*of_rows, *of_faces])
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

    def _take_faces(self, scene: Scene, first: int) -> None:
        """Triangles, mesh by mesh, after so many other things."""
        meshes, dtype = scene.meshes, self.dtype
        self.first_face = first
        self.corners = _of_corners([mesh.corners for mesh in meshes], dtype)
        """(3 axes, 3 corners, faces)"""
        low, high = self.corners.min(axis=1), self.corners.max(axis=1)
        self.middle = (low + high) / 2
        self.ball = ((self.corners - self.middle[:, np.newaxis]) ** 2).sum(axis=0).max(axis=0)
        """(faces,): the square of the radius of a ball about the middle that holds each."""
        lengths = list(map(len, meshes))
        self.closed = np.repeat(np.array([mesh.closed for mesh in meshes], bool), lengths)
        shadings = np.array([SHADINGS.index(mesh.shading) for mesh in meshes], np.int64)
        self.shading = np.repeat(shadings, lengths)
        self.token = path_tokens(meshes, first)
        self.face_normal = np.concatenate(
            [np.zeros((0, 3)), *(mesh.face_normals for mesh in meshes)]
        ).T.astype(dtype)
        self.corner_normal = _of_corners([mesh.corner_normals for mesh in meshes], dtype)
        self.corner_color = None
        if any(mesh.colors is not None for mesh in meshes):
            self.corner_color = _of_corners(list(map(_colors, meshes)), dtype)

    def column(self, v: tuple[float, float, float]) -> Array:
        return np.array(v, self.dtype)[:, np.newaxis]


def _of_corners(parts: list[Array], dtype: np.dtype[Any]) -> Array:
    """Of (faces, corners, 3) one after the other, (3, corners, faces)."""
    whole = np.concatenate([np.zeros((0, 3, 3)), *parts])
    return np.ascontiguousarray(whole.astype(dtype).T)


def _colors(mesh: Mesh) -> Array:
    found = mesh.corner_colors
    return np.ones((len(mesh), 3, 3)) if found is None else found
