"""Spheres: where rays meet them (11.4, 11.5, 11.7)."""

from collections.abc import Iterator

import numpy as np

from clrt.truth.rays import Array, Rays, dot, norm
from clrt.truth.world import World

BLOCK_PAIRS = 1 << 16  # of a ray and a sphere, that are tested at a time


def meetings(world: World, rays: Rays) -> Iterator[tuple[slice, Array, Array]]:
    """Where rays meet spheres, some of these at a time: which, whether from inside and the
    distances, (rays, spheres), infinity where they do not (11.4)."""
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
