"""Capsules: as the kernel tests them, in a tree of their own."""

import numpy as np

from clrt.renderer.pack.structs import Array, Real
from clrt.scene import lens
from clrt.scene.capsules import Capsules


def reach(capsules: Capsules, origin: Array) -> float:
    """How far many capsules reach from the origin."""
    farthest = 0.0
    for block in lens.blocks(len(capsules)):
        for end in (capsules.start[block], capsules.end[block]):
            away = end - origin
            distance = np.sqrt(np.einsum("ij,ij->i", away, away)) + capsules.radius[block]
            farthest = max(farthest, float(distance.max()))
    return farthest


def rows(capsules: Capsules, origin: Array, scale: float, real: Real) -> Array:
    """(capsules, 8) of real: the start from the origin, the radius, the axis of unit length and the
    length, scaled. Each is rounded once: so a short bond far away has the direction that it has in
    the world, not that of two rounded ends."""
    found = np.empty((len(capsules), 8), real)
    for block in lens.blocks(len(capsules)):
        start, end = capsules.start[block].astype(np.float64), capsules.end[block]
        axis = (end - start) * scale
        length = np.sqrt(np.einsum("ij,ij->i", axis, axis))
        found[block, :3] = (start - origin) * scale
        found[block, 3] = capsules.radius[block] * np.float64(scale)
        found[block, 4:7] = axis / np.where(length > 0, length, 1)[:, np.newaxis]
        found[block, 7] = length
    return found


def tree_keys(capsules: Capsules) -> Array:
    """What a tree is ordered by, (capsules, 4) float32: the middle and the longest side of the box
    around each, in units of the box around the middles, from about the middle one."""
    start, end = capsules.start.astype(np.float64), capsules.end.astype(np.float64)
    # Halves, lest two be farther apart than any number.
    middle = start / 2 + end / 2
    side = abs(end / 2 - start / 2).max(axis=1) + capsules.radius
    half = float(max(np.max(column) / 2 - np.min(column) / 2 for column in middle.T)) or 1.0
    origin = np.median(middle[lens.some(len(middle))], axis=0)
    keys = np.empty((len(capsules), 4), np.float32)
    keys[:, :3] = (middle / 2 - origin / 2) / half
    keys[:, 3] = np.minimum(side / half, 1e30)
    return keys
