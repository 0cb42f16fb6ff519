"""Hits: what rays meet of all that there is: spheres, capsules and faces, numbered one after the
other."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from clrt.truth import capsules, faces, spheres
from clrt.truth.rays import Array, Rays, unit
from clrt.truth.world import World


def _meetings(world: World, rays: Rays) -> Iterator[tuple[slice, Array, Array]]:
    """Where rays meet things, some of these at a time, in order: see spheres.meetings()."""
    world.rays += rays.pixel.size
    yield from spheres.meetings(world, rays)
    yield from capsules.meetings(world, rays)
    yield from faces.meetings(world, rays)


def nearest(world: World, rays: Rays) -> tuple[Array, Array]:
    """What is hit first, -1 if none, and its distance, infinity if none (11.5): behind what each
    ray has passed, by distance and of equal distances by number."""
    hit = np.full(rays.pixel.size, -1)
    distance = np.full(rays.pixel.size, np.inf, world.dtype)
    alike = faces.ALIKE * np.finfo(world.dtype).eps
    for some, _, distances in _meetings(world, rays):
        behind, passed = rays.behind[:, np.newaxis], rays.passed[:, np.newaxis]
        later = passed < np.arange(some.start, some.stop)
        distances[(distances < behind) | ((distances == behind) & ~later)] = np.inf
        # Of equal ones the first. Rounding parts the distances of faces at one place.
        of_faces = some.start >= world.first_face
        least = distances.min(axis=1)
        first = (distances <= _around(least, alike * of_faces)[:, np.newaxis]).argmax(axis=1)
        nearest = np.take_along_axis(distances, first[:, np.newaxis], axis=1)[:, 0]
        both = of_faces & (hit >= world.first_face)
        closer = nearest < _around(distance, np.where(both, -alike, 0))
        hit[closer] = some.start + first[closer]
        distance[closer] = nearest[closer]
    return hit, distance


def _around(distance: Array, part: Array | float) -> Array:
    """Distances and a part of them, which are infinite as they were."""
    found: Array = distance + part * abs(np.where(np.isfinite(distance), distance, 0))
    return found


def clear(world: World, rays: Rays, limit: Array) -> Array:
    """How much of a light that is `limit` away what a ray to it enters on its way leaves: 0 or 1 if
    all of that is opaque (11.7)."""
    left = np.ones(rays.pixel.size, world.dtype)
    for some, within, distances in _meetings(world, rays):
        enters = (distances < limit[:, np.newaxis]) & ~within
        part = world.transmission[world.material[some]] + 1 - world.opacity[some]
        left *= np.where(enters, part, world.dtype.type(1)).prod(axis=1)
    return left


@dataclass
class Met:
    """What rays have met, a column a ray."""

    hit: Array
    """Which of all things, (n,)."""
    normal: Array
    """(3, n): outwards, of unit length; of faces with two sides to where the ray comes from."""
    shaded: Array
    """(3, n): the normal that light is worked out with."""
    color: Array | None
    """(3, n): multiplies the material's; None: white."""
    lift: Array
    """(n,): how far off it rays start."""
    token: NDArray[np.uint32]
    """(n,): what the path's hash has of it."""
    of_faces: NDArray[np.bool_]
    """(n,): what follows is of these, one after the other."""
    face: Array
    side: Array
    """1, or -1 where the back is seen."""
    at: Array
    """(3, n): how near to each corner."""


def met(world: World, rays: Rays, hit: Array, point: Array) -> Met:
    """What is known of things at points (3, n), which rays have hit."""
    of_spheres, of_faces = hit < len(world.radius), hit >= world.first_face
    normal = np.empty_like(point)
    normal[:, of_spheres] = unit(point[:, of_spheres] - world.center[:, hit[of_spheres]])
    rest = ~of_spheres & ~of_faces
    capsule = hit[rest] - len(world.radius)
    normal[:, rest] = capsules.normal(world, capsule, point[:, rest])
    face = hit[of_faces] - world.first_face
    some = rays.only(of_faces)
    at = faces.weights_at(world, some, face)
    normal[:, of_faces], side = faces.normal(world, some, face)
    shaded = normal.copy()
    shaded[:, of_faces] = faces.shading_normal(world, face, normal[:, of_faces], side, at)
    token = (hit + 1).astype(np.uint32)
    token[of_faces] = world.token[face]
    lift = np.zeros(hit.size, world.dtype)
    lift[of_faces] = faces.lift(world, some, face, point[:, of_faces])
    color = None
    if world.color is not None or world.corner_color is not None:
        color = np.ones_like(point)
        if world.color is not None:
            color[:, ~of_faces] = world.color[:, hit[~of_faces]]
        if world.corner_color is not None:
            color[:, of_faces] = faces.color(world.corner_color, face, at)
    return Met(hit, normal, shaded, color, lift, token, of_faces, face, side, at)
