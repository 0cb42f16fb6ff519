"""Samples: the points at which a pixel is looked at.

They are those of a Sobol sequence in two dimensions, the first 2^k of which have one point in every
box of 2^-j x 2^(j-k), scrambled after Owen, which leaves that and makes them random otherwise. The
bits of a point are scrambled by a hash of those above: Burley, Practical Hash-based Owen
Scrambling, Journal of Computer Graphics Techniques 9(4), 2020, after Laine and Karras, 2011.

It takes NumPy 0.2 ms for 256 points and 20 ms for 65536, so nothing is kept in a file.
"""

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]

EVERY_OTHER = ((1, 0x55555555), (2, 0x33333333), (4, 0x0F0F0F0F), (8, 0x00FF00FF), (16, 0x0000FFFF))
"""Of the bits of a number the lower of each pair, of each pair of pairs and so on."""


@functools.lru_cache(4)  # frames of an animation have the same ones
def table(count: int, pairs: int = 1, first: int = 0) -> NDArray[np.uint32]:
    """The first points of some sequences that do not know of each other: (pairs, count, 2), as
    parts of 2^32. first: the number of the first sequence."""
    index = np.arange(count, dtype=np.uint32)
    numbers = np.arange(3 * first + 1, 3 * (first + pairs) + 1, dtype=np.uint32)
    seeds = _mixed(numbers).reshape(pairs, 3)
    found = np.empty((pairs, count, 2), np.uint32)
    for pair, (order, *axes) in zip(found, seeds, strict=True):
        # Scrambled as well: which of two sequences' points come together.
        place = _scrambled(index, order)
        for axis, seed in enumerate(axes):
            pair[:, axis] = _scrambled(_sobol(place, axis), seed)
    found.flags.writeable = False
    return found


CENTRED = {
    1: ((0.0, 0.0),),
    4: ((0.25, 0.75), (0.75, -0.25), (-0.25, -0.75), (-0.75, 0.25)),
}
"""So many points that their mean is the pixel's middle: a mean of samples is then right where
colours change evenly. The four are those of rotated grid supersampling. Sobol's first four are off
by 0.04 pixels (rms over scramblings); balls of five pixels look worse by these than by one point
(benchmarks/NOTES.md)."""


PIXEL = 33545
"""The number of the pixel's sequence: of 40,000 one whose first 16 points leave little room. A
straight edge with all of them on one side parts 0.052 of the pixel from them at most (of most
sequences 0.085), a disc of two pixels' radius 0.054, one of 0.2 pixels 0.125, and a band between
two points 0.24. Discs of any size have room for 0.054 beside the first 48. So an edge that the
first samples do not see is less than a sixteenth of its contrast off, where small balls have 48."""


def offsets(count: int) -> NDArray[np.float64]:
    """Where samples lie in a pixel: (count, 2), right and up of its middle, in half pixels."""
    if count in CENTRED:
        return np.array(CENTRED[count])
    found: NDArray[np.float64] = (table(count, first=PIXEL)[0] + 0.5) / 2.0**31 - 1
    return found


def _reversed(bits: Array) -> Array:
    for shift, mask in EVERY_OTHER:
        low = np.uint32(mask)
        bits = (bits & low) << np.uint32(shift) | bits >> np.uint32(shift) & low
    return bits


def _sobol(index: Array, axis: int) -> Array:
    """One coordinate of each point, as part of 2^32. The second axis' matrix is Pascal's triangle
    modulo 2, which is a product of five sparse ones."""
    if axis:
        for shift, mask in EVERY_OTHER:
            index = index ^ index >> np.uint32(shift) & np.uint32(mask)
    return _reversed(index)


def _scrambled(part: Array, seed: np.uint32) -> Array:
    bits = _reversed(part) + seed
    for factor in (0x6C50B47C, 0xB82F1E52, 0xC7AFE638, 0x8D22F6E6):
        bits = bits ^ bits * np.uint32(factor)
    return _reversed(bits)


def _mixed(number: Array) -> Array:
    """A hash: lowbias32 of Chris Wellons' search for such functions, 2018."""
    number = (number ^ number >> np.uint32(16)) * np.uint32(0x7FEB352D)
    number = (number ^ number >> np.uint32(15)) * np.uint32(0x846CA68B)
    mixed: Array = number ^ number >> np.uint32(16)
    return mixed
