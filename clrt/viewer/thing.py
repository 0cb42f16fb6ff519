"""Thing: what has an index in a scene: a sphere, a capsule or a face of a mesh."""

from typing import Any, Literal, NamedTuple

import numpy as np

from clrt.scene.camera import Camera
from clrt.scene.scene import Scene
from clrt.values import Array, Vec3
from clrt.viewer import orbit

Ring = tuple[float, float, float]
"""Where a ball is in the picture: column, row and radius, in pixels."""


class Thing(NamedTuple):
    """The hull of balls of one radius around its corners."""

    kind: Literal["sphere", "capsule", "face"]
    number: int
    """Among those of its kind; a face's is that in its mesh."""
    corners: Array
    """(1, 3), of a capsule (2, 3), of a face (3, 3), world units."""
    radius: float
    about: dict[str, Any]
    """What is told of it."""

    @property
    def middle(self) -> Vec3:
        x, y, z = self.corners.mean(axis=0).tolist()
        return x, y, z

    def rings(self, camera: Camera, size: orbit.Size) -> list[Ring] | None:
        """Of its balls; None: one is behind the camera."""
        found = [
            orbit.circle(camera, (x, y, z), self.radius, size)
            for x, y, z in self.corners.astype(float).tolist()
        ]
        rings = [ring for ring in found if ring is not None]
        return rings if len(rings) == len(found) else None


def thing(scene: Scene, index: int) -> Thing | None:
    """The thing of an index, as the pass "id" has it; None: there is none."""
    if index < 0:
        return None
    told: dict[str, Any] = {"index": index}
    if index < len(scene.spheres):
        sphere = scene.spheres[index]
        told |= {"position": sphere.center, "radius": sphere.radius, "material": sphere.material}
        return Thing("sphere", index, np.array([sphere.center]), sphere.radius, told)
    index -= len(scene.spheres)
    if index < len(scene.capsules):
        capsule = scene.capsules[index]
        told |= {"start": capsule.start, "end": capsule.end, "radius": capsule.radius}
        corners = np.array([capsule.start, capsule.end])
        told |= {"material": capsule.material}
        return Thing("capsule", index, corners, capsule.radius, told)
    index -= len(scene.capsules)
    for number, mesh in enumerate(scene.meshes):
        if index < len(mesh):
            corners = mesh.vertices[mesh.faces[index]]
            told |= {"mesh": number, "face": index} if len(scene.meshes) > 1 else {"face": index}
            told |= {"position": tuple(corners.mean(axis=0).tolist()), "material": mesh.material}
            return Thing("face", index, corners, 0.0, told)
        index -= len(mesh)
    return None
