"""Arrows: vectors of particles as capsules: a shaft, and a head of balls that get smaller."""

import numpy as np

from clrt.errors import RequestError, warn
from clrt.film.color import srgb, to_linear
from clrt.particles import derived
from clrt.particles.particlefile import ATOMS
from clrt.particles.particles import Particles
from clrt.scene.capsules import Capsules
from clrt.values import Array, did_you_mean, frozen, some

MEAN = 2.0
"""The mean length of arrows, if nothing is said: in median radii of the particles."""
SHAFT, THIN = 0.25, 1 / 16
"""The radius of a shaft is the larger of two: in median radii of the particles, and in the mean
length of arrows."""
HEAD = 2.3
"""The radius of a head at its base, and ..."""
LONG = 6.5
"""... its length, in radii of the shaft."""
TIP, BALLS = 0.12, 12
"""The radius of the last ball of a head, in that of the first; and how many there are."""


def vectors(particles: Particles, name: str) -> Array:
    """(n, 3): three columns, as vx, vy and vz of "v".

    Raises:
        RequestError: there are none.
    """
    known = derived.vectors([*particles.values])
    if name not in known:
        expected = (
            f"expected one of {some(known, 12)}" if known else "expected columns as vx, vy, vz"
        )
        raise RequestError(f"vectors: {expected}, got {name!r}{did_you_mean(name, known)}")
    found = np.stack([particles.values[one].astype(np.float64) for one in known[name]], axis=1)
    if missing := np.count_nonzero(~np.isfinite(found).all(axis=1)):
        said = f"{missing:,} of {len(found):,} are no finite numbers and have no arrow"
        warn("vectors", said)
    return found


def mean_of(vectors: Array) -> float:
    """The mean length of those that have an arrow; 0: none has one."""
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(vectors, axis=1)
    lengths = lengths[np.isfinite(lengths) & (lengths > 0)]
    return float(lengths.mean()) if len(lengths) else 0.0


def capsules(
    positions: Array,
    radii: Array,
    ways: Array,
    thick: float,
    color: str,
    material: str,
    own: Array | None,
    moved: Array,
) -> tuple[Capsules, Array]:
    """Arrows that begin at the surface of each particle, and their tips (k, 3). A vector that is 0
    or no number has none.

    Args:
        ways: (n, 3), from the surface to the tip.
        thick: the radius of shafts; those of arrows that are shorter than a head are smaller.
        color, material, own, moved: as bonding.capsules() has them.
    """
    if color != ATOMS:
        own = np.broadcast_to(to_linear(srgb("vector_color", color)), (len(positions), 3))
    with np.errstate(over="ignore"):
        lengths = np.linalg.norm(ways, axis=1)
    row = np.flatnonzero(np.isfinite(lengths) & (lengths > 0))
    length = lengths[row, np.newaxis]
    unit = ways[row] / length
    begin = positions[row] + unit * radii[row, np.newaxis]
    size = thick * np.minimum(length / (LONG * thick), 1)
    # Balls that touch a cone from inside. The first ends LONG before the tip, the last one there.
    parts = np.geomspace(1, TIP, BALLS)
    slope = (LONG - HEAD * (1 + TIP)) / (1 - TIP)
    places = [
        begin + unit * (length - (HEAD * TIP + slope * (part - TIP)) * size) for part in parts
    ]
    start = np.concatenate([positions[row], *places])
    end = np.concatenate([places[0], *places])
    thicks = [size, *(HEAD * part * size for part in parts)]
    rows = np.tile(row, 1 + BALLS)
    many = len(moved)
    return Capsules(
        frozen((start + moved[:, np.newaxis]).reshape(-1, 3)),
        frozen((end + moved[:, np.newaxis]).reshape(-1, 3)),
        frozen(np.tile(np.concatenate(thicks)[:, 0], many)),
        material,
        None if own is None else frozen(np.tile(own[rows], (many, 1))),
    ), (begin + unit * length + moved[:, np.newaxis]).reshape(-1, 3)
