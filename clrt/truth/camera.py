"""Camera: the rays through points of the screen (11.2)."""

from typing import Any

import numpy as np

from clrt.scene.camera import Camera
from clrt.truth.rays import Array, Rays, norm, unit
from clrt.truth.world import World


def screen(camera: Camera, width: int, height: int, dtype: np.dtype[Any]) -> tuple[Array, Array]:
    """Where the columns and rows of pixels are on the screen (11.1): of an orthographic camera as
    far from its axis as their rays are, in world units."""
    if camera.height is not None:
        top = dtype.type(camera.height) / 2
        right = top * width / height
    else:
        right = np.tan(np.radians(dtype.type(camera.fov)) / 2)
        if camera.fov == 90:
            right = dtype.type(1)  # which tan(pi / 4) misses by a rounding
        top = right * height / width
    x: Array = np.linspace(-right, right, width, dtype=dtype)
    return x, np.linspace(top, -top, height, dtype=dtype)


def first_rays(world: World, x: Array, y: Array) -> Rays:
    """The rays through points of the screen (11.2)."""
    n = x.size
    inside = np.zeros((n, len(world.panes)), bool)
    if world.orthographic:  # they have no start: any of their points will do
        origin = world.look_at + x * world.right + y * world.up
        direction = np.repeat(-world.back, n, axis=1)
    else:
        origin = np.repeat(world.camera, n, axis=1)
        direction = unit(x * world.right + y * world.up - world.back)
        inside[:] = norm(world.camera - world.center[:, world.panes]) < world.radius[world.panes]
    pixel, nothing = np.arange(n), np.full(n, -1)
    weight, path = np.ones(n, world.dtype), np.zeros(n, np.uint32)
    behind = np.full(n, -np.inf, world.dtype)
    return Rays(pixel, weight, origin, direction, nothing, inside, path, 0, behind, nothing)


def to_camera(world: World, point: Array) -> Array:
    """The direction from where a point is looked at."""
    return world.back if world.orthographic else unit(world.camera - point)
