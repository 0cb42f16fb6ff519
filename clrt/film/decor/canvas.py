"""Canvas: drawings as pixels."""

import functools
from math import ceil, floor
from typing import NamedTuple

import numpy as np

from clrt.film.decor.drawing import Area, Box, Drawing, Rule, Shape, Stroke, Wedge, Words
from clrt.film.decor.lettering import Lettered, digit, lettered
from clrt.film.develop import Marks
from clrt.values import Array, Color


@functools.lru_cache(64)  # frames of an animation have the same ones
def marks(drawing: Drawing, region: Area, ink: Color, ground: Color | None) -> Marks:
    """A drawing in a region of a picture.

    Args:
        ink: of lines and text, linear.
        ground: the background, linear; around ink it covers the picture a little. None: it is not
            known.
    """
    left, top, right, bottom = region
    patch = _painted(drawing, ink, ground)
    down, aside = patch.top - top, patch.left - left  # from the region's corner to the patch's
    cut = patch.colors[
        max(-down, 0) : max(bottom - patch.top, 0), max(-aside, 0) : max(right - patch.left, 0)
    ]
    rows, columns = cut.shape[:2]
    row = (np.arange(rows) + max(down, 0)) * (right - left)
    pixel = (row[:, np.newaxis] + np.arange(columns) + max(aside, 0)).reshape(-1)
    color = cut.reshape(-1, 4)
    if drawing.room is not None:
        return Marks(pixel, color, True)
    there = np.flatnonzero(color[:, 3])
    return Marks(pixel[there], color[there])


class _Patch(NamedTuple):
    """A part of a picture, or a part beside it."""

    left: int
    top: int
    colors: Array
    """(height, width, 4) float32, premultiplied."""


def _painted(drawing: Drawing, ink: Color, ground: Color | None) -> _Patch:
    rims = max(round(drawing.em / 12), 1)
    bounds = drawing.room or _bounds(drawing.shapes, rims)
    left, top, right, bottom = bounds
    boxes = np.zeros((max(bottom - top, 0), max(right - left, 0), 4), np.float32)
    inked = np.zeros(boxes.shape[:2], np.uint8)
    for shape in drawing.shapes:
        if isinstance(shape, Box):
            _color(boxes, shape, left, top)
        elif isinstance(shape, Wedge):
            _wedge(boxes, shape, left, top)
        _ink(inked, shape, left, top)
    rim = inked if ground is None else _wider(_wider(inked, rims).T, rims).T
    colors = boxes.reshape(-1, 4)
    there = np.flatnonzero(rim)  # most of a panel is empty
    found = colors[there]
    if ground is not None:
        around = _layer(rim.reshape(-1)[there], ground)
        found += around * (1 - found[:, 3:])
    drawn = _layer(inked.reshape(-1)[there], ink)
    colors[there] = found * (1 - drawn[:, 3:]) + drawn
    return _Patch(left, top, boxes)


def _wider(inked: Array, by: int) -> Array:
    """The most ink of each pixel and of those so far above and below it."""
    found = inked.copy()
    for step in range(1, min(by + 1, len(inked))):
        np.maximum(found[step:], inked[:-step], out=found[step:])
        np.maximum(found[:-step], inked[step:], out=found[:-step])
    return found


def _layer(coverage: Array, ink: Color) -> Array:
    share = (coverage / np.float32(255)).astype(np.float32)
    found: Array = share[..., np.newaxis] * np.array((*ink, 1), np.float32)
    return found


def _bounds(shapes: tuple[Shape, ...], rims: int) -> Area:
    """Around shapes and the rims of their ink."""
    every = np.array([_around(shape) for shape in shapes])
    low, high = np.floor(every[:, :2].min(axis=0)), np.ceil(every[:, 2:].max(axis=0))
    x0, y0, x1, y1 = map(int, [*(low - rims), *(high + rims)])
    return x0, y0, x1, y1


def _around(shape: Shape) -> tuple[float, float, float, float]:
    if isinstance(shape, Words):
        coverage, left, top = _placed(shape)
        return left, top, left + coverage.shape[1], top + coverage.shape[0]
    if isinstance(shape, Stroke):
        reach = shape.width / 2 + 1
        (x0, x1), (y0, y1) = sorted((shape.x0, shape.x1)), sorted((shape.y0, shape.y1))
        return x0 - reach, y0 - reach, x1 + reach, y1 + reach
    if isinstance(shape, Wedge):
        x, y = zip(shape.base0, shape.tip, shape.base1, strict=True)
        reach = shape.thin + 1.0
        return min(x) - reach, min(y) - reach, max(x) + reach, max(y) + reach
    more = shape.thin if isinstance(shape, Box) else 0
    return shape.left - more, shape.top - more, shape.right + more, shape.bottom + more


