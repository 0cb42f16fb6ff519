"""Film: the settings that turn gathered light into a picture."""

import math
from collections.abc import Sequence
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


def _line(struct: msgspec.Struct, key: str) -> None:
    given = getattr(struct, key)
    good = isinstance(given, str) and given.isprintable()
    require(good, key, "a line of text", given)


OUTLINE = 100.0
"""The widest, in pixels: a region is rendered with a margin of half as many."""


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
    """For previews: neighbours that show the same spheres share the noise of few samples."""
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
    cells: Sequence[Cell] = ()
    """Boxes whose edges are drawn."""

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
        _line(self, "colorbar")
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
