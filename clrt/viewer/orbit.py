"""Orbit: where a camera goes when somebody turns, pans or zooms a picture.

They are functions of a camera, and keep `look_at` in the middle of the picture. Pan and zoom go by
the plane through it that faces the camera. Raises SceneError where no camera can be.
"""

from typing import TypeAlias

import numpy as np
from msgspec.structs import replace

from clrt.scene.camera import Camera
from clrt.scene.lens import half_screen
from clrt.values import Array, Vec3

Pixel: TypeAlias = tuple[float, float]
"""A column and a row: whole numbers are the middles of pixels."""
Size: TypeAlias = tuple[int, int]
"""Of the picture, columns and rows."""

POLE = 89.0
"""Degrees above and below look_at: at 90 nobody knows where right is."""


def turned(camera: Camera, right: float, up: float) -> Camera:
    """The camera goes round look_at at its distance: degrees to the right about its `up`, then
    upwards, not past POLE."""
    back, axis = np.array(camera.basis()[2]), np.array(camera.up)
    axis = axis / np.linalg.norm(axis)
    rise = np.clip(back @ axis, -1, 1)
    level = back - rise * axis
    level = level / np.linalg.norm(level)
    before = np.degrees(np.arcsin(rise))
    most = max(POLE, abs(before))
    turn, tilt = np.radians(right), np.radians(np.clip(before + up, -most, most))
    level = np.cos(turn) * level + np.sin(turn) * np.cross(axis, level)
    back = np.cos(tilt) * level + np.sin(tilt) * axis
    return replace(camera, position=camera.look_at + _distance(camera) * back)


def panned(camera: Camera, right: float, down: float, size: Size) -> Camera:
    """The picture goes so many pixels to the right and down."""
    way = point(camera, (0, 0), size) - point(camera, (right, down), size)
    return replace(camera, position=camera.position + way, look_at=camera.look_at + way)


def zoomed(camera: Camera, factor: float, at: Pixel, size: Size) -> Camera:
    """The picture becomes `factor` times as large; the point at a pixel stays there.

    The camera is scaled about that point: so a perspective one comes nearer.
    """
    kept = point(camera, at, size)
    position, look_at = (kept + (place - kept) / factor for place in _places(camera))
    height = None if camera.height is None else camera.height / factor
    return replace(camera, position=position, look_at=look_at, height=height)


def from_side(camera: Camera, side: Vec3) -> Camera:
    """The camera stands on a side of look_at, at its distance: its `up` stays, or is an axis that
    goes not along the view."""
    way = np.array(side) / np.linalg.norm(side)
    ups = [camera.up, (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
    up = next(up for up in ups if np.linalg.norm(np.cross(way, up)) > 1e-6 * np.linalg.norm(up))
    return replace(camera, position=camera.look_at + _distance(camera) * way, up=up)


def towards(camera: Camera, place: Vec3) -> Camera:
    """The camera moves, as it is turned, so that it looks at a place."""
    position, look_at = _places(camera)
    return replace(camera, position=place + (position - look_at), look_at=place)


def circle(
    camera: Camera, center: Vec3, radius: float, size: Size
) -> tuple[float, float, float] | None:
    """Where a sphere is in the picture: column, row and radius, in pixels; None: behind it."""
    right, up, back = np.array(camera.basis())
    way = np.array(center) - camera.position
    ahead = 1.0 if camera.orthographic else float(-way @ back)
    if ahead <= 0:
        return None
    half = half_screen(camera, *size).astype(float) * ahead
    pixels = (np.array(size) - 1) / 2
    x, y = pixels * (1 + np.array([way @ right, -way @ up]) / half)
    return float(x), float(y), float(radius / half[0] * pixels[0])


def held(camera: Camera, frame: Size, size: Size) -> Camera:
    """The camera zoomed out so that what it sees in a picture of the shape of `frame` is in one of
    `size` as well, which has another shape."""
    larger = float((_half(camera, frame) / _half(camera, size)).max())
    middle = (size[0] - 1) / 2, (size[1] - 1) / 2
    return camera if larger <= 1 else zoomed(camera, 1 / larger, middle, size)


def orthographic(camera: Camera, size: Size) -> Camera:
    """The same view without perspective, nor a lens: as high at look_at."""
    if camera.orthographic:
        return camera
    height = 2 * _half(camera, size)[1]
    straight = {"projection": "orthographic", "height": height, "fov": None}
    return replace(camera, **straight, aperture_radius=0.0, focus_distance=None)


def perspective(camera: Camera, fov: float, size: Size) -> Camera:
    """The same view in perspective: as high at look_at, from as far away as that needs."""
    if camera.height is None:
        return camera
    seen = replace(camera, projection="perspective", height=None, fov=fov)
    away = camera.height / 2 / float(half_screen(seen, *size)[1])
    return replace(seen, position=camera.look_at + away * np.array(camera.basis()[2]))


def point(camera: Camera, at: Pixel, size: Size) -> Array:
    """The point at a pixel in the plane through look_at: (3,), in world space."""
    right, up, _ = np.array(camera.basis())
    # The middles of the first and of the last pixel are on the edges of the screen.
    part = 2 * np.array(at, float) / np.maximum(np.array(size) - 1, 1) - 1
    x, y = part * _half(camera, size)
    found: Array = camera.look_at + x * right - y * up
    return found


def _half(camera: Camera, size: Size) -> Array:
    """Half the width and height of the view in the plane through look_at: (2,), world units."""
    away = 1.0 if camera.orthographic else _distance(camera)
    return away * half_screen(camera, *size).astype(float)


def _places(camera: Camera) -> tuple[Array, Array]:
    return np.array(camera.position), np.array(camera.look_at)


def _distance(camera: Camera) -> float:
    position, look_at = _places(camera)
    return float(np.linalg.norm(position - look_at))
