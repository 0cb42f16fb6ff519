"""Panel: the colour bar, or the legend, at the right of a picture.

All its lengths are in ems, and an em is a part of the picture: so it looks alike at every size.
"""

import functools
from typing import TYPE_CHECKING

import numpy as np

from clrt.film import color
from clrt.film.decor.lettering import font, legible
from clrt.film.decor.ticks import ticks
from clrt.film.develop import Marks
from clrt.particles import palette
from clrt.scene.film import Film
from clrt.values import BLACK, Array, Color

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

SIDE = 36
"""The picture's smaller side, in ems."""
LEAST = 7.0
"""Of an em, pixels: less cannot be read."""
LENGTH = 0.6
"""Of the bar, of the picture's height."""
APART = 2.5
"""Ticks, at least, in ems."""
LINE = 1.6
"""From one entry of a legend to the next, in ems."""
MARGIN, BAR, TICK, GAP = 1.0, 1.0, 0.3, 0.4
"""In ems."""


def marks(
    look: Film,
    size: tuple[int, int],
    region: tuple[int, int, int, int],
    ink: Color,
    ground: Color | None,
) -> Marks:
    """The legend of `look`, or if it has none its colour bar, in a region of a picture.

    Args:
        look: with colorbar, and with colorbar_clim if it has no legend.
        size: of the whole picture, columns and rows.
        region: (x0, y0, x1, y1) of it.
        ink: of lines and text, linear.
        ground: the background, linear; around lines and text it covers the picture a little. None:
            it is not known.
    """
    width, height = size
    left, top, right, bottom = region
    painted = _painted(look, width, height, ink, ground)
    start = width - painted.shape[1]  # where the panel begins
    cut = painted[top:bottom, max(left - start, 0) : max(right - start, 0)]
    row, column = np.nonzero(np.ones(cut.shape[:2]) if look.colorbar_room else cut[..., 3])
    pixel = row * (right - left) + column + max(start - left, 0)
    return Marks(pixel, cut[row, column], look.colorbar_room)


def room(look: Film, size: tuple[int, int]) -> int:
    """How many columns at the right of a picture it takes."""
    columns: int = _painted(look, *size, BLACK, None).shape[1]
    return columns


@functools.lru_cache(4)  # frames of an animation have the same one
def _painted(look: Film, width: int, height: int, ink: Color, ground: Color | None) -> Array:
    """(height, at most width, 4) float32, premultiplied: the right of the picture."""
    draw = _legend if look.legend else _bar
    canvas = draw(look, height, max(min(width, height) / SIDE, LEAST))
    return canvas.painted(ink, ground)[:, -width:]


class _Canvas:
    """Boxes of colours, and the ink."""

    def __init__(self, width: float, height: int, em: float) -> None:
        from PIL import Image, ImageDraw

        self.em, self.width, self.height = em, round(width), height
        self._boxes = np.zeros((height, self.width, 4), np.float32)
        self._ink = Image.new("L", (self.width, height))
        self._draw = ImageDraw.Draw(self._ink)
        self._thin = max(round(em / 15), 1)
        self._font = font(em)
        self._digit = -self._font.getbbox("0", anchor="ls")[1]

    def box(self, x0: float, y0: float, x1: float, y1: float, colors: Array) -> None:
        """A box with a frame; a colour for each of its rows, linear, or one for all."""
        left, top, right, bottom = (max(round(at), 0) for at in (x0, y0, x1, y1))
        self._boxes[top:bottom, left:right, :3] = colors[: self.height, np.newaxis]
        self._boxes[top:bottom, left:right, 3] = 1
        thin = self._thin
        around = left - thin, top - thin, right + thin - 1, bottom + thin - 1
        self._draw.rectangle(around, outline=255, width=thin)

    def tick(self, x0: float, x1: float, y: float) -> None:
        top = round(y - self._thin / 2)
        self._draw.rectangle((round(x0), top, round(x1) - 1, top + self._thin - 1), fill=255)

    def write(self, x: float, y: float, text: str, anchor: str = "l") -> None:
        """A text that starts at x, or ends there if its anchor is "r"; y is its digits' middle."""
        where = round(x), round(y + self._digit / 2)
        self._draw.text(where, text, fill=255, font=self._font, anchor=f"{anchor}s")

    def write_upward(self, x: float, text: str) -> None:
        """A turned text whose digits' middle is x, at half the height; smaller if it has to be."""
        from PIL import Image, ImageDraw

        letters, most = self._font, self.height - 2 * MARGIN * self.em
        while letters.getlength(text) > most and letters.size > LEAST / 2:
            letters = font(0.95 * letters.size)
        strip = Image.new("L", (self.height, round(2 * self.em)))
        where = self.height / 2, self.em + self._digit / 2
        ImageDraw.Draw(strip).text(where, text, fill=255, font=letters, anchor="ms")
        turned = strip.transpose(Image.Transpose.ROTATE_90)
        self._ink.paste(255, (round(x - self.em), 0), turned)

    def painted(self, ink: Color, ground: Color | None) -> Array:
        """(height, width, 4) float32, premultiplied."""
        from PIL import ImageFilter

        found = np.zeros_like(self._boxes)
        if ground is not None:
            rim = self._ink
            for _ in range(max(round(self.em / 12), 1)):  # pixel by pixel, which is quicker
                rim = rim.filter(ImageFilter.MaxFilter(3))
            found = _layer(np.asarray(rim), ground)
        found = found * (1 - self._boxes[..., 3:]) + self._boxes
        drawn = _layer(np.asarray(self._ink), ink)
        painted: Array = found * (1 - drawn[..., 3:]) + drawn
        return painted


