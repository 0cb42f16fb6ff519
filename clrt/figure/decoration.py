"""Decoration: what a film says of the particles in the picture: a colour bar or a legend, boxes and
labels."""

import re
from collections.abc import Sequence
from typing import Any

from msgspec.structs import replace

from clrt.errors import RequestError
from clrt.figure.representation import Representation
from clrt.scene.film import Film

LOGARITHM = re.compile(r"(log10|log)\((.*)\)")


def decorated(film: Film, parts: Sequence[Representation]) -> Film:
    """A film with the boxes and labels of particles, and what it asks for and does not say: the
    fields of its label, those of the first; the edges that its axes are along; the range and the
    map of its colour bar, those of the first that are coloured by a column, or a legend, that of
    the first that are coloured by element, type or text.

    Raises:
        RequestError: nothing is coloured so, or there is no box.
    """
    drawn = [part.cell for part in parts if part.cell and not part.is_solid]
    film = replace(
        film,
        cells=(*film.cells, *drawn),
        labels=(*film.labels, *(label for part in parts for label in part.labels)),
        label=next((part.label for part in parts), film.label),
    )
    if film.scalebar == "auto" and not film.scalebar_label:
        film = replace(film, scalebar_label=next((part.unit for part in parts), ""))
    if film.axes == "abc" and film.axes_edges is None:
        boxes = [part.box for part in parts if part.box is not None]
        if not boxes:
            raise RequestError("axes: expected particles in a box, for abc are its edges")
        film = replace(film, axes_edges=boxes[0].edges)
    if not film.colorbar or film.legend:
        return film
    for part in parts:
        if part.source.by == "column":
            return _with_bar(film, part)
    if film.colorbar_clim is not None:
        return film
    for part in parts:
        if part.source.by in ("element", "type", "text"):
            return replace(film, legend=part.legend())
    expected = "particles coloured by a column, by element or by type"
    raise RequestError(f"colorbar: expected {expected}")


def _with_bar(film: Film, part: Representation) -> Film:
    reach, clim = part.meaning.reach, film.colorbar_clim or part.meaning.clim
    if reach is None or clim is None:
        return replace(film, colorbar="")
    of = LOGARITHM.fullmatch(part.source.title)
    log: Any = film.colorbar_log or (of[1] if of and _is_whole(of[2]) else "")
    label = film.colorbar
    if of and " ".join(label.split()) == part.source.title:
        label = of[2]  # the ticks are its values, not their logarithms
    return replace(
        film,
        colorbar=label,
        colorbar_cmap=film.colorbar_cmap or part.cmap,
        colorbar_clim=clim,
        colorbar_log=log,
        colorbar_ends=(reach[0] < clim[0], reach[1] > clim[1]),
    )


def _is_whole(inside: str) -> bool:
    """Whether brackets that are opened in it are closed in it."""
    depth = 0
    for character in inside:
        depth += {"(": 1, ")": -1}.get(character, 0)
        if depth < 0:
            return False
    return depth == 0
