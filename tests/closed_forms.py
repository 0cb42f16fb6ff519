"""What pictures of round lights, skies, lenses and mirrors are known to show, in float64.

Directions from a point fill a sphere. A ball, a light and a disc in the sky each fill a cap of it,
whose size is the half angle. Angles are in radians.
"""

from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from clrt import Camera, Sphere
from clrt.values import Vec3

Array = NDArray[Any]

NODES, WEIGHTS = np.polynomial.legendre.leggauss(80)
FLAT = 1e8
GROUND = Sphere((0, -FLAT, 0), FLAT, "ground")


def down_on(x: float, z: float, height: float) -> Camera:
    """Straight down on a part of the ground, x to the right and z down."""
    at = (x, 0, z)
    return Camera((x, 20, z), at, (0, 0, -1), projection="orthographic", height=height)


def on_ground(camera: Camera, size: tuple[int, int]) -> Array:
    """The points of the ground in the middles of pixels, (rows, columns, 3), straight below."""
    columns, rows = size
    if camera.height is None:
        right = np.tan(np.radians(camera.fov or 0) / 2) * camera.position[1]
    else:
        right = camera.height / 2 * columns / rows
    up = right * rows / columns
    x = camera.position[0] + np.linspace(-right, right, columns)
    x, z = np.meshgrid(x, camera.position[2] + np.linspace(-up, up, rows))
    below = (x**2 + z**2) / (FLAT + np.sqrt(FLAT**2 - x**2 - z**2))
    return np.stack([x, -below, z], axis=-1)


def cap_of(points: Array, center: Vec3, radius: float) -> tuple[Array, Array, Array]:
    """How points see a ball: the direction of its middle (..., 3), the half angle of its cap and
    the angle of its middle from straight up."""
    to = np.array(center) - points
    distance = np.linalg.norm(to, axis=-1)
    to /= distance[..., np.newaxis]
    return to, np.arcsin(np.minimum(radius / distance, 1)), np.arccos(to[..., 1])


def between(u: Array, v: Array) -> Array:
    """The angle between directions."""
    angle: Array = 2 * np.arcsin(np.minimum(np.linalg.norm(u - v, axis=-1) / 2, 1))
    return angle


def covered(a: ArrayLike, b: ArrayLike, g: ArrayLike) -> Array:
    """The part of a cap of half angle a that one of half angle b covers, their middles g apart.

    By integration over the circles about the first one's middle: of each the second cap covers an
    arc, up to an angle on either side that a spherical triangle with the sides t, g, b has.
    """
    a, b, g = (v[..., np.newaxis] for v in np.broadcast_arrays(a, b, g))
    t, dt = _between(a, abs(g - b), g + b)
    beyond = np.sin((b + t - g) / 2) * np.sin((b - t + g) / 2)
    within = np.sin((t + g + b) / 2) * np.sin((t + g - b) / 2)
    arc = 2 * np.arctan2(np.sqrt(np.maximum(beyond, 0)), np.sqrt(np.maximum(within, 0)))
    part: Array = (np.sin(t) * arc * dt).sum(axis=-1) / (2 * np.pi * np.sin(a[..., 0] / 2) ** 2)
    return part


def mean_cosine(a: ArrayLike, g: ArrayLike) -> Array:
    """The mean of max(N.L, 0) over a cap of half angle a, its middle g off the normal N."""
    a, g = (v[..., np.newaxis] for v in np.broadcast_arrays(a, g))
    horizon = abs(np.pi / 2 - g)
    t, dt = _between(a, horizon, horizon)
    up, aside = np.cos(t) * np.cos(g), np.sin(t) * np.sin(g)
    arc = np.arccos(np.clip(-up / np.where(aside > 0, aside, 1), -1, 1))
    arc = np.where(aside > 0, arc, np.where(up > 0, np.pi, 0))
    flux = np.sin(t) * (up * arc + aside * np.sin(arc))
    mean: Array = (flux * dt).sum(axis=-1) / (2 * np.pi * np.sin(a[..., 0] / 2) ** 2)
    return mean


def _between(end: Array, *kinks: Array) -> tuple[Array, Array]:
    """Where to look at what has roots at 0, at `end` and at kinks in between, and the weights."""
    ends = np.sort([np.zeros_like(end), *(np.minimum(kink, end) for kink in kinks), end], axis=0)
    found = []
    for low, high in pairwise(ends):
        turn = np.pi / 2 * NODES
        at = (low + high) / 2 + (high - low) / 2 * np.sin(turn)
        found.append((at, WEIGHTS * np.pi / 2 * np.cos(turn) * (high - low) / 2))
    t, dt = (np.concatenate(parts, axis=-1) for parts in zip(*found, strict=True))
    return t, dt


def hidden_sky(half_angle: ArrayLike, g: ArrayLike) -> Array:
    """The part of a sky, weighed by the cosine, that a cap hides which is all above the horizon:
    the form factor of a ball."""
    hidden: Array = np.sin(half_angle) ** 2 * np.cos(g)
    return hidden


def slope(counts: ArrayLike, errors: ArrayLike) -> float:
    """Of the logarithm of an error over that of a number of samples."""
    return float(np.polyfit(np.log(counts), np.log(errors), 1)[0])


def lens_beyond(u: ArrayLike) -> Array:
    """The part of a disc of radius 1 that lies beyond u: of a lens, what sees the far side of an
    edge."""
    u = np.clip(u, -1, 1)
    part: Array = 0.5 - (u * np.sqrt(1 - u * u) + np.arcsin(u)) / np.pi
    return part
