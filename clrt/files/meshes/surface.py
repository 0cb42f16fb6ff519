"""Surface: what a file or an object has of a mesh, before it is one."""

from dataclasses import dataclass, field

import numpy as np

from clrt.files.particles import rules
from clrt.values import Array


@dataclass
class Surface:
    """Triangles as they are read."""

    vertices: Array
    faces: Array
    """(m, 3): indices from 0."""
    normals: Array | None = None
    colors: Array | None = None
    """sRGB: uint8, uint16, or floats from 0 to 1; one a vertex or one a face."""
    columns: dict[str, Array] = field(default_factory=dict)
    """Numbers by their names, (n,) of vertices or (m,) of faces, which can give colours."""


def triangles(corners: Array, starts: Array, counts: Array) -> tuple[Array, Array]:
    """Polygons as fans about their first corners.

    Args:
        corners: (k,): the corners of one polygon after the other.
        starts: (m,): where each begins in `corners`.
        counts: (m,): how many it has.

    Returns:
        (t, 3) of `corners`, in the polygons' order, and (t,): which polygon each is of. Of less
        than three corners there is none.
    """
    fans = np.maximum(counts - 2, 0)
    polygon = np.repeat(np.arange(len(counts)), fans)
    second = np.arange(len(polygon)) - np.repeat(np.cumsum(fans) - fans, fans) + 1
    first = starts[polygon]
    return np.stack(
        [corners[first], corners[first + second], corners[first + second + 1]], axis=1
    ), polygon


def merged(rows: Array) -> tuple[Array, Array]:
    """Different rows, (k, columns), in the order in which they come first, and (n,) int32: which of
    them each of n is. -0 is 0."""
    n = len(rows)
    plain = np.ascontiguousarray(rows + rows.dtype.type(0))
    words = plain.view(f"u{rows.itemsize}").reshape(n, rows.shape[1])
    # A row's place in the lower bits of its hash: so one sort, of numbers, gives groups and order.
    places = np.uint64(max(n - 1, 1).bit_length())
    keys = (_hashes(words) << places) | np.arange(n, dtype=np.uint64)
    keys.sort()
    order = (keys & np.uint64((1 << int(places)) - 1)).astype(np.int32)
    keys >>= places
    new = np.ones(n, bool)
    np.not_equal(keys[1:], keys[:-1], out=new[1:])
    first = np.empty(n, np.int32)  # for each row the first one like it
    starts = order[new]
    first[order] = np.repeat(starts, np.diff(np.flatnonzero(np.append(new, True))))
    odd = np.zeros(n, bool)
    for column in words.T:
        odd |= column[first] != column
    if odd.any():  # of two different rows with one hash
        some = np.flatnonzero(np.isin(first, first[odd]))
        _, one, which = np.unique(words[some], axis=0, return_index=True, return_inverse=True)
        first[some] = some[one[which.reshape(-1)]]
    is_first = first == np.arange(n, dtype=np.int32)
    rank = np.cumsum(is_first, dtype=np.int32) - np.int32(1)
    return rows[is_first], rank[first]


def _hashes(words: Array) -> Array:
    """(n,) uint64 of rows of whole numbers: those of equal rows are equal."""
    keys = np.zeros(len(words), np.uint64)
    for column in words.T:
        keys ^= column
        keys *= rules.SPREAD
        keys ^= keys >> np.uint64(29)
    return keys
