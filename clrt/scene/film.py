"""Film: the settings that turn gathered light into a picture."""

import math
import re
from collections.abc import Sequence
from importlib.util import find_spec
from string import Formatter
from typing import Literal

import msgspec
from msgspec.structs import force_setattr

from clrt.errors import RequestError, SceneError
from clrt.particles import palette
from clrt.values import (
    Color,
    Vec3,
    all_of,
    number,
    require,
    switches,
    vectors,
)


class LegendEntry(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A colour of a legend, and its name."""

    name: str
    color: Color

    def __post_init__(self) -> None:
        _line(self, "name")
        vectors(self, "color")


class Cell(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A box whose edges are drawn."""

    edges: tuple[Vec3, Vec3, Vec3]
    """A row for each of the three that meet in `origin`; (3, 3)."""
    origin: Vec3 = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        vectors(self, "origin")
        try:
            rows = tuple((float(x), float(y), float(z)) for x, y, z in self.edges)
            good = len(rows) == 3 and all(math.isfinite(x) for row in rows for x in row)
        except (TypeError, ValueError, OverflowError):
            good = False
        require(good, "edges", "three rows of three finite numbers", self.edges)
        force_setattr(self, "edges", rows)


EXTRA = "pip install 'clrt[text]'"


def is_math(text: str) -> bool:
    """Whether a text has dollar signs in pairs, between which formulas are. Written `\\$` one is
    no such sign."""
    signs = len(re.findall(r"(?<!\\)\$", text))
    return signs > 0 and signs % 2 == 0


def _line(struct: msgspec.Struct, key: str) -> None:
    given = getattr(struct, key)
    good = isinstance(given, str) and given.isprintable()
    require(good, key, "a line of text", given)
    if is_math(given) and find_spec("matplotlib") is None:
        raise SceneError(f"{key}: what is between $ needs matplotlib: {EXTRA}")


class Label(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A text at a place in the world."""

    text: str
    position: Vec3
    radius: float = 0.0
    """Of what it is on: it is hidden by what is nearer than that."""

    def __post_init__(self) -> None:
        _line(self, "text")
        vectors(self, "position")
        number(self, "radius", "a finite number from 0", lambda radius: radius >= 0)


def fields_of(template: str) -> list[str]:
    """The names in braces, as str.format() has them.

    Raises:
        ValueError: braces that have no other end.
    """
    return [name for _, name, _, _ in Formatter().parse(template) if name is not None]


OUTLINE = 100.0
"""The widest, in pixels: a region is rendered with a margin of half as many."""
CHOICES = {
    "colorbar_side": ("right", "bottom"),
    "colorbar_log": ("", "log10", "log"),
    "axes": ("", "xyz", "abc"),
}


class Film(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """The settings that turn gathered light into a picture: clrt.film.develop has the steps."""

    background: Color = (0.0, 0.0, 0.0)
    """The colour where a ray of the camera's leaves the scene, after mirrors as well."""
    transparent: bool = False
    """The picture has alpha in place of the background."""
    transfer: Literal["linear", "srgb"] = "linear"
    """The curve of integer films and files; floats are linear."""
    outline: float = 0.0
    """The width of the line around a sphere that stands before something else, pixels; 0: none."""
    outline_color: Color = (0.0, 0.0, 0.0)
    depth_cue: tuple[float, float] = (0.0, 0.0)
    """From the first depth to the second, world units, colours go over into the background. Two
    zeros: they do not."""
    denoise: bool = False
    """What is drawn at random is filtered, by what neighbours show, below 16 samples."""
    colorbar: str = ""
    """The label of a colour bar, or of a legend if there is one; " ": neither has one. "": none is
    drawn."""
    colorbar_cmap: str | None = None
    """The bar's colour map, by its name in clrt.palette; None: "viridis"."""
    colorbar_clim: tuple[float, float] | None = None
    """What the bar's ends stand for."""
    colorbar_room: bool = False
    """Nothing else is drawn where the bar or the legend is."""
    legend: Sequence[LegendEntry] = ()
    """Entries that are drawn instead of the bar."""
    colorbar_side: Literal["right", "bottom"] = "right"
    """Where the bar is; a legend is at the right."""
    colorbar_ends: tuple[bool, bool] = (False, False)
    """Whether there are values below its low end, and above its high one: marks there say so."""
    colorbar_log: Literal["", "log10", "log"] = ""
    """What is coloured is this logarithm of what its numbers are to be."""
    cells: Sequence[Cell] = ()
    """Boxes whose edges are drawn."""
    line_width: float = 1 / 540
    """Of those edges, of the picture's smaller side."""
    font_size: float = 1 / 36
    """Of text, an em, of the picture's smaller side."""
    title: str = ""
    """Above, in the middle."""
    label: str = ""
    """In the upper left corner. It can have fields in braces, as Python's str.format() has them:
    frame and time, and of files of particles step and columns that have one value."""
    labels: Sequence[Label] = ()
    """Texts at what is seen."""
    scalebar: float | Literal["auto"] | None = None
    """A length in world units that is drawn, if the camera is orthographic; "auto": a round one."""
    scalebar_label: str = ""
    """The text at it; with "auto" what follows the number."""
    axes: Literal["", "xyz", "abc"] = ""
    """Which ways are drawn in the lower left corner: the world's, or those of axes_edges."""
    axes_edges: tuple[Vec3, Vec3, Vec3] | None = None
    """A row for each of a, b and c."""

    def __post_init__(self) -> None:
        vectors(self, "background", "outline_color")
        switches(self, "transparent", "denoise", "colorbar_room")
        good = self.transfer in ("linear", "srgb")
        require(good, "transfer", "'linear' or 'srgb'", self.transfer)
        expected = f"a number from 0 to {OUTLINE:g}"
        number(self, "outline", expected, lambda width: 0 <= width <= OUTLINE)
        try:
            near, far = map(float, self.depth_cue)
            good = math.isfinite(near) and math.isfinite(far) and (near < far or near == far == 0)
        except (TypeError, ValueError, OverflowError):
            good = False
        require(good, "depth_cue", "two finite numbers, the first one less", self.depth_cue)
        force_setattr(self, "depth_cue", (near, far))
        all_of(self, "legend", LegendEntry, "a LegendEntry")
        all_of(self, "cells", Cell, "a Cell")
        all_of(self, "labels", Label, "a Label")
        for key in ("colorbar", "title", "label", "scalebar_label"):
            _line(self, key)
        try:
            fields_of(self.label)
        except ValueError as error:
            raise SceneError(f"label: {error}; a brace alone is written twice") from None
        for key, known in CHOICES.items():
            given = getattr(self, key)
            require(given in known, key, f"one of {', '.join(map(repr, known))}", given)
        ends = self.colorbar_ends
        good = isinstance(ends, Sequence) and len(ends) == 2 and set(ends) <= {True, False}
        require(good, "colorbar_ends", "true or false, twice", ends)
        force_setattr(self, "colorbar_ends", tuple(map(bool, ends)))
        number(self, "line_width", "a number from 0 to 0.1", lambda width: 0 <= width <= 0.1)
        number(self, "font_size", "a number above 0, at most 0.5", lambda size: 0 < size <= 0.5)
        if self.scalebar is not None and self.scalebar != "auto":
            number(self, "scalebar", "a finite number above 0, or 'auto'", lambda x: x > 0)
        if self.axes_edges is not None:
            force_setattr(self, "axes_edges", Cell(self.axes_edges).edges)
        good = self.colorbar_cmap is None or isinstance(self.colorbar_cmap, str)
        require(good, "colorbar_cmap", "the name of a colour map", self.colorbar_cmap)
        try:
            if self.colorbar_cmap is not None:
                palette.colormap(self.colorbar_cmap)
            if self.colorbar_clim is not None:
                clim = palette.check_limits(self.colorbar_clim)
                force_setattr(self, "colorbar_clim", clim)
        except RequestError as error:  # of cmap or clim
            raise SceneError(f"colorbar_{error}") from None
