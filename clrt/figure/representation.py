"""Representation: particles as spheres and capsules, with what their colours and radii mean."""

from collections.abc import Mapping, Sequence
from typing import Any, Literal, NamedTuple

import numpy as np

from clrt.errors import RequestError
from clrt.figure import bonding, captions
from clrt.figure.coloring import Legend, Limits, Source, coloring, opacities
from clrt.figure.lines import Asked, Lines, Sizes, edges, lines
from clrt.figure.meaning import Meaning
from clrt.figure.radii import radii_of
from clrt.film.color import linear
from clrt.particles import choose
from clrt.particles.particlefile import ATOMS, PLAIN
from clrt.particles.particles import Particles
from clrt.scene.capsules import Capsules
from clrt.scene.film import Cell, Label
from clrt.scene.spheres import Spheres
from clrt.values import Array, frozen

UNITS = {"angstrom": "Å", "bohr": "a₀", "um": "µm"}
"""How some are written."""


class Representation(NamedTuple):
    """Particles as spheres and capsules, and what their colours mean."""

    spheres: Spheres
    rows: Array | None
    """(n,) which of the particles each sphere is; None: the spheres are the particles."""
    source: Source
    """What they have their colours of."""
    cmap: str
    meaning: Meaning
    legend: Legend
    """What the colours stand for, if they are of an element, a type or text."""
    box: Cell | None = None
    """The box that they are in."""
    cell: Cell | None = None
    """The box that is to be drawn."""
    labels: tuple[Label, ...] = ()
    """Texts at the spheres."""
    label: str = ""
    """That of the film, with its fields filled."""
    unit: str = ""
    """Of lengths, as it is written; "": nobody knows."""
    capsules: Capsules | None = None
    """Bonds, arrows, and edges of a solid box."""
    parts: Sequence[Spheres] = ()
    """They hold all that is drawn beside the box."""
    is_solid: bool = False
    """The box is drawn by capsules."""


def nothing(material: str, cmap: str, label: str) -> Representation:
    """Of no particles, for a figure of something else."""
    spheres = Spheres(np.zeros((0, 3)), np.zeros(0), material)
    return Representation(spheres, None, Source("one", ""), cmap, Meaning(), tuple, label=label)


def represented(
    particles: Particles,
    *,
    material: str = PLAIN,
    select: str | None = None,
    hide: str | None = None,
    mask: Array | None = None,
    wrap: bool = False,
    replicate: Sequence[int] = (1, 1, 1),
    radius: float | Mapping[str, float] | None = None,
    balls: bool = False,
    scale: float = 1.0,
    color: str | None = None,
    colors: str | Mapping[str, Any] | None = None,
    opacity: float | str | None = None,
    cmap: str = "viridis",
    clim: Limits = None,
    cell: bool | Literal["solid"] = False,
    bonds: Any = None,
    bond_radius: float | None = None,
    bond_color: str = ATOMS,
    vectors: str | None = None,
    vector_scale: float | None = None,
    vector_color: str = ATOMS,
    labels: str | None = None,
    label: str = "",
    meaning: Meaning | None = None,
) -> Representation:
    """Particles as spheres and capsules, as a ParticleFile's fields of the same names say.

    Args:
        mask: (n,) of bool: only these are there.
        balls: radii are those of balls at sticks, which are bonds if none are said.
        label: that of the film, whose fields are filled.
        meaning: of another frame; then nothing is said again, and no particle may be left.

    Raises:
        RequestError: naming the key, if the particles do not have what it needs.
    """
    if wrap:
        particles = choose.wrapped(particles)
    if isinstance(bonds, np.ndarray):
        particles, bonds = particles.replaced(bonds=bonds), bonding.LISTED
    if cell and particles.cell is None:
        raise RequestError("cell: expected particles in a box, got none")
    columns = particles.columns
    written = None if labels is None else choose.column("labels", labels, columns)
    kept = choose.selected(columns, len(particles), select, hide, may_be_none=meaning is not None)
    if mask is not None:
        kept = mask if kept is None else kept & mask
    rows = None if kept is None else np.flatnonzero(kept)
    radii, spare = radii_of(particles, radius, meaning, balls)
    shades = coloring(particles, columns, rows, color, colors, cmap, clim, material, meaning)
    spheres = Spheres(
        particles.positions if rows is None else frozen(particles.positions[rows]),
        frozen((radii if rows is None else radii[rows]) * scale),
        material,
        None if shades.srgb is None else frozen(linear(shades.srgb)),
        opacities(particles, columns, rows, opacity),
    )
    sticks = balls if bonds is None else bonds
    asked = Asked(sticks, bond_radius, bond_color, vectors, vector_scale, vector_color)
    moved = choose.images(particles, replicate) if tuple(replicate) != (1, 1, 1) else None
    beside = Lines(None, [], Sizes())
    if asked != Asked():
        there = particles if kept is None else particles.where(kept)
        known = None if meaning is None else meaning.lines or Sizes()
        ways = np.zeros((1, 3)) if moved is None else moved
        beside = lines(there, spheres.radius, spheres.color, ways, material, asked, known)
    if moved is not None:
        rows = np.tile(np.arange(len(particles)) if rows is None else rows, len(moved))
        spheres = _repeated(spheres, material, moved)
    box, capsules = _box(particles, replicate), beside.capsules
    if cell == "solid" and box is not None:
        walls = edges(box, material)
        capsules = walls if capsules is None else Capsules.joined([capsules, walls])
    return Representation(
        spheres,
        rows,
        shades.source,
        cmap,
        shades.meaning._replace(spare=spare, lines=beside.sizes),
        shades.legend,
        box,
        box if cell else None,
        () if written is None else tuple(captions.labels(written, rows, spheres)),
        captions.filled(label, {**captions.USUAL, **particles.facts}, particles, rows),
        UNITS.get(particles.unit or "", particles.unit or ""),
        capsules,
        [spheres, *beside.aside],
        cell == "solid",
    )


def _repeated(spheres: Spheres, material: str, moved: Array) -> Spheres:
    """The images of spheres, one after the other: as many as they are moved, (images, 3)."""
    many = len(moved)

    def tiled(array: Array | None) -> Array | None:
        return None if array is None else frozen(np.concatenate([array] * many))

    return Spheres(
        frozen((spheres.center + moved[:, np.newaxis]).reshape(-1, 3)),
        frozen(np.tile(spheres.radius, many)),
        material,
        tiled(spheres.color),
        tiled(spheres.opacity),
    )


def _box(particles: Particles, replicate: Sequence[int]) -> Cell | None:
    """The box that particles are in, as long as so many of it."""
    if particles.cell is None:
        return None
    edges = particles.cell * np.array(replicate)[:, np.newaxis]
    return Cell(edges, particles.origin)  # type: ignore[arg-type]
