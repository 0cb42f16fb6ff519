"""Coloring: particles as spheres: how large they are, of which colour, and what that means."""

from collections.abc import Sequence
from contextlib import suppress
from typing import Literal, NamedTuple

import numpy as np
from msgspec.structs import replace

from clrt.errors import RequestError
from clrt.film import color as colors
from clrt.film.decor import legend
from clrt.particles import elements, palette
from clrt.particles.particlefile import MATTE
from clrt.particles.particles import Particles
from clrt.scene.film import Cell, Film
from clrt.scene.spheres import Spheres
from clrt.values import Array, frozen, some

By = Literal["file", "element", "type", "material", "column"]


class Colored(NamedTuple):
    """Particles as spheres, and what their colours mean."""

    spheres: Spheres
    particles: Particles
    by: By
    """What they have their colours of."""
    cmap: str
    clim: tuple[float, float] | None
    """What the ends of the map stand for, if it is of a column."""
    cell: Cell | None
    """The box that is to be drawn."""


def colored(
    particles: Particles,
    *,
    material: str = MATTE,
    radius: float | None = None,
    scale: float = 1.0,
    color: str | None = None,
    cmap: str = "viridis",
    clim: tuple[float, float] | None = None,
    cell: bool = False,
) -> Colored:
    """Particles as spheres, as a ParticleFile's fields of the same names say.

    Raises:
        RequestError: naming the key, if the particles do not have what it needs.
    """
    radii = _radii(particles, radius) * scale
    by, column = _by(particles, color)
    limits, srgb = None, None
    if by == "file":
        srgb = particles.colors
    elif by == "element":
        srgb = elements.COLORS[particles.elements]
    elif by == "type" and particles.types is not None:
        srgb = palette.of_types(particles.types)
    elif column is not None:
        limits = palette.limits(column, clim)
        srgb = palette.of_values(column, cmap, limits)
    own = None if srgb is None else frozen(colors.linear(srgb))
    spheres = Spheres(particles.positions, frozen(radii), material, own)
    return Colored(spheres, particles, by, cmap, limits, box_of(particles) if cell else None)


def decorated(film: Film, parts: Sequence[Colored]) -> Film:
    """A film with the boxes of particles, and what it asks for and does not say: the range and the
    map of its colour bar, those of the first that are coloured by a column, or a legend, that of
    the first that are coloured by element or type.

    Raises:
        RequestError: nothing is coloured so.
    """
    film = replace(film, cells=(*film.cells, *(part.cell for part in parts if part.cell)))
    if not film.colorbar or film.legend:
        return film
    for part in parts:
        if part.by == "column":
            return replace(
                film,
                colorbar_cmap=film.colorbar_cmap or part.cmap,
                colorbar_clim=film.colorbar_clim or part.clim,
            )
    if film.colorbar_clim is not None:
        return film
    for part in parts:
        if part.by == "element" and part.particles.elements is not None:
            return replace(film, legend=legend.of_elements(part.particles.elements))
        if part.by == "type" and part.particles.types is not None:
            entries = legend.of_types(part.particles.types, part.particles.type_names)
            return replace(film, legend=entries)
    raise RequestError("colorbar: expected particles coloured by a column, by element or by type")


def box_of(particles: Particles) -> Cell:
    """The box that particles are in.

    Raises:
        RequestError: they are in none.
    """
    if particles.cell is None:
        raise RequestError("cell: expected particles in a box, got none")
    return Cell(particles.cell, particles.origin)  # type: ignore[arg-type]


def _radii(particles: Particles, radius: float | None) -> Array:
    if radius is not None:
        return np.full(len(particles), radius)
    if particles.radii is not None:
        return particles.radii
    if particles.elements is None:
        expected = "a number for particles that have neither radii nor elements"
        raise RequestError(f"radius: expected {expected}, got none")
    found: Array = elements.VAN_DER_WAALS[particles.elements]
    return found


def _by(particles: Particles, color: str | None) -> tuple[By, Array | None]:
    """What gives the colours, and the column if it is one."""
    there: list[By] = ["material"]
    if particles.types is not None:
        there.insert(0, "type")
    if particles.elements is not None:
        there.insert(0, "element")
    if particles.colors is not None:
        there.insert(0, "file")
    if color is None:
        return there[0], None
    for by in there:
        if by == color:
            return by, None
    with suppress(RequestError):
        return "column", particles.column(color)
    known = some([*there, *particles.values, "x", "y", "z"], 20)
    raise RequestError(f"color: expected one of {known}, got {color!r}")
