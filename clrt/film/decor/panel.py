"""Panel: the colour bar, at the right of a picture or below it, or the legend.

All its lengths are in ems, and an em is a part of the picture: so it looks alike at every size.
"""

import functools
from collections.abc import Sequence

import numpy as np
from msgspec.structs import replace

from clrt.film import color
from clrt.film.decor.drawing import (
    LEAST,
    Area,
    Box,
    Drawing,
    Rule,
    Shape,
    Wedge,
    Words,
    em_of,
    thin,
)
from clrt.film.decor.lettering import width
from clrt.film.decor.ticks import Ticks, powers, ticks
from clrt.particles import palette
from clrt.scene.film import Film
from clrt.values import Color

LENGTH = 0.6
"""Of the bar, of the picture's height, or of its width where it is below."""
APART = 2.5
"""Ticks one above the other, at least, in ems."""
ASIDE = 5.0
"""Ticks side by side, likewise."""
LINE = 1.6
"""From one entry of a legend to the next, in ems."""
MARGIN, BAR, TICK, GAP = 1.0, 1.0, 0.3, 0.4
"""In ems."""


def drawing(look: Film, size: tuple[int, int]) -> Drawing:
    """The legend of `look`, or if it has none its colour bar.

    Args:
        look: with colorbar, and with colorbar_clim if it has no legend.
        size: of the picture, columns and rows.
    """
    shapes, area = _laid_out(_alone(look), size)
    return Drawing(shapes, em_of(look, size), area if look.colorbar_room else None)


def room(look: Film, size: tuple[int, int]) -> tuple[int, int]:
    """How many columns at the right of a picture it takes, and how many rows at its bottom."""
    left, top, right, bottom = _laid_out(_alone(look), size)[1]
    return (0, bottom - top) if _is_below(look) else (right - left, 0)


def _alone(look: Film) -> Film:
    """Without what differs from frame to frame, so that frames have the same one."""
    return replace(look, label="", labels=(), cells=())


def _is_below(look: Film) -> bool:
    return look.colorbar_side == "bottom" and not look.legend


@functools.lru_cache(4)  # frames of an animation have the same one
def _laid_out(look: Film, size: tuple[int, int]) -> tuple[tuple[Shape, ...], Area]:
    """The shapes, and what part of the picture they need."""
    (columns, rows), em = size, em_of(look, size)
    if _is_below(look):
        shapes, taken = _lying(look, size, em)
        return tuple(shapes), (0, max(rows - taken, 0), columns, rows)
    shapes, taken = (_legend if look.legend else _upright)(look, size, em)
    return tuple(shapes), (max(columns - taken, 0), 0, columns, rows)


def _scale(look: Film, most: int) -> Ticks:
    assert look.colorbar_clim is not None  # a scene that has none is refused
    low, high = look.colorbar_clim
    if look.colorbar_log:
        return powers(low, high, max(most, 2), 10 if look.colorbar_log == "log10" else np.e)
    return ticks(low, high, max(most, 2))


def _shades(look: Film, length: int) -> tuple[Color, ...]:
    """Linear, from the low end to the high one."""
    assert look.colorbar_clim is not None
    low, high = look.colorbar_clim
    part = (np.arange(length) + 0.5) / length
    values = np.clip(low * (1 - part) + high * part, low, high)
    srgb = palette.of_values(values, look.colorbar_cmap or "viridis", (low, high))
    return tuple(map(tuple, color.linear(srgb).tolist()))


def _upright(look: Film, size: tuple[int, int], em: float) -> tuple[list[Shape], int]:
    """A bar at the right, and how many columns it takes."""
    columns, height = size
    length = max(round(LENGTH * height), 1)
    scale = _scale(look, int(length / (APART * em)))
    label = look.colorbar.strip()
    # From the left: margin, bar, ticks, numbers, label, margin.
    number = (MARGIN + BAR + TICK + GAP) * em
    end = number + _longest(scale.texts, em)
    spare = max(MARGIN * em + width(scale.note, em) - end, 0)
    after = ((GAP + 1) * em if label else 0) + MARGIN * em
    taken = round(end + after + spare)
    start = columns - taken + spare
    left, right = (round(start + at * em) for at in (MARGIN, MARGIN + BAR))
    top = (height - length) // 2
    shades = _shades(look, length)
    shapes: list[Shape] = [Box(left, top, right, top + length, shades[::-1], thin(em))]
    middle, tip = (left + right) / 2, BAR * em
    for beyond, y, shade in zip((top + length, top), (tip, -tip), (0, -1), strict=True):
        if look.colorbar_ends[shade]:
            corners = (left, beyond), (middle, beyond + y), (right, beyond)
            shapes.append(Wedge(*corners, shades[shade], thin(em)))
    for part, text in zip(scale.parts, scale.texts, strict=True):
        y = top + (1 - part) * length
        first = round(y - thin(em) / 2)
        reach = TICK if text else TICK / 2
        shapes.append(Rule(right, first, round(right + reach * em), first + thin(em)))
        if text:
            shapes.append(Words(text, round(start + number), y, em))
    if scale.note:
        above = top - (1.5 + BAR * look.colorbar_ends[1]) * em
        shapes.append(Words(scale.note, round(start + end), above, em, "r"))
    if label:
        x, small = columns - (MARGIN + 0.5) * em, fitting(label, em, height - 2 * MARGIN * em)
        shapes.append(Words(label, x, height / 2, small, upward=True))
    return shapes, taken


