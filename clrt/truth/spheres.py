"""Spheres: where rays meet them (11.4, 11.5, 11.7)."""

from collections.abc import Iterator

import numpy as np

from clrt.truth.rays import Array, Rays, dot, norm
from clrt.truth.world import World

BLOCK_PAIRS = 1 << 16  # of a ray and a sphere, that are tested at a time


def meetings(world: World, rays: Rays) -> Iterator[tuple[slice, Array, Array]]:
    """Where rays meet spheres, some of these at a time: which, whether from inside and the
    distances, (rays, spheres), infinity where they do not (11.4)."""
    world.rays += rays.pixel.size
    # All rays against one sphere, or few rays against many: as many pairs as the cache holds.
    block = max(1, BLOCK_PAIRS // max(rays.pixel.size, 1))
    for start in range(0, len(world.radius), block):
        some = slice(start, min(start + block, len(world.radius)))
        within = np.zeros((rays.pixel.size, some.stop - start), bool)
        here = (world.panes >= start) & (world.panes < some.stop)
        within[:, world.panes[here] - start] = rays.inside[:, here]
        from_center = rays.origin[:, :, np.newaxis] - world.center[:, np.newaxis, some]
        b = 2 * dot(rays.direction[:, :, np.newaxis], from_center)
        c = norm(from_center) ** 2 - world.radius[some] ** 2
        delta = b**2 - 4 * c
        root = np.sqrt(np.maximum(delta, 0))
        distance = np.where(within, -b + root, -b - root) / 2
        line = world.orthographic and rays.bounce == 0
        met = (delta > 0) & (line | (distance > 0)) & (world.opacity[some] > 0)
        if world.exact:  # the sphere that a ray leaves is met from inside only
            met &= within | (rays.leaves[:, np.newaxis] != np.arange(start, some.stop))
        distance[~met] = np.inf
        yield some, within, distance


def nearest(world: World, rays: Rays) -> tuple[Array, Array]:
    """The sphere hit first, -1 if none, and its distance, infinity if none (11.5): behind what each
    ray has passed, by distance and of equal distances by number."""
    hit = np.full(rays.pixel.size, -1)
    distance = np.full(rays.pixel.size, np.inf, world.dtype)
    for some, _, distances in meetings(world, rays):
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
    """How much of a light that is `limit` away the spheres leave that a ray to it enters on its
    way: 0 or 1 if all are opaque (11.7)."""
    left = np.ones(rays.pixel.size, world.dtype)
    for some, within, distances in meetings(world, rays):
        enters = (distances < limit[:, np.newaxis]) & ~within
        part = world.transmission[world.material[some]] + 1 - world.opacity[some]
        left *= np.where(enters, part, world.dtype.type(1)).prod(axis=1)
    return left
