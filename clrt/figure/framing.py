"""Framing: a camera that sees all of a figure."""

import math
from collections.abc import Iterable, Sequence
from typing import Literal, get_args

import numpy as np

from clrt.errors import RequestError
from clrt.scene import lens
from clrt.scene.camera import Camera
from clrt.scene.spheres import Spheres
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
    parts: Iterable[Spheres],
    corners: Array,
    towards: Vec3,
    size: tuple[int, int],
    projection: Projection = "orthographic",
    margin: float = 0.0,
    room: float = 0.0,
) -> Camera:
    """The nearest camera that sees all of some spheres and points, or the smallest height of it.

    Args:
        parts: the spheres; they are gone through once.
        corners: (n, 3), the points.
        towards: the way from the middle to the camera. Up is +z, or +y if it goes along z.
        size: of the picture, columns and rows.
        margin: the part of the picture that stays free at each of its sides.
        room: the part that stays free at its right as well, for a colour bar.

    Raises:
        RequestError: there is nothing to see.
    """
    up = (0.0, 1.0, 0.0) if towards[0] == towards[1] == 0 else (0.0, 0.0, 1.0)
    axes = np.array(Camera(towards, (0.0, 0.0, 0.0), up).basis())
    aspect = size[0] / size[1]
    # How far from the middle of the picture what is held may reach to the right, to the left and
    # up, in halves of its width and height.
    inner = 1 - 2 * margin
    reach = np.array([[inner - 2 * room, inner], [inner, inner]])
    if projection == "orthographic":
        low, high = _extent(parts, corners, axes)
        extent = high - low
        height = float((extent[:2] / (aspect, 1) / reach.sum(axis=1)).max()) * 2
        half = height / 2 * np.array([aspect, 1])
        middle = low / 2 + high / 2
        middle[:2] += half * (reach[:, 1] - reach[:, 0]) / 2
        look_at = middle @ axes
        position = look_at + max(extent[2], height) * axes[2]
        return Camera(_point(position), _point(look_at), up, projection=projection, height=height)
    # Each side of the cone of view touches what it holds where x + t z + r sqrt(1 + t^2) is
    # largest, t being its slope and z towards the camera; and it goes through where that is.
    slopes = math.tan(math.radians(FOV / 2)) * reach / [[1], [aspect]]
    outward = [
        sign * axes[i] + slopes[i, j] * axes[2] for i in range(2) for j, sign in enumerate((1, -1))
    ]
    low, high = _extent(parts, corners, np.array([*outward, axes[2]]))
    sides = high[:4].reshape(2, 2)
    z = (sides.sum(axis=1) / slopes.sum(axis=1)).max()
    x, y = (sides[:, 0] - slopes[:, 0] * z + slopes[:, 1] * z - sides[:, 1]) / 2
    position = np.array([x, y, z])
    look_at = np.array([x, y, low[4] / 2 + high[4] / 2])
    return Camera(_point(position @ axes), _point(look_at @ axes), up, FOV)


def extent(spheres: Spheres, corners: Array) -> float:
    """The longest side of the box around spheres and points, along the axes of the world."""
    low, high = _extent([spheres], corners, np.eye(3))
    return float((high - low).max())


def _extent(parts: Iterable[Spheres], corners: Array, axes: Array) -> tuple[Array, Array]:
    """The least and the largest value along each of some axes, (m,) each, of spheres and points.

    axes: (m, 3), of any length: along one of length l a sphere reaches l r from its middle.

    Raises:
        RequestError: there are none.
    """
    length = np.linalg.norm(axes, axis=1)
    along = corners @ axes.T
    low, high = along.min(axis=0, initial=np.inf), along.max(axis=0, initial=-np.inf)
    for spheres in parts:
        for block in lens.blocks(len(spheres)):
            center, radius = (
                spheres.center[block].astype(float).T,
                spheres.radius[block].astype(float),
            )
            for i, (x, y, z) in enumerate(axes):
                # Not a product of matrices: what it rounds to depends on how they lie in memory.
                middle, reach = center[0] * x + center[1] * y + center[2] * z, length[i] * radius
                low[i] = min(low[i], (middle - reach).min())
                high[i] = max(high[i], (middle + reach).max())
    if low[0] > high[0]:
        raise RequestError("particles: expected at least one, got none")
    return low, high


def _point(array: Array) -> Vec3:
    x, y, z = map(float, array)
    return x, y, z