def _lying(look: Film, size: tuple[int, int], em: float) -> tuple[list[Shape], int]:
    """A bar below, and how many rows it takes."""
    columns, height = size
    length = max(round(LENGTH * columns), 1)
    wide = ASIDE * em
    scale = _scale(look, int(length / wide))
    while (longest := _longest(scale.texts, em) + em) > wide and wide < length / 2:
        wide = longest
        scale = _scale(look, int(length / wide))
    label = look.colorbar.strip()
    # From above: margin, bar, ticks, numbers, label, margin.
    below = (MARGIN + BAR + TICK + GAP) * em
    taken = round(below + (1 + (GAP + 1) * bool(label)) * em + MARGIN * em)
    start, left = height - taken, (columns - length) // 2
    top, bottom = (round(start + at * em) for at in (MARGIN, MARGIN + BAR))
    shades = _shades(look, length)
    shapes: list[Shape] = [Box(left, top, left + length, bottom, shades, thin(em), across=True)]
    middle, tip = (top + bottom) / 2, BAR * em
    for beyond, x, shade in zip((left, left + length), (-tip, tip), (0, -1), strict=True):
        if look.colorbar_ends[shade]:
            corners = (beyond, top), (beyond + x, middle), (beyond, bottom)
            shapes.append(Wedge(*corners, shades[shade], thin(em)))
    for part, text in zip(scale.parts, scale.texts, strict=True):
        x = left + part * length
        first = round(x - thin(em) / 2)
        reach = TICK if text else TICK / 2
        shapes.append(Rule(first, bottom, first + thin(em), round(bottom + reach * em)))
        if text:
            shapes.append(Words(text, x, start + below + em / 2, em, "m"))
    if scale.note:
        x = left + length + (1 + BAR * look.colorbar_ends[1]) * em
        shapes.append(Words(scale.note, x, (top + bottom) / 2, em))
    if label:
        small = fitting(label, em, columns - 2 * MARGIN * em)
        y = height - (MARGIN + 0.5) * em
        shapes.append(Words(label, columns / 2, y, small, "m"))
    return shapes, taken


def _legend(look: Film, size: tuple[int, int], em: float) -> tuple[list[Shape], int]:
    """A legend at the right, and how many columns it takes."""
    columns, height = size
    title = look.colorbar.strip()
    lines = max(int((height / em - 2 * MARGIN) / LINE) - bool(title), 1)
    shown = look.legend if len(look.legend) <= lines else look.legend[: lines - 1]
    names = [entry.name for entry in shown]
    more = [f"and {len(look.legend) - len(shown)} more"] if len(shown) < len(look.legend) else []
    named = (MARGIN + BAR + GAP) * em
    end = max(named + _longest(names, em), MARGIN * em + _longest([title, *more], em))
    taken = round(end + MARGIN * em)
    start, shapes = columns - taken, list[Shape]()
    many = len(names) + len(more) + bool(title)
    y = (height - (many - 1) * LINE * em) / 2

    def write(text: str, x: float) -> None:
        shapes.append(Words(text, round(start + x), y, em))

    if title:
        write(title, MARGIN * em)
        y += LINE * em
    for entry, name in zip(shown, names, strict=True):
        half = BAR * em / 2
        x0, y0, x1, y1 = (
            *(round(start + MARGIN * em), round(y - half)),
            *(round(start + MARGIN * em + 2 * half), round(y + half)),
        )
        shapes.append(Box(x0, y0, x1, y1, (entry.color,), thin(em)))
        write(name, named)
        y += LINE * em
    for text in more:
        write(text, MARGIN * em)
    return shapes, taken


def fitting(text: str, em: float, most: float) -> float:
    """An em with which a text is not longer than so much, if there is one that can be read."""
    while width(text, em) > most and em > LEAST / 2:
        em *= 0.95
    return em


def _longest(texts: Sequence[str], em: float) -> float:
    return max((width(text, em) for text in texts), default=0.0)
