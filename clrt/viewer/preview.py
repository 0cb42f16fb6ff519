"""Preview: spheres as shaded discs, by NumPy: what is seen until a program is there."""

from typing import NamedTuple

import numpy as np

from clrt.film import develop
from clrt.scene.lens import half_screen
from clrt.scene.scene import Scene
from clrt.scene.spheres import Spheres
from clrt.values import Array, Color

HEIGHT = 180
"""Rows, at most."""
PAINTED = 500_000
"""Pixels, at most, some more than once: the nearest spheres have them."""
LIT = (-0.4, 0.5, 0.77)
"""The way to the light: right, up and back of the camera."""
SHADE = 0.4
"""Of the light where it does not come."""


class _Discs(NamedTuple):
    """Spheres as they are seen, in pixels, the farthest first."""

    column: Array
    row: Array
    radius: Array
    color: Array
    """(n, 3), linear."""


def preview(scene: Scene, size: tuple[int, int]) -> Array:
    """A small picture of the shape of `size`, (height, width, 3) uint8. A nearer middle hides a
    farther one, and discs stay round at the edges of a wide view."""
    height = min(size[1], HEIGHT)
    width = max(round(size[0] * height / size[1]), 1)
    discs = _discs(scene, width, height)
    # The box of each, cut at the picture's edges.
    low = np.maximum(np.rint([discs.column - discs.radius, discs.row - discs.radius]), 0)
    high = np.rint([discs.column + discs.radius, discs.row + discs.radius]) + 1
    wide, high = np.maximum(np.minimum(high, [[width], [height]]) - low, 0).astype(np.int64)
    pixels = wide * high
    kept = np.cumsum(pixels[::-1])[::-1] <= PAINTED
    count = np.where(kept, pixels, 0)
    which = np.repeat(np.arange(len(count)), count)
    place = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    x, y = low[0, which] + place % wide[which], low[1, which] + place // wide[which]
    radius = discs.radius[which]
    right, down = (x - discs.column[which]) / radius, (y - discs.row[which]) / radius
    inside = np.flatnonzero(right**2 + down**2 <= 1)
    which, right, down = which[inside], right[inside], down[inside]
    towards = np.sqrt(1 - right**2 - down**2)
    facing = np.maximum(LIT[0] * right - LIT[1] * down + LIT[2] * towards, 0)
    light = SHADE + (1 - SHADE) * facing
    picture = np.tile(np.array(scene.film.background, np.float32), (height, width, 1))
    there = y[inside].astype(np.int64), x[inside].astype(np.int64)
    picture[there] = light[:, np.newaxis] * discs.color[which]  # of several the last one stays
    return develop.integers(picture, np.dtype(np.uint8), scene.film.transfer)


def _discs(scene: Scene, width: int, height: int) -> _Discs:
    spheres, camera = Spheres.of(scene.spheres), scene.camera
    axes = np.array(camera.basis())
    right, up, back = ((spheres.center - np.array(camera.position)) @ axes.T).T
    order = np.argsort(back, kind="stable")
    order = order[(back[order] < 0) | camera.orthographic]
    half = half_screen(camera, width, height).astype(float)
    ahead = 1.0 if camera.orthographic else -back[order]
    unit = (width - 1) / 2 / half[0] / ahead
    own = np.array([_color(scene, name) for name in spheres.names or list(scene.materials)])
    color = own.reshape(-1, 3)[spheres.material_index[order]]
    if spheres.color is not None:
        color = color * spheres.color[order]
    radius = np.clip(spheres.radius[order] * unit, 0.5, 1e6)
    column, row = (width - 1) / 2 + right[order] * unit, (height - 1) / 2 - up[order] * unit
    seen = (abs(column - width / 2) < width + radius) & (abs(row - height / 2) < height + radius)
    return _Discs(column[seen], row[seen], radius[seen], color[seen])


def _color(scene: Scene, material: str) -> Color:
    known = scene.materials.get(material)
    return (1.0, 1.0, 1.0) if known is None else known.diffuse
