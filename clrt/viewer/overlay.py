"""Overlay: what is drawn over a picture, in files of its own: so it is sharp and stays where it is
while the picture under it is small."""

import io
from typing import Any, NamedTuple

import numpy as np
from msgspec.structs import replace
from PIL import Image

from clrt.film import develop
from clrt.film.decor import decorations
from clrt.film.develop import Marks, Seen
from clrt.scene.film import Film
from clrt.scene.scene import Scene
from clrt.values import Array
from clrt.viewer.orbit import Size

RUNS = 3
"""zlib's strategy Z_RLE: the quickest where most is empty."""


class Layer(NamedTuple):
    """A PNG with alpha, and where in the picture it begins."""

    x: int
    y: int
    file: bytes


STILL: dict[str, Any] = {"colorbar": "", "legend": (), "title": "", "label": ""}
"""What a film has without marks that stay where they are, whatever the camera."""
MOVING: dict[str, Any] = {"cells": (), "labels": (), "scalebar": None, "axes": ""}
"""Without those that go with it."""


def bare(scene: Scene) -> Scene:
    """A scene with nothing over its picture."""
    return replace(scene, film=replace(scene.film, **STILL, **MOVING))


def needs_depth(film: Film) -> bool:
    """Whether spheres hide some of it."""
    return bool(film.cells or film.labels)


class Overlay:
    """What is over the pictures of one page. What no camera changes is drawn once."""

    def __init__(self) -> None:
        self._still: tuple[Film, Size] | None = None
        self._kept: list[Layer] = []

    def layers(self, scene: Scene, size: Size, depth: Array | None) -> list[Layer]:
        """One over the other.

        depth: of the picture's pixels, as of the pass, in a picture of any size; if needed.
        """
        film = scene.film
        if not develop.has_marks(film):
            return []
        # A scale bar and axes are beside the colour bar: then all is drawn together.
        together = film.scalebar is not None or bool(film.axes)
        moving = film if together else replace(film, **STILL)
        layers = []
        if develop.has_marks(moving):
            seen = None if depth is None else _seen(_enlarged(depth, size))
            layers = _layers(replace(scene, film=moving), size, seen)
        if together:
            return layers
        still = replace(film, **MOVING)
        if self._still != (still, size):
            self._kept = _layers(replace(scene, film=still), size, None)
            self._still = still, size
        return [*layers, *self._kept]


def _seen(depth: Array) -> Seen:
    """Depths as what draws over pictures takes them; it asks for nothing else."""
    nothing = np.zeros(0)
    return Seen(nothing, depth, nothing, np.s_[:, :])


def _enlarged(depth: Array, size: Size) -> Array:
    """Each pixel has that of the nearest one."""
    width, height = size
    rows = (np.arange(height) + 0.5) * (len(depth) / height)
    columns = (np.arange(width) + 0.5) * (depth.shape[1] / width)
    found: Array = depth[rows.astype(np.intp)[:, np.newaxis], columns.astype(np.intp)]
    return found


def _layers(scene: Scene, size: Size, seen: Seen | None) -> list[Layer]:
    whole, alpha = (0, 0, *size), scene.film.transparent
    marks = decorations.marks(scene, size, whole, alpha, seen)
    return [_layer(each, size[0], scene.film) for each in marks if len(each.pixel)]


def _layer(marks: Marks, width: int, film: Film) -> Layer:
    row, column = np.divmod(marks.pixel, width)
    x, y = int(column.min()), int(row.min())
    linear = marks.color[np.newaxis]
    if marks.hides:
        ground = develop.on_background(linear, film.background)
        linear = np.concatenate([ground, np.ones_like(linear[..., :1])], axis=2)
    colors = develop.integers(linear, np.dtype(np.uint8), film.transfer)[0]
    colors[:, 3] = _alphas(colors.astype(float), linear, film)
    kinds, which = np.unique(colors.view(np.uint32)[:, 0], return_inverse=True)
    shape = int(row.max()) - y + 1, int(column.max()) - x + 1
    file = io.BytesIO()
    if len(kinds) < 256:  # the first one is nothing
        drawn = np.zeros(shape, np.uint8)
        drawn[row - y, column - x] = which + 1
        picture = Image.fromarray(drawn, "P")
        picture.putpalette(bytes(4) + kinds.tobytes(), "RGBA")
    else:
        whole = np.zeros((*shape, 4), np.uint8)
        whole[row - y, column - x] = colors
        picture = Image.fromarray(whole)
    picture.save(file, "PNG", compress_level=1, compress_type=RUNS)
    return Layer(x, y, file.getvalue())


def _alphas(colors: Array, linear: Array, film: Film) -> Array:
    """Alphas (n,) with which bytes give, mixed as pages mix them, over the background what clrt
    gives in linear light: thin dark lines were twice as dark."""
    byte = np.dtype(np.uint8)
    mixed = develop.integers(develop.on_background(linear, film.background), byte, film.transfer)
    ground = np.array([[film.background]], np.float32)
    below = develop.integers(ground, byte, film.transfer)[0, 0].astype(float)
    apart = colors[:, :3] - below
    channel = abs(apart).argmax(axis=1)[:, np.newaxis]
    full = np.take_along_axis(apart, channel, 1)[:, 0]
    part = np.take_along_axis(mixed[0] - below, channel, 1)[:, 0]
    alike = abs(full) < 8  # the quotient would say nothing
    found: Array = np.where(alike, colors[:, 3], 255 * part / np.where(alike, 1, full))
    rounded: Array = np.rint(np.clip(found, 0, 255))
    return rounded
