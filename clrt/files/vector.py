"""Vector files: a picture as pixels, and the words and shapes over it as such, by matplotlib."""

from importlib.util import find_spec
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from clrt.errors import RequestError
from clrt.film import color
from clrt.film.decor.drawing import Box, Drawing, Overlay, Rule, Shape, Stroke, Wedge, Words
from clrt.film.decor.lettering import digit
from clrt.scene.film import EXTRA
from clrt.values import Array, Color

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SUFFIXES = (".svg", ".pdf")
POINTS = 8.0
"""Of an em, on the page."""
LEAST_SIDE = 36
"""Of the smaller side of a picture without words, in such ems."""
STYLE: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "mathtext.fontset": "dejavusans",
    "svg.fonttype": "none",  # text stays text
    "svg.hashsalt": "clrt",  # and the same picture the same file
    "pdf.fonttype": 42,
    "text.usetex": False,
    "path.simplify": False,
}


def check(path: Path) -> None:
    """Finds out whether a vector file could be written.

    Raises:
        RequestError: matplotlib is not there.
    """
    if find_spec("matplotlib") is None:
        raise RequestError(f"{path}: {path.suffix} needs matplotlib: {EXTRA}")


def write(path: Path, suffix: str, film: Array, overlay: Overlay | None, transfer: str) -> None:
    """Writes a picture and what is drawn over it. An em is 8 points on the page.

    Args:
        path: where to.
        suffix: ".svg" or ".pdf".
        film: (height, width, 3 or 4) uint8, straight.
        transfer: of the film, which its inks have as well.
    """
    import matplotlib
    from matplotlib.figure import Figure

    height, width = film.shape[:2]
    ems = [drawing.em for drawing in overlay.drawings] if overlay else []
    scale = POINTS / (ems[0] if ems else min(height, width) / LEAST_SIDE)
    with matplotlib.rc_context(STYLE):
        page = Figure(figsize=(width * scale / 72, height * scale / 72), dpi=72)
        axes = page.add_axes((0, 0, 1, 1))
        axes.set_axis_off()
        axes.imshow(film, extent=(0, width, height, 0), interpolation="none", aspect="auto")
        if overlay is not None:
            pen = _Pen(axes, scale, overlay, transfer)
            for drawing in overlay.drawings:
                pen.draw(drawing)
        axes.set_xlim(0, width)
        axes.set_ylim(height, 0)
        dates = {"Date": None} if suffix == ".svg" else {"CreationDate": None}
        page.savefig(path, format=suffix[1:], metadata=dates, transparent=True)


class _Pen:
    """Draws shapes on a page, whose unit is a pixel of the picture."""

    def __init__(self, axes: "Axes", scale: float, overlay: Overlay, transfer: str) -> None:
        self.axes, self.scale, self.transfer = axes, scale, transfer
        self.ink = self._srgb(overlay.ink)
        self.ground = None if overlay.ground is None else self._srgb(overlay.ground)
        self.order = 1

    def draw(self, drawing: Drawing) -> None:
        if drawing.room is not None:
            if self.ground is not None:
                self._fill(*drawing.room, self.ground)
        elif self.ground is not None:
            for shape in drawing.shapes:
                self._draw(shape, self.ground, max(round(drawing.em / 12), 1))
        for shape in drawing.shapes:
            self._draw(shape, self.ink, 0)

    def _draw(self, shape: Shape, ink: Any, rim: int) -> None:
        """In ink, so much wider at each side."""
        self.order += 1
        if isinstance(shape, Words):
            self._write(shape, ink, rim)
        elif isinstance(shape, Rule):
            x0, y0, x1, y1 = shape
            self._fill(x0 - rim, y0 - rim, x1 + rim, y1 + rim, ink)
        elif isinstance(shape, Stroke):
            self._line(shape, ink, rim)
        elif isinstance(shape, Box):
            more = shape.thin + rim
            self._fill(
                *(shape.left - more, shape.top - more, shape.right + more, shape.bottom + more), ink
            )
            if not rim:
                self._colors(shape)
        else:
            self._wedge(shape, ink, rim)

    def _write(self, words: Words, ink: Any, rim: int) -> None:
        from matplotlib.patheffects import Stroke as Outline

        below = digit(words.em) / 2
        x, y = (words.x + below, words.y) if words.upward else (words.x, words.y + below)
        anchor = {"l": "left", "m": "center", "r": "right"}["m" if words.upward else words.anchor]
        wide = 2 * rim * self.scale
        self.axes.text(
            x,
            y,
            words.text,
            fontsize=words.em * self.scale,
            color=ink,
            rotation=90 if words.upward else 0,
            horizontalalignment="right" if words.upward else anchor,
            verticalalignment="center" if words.upward else "baseline",
            zorder=self.order,
            path_effects=[Outline(linewidth=wide, foreground=ink)] if rim else None,
        )

    def _line(self, stroke: Stroke, ink: Any, rim: int) -> None:
        self.axes.plot(
            [stroke.x0, stroke.x1],
            [stroke.y0, stroke.y1],
            color=ink,
            linewidth=(stroke.width + 2 * rim) * self.scale,
            solid_capstyle="round",
            zorder=self.order,
        )

    def _fill(self, x0: float, y0: float, x1: float, y1: float, ink: Any) -> None:
        from matplotlib.patches import Rectangle

        self.order += 1
        box = Rectangle((x0, y0), x1 - x0, y1 - y0, color=ink, linewidth=0, zorder=self.order)
        self.axes.add_patch(box)

    def _colors(self, box: Box) -> None:
        """Each colour from where it begins to the other end, over the one before: without gaps."""
        first = 0
        for shade, some in groupby(box.colors):
            x, y = (box.left + first, box.top) if box.across else (box.left, box.top + first)
            self._fill(x, y, box.right, box.bottom, self._srgb(shade))
            first += len(list(some))

    def _wedge(self, wedge: Wedge, ink: Any, rim: int) -> None:
        from matplotlib.patches import Polygon

        if not rim:
            corners = [wedge.base0, wedge.tip, wedge.base1]
            inside = Polygon(corners, color=self._srgb(wedge.color), linewidth=0, zorder=self.order)
            self.axes.add_patch(inside)
            self.order += 1
        for start in (wedge.base0, wedge.base1):
            self._line(Stroke(*start, *wedge.tip, wedge.thin), ink, rim)

    def _srgb(self, linear: Color) -> Any:
        given = np.clip(np.array(linear, float), 0, 1)
        return tuple((color.to_srgb(given) if self.transfer == "srgb" else given).tolist())
