"""Lines: what is drawn of particles beside their spheres, as capsules: bonds, arrows, and the edges
of their box."""

from typing import Any, NamedTuple

import numpy as np

from clrt.errors import warn
from clrt.figure import arrows, bonding
from clrt.film.decor.cell import EDGES, corners_of
from clrt.particles.particlefile import ATOMS
from clrt.particles.particles import Particles
from clrt.scene.capsules import Capsules
from clrt.scene.film import Cell
from clrt.scene.spheres import Spheres
from clrt.values import Array, frozen

EDGE = 1 / 400
"""The radius of the edges of a box, in the longest way through it."""
EDGE_COLOR = (0.08, 0.08, 0.08)
"""Linear."""


class Asked(NamedTuple):
    """What is drawn, as a ParticleFile's fields of the same names say."""

    bonds: Any = False
    bond_radius: float | None = None
    bond_color: str = ATOMS
    vectors: str | None = None
    vector_scale: float | None = None
    vector_color: str = ATOMS


class Sizes(NamedTuple):
    """Of all frames of a trajectory."""

    bond: float | None = None
    """The radius of bonds."""
    arrow: float | None = None
    """How long arrows are, in their vectors."""
    shaft: float | None = None
    """The radius of their shafts."""


class Lines(NamedTuple):
    """Capsules, and what they have beside the spheres."""

    capsules: Capsules | None
    aside: list[Spheres]
    """Where they reach out of the spheres."""
    sizes: Sizes


def lines(
    particles: Particles,
    radii: Array,
    own: Array | None,
    moved: Array,
    material: str,
    asked: Asked,
    known: Sizes | None,
) -> Lines:
    """Bonds and arrows of particles.

    Args:
        radii: (n,), of their spheres.
        own: (n, 3), their linear colours; None: white.
        moved: (images, 3), where the images of all are moved.
        known: of another frame; then it is no error that there is nothing.

    Raises:
        RequestError: the particles do not have what it needs.
    """
    parts, aside, sizes = list[Capsules](), list[Spheres](), known or Sizes()
    found = bonding.found(particles, asked.bonds, says=known is None)
    said = asked.bonds not in (True, bonding.LISTED)
    if found is not None and len(found.pairs):
        thick = asked.bond_radius or sizes.bond or bonding.radius_of(particles, float(radii.min()))
        made, ends = bonding.capsules(
            particles, found, thick, asked.bond_color, material, own, moved
        )
        parts.append(made)
        aside.append(Spheres(ends, thick, material))
        sizes = sizes._replace(bond=thick)
    elif known is None and found is not None and said:
        warn("bonds", "none are found")
    elif known is None:
        _say_of_none("bonds", bond_radius=asked.bond_radius, bond_color=asked.bond_color)
    if asked.vectors is not None and len(particles):
        ways = arrows.vectors(particles, asked.vectors)
        usual = float(np.median(radii))
        mean = arrows.mean_of(ways)
        scale = asked.vector_scale or sizes.arrow or arrows.MEAN * usual / (mean or 1)
        thick = sizes.shaft or max(arrows.SHAFT * usual, arrows.THIN * mean * scale)
        with np.errstate(over="ignore"):
            ways = ways * scale
        made, ends = arrows.capsules(
            particles.positions,
            radii,
            ways,
            thick,
            asked.vector_color,
            material,
            own,
            moved,
        )
        parts.append(made)
        aside.append(Spheres(ends, arrows.HEAD * arrows.TIP * thick, material))
        sizes = sizes._replace(arrow=scale, shaft=thick)
    elif known is None:
        _say_of_none("vectors", vector_scale=asked.vector_scale, vector_color=asked.vector_color)
    return Lines(Capsules.joined(parts) if parts else None, [a for a in aside if len(a)], sizes)


def _say_of_none(what: str, **looks: Any) -> None:
    """Says that looks were given of what is not there."""
    for key, given in looks.items():
        if given not in (None, ATOMS):
            warn(key, f"expected {what}, there are none to draw")


def edges(box: Cell, material: str) -> Capsules:
    """The twelve edges of a box."""
    corners = corners_of(box)
    through = max(float(np.linalg.norm(corners[i] - corners[7 - i])) for i in range(4))
    ends = corners[np.array(EDGES)]
    color = np.broadcast_to(np.array(EDGE_COLOR), (len(EDGES), 3))
    start, end = (frozen(ends[:, k].copy()) for k in (0, 1))
    return Capsules(start, end, EDGE * through, material, frozen(color.copy()))
