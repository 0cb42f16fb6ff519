"""Meshes: their triangles as the kernel tests them, in a tree of their own, and how they look."""

from collections.abc import Sequence

import numpy as np

from clrt.renderer.pack.structs import MAX_COLOR, Array, Real, face_look_dtype
from clrt.scene import lens
from clrt.scene.mesh import SHADINGS, Mesh, blocks, path_tokens

LARGE = 4
"""A face counts as no larger than this many times the middle one where a tree is ordered."""


def count(meshes: Sequence[Mesh]) -> int:
    """Of faces."""
    return sum(map(len, meshes))


def per_face(meshes: Sequence[Mesh], values: Sequence[int]) -> Array:
    """(faces,) int32 of one value a mesh."""
    return np.repeat(np.array(values, np.int32), [len(mesh) for mesh in meshes])


def sizes(meshes: Sequence[Mesh]) -> Array:
    """(meshes,): the longest side of the box around each."""
    return np.array([np.ptp(mesh.vertices, axis=0).max() for mesh in meshes], np.float64)


def reach(meshes: Sequence[Mesh], origin: Array) -> float:
    """How far the corners of many faces reach from the origin."""
    farthest = 0.0
    for mesh in meshes:
        for block in lens.blocks(len(mesh.vertices)):
            away = mesh.vertices[block] - origin
            farthest = max(farthest, float(np.einsum("ij,ij->i", away, away).max()))
    return float(np.sqrt(farthest))


def rows(meshes: Sequence[Mesh], origin: Array, scale: float, real: Real) -> Array:
    """(faces, 10) of real: three corners from the origin, scaled, and the largest of their
    coordinates, 0 of a closed mesh. Each vertex is rounded once, so faces that share an edge share
    the rounded one."""
    found = np.empty((count(meshes), 10), real)
    start = 0
    for mesh in meshes:
        some = found[start : start + len(mesh)]
        corners = ((mesh.vertices - origin) * scale).astype(real)
        for block in blocks(len(mesh)):
            some[block, :9] = corners.take(mesh.faces[block], axis=0).reshape(-1, 9)
            some[block, 9] = 0 if mesh.closed else abs(some[block, :9]).max(axis=1)
        start += len(mesh)
    return found


def tree_keys(meshes: Sequence[Mesh]) -> Array:
    """What a tree is ordered by, (faces, 4) float32: the middle and the longest side of the box
    around each, in units of the box around the middles, from about the middle one. A few large
    faces, of a ground, are as large as LARGE middle ones: else they would be parted by size."""
    some = np.concatenate(
        [mesh.vertices[:: -(-len(mesh.vertices) // 1000) or 1] for mesh in meshes]
    )
    half = float(np.ptp(some / 2, axis=0).max()) or 1.0
    origin = np.median(some, axis=0)
    found, start = np.empty((count(meshes), 4), np.float32), 0
    for mesh in meshes:
        keys = found[start : start + len(mesh)]
        # Halves, lest two be farther apart than any number.
        places = ((mesh.vertices / 2 - origin / 2) / half).astype(np.float32)
        sides = np.ascontiguousarray(places.T)
        for block in blocks(len(mesh)):
            corners, longest = mesh.faces[block].T.astype(np.intp), np.float32(0)
            for axis, side in enumerate(sides):
                a, b, c = side.take(corners)
                low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
                keys[block, axis] = (low + high) / 2
                longest = np.maximum(longest, high - low)
            keys[block, 3] = longest
        start += len(mesh)
    np.minimum(found[:, 3], LARGE * np.median(found[:: len(found) // 1000 + 1, 3]), out=found[:, 3])
    return found


def looks(meshes: Sequence[Mesh], first: int, real: Real) -> Array:
    """(faces,) of face_look_dtype. first: how many things come before them."""
    found, start = np.empty(count(meshes), face_look_dtype(real)), 0
    for mesh in meshes:
        some = found[start : start + len(mesh)]
        some["normal"] = mesh.face_normals
        some["shading"] = SHADINGS.index(mesh.shading)
        some["closed"] = mesh.closed
        start += len(mesh)
    found["token"] = path_tokens(meshes, first).view(np.int32)
    return found


def corners(meshes: Sequence[Mesh]) -> Array:
    """(faces, 3) int32: the vertices of faces, those of all meshes one after the other."""
    found, start, first = np.empty((count(meshes), 3), np.int32), 0, 0
    for mesh in meshes:
        np.add(mesh.faces, first, out=found[start : start + len(mesh)])
        start, first = start + len(mesh), first + len(mesh.vertices)
    return found


def normals(meshes: Sequence[Mesh], real: Real) -> Array:
    """(vertices, 3): of unit length, 0 where the face's is to be taken, as for flat meshes."""
    return np.concatenate(
        [
            np.zeros(mesh.vertices.shape, real)
            if mesh.shading == "flat"
            else mesh.vertex_normals.astype(real)
            for mesh in meshes
        ]
    )


def vertex_colors(meshes: Sequence[Mesh], real: Real) -> Array | None:
    """(vertices, 3), white where a mesh has none of its own; None: all have none."""
    if not any(mesh.has_vertex_colors for mesh in meshes):
        return None
    return np.concatenate(
        [
            np.clip(mesh.colors, -MAX_COLOR, MAX_COLOR).astype(real)
            if mesh.colors is not None and mesh.has_vertex_colors
            else np.ones(mesh.vertices.shape, real)
            for mesh in meshes
        ]
    )


def arguments(meshes: Sequence[Mesh], first: int, real: Real) -> dict[str, Array]:
    """Of the kernel: what does not depend on the camera and is needed. first: see looks()."""
    if not meshes:
        return {}
    found = {"looks": looks(meshes, first, real)}
    smooth = any(mesh.shading != "flat" for mesh in meshes)
    colors = vertex_colors(meshes, real)
    if smooth:
        found["vertex_normals"] = normals(meshes, real)
    if colors is not None:
        found["vertex_colors"] = colors
    if smooth or colors is not None:
        found["corners"] = corners(meshes)
    return found
