"""Faces: where rays meet triangles, and how those are shaded.

A ray passes an edge on the side that the sign of a triple product tells. Where float64 cannot tell
it, for the product is less than its error, it is worked out in fractions. So of two faces with a
common edge each ray that comes near meets one, or both if it meets the edge.
"""

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

from clrt.scene.light import Shining
from clrt.scene.mesh import SHADINGS
from clrt.truth import camera, lights
from clrt.truth.rays import Array, Rays, dot, unit
from clrt.truth.spheres import BLOCK_PAIRS
from clrt.truth.world import World

ALIKE = 16
"""Distances that differ by less than so many units in the last place are those of one point."""
LIFT = 8
"""So many roundings of the largest coordinate rays start off a face that has two sides."""


def meetings(world: World, rays: Rays) -> Iterator[tuple[slice, Array, Array]]:
    """Where rays meet faces: as spheres.meetings(). Those of closed meshes they meet from the front
    only."""
    first = world.first_face
    block = max(1, BLOCK_PAIRS // max(rays.pixel.size, 1))
    for start in range(0, world.corners.shape[2], block):
        some = slice(start, min(start + block, world.corners.shape[2]))
        ids = np.arange(first + some.start, first + some.stop)
        near = _near_balls(world, rays, some)
        near &= (rays.leaves[:, np.newaxis] != ids) & (world.opacity[ids] > 0)
        ray, face = np.nonzero(near)
        # A rounding of where a ray starts is the same for all corners.
        corners = world.corners[:, :, start + face] - rays.origin[:, np.newaxis, ray]
        weights = _weights(rays.direction[:, ray], corners)
        front = (weights >= 0).all(axis=0)
        back = (weights <= 0).all(axis=0) & ~world.closed[start + face]
        whole = weights.sum(axis=0)
        met = (front | back) & (whole != 0)
        ray, face, corners = ray[met], face[met], corners[:, :, met]
        # A mean of the corners' distances: between them whatever the rounding.
        away = dot(corners, rays.direction[:, np.newaxis, ray])
        along = ((weights[:, met] / whole[met]) * away).sum(axis=0)
        if not (world.orthographic and rays.bounce == 0):
            along[along <= 0] = np.inf
        distance = np.full(near.shape, np.inf, world.dtype)
        distance[ray, face] = along
        yield slice(first + some.start, first + some.stop), np.zeros(near.shape, bool), distance


def _near_balls(world: World, rays: Rays, some: slice) -> NDArray[np.bool_]:
    """(rays, faces): whether a ray's line passes the ball around a face, or nearly so."""
    away = world.middle[:, np.newaxis, some] - rays.origin[:, :, np.newaxis]
    along = dot(away, rays.direction[:, :, np.newaxis])
    square = dot(away, away)
    slack = 64 * np.finfo(world.dtype).eps
    found: NDArray[np.bool_] = square * (1 - slack) - along**2 <= world.ball[some] * (1 + slack)
    return found


def _weights(direction: Array, corners: Array) -> Array:
    """(3, n): for each corner twice the area of the triangle of the other two and the ray's point,
    as seen along the ray: all at least 0 where it meets the front, at most 0 where the back. With
    the sign of the exact value for these corners, (3 axes, 3 corners, n), from the rays' starts."""
    found = np.empty((3, corners.shape[2]), corners.dtype)
    for k in range(3):
        b, c = corners[:, (k + 1) % 3], corners[:, (k + 2) % 3]
        up, down = np.empty_like(b), np.empty_like(b)
        for axis in range(3):
            i, j = (axis + 1) % 3, (axis + 2) % 3
            up[axis], down[axis] = c[i] * b[j], c[j] * b[i]
        found[k] = dot(direction, up - down)
        # Two products, their difference, a product and two sums: six roundings.
        error = 4 * np.finfo(b.dtype).eps * dot(abs(direction), abs(up) + abs(down))
        for n in np.flatnonzero((abs(found[k]) <= error) & (error > 0)):
            found[k, n] = _exactly(direction[:, n], c[:, n], b[:, n])
    return found


def _exactly(direction: Array, c: Array, b: Array) -> float:
    """direction . c x b, rounded once."""
    d, p, q = ([Fraction(*x.as_integer_ratio()) for x in v] for v in (direction, c, b))
    return float(sum(d[k - 2] * (p[k - 1] * q[k] - p[k] * q[k - 1]) for k in range(3)))


def weights_at(world: World, rays: Rays, face: Array) -> Array:
    """(3, n): how near to each corner of its face each ray meets it; their sum is 1."""
    corners = world.corners[:, :, face] - rays.origin[:, np.newaxis]
    found = _weights(rays.direction, corners)
    whole: Array = found / found.sum(axis=0)
    return whole


def normal(world: World, rays: Rays, face: Array) -> tuple[Array, Array]:
    """(3, n): of unit length; of a mesh that is not closed towards where the ray comes from; and
    1, or -1 where the back is seen."""
    found = world.face_normal[:, face]
    side = np.where(~world.closed[face] & (dot(found, rays.direction) > 0), -1, 1)
    return side * found, side


def shading_normal(world: World, face: Array, geometric: Array, side: Array, at: Array) -> Array:
    """What faces are shaded with, but for Gouraud: their normals, or between their corners'."""
    found = geometric.copy()
    smooth = world.shading[face] == SHADINGS.index("phong")
    normals = side[smooth] * world.corner_normal[:, :, face[smooth]]
    between = unit((at[:, smooth] * normals).sum(axis=1))
    found[:, smooth] = np.where((between != 0).any(axis=0), between, geometric[:, smooth])
    return found


def color(corner_color: Array, face: Array, at: Array) -> Array:
    """(3, n): between the colours of faces' corners."""
    found: Array = (at * corner_color[:, :, face]).sum(axis=1)
    return found


def gouraud(world: World, light: Shining, face: Array, side: Array, at: Array) -> Array:
    """(3, n): diffuse and specular light of a lamp at the corners of faces, interpolated. A corner
    that looks away from the light has none."""
    total = np.zeros((3, face.size), world.dtype)
    material = world.material[world.first_face + face]
    shininess = world.shininess[material]
    for k in range(3):
        corner = world.corners[:, k, face]
        normal = side * world.corner_normal[:, k, face]
        to_light, _ = lights.toward(world, light, corner)
        to_camera = camera.to_camera(world, corner)
        cosine = dot(normal, to_light)
        mirrored = 2 * cosine * normal - to_light
        highlight = np.where(
            world.phong[material],
            np.maximum(dot(mirrored, to_camera), 0) ** shininess,
            np.maximum(dot(normal, unit(to_light + to_camera)), 0) ** (shininess / 4),
        )
        diffuse = world.diffuse[:, material] * world.column(light.diffuse) * cosine
        if world.corner_color is not None:
            diffuse *= world.corner_color[:, k, face]
        specular = world.specular[:, material] * world.column(light.specular) * highlight
        total += at[k] * np.where(cosine >= 0, diffuse + specular, 0)
    return total


def lift(world: World, rays: Rays, face: Array, point: Array) -> Array:
    """How far off faces rays start, against what their points are off by."""
    reach = np.maximum(abs(point).max(axis=0), abs(point - world.camera).max(axis=0))
    size = LIFT * np.finfo(world.dtype).eps / 2 * np.maximum(reach, abs(rays.origin).max(axis=0))
    found: Array = np.where(world.closed[face], 0, size)
    return found
