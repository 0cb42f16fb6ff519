"""Rules for all that is read: what is left out, and what is said of it."""

import re
import warnings
from collections.abc import Mapping
from contextlib import suppress
from typing import NamedTuple

import numpy as np

from clrt.errors import ParticleWarning
from clrt.values import Array, frozen

MOST_COUNTED = 20_000
"""Of more particles than these only some are looked at for places that others have: those whose x,
or whose whole positions, have certain hashes, so that two at one place are both in or both out."""
SPREAD = np.uint64(0x9E3779B97F4A7C15)
"""2^64 by the golden ratio: the upper bits of its multiples are spread evenly."""
MANY = 0.01
"""The part of the particles that may be at the place of another without a word."""
ROUNDED = 1e-3
"""How far a distance from the origin may be from one that is rounded, in parts of the largest."""


def say(source: str, text: str) -> None:
    """A ParticleWarning that names the file."""
    warnings.warn(f"{source}: {text}", ParticleWarning, stacklevel=3)


TWICE = "\0"
"""Begins the name of a column whose name another one has, and which is not used."""


def first_of_each(names: list[str], source: str) -> list[str]:
    """Names of columns, of which those that were there before begin with TWICE."""
    if len(set(names)) == len(names):
        return names
    there, found = set[str](), list[str]()
    for i, name in enumerate(names):
        if name in there and name:
            say(source, f"{name}: two columns have this name: the first is used")
            name = f"{TWICE}{i}"
        there.add(name)
        found.append(name)
    return found


class Kept(NamedTuple):
    """Which particles are drawn."""

    mask: Array | None
    """(n,) of bool; None: all."""
    said: list[str]
    """What is to be said of the others."""


def kept(positions: Array, radii: Array | None) -> Kept:
    """All particles but those whose positions are not finite, or whose radii are 0 or not finite.

    Args:
        positions: (n, 2) or (n, 3).
        radii: (n,), or one for all.
    """
    n = len(positions)
    masks = list[tuple[Array, str]]()
    is_numbers = positions.dtype.kind in "biuf"  # else Particles() says what is wrong
    if is_numbers and not np.isfinite(positions).all():
        masks.append((np.asarray(np.isfinite(positions.T).all(axis=0)), "no finite position"))
    if radii is not None and radii.dtype.kind in "biuf":
        for good, why in ((radii != 0, "radius 0"), (np.isfinite(radii), "no finite radius")):
            if not good.all():
                masks.append((np.broadcast_to(good, (n,)), why))
    mask: Array | None = None
    said = list[str]()
    for good, why in masks:
        left = np.count_nonzero(~good if mask is None else mask & ~good)
        mask = good if mask is None else np.logical_and(mask, good)
        if left:
            said.append(f"{left} of {n} particles are left out: {why}")
    return Kept(mask, said)


def crowded(positions: Array) -> str | None:
    """What is to be said of particles that are at one place, or None: there are few of them.

    Args:
        positions: (n, 3), finite.
    """
    n = len(positions)
    if n < 2:
        return None
    if (positions[0] == positions[-1]).all() and (positions == positions[0]).all():
        return f"all {n} particles are at one place"
    looked_at = positions
    if n > MOST_COUNTED:
        limit = np.uint64((1 << 64) // (n // MOST_COUNTED + 1))
        looked_at = positions[_bits(positions[:, 0]) * SPREAD < limit]  # found soonest
        if len(looked_at) < MOST_COUNTED // 2:  # x may have few values
            looked_at = positions[_hashes(positions) < limit]
    hashes = _hashes(looked_at)
    hashes.sort()
    same = np.count_nonzero(hashes[1:] == hashes[:-1])
    if same <= MANY * len(hashes):
        return None
    part = f"{same} of {n}" if n <= MOST_COUNTED else f"about {same / len(hashes):.0%} of {n}"
    return f"{part} particles are at the place of another, and hide or are hidden by it"


def _bits(column: Array) -> Array:
    """(n,) uint64, the same for the same number: + 0.0 makes one of the two zeros."""
    return np.add(column, 0.0, dtype=np.float64).view(np.uint64)


def _hashes(positions: Array) -> Array:
    """(n,) uint64, the same for the same place. Two of 20,000 others agree once in 10^10 files."""
    whole = np.zeros(len(positions), np.uint64)
    for axis in range(positions.shape[1]):
        whole = (whole ^ _bits(positions[:, axis])) * SPREAD
        whole ^= whole >> np.uint64(29)
    return whole


def is_distance(column: Array, positions: Array) -> bool:
    """Whether a column (n,) is each particle's distance from the origin, or from the z axis."""
    if len(column) < 3 or column.dtype.kind not in "iuf" or column.shape != (len(positions),):
        return False
    for width in {2, positions.shape[1]}:
        expected = np.sqrt((positions[:, :width].astype(np.float64) ** 2).sum(axis=1))
        most = expected.max()
        away = np.abs(column - expected).max()
        if away <= ROUNDED * most < 100 * ROUNDED * np.ptp(expected):
            return True
    return False


def bytes_of(colors: Array) -> Array:
    """Colours (n, 3) of 8 bits, of 16 bits or of floats to 255 as Particles takes them.

    Floats are to 255 if one is above 2: none that is to 1 is so far beyond it.
    """
    if colors.dtype == np.uint16 and colors.max(initial=0) > 255:
        return frozen((colors / 65535).astype(np.float32))
    if colors.dtype.kind != "f":
        return colors
    with np.errstate(invalid="ignore"):
        most = colors.max(initial=0)
        if not 1 < most <= 65535:
            return colors
        found = colors.astype(np.uint8)
        if (found == colors).all():
            return frozen(found)
    if most <= 2 or 255 < most < 4096:
        return colors
    return frozen(colors / (255 if most <= 255 else 65535))


def facts(given: Mapping[str, str]) -> dict[str, float]:
    """Those of some texts that are a number, by their names; whole numbers stay whole."""
    found = dict[str, float]()
    for name, text in given.items():
        if name.isidentifier():
            with suppress(ValueError):
                found[name] = int(text) if re.fullmatch(r"\s*[-+]?\d+\s*", text) else float(text)
    return found