def _layer(coverage: Array, ink: Color) -> Array:
    share = (coverage / np.float32(255)).astype(np.float32)
    found: Array = share[..., np.newaxis] * np.array((*ink, 1), np.float32)
    return found


def _longest(letters: "FreeTypeFont", texts: list[str]) -> float:
    return max((letters.getlength(text) for text in texts), default=0.0)


def _bar(look: Film, height: int, em: float) -> _Canvas:
    assert look.colorbar_clim is not None  # a scene that has none is refused
    low, high = look.colorbar_clim
    length = max(round(LENGTH * height), 1)
    scale = ticks(low, high, max(int(length / (APART * em)), 2))
    letters, label = font(em), legible(look.colorbar).strip()
    # From the left: margin, bar, ticks, numbers, label, margin.
    number = (MARGIN + BAR + TICK + GAP) * em
    end = number + _longest(letters, list(scale.texts))
    spare = max(MARGIN * em + letters.getlength(scale.note) - end, 0)
    after = ((GAP + 1) * em if label else 0) + MARGIN * em
    canvas = _Canvas(end + after + spare, height, em)
    top, left = (height - length) // 2, spare + MARGIN * em
    part = (np.arange(length, 0, -1) - 0.5) / length
    values = np.clip(low * (1 - part) + high * part, low, high)
    srgb = palette.of_values(values, look.colorbar_cmap or "viridis", (low, high))
    canvas.box(left, top, left + BAR * em, top + length, color.linear(srgb))
    for part_of_it, text in zip(scale.parts, scale.texts, strict=True):
        y = top + (1 - part_of_it) * length
        canvas.tick(left + BAR * em, left + (BAR + TICK) * em, y)
        canvas.write(spare + number, y, text)
    canvas.write(spare + end, top - 1.5 * em, scale.note, "r")
    if label:
        canvas.write_upward(canvas.width - (MARGIN + 0.5) * em, label)
    return canvas


def _legend(look: Film, height: int, em: float) -> _Canvas:
    title = legible(look.colorbar).strip()
    room = max(int((height / em - 2 * MARGIN) / LINE) - bool(title), 1)
    shown = look.legend if len(look.legend) <= room else look.legend[: room - 1]
    names = [legible(entry.name) for entry in shown]
    more = [f"and {len(look.legend) - len(shown)} more"] if len(shown) < len(look.legend) else []
    letters = font(em)
    named = (MARGIN + BAR + GAP) * em
    end = max(named + _longest(letters, names), MARGIN * em + _longest(letters, [title, *more]))
    canvas = _Canvas(end + MARGIN * em, height, em)
    lines = len(names) + len(more) + bool(title)
    y = (height - (lines - 1) * LINE * em) / 2
    if title:
        canvas.write(MARGIN * em, y, title)
        y += LINE * em
    for entry, name in zip(shown, names, strict=True):
        half = BAR * em / 2
        box = MARGIN * em, y - half, MARGIN * em + 2 * half, y + half
        canvas.box(*box, np.array([entry.color], np.float32))
        canvas.write(named, y, name)
        y += LINE * em
    for text in more:
        canvas.write(MARGIN * em, y, text)
    return canvas
