"""Framing: a camera that sees all of a figure."""

import itertools
import math
import re
from collections.abc import Iterable, Sequence
from typing import Literal, get_args

import numpy as np

from clrt.errors import RequestError, SceneError
from clrt.scene import lens
from clrt.scene.camera import Camera
from clrt.scene.capsules import Capsules
from clrt.scene.spheres import Spheres
from clrt.values import Array, Vec3, did_you_mean

_AZIMUTH, _HEIGHT = math.radians(-60), math.radians(30)
VIEWS: dict[str, Vec3] = {
    "corner": (
        math.cos(_HEIGHT) * math.cos(_AZIMUTH),
        math.cos(_HEIGHT) * math.sin(_AZIMUTH),
        math.sin(_HEIGHT),
    ),
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


def direction(given: str | Sequence[float], key: str = "view") -> Vec3:
    """The way from the middle to the camera, or the way up.

    Args:
        given: a name of VIEWS, three numbers, or text of them, as "1,1,0" or "1 1 0".
        key: for errors.

    Raises:
        RequestError: it is no direction.
    """
    if isinstance(given, str) and given in VIEWS:
        return VIEWS[given]
    found = three(given)
    if found is None or not any(found):
        near = did_you_mean(given, VIEWS) if isinstance(given, str) else ""
        expected = f"one of {', '.join(VIEWS)} or three numbers, not all 0, as 1,1,0"
        raise RequestError(f"{key}: expected {expected}, got {given!r}{near}")
    return found


def point(given: str | Sequence[float], key: str) -> Vec3:
    """Three numbers, or text of them.

    Raises:
        RequestError: they are none.
    """
    found = three(given)
    if found is None:
        raise RequestError(f"{key}: expected three numbers, as 1,1,0, got {given!r}")
    return found


def three(given: str | Sequence[float]) -> Vec3 | None:
    """Three finite numbers; None if they are none."""
    try:
        parts = re.split(r"[\s,]+", given.strip(" \t()[]")) if isinstance(given, str) else given
        x, y, z = map(float, parts)
    except (TypeError, ValueError):
        return None
    return (x, y, z) if all(map(math.isfinite, (x, y, z))) else None


def is_flat(spheres: Spheres, corners: Array) -> bool:
    """Whether all middles have one z; where there are none, all corners."""
    z = spheres.center[:, 2] if len(spheres) else corners[:, 2]
    return bool((z == z[:1]).all())


def holding(
    parts: Iterable[Spheres],
    corners: Array,
    towards: Vec3,
    size: tuple[int, int],
    projection: Projection = "orthographic",
    margin: float = 0.0,
    room: tuple[float, float, float] = (0.0, 0.0, 0.0),
    up: Vec3 | None = None,
    zoom: float = 1.0,
    center: Vec3 | None = None,
) -> Camera:
    """The nearest camera that sees all of some spheres and points, or the smallest height of it.

    Args:
        parts: the spheres; they are gone through once.
        corners: (n, 3), the points.
        towards: the way from the middle to the camera.
        size: of the picture, columns and rows.
        margin: the part of the picture that stays free at each of its sides.
        room: the parts that stay free as well, for a colour bar or a title: at its right, at its
            bottom and at its top.
        up: None: +z, or +y if `towards` goes along z.
        zoom: how much larger all is than where all is in view.
        center: what is in the middle of what does not stay free; None: the middle of all.

    Raises:
        RequestError: there is nothing to see, or `up` goes along `towards`.
    """
    if up is None:
        up = (0.0, 1.0, 0.0) if towards[0] == towards[1] == 0 else (0.0, 0.0, 1.0)
    try:
        Camera(towards, (0.0, 0.0, 0.0), up)
    except SceneError:
        raise RequestError(f"up: expected a direction not along the view, got {up}") from None
    axes = np.array(Camera(towards, (0.0, 0.0, 0.0), up).basis())
    aspect = size[0] / size[1]
    # How far spheres and points may reach from the middle of the picture to the right, to the
    # left, up and down, in halves of its width and height.
    reach = 1 - 2 * margin - 2 * np.array([[room[0], 0], [room[2], room[1]]])
    seen = None if center is None else axes @ center
    if projection == "orthographic":
        low, high = _extent(parts, corners, axes)
        if seen is not None:
            half = np.maximum(high - seen, seen - low)
            low[:2], high[:2] = (seen - half)[:2], (seen + half)[:2]
        extent = high - low
        height = float((extent[:2] / (aspect, 1) / reach.sum(axis=1)).max()) * 2
        away = max(extent[2], height)
        height /= zoom
        half = height / 2 * np.array([aspect, 1])
        middle = low / 2 + high / 2
        middle[:2] += half * (reach[:, 1] - reach[:, 0]) / 2
        look_at = middle @ axes
        position = look_at + away * axes[2]
        return Camera(_point(position), _point(look_at), up, projection=projection, height=height)
    # Each side of the cone of view touches what it holds where x + t z + r sqrt(1 + t^2) is
    # largest, t being its slope and z towards the camera; and it goes through where that is.
    slopes = math.tan(math.radians(FOV / 2)) * reach / [[1], [aspect]]
    outward = [
        sign * axes[i] + slopes[i, j] * axes[2] for i in range(2) for j, sign in enumerate((1, -1))
    ]
    low, high = _extent(parts, corners, np.array([*outward, axes[2]]))
    sides = high[:4].reshape(2, 2)
    # Half as wide as the cone is where it is one away, and how far its axis is from the middle of
    # what does not stay free.
    wide, aside = slopes.sum(axis=1) / 2, (slopes[:, 1] - slopes[:, 0]) / 2
    if seen is None:
        z = (sides.sum(axis=1) / slopes.sum(axis=1)).max()
        x, y = (sides[:, 0] - slopes[:, 0] * z + slopes[:, 1] * z - sides[:, 1]) / 2
        ahead = low[4] / 2 + high[4] / 2
    else:
        ahead = seen[2]
        from_middle = (sides - np.outer(seen[:2], (1, -1)) + np.outer(ahead * aside, (1, -1))).max(
            axis=1
        )
        z = (from_middle / wide).max()
        x, y = seen[:2] + (z - ahead) * aside
    shift = (z - ahead) * aside * (1 / zoom - 1)
    position = np.array([x + shift[0], y + shift[1], z])
    look_at = np.array([*position[:2], ahead])
    fov = math.degrees(2 * math.atan(math.tan(math.radians(FOV / 2)) / zoom)) if zoom != 1 else FOV
    return Camera(_point(position @ axes), _point(look_at @ axes), up, fov)


def extent(spheres: Spheres, corners: Array) -> float:
    """The longest side of the box around spheres and points, along the axes of the world."""
    low, high = _extent([spheres], corners, np.eye(3))
    return float((high - low).max())


def is_seen(
    camera: Camera,
    spheres: Spheres,
    capsules: Capsules | None,
    corners: Array,
    size: tuple[int, int],
) -> bool:
    """Whether a pixel or more of the picture is within the box around spheres and points, and, if
    there are no points, a sphere or a capsule is in the picture."""
    if not len(corners) and not lens.meets(
        camera, spheres, capsules, lens.half_screen(camera, *size)
    ):
        return False
    low, high = _extent([spheres], corners, np.eye(3))
    ends = np.array([*itertools.product(*zip(low, high, strict=True))]) - camera.position
    x, y, z = np.array(camera.basis()) @ ends.T
    if camera.orthographic:
        half = np.full(len(z), (camera.height or 0) / 2)
    elif (z >= 0).any():
        return True  # the camera is beside it
    else:
        half = -z * math.tan(math.radians((camera.fov or 0) / 2))
    places = np.stack([x * size[1] / size[0], y]) / half
    inside = np.minimum(places.max(axis=1), 1) - np.maximum(places.min(axis=1), -1)
    pixels = inside / 2 * size
    return bool(pixels.min() > 0 and pixels.max() >= 1)


def _extent(parts: Iterable[Spheres], corners: Array, axes: Array) -> tuple[Array, Array]:
    """The least and the largest value along each of some axes, (m,) each, of spheres and points.

    axes: (m, 3), of any length: along one of length l a sphere reaches l r from its middle.

    Raises:
        RequestError: there are none.
    """
    length = np.linalg.norm(axes, axis=1)
    low, high = np.full(len(axes), np.inf), np.full(len(axes), -np.inf)
    for block in lens.blocks(len(corners)):
        along = axes @ corners[block].T
        low, high = np.minimum(low, along.min(axis=1)), np.maximum(high, along.max(axis=1))
    for spheres in parts:
        for block in lens.blocks(len(spheres)):
            center = np.ascontiguousarray(spheres.center[block].T, float)
            radius = spheres.radius[block].astype(float)
            for i, (x, y, z) in enumerate(axes):
                # Not a product of matrices: its rounding depends on how they lie in memory.
                middle, reach = center[0] * x + center[1] * y + center[2] * z, length[i] * radius
                low[i] = min(low[i], (middle - reach).min())
                high[i] = max(high[i], (middle + reach).max())
    if low[0] > high[0]:
        raise RequestError("particles: expected at least one, got none")
    return low, high


def _point(array: Array) -> Vec3:
    x, y, z = map(float, array)
    return x, y, z
