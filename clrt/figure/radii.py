"""Radii: how large the spheres of particles are."""

import warnings
from collections.abc import Mapping

import numpy as np

from clrt.errors import ParticleWarning
from clrt.figure.meaning import Meaning
from clrt.particles import choose, elements
from clrt.particles.neighbours import spacing
from clrt.particles.particles import Particles
from clrt.values import Array

BALL_OF_ATOM, BALL = 0.25, 0.5
"""The radius of a ball of ball-and-stick: of an element's van der Waals radius, and of another."""


def radii_of(
    particles: Particles,
    radius: float | Mapping[str, float] | None,
    meaning: Meaning | None,
    balls: bool,
) -> tuple[Array, float | None]:
    """The radii of particles (n,), and that of those that have none.

    Args:
        radius: of all, or of some kinds.
        meaning: of another frame.
        balls: radii that are not given are smaller.
    """
    n = len(particles)
    if radius is not None and not isinstance(radius, Mapping):
        return np.full(n, radius), None
    found = np.full(n, np.nan)
    kinds = choose.kinds_of(particles) if radius else {}
    for key, one in (radius or {}).items():
        of = next((text for text in kinds.values() if key in text.kinds), None)
        if of is not None:
            found[of.which == of.kinds.index(key)] = one
        elif meaning is None:
            choose.say_absent("radius", key, kinds)
    left = np.isnan(found)
    if not left.any():
        return found, None
    if particles.elements is not None and (balls or particles.radii is None):
        known: Array = elements.VAN_DER_WAALS[particles.elements] / particles.angstroms
        known = known * BALL_OF_ATOM if balls else known
    elif particles.radii is not None:
        known = particles.radii * BALL if balls else particles.radii
    else:
        known_spare = None if meaning is None else meaning.spare
        spare = known_spare or _half_apart(particles) * (BALL if balls else 1)
        found[left] = spare
        return found, spare
    return (known if left.all() else np.where(left, known, found)), None


def _half_apart(particles: Particles) -> float:
    """Half the median distance of nearest neighbours."""
    apart = spacing(particles.positions)
    radius = 1.0 if apart is None else apart / 2
    why = "half the median distance between nearest neighbours" if apart else "there is one place"
    said = f"radius {radius:.4g}: {why}; --radius X, radii=X in Python, says another"
    warnings.warn(said, ParticleWarning, stacklevel=4)
    return radius
