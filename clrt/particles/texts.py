"""Texts: columns of text as numbers, for there are few different ones."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from clrt.values import Array

SLOTS = 16
"""Bits of a hash."""
SPREAD = np.uint64(0x9E3779B97F4A7C15)
"""2^64 / golden ratio, odd: D. E. Knuth, The Art of Computer Programming 3, section 6.4."""


@dataclass(frozen=True, eq=False)
class Text:
    """A column of text."""

    kinds: tuple[str, ...]
    """The different texts, in order."""
    which: Array
    """(n,) whole numbers: the index in `kinds` of each particle's."""

    @classmethod
    def of(cls, names: Sequence[str], which: Array) -> "Text":
        """Of names in any order, each of which can be there or not.

        which: (n,) whole numbers: the index in `names` of each particle's.
        """
        there = np.flatnonzero(np.bincount(which, minlength=len(names)))
        kinds = sorted({names[k] for k in there.tolist()})
        rank = np.zeros(len(names), np.int32)
        rank[there] = [kinds.index(names[k]) for k in there.tolist()]
        return cls(tuple(kinds), rank[which])

    def array(self) -> Array:
        """(n,) str."""
        found: Array = np.array(self.kinds or ("",))[self.which]
        return found


def distinct(names: Array) -> Text:
    """The texts that there are, in order, and the index of each particle's.

    A hash table of NumPy's takes a sixth of the time of np.unique(), which sorts; where two texts
    have one hash np.unique() it is.

    names: (n,) of kind "U" or "S", which is UTF-8.
    """
    n = len(names)
    if n == 0:
        return Text((), np.zeros(0, np.int32))
    names = np.ascontiguousarray(names.astype(names.dtype.newbyteorder("="), copy=False))
    unit = np.uint8 if names.dtype.kind == "S" else np.uint32
    letters: Array = names.view(unit).reshape(n, -1)
    key = np.zeros(n, np.uint64)
    exact = letters.shape[1] <= 8 and bool((letters < 256).all())
    for column in letters.T:
        key *= np.uint64(256) if exact else SPREAD
        key += column
    slot = (key * SPREAD >> np.uint64(64 - SLOTS)).astype(np.intp)
    last: Array = np.full(1 << SLOTS, -1, np.int32 if n < 2**31 else np.int64)
    last[slot] = np.arange(n)
    leader = last[slot]
    one = key if exact else names
    if not (one[leader] == one).all():
        kinds, which = np.unique(names, return_inverse=True)
        return Text(_decoded(kinds), which.reshape(-1))
    used = np.flatnonzero(last >= 0)
    kinds = names[last[used]]
    order = np.argsort(kinds)
    rank = np.zeros(1 << SLOTS, np.int32)
    rank[used[order]] = np.arange(len(order))
    return Text(_decoded(kinds[order]), rank[slot])


def _decoded(kinds: Array) -> tuple[str, ...]:
    found = kinds.tolist()
    if kinds.dtype.kind == "S":
        return tuple(one.decode("utf-8", "replace") for one in found)
    return tuple(found)
