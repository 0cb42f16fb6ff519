"""Hits: what rays meet of all that there is, spheres and capsules, numbered one after the other."""

from collections.abc import Iterator

import numpy as np

from clrt.truth import capsules, spheres
from clrt.truth.rays import Array, Rays, unit
from clrt.truth.world import World


def _meetings(world: World, rays: Rays) -> Iterator[tuple[slice, Array, Array]]:
    """Where rays meet things, some of these at a time, in order: see spheres.meetings()."""
    world.rays += rays.pixel.size
    yield from spheres.meetings(world, rays)
    yield from capsules.meetings(world, rays)


def nearest(world: World, rays: Rays) -> tuple[Array, Array]:
    """What is hit first, -1 if none, and its distance, infinity if none (11.5): behind what each
    ray has passed, by distance and of equal distances by number."""
    hit = np.full(rays.pixel.size, -1)
    distance = np.full(rays.pixel.size, np.inf, world.dtype)
    for some, _, distances in _meetings(world, rays):
        behind, passed = rays.behind[:, np.newaxis], rays.passed[:, np.newaxis]
        later = passed < np.arange(some.start, some.stop)
        distances[(distances < behind) | ((distances == behind) & ~later)] = np.inf
        first = distances.argmin(axis=1)  # of equal ones the first
        nearest = np.take_along_axis(distances, first[:, np.newaxis], axis=1)[:, 0]
        closer = nearest < distance
        hit[closer] = some.start + first[closer]
        distance[closer] = nearest[closer]
    return hit, distance


def clear(world: World, rays: Rays, limit: Array) -> Array:
    """How much of a light that is `limit` away what a ray to it enters on its way leaves: 0 or 1 if
    all of that is opaque (11.7)."""
    left = np.ones(rays.pixel.size, world.dtype)
    for some, within, distances in _meetings(world, rays):
        enters = (distances < limit[:, np.newaxis]) & ~within
        part = world.transmission[world.material[some]] + 1 - world.opacity[some]
        left *= np.where(enters, part, world.dtype.type(1)).prod(axis=1)
    return left


def normal(world: World, hit: Array, point: Array) -> Array:
    """Outwards, of unit length, at points (3, n) of what is hit."""
    found = np.empty_like(point)
    n = len(world.radius)
    of_spheres = hit < n
    found[:, of_spheres] = unit(point[:, of_spheres] - world.center[:, hit[of_spheres]])
    rest = ~of_spheres
    found[:, rest] = capsules.normal(world, hit[rest] - n, point[:, rest])
    return found
