"""Bonding: the bonds of particles as capsules."""

from typing import Any

import numpy as np

from clrt.errors import RequestError
from clrt.film.color import srgb, to_linear
from clrt.particles import bonds
from clrt.particles.bonds import Bonds
from clrt.particles.particlefile import ATOMS
from clrt.particles.particles import ANGSTROMS as UNITS
from clrt.particles.particles import Particles
from clrt.scene.capsules import Capsules
from clrt.values import Array, frozen

ANGSTROMS = 0.15
"""The radius of a bond, if nothing is said and the unit of length is known."""
LISTED = "listed"
PART = 0.3
"""Else so much of the least radius of a particle."""


def found(particles: Particles, given: Any, says: bool) -> Bonds | None:
    """The bonds that are to be drawn.

    Args:
        given: as of a clrt.ParticleFile, or LISTED: the particles' and no others.
        says: whether it is an error that there are none.

    Raises:
        RequestError: the particles do not have what it needs.
    """
    if given is False or given == "none":
        return None
    cell = bonds.periodic(particles)
    if given == LISTED:
        assert particles.bonds is not None
        return bonds.listed(particles.bonds, particles.positions, cell)
    if given is True or given == "file":
        own_or_none = bonds.of_file(particles)
        if own_or_none is not None or (given is True and particles.elements is None):
            return own_or_none
        if given == "file":
            if says:
                expected = "particles with bonds; auto, or a distance, finds some"
                raise RequestError(f"bonds: expected {expected}")
            return None
        given = "auto"
    if given == "auto":
        return bonds.automatic(particles)
    return bonds.within(particles.positions, given / 2, cell)


def capsules(
    particles: Particles,
    found: Bonds,
    radius: float,
    color: str,
    material: str,
    own: Array | None,
    moved: Array,
) -> tuple[Capsules, Array]:
    """Bonds as capsules, and the ends of those (k, 3) that end at no particle.

    A bond has one capsule, or two halves where its ends have two colours, or where the second
    particle is beside the first by an image of it: then each has its half.

    Args:
        radius: of all.
        color: "atoms", or sRGB of all.
        own: (n, 3), the particles' linear colours; None: white.
        moved: (images, 3), where the images of all are moved.
    """
    if color != ATOMS:
        own = np.broadcast_to(to_linear(srgb("bond_color", color)), (len(particles), 3))
    ways = found.ways(particles.positions, bonds.periodic(particles))
    first, second = found.pairs.T
    is_open: Array = np.asarray(found.shifts.any(axis=1))
    halved = is_open if own is None else is_open | (own[first] != own[second]).any(axis=1)
    half = ways[halved] / 2
    row = np.concatenate([first[~halved], first[halved], second[halved]])
    way = np.concatenate([ways[~halved], half, -half])
    ends_open = np.flatnonzero(np.tile(is_open[halved], 2)) + np.count_nonzero(~halved)
    start = (particles.positions[row] + moved[:, np.newaxis]).reshape(-1, 3)
    end = start + np.tile(way, (len(moved), 1))
    colors = None if own is None else frozen(np.tile(own[row], (len(moved), 1)))
    ends = end.reshape(len(moved), -1, 3)[:, ends_open].reshape(-1, 3)
    return Capsules(frozen(start), frozen(end), radius, material, colors), ends


def radius_of(particles: Particles, least: float) -> float:
    """The radius of bonds of which nothing is said.

    least: the least radius of a particle.
    """
    is_known = particles.unit in UNITS or particles.elements is not None
    return ANGSTROMS / particles.angstroms if is_known else PART * least
