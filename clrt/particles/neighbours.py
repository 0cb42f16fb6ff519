"""Neighbours: how far particles are apart."""

import numpy as np

from clrt.values import Array

ASKED = 1000
"""Particles whose nearest neighbour is looked for, at most."""


def spacing(positions: Array) -> float | None:
    """The median distance from a particle to the nearest other one that is not at the same place,
    float64, of at most ASKED particles that are evenly chosen; None if there are no two places.

    Particles are sorted along their longest side. Around each asked one a few neighbours in that
    order bound the distance, and only those that are no farther away along the side are looked at.

    positions: (n, 3), finite.
    """
    if len(positions) == 0:
        return None
    low, high = positions.min(axis=0), positions.max(axis=0)
    with np.errstate(over="ignore"):
        axis = int(np.argmax(high.astype(np.float64) - low))
    order = np.argsort(positions[:, axis], kind="stable")
    sorted_ = positions[order].astype(np.float64)
    along = np.ascontiguousarray(sorted_[:, axis])
    asked = np.linspace(0, len(order) - 1, min(ASKED, len(order))).astype(np.intp)
    place = np.empty(len(order), np.intp)
    place[order] = np.arange(len(order))
    found = [_nearest(sorted_, along, at) for at in place[asked].tolist()]
    apart = [distance for distance in found if 0 < distance < np.inf]
    return float(np.median(apart)) if apart else None


def _nearest(points: Array, along: Array, at: int) -> float:
    """The distance of point `at` from the nearest that is not at its place; infinity if none is.

    along: (n,), ascending: what the points are sorted by.
    """
    reach = max(int(len(points) ** (2 / 3)) // 4, 32)  # a cube's slab so thick has them near
    while True:
        first, last = max(at - reach, 0), min(at + reach + 1, len(points))
        bound = _least(points[first:last], points[at])
        if bound < np.inf or last - first == len(points):
            break
        reach *= 8
    first, last = np.searchsorted(along, (along[at] - bound, along[at] + bound), "left")
    return min(bound, _least(points[first : last + 1], points[at]))


def _least(points: Array, point: Array) -> float:
    away = points - point
    squared = np.einsum("ij,ij->i", away, away)
    return float(np.sqrt(squared[squared > 0].min(initial=np.inf)))