def _placed(words: Words) -> tuple[Array, int, int]:
    """A text's pixels, and where the first one is."""
    found: Lettered = lettered(words.text, words.em)
    before = {"l": 0.0, "m": found.width / 2, "r": found.width}[
        "m" if words.upward else words.anchor
    ]
    below = digit(words.em) / 2
    if words.upward:
        coverage = np.rot90(found.coverage)
        start = round(words.y + before)
        return coverage, round(words.x + below) + found.top, start - found.left - len(coverage)
    return found.coverage, round(words.x - before) + found.left, round(words.y + below) + found.top


def _ink(inked: Array, shape: Shape, left: int, top: int) -> None:
    """Adds the ink of a shape to a part of a picture whose first pixel is there."""
    if isinstance(shape, Words):
        coverage, x, y = _placed(shape)
        _lay(inked, coverage, x - left, y - top)
    elif isinstance(shape, Stroke):
        _line(inked, shape, left, top)
    elif isinstance(shape, Wedge):
        for start in (shape.base0, shape.base1):
            _line(inked, Stroke(*start, *shape.tip, shape.thin), left, top)
    elif isinstance(shape, Box):
        x0, y0, x1, y1, more = *shape[:4], shape.thin
        for rule in (
            Rule(x0 - more, y0 - more, x1 + more, y0),
            Rule(x0 - more, y1, x1 + more, y1 + more),
            Rule(x0 - more, y0, x0, y1),
            Rule(x1, y0, x1 + more, y1),
        ):
            _ink(inked, rule, left, top)
    else:
        x0, y0, x1, y1 = shape
        inked[max(y0 - top, 0) : max(y1 - top, 0), max(x0 - left, 0) : max(x1 - left, 0)] = 255


def _lay(inked: Array, coverage: Array, x: int, y: int) -> None:
    """Coverage whose first pixel is there; what is outside is cut off."""
    height, width = coverage.shape
    there = inked[max(y, 0) : max(y + height, 0), max(x, 0) : max(x + width, 0)]
    part = coverage[max(-y, 0) :, max(-x, 0) :][: there.shape[0], : there.shape[1]]
    np.maximum(
        there[: part.shape[0], : part.shape[1]], part, out=there[: part.shape[0], : part.shape[1]]
    )


def _line(inked: Array, stroke: Stroke, left: int, top: int) -> None:
    """How much of each pixel is on it, by the distance of the pixel's middle."""
    x0, y0 = map(floor, _around(stroke)[:2])
    x1, y1 = map(ceil, _around(stroke)[2:])
    width, height = x1 - x0, y1 - y0
    x = np.arange(width) + (x0 + 0.5 - stroke.x0)
    y = (np.arange(height) + (y0 + 0.5 - stroke.y0))[:, np.newaxis]
    way = stroke.x1 - stroke.x0, stroke.y1 - stroke.y0
    length2 = max(way[0] ** 2 + way[1] ** 2, np.finfo(float).tiny)
    part = np.clip((x * way[0] + y * way[1]) / length2, 0, 1)
    away = np.hypot(x - part * way[0], y - part * way[1])
    share = np.clip(stroke.width / 2 + 0.5 - away, 0, 1)
    _lay(inked, np.rint(255 * share).astype(np.uint8), x0 - left, y0 - top)


def _color(boxes: Array, box: Box, left: int, top: int) -> None:
    colors = np.array(box.colors, np.float32)
    x0, y0 = box.left - left, box.top - top
    there = boxes[max(y0, 0) : max(box.bottom - top, 0), max(x0, 0) : max(box.right - left, 0)]
    if len(colors) > 1:
        first = max(-x0, 0) if box.across else max(-y0, 0)
        colors = colors[first : first + there.shape[1 if box.across else 0]]
    there[..., :3] = colors if box.across else colors[:, np.newaxis]
    there[..., 3] = 1


FINE = 4
"""Rows and columns in a pixel, of slanted sides."""


def _wedge(boxes: Array, wedge: Wedge, left: int, top: int) -> None:
    from PIL import Image, ImageDraw

    x0, y0 = map(floor, _around(wedge)[:2])
    x1, y1 = map(ceil, _around(wedge)[2:])
    fine = Image.new("L", (FINE * (x1 - x0), FINE * (y1 - y0)))
    points = [(FINE * (x - x0), FINE * (y - y0)) for x, y in wedge[:3]]
    ImageDraw.Draw(fine).polygon(points, fill=255)
    share = np.zeros(boxes.shape[:2], np.uint8)
    _lay(share, np.asarray(fine.reduce(FINE)), x0 - left, y0 - top)
    boxes += _layer(share, wedge.color) * (1 - boxes[..., 3:])
