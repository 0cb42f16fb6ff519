"""View: a camera that sees all of a figure."""

import math
from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np

from clrt.errors import RequestError
from clrt.scene import Camera
from clrt.spheres import Spheres
from clrt.values import Array, Vec3

VIEWS: dict[str, Vec3] = {
    "iso": (1.0, 1.0, 1.0),
    "x": (1.0, 0.0, 0.0),
    "-x": (-1.0, 0.0, 0.0),
    "y": (0.0, 1.0, 0.0),
    "-y": (0.0, -1.0, 0.0),
    "z": (0.0, 0.0, 1.0),
    "-z": (0.0, 0.0, -1.0),
}
"""Where the camera stands, as seen from the middle."""

FOV = 30.0
"""Of a perspective camera, degrees."""

Projection = Literal["orthographic", "perspective"]
PROJECTIONS: tuple[Projection, ...] = get_args(Projection)


def direction(view: str | Sequence[float]) -> Vec3:
    """The way from the middle to the camera.

    Raises:
        RequestError: it is no view.
    """
    if isinstance(view, str) and view in VIEWS:
        return VIEWS[view]
    try:
        x, y, z = map(float, view)
        good = all(map(math.isfinite, (x, y, z))) and any((x, y, z))
    except (TypeError, ValueError):
        good = False
    if not good:
        expected = f"one of {', '.join(VIEWS)} or three numbers"
        raise RequestError(f"view: expected {expected}, got {view!r}")
    return x, y, z


def holding(
    spheres: Spheres,
    corners: Array,
    towards: Vec3,
    size: tuple[int, int],
    projection: Projection = "orthographic",
    margin: float = 0.0,
) -> Camera:
    """The nearest camera that sees all of some spheres and points, or the smallest height of it.

    Args:
        corners: (n, 3), the points.
        towards: the way from the middle to the camera. Up is +z, or +y if it goes along z.
        size: of the picture, columns and rows.
        margin: the part of the picture that stays free at each of its sides.

    Raises:
        RequestError: there is nothing to see.
    """
    if len(spheres) + len(corners) == 0:
        raise RequestError("particles: expected at least one, got none")
    up = (0.0, 1.0, 0.0) if towards[0] == towards[1] == 0 else (0.0, 0.0, 1.0)
    axes = np.array(Camera(towards, (0.0, 0.0, 0.0), up).basis())
    aspect = size[0] / size[1]
    inner = 1 - 2 * margin  # the part of the picture that is to be filled
    if projection == "orthographic":
        low, high = _extent(spheres, corners, axes)
        middle, extent = low / 2 + high / 2, high - low
        height = float(max(extent[1], extent[0] / aspect) / inner)
        ahead = max(extent[2], height)
        look_at = middle @ axes
        position = look_at + ahead * axes[2]
        return Camera(_point(position), _point(look_at), up, projection=projection, height=height)
    half = math.tan(math.radians(FOV / 2)) * inner
    slopes = np.array([half, half / aspect])
    # The sides of the cone of view that touch what they hold: x + t z + r sqrt(1 + t^2) is largest
    # there, z being towards the camera, and all four go through where the camera is.
    sides = [
        [_extent(spheres, corners, axes[[i]] * sign + slope * axes[2])[1][0] for sign in (1, -1)]
        for i, slope in enumerate(slopes)
    ]
    x, y = (float(a - b) / 2 for a, b in sides)
    z = max(float(a + b) / (2 * slope) for (a, b), slope in zip(sides, slopes, strict=True))
    low, high = _extent(spheres, corners, axes[[2]])
    position = np.array([x, y, z])
    look_at = np.array([x, y, float(low[0] / 2 + high[0] / 2)])
    return Camera(_point(position @ axes), _point(look_at @ axes), up, FOV)


def extent(spheres: Spheres, corners: Array) -> float:
    """The longest side of the box around spheres and points, along the axes of the world."""
    low, high = _extent(spheres, corners, np.eye(3))
    return float((high - low).max())


def _extent(spheres: Spheres, corners: Array, axes: Array) -> tuple[Array, Array]:
    """The least and the largest value along each of some axes, (m,) each, of spheres and points.

    axes: (m, 3), of any length: along one of length l a sphere reaches l r from its middle.
    """
    length = np.linalg.norm(axes, axis=1)
    low, high = np.full(len(axes), np.inf), np.full(len(axes), -np.inf)
    for i, axis in enumerate(axes):
        # Not a product of matrices: what that rounds to depends on how they lie in memory.
        x, y, z = (part * one for part, one in zip(spheres.center.T, axis, strict=True))
        along = x + y + z
        reach = length[i] * spheres.radius
        points = corners @ axis
        low[i] = min((along - reach).min(initial=np.inf), points.min(initial=np.inf))
        high[i] = max((along + reach).max(initial=-np.inf), points.max(initial=-np.inf))
    return low, high


def _point(array: Array) -> Vec3:
    x, y, z = map(float, array)
    return x, y, z
