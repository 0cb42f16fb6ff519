"""Glass: which spheres let light through, and how many of them a ray can be inside of at once."""

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from clrt.scene.camera import Camera
from clrt.scene.material import Material
from clrt.scene.spheres import Spheres

Array: TypeAlias = NDArray[Any]

MOST = 4
"""The most transparent spheres that a ray keeps count of."""
SWEEP = 10**4
"""Up to so many are looked at to find out whether fewer are enough."""
TOUCH = 1e-6
"""Spheres that are closer than this, in units of their radii, meet: which comes first is a matter
of rounding."""


def meetings(center: Array, radius: Array) -> Array:
    """How many others each of some spheres meets, (n,); MOST of more than SWEEP spheres.

    center: (n, 3). Sorted by where they begin along x each is compared with those that begin before
    it ends.
    """
    n = len(radius)
    if n > SWEEP:
        return np.full(n, MOST)
    order = np.argsort(center[:, 0] - radius)
    center, radius = center[order], radius[order] * (1 + TOUCH)
    low, high = center[:, 0] - radius, center[:, 0] + radius
    ends = np.searchsorted(low, high)
    met = np.zeros(n, np.int64)
    for i, end in enumerate(ends):
        others = slice(i + 1, end)
        away = np.linalg.norm(center[others] - center[i], axis=1)
        near = away < radius[others] + radius[i]
        met[others] += near
        met[i] += near.sum()
    found = np.empty(n, np.int64)
    found[order] = met
    return found


def orders(radius: Array, transparent: Array) -> Array:
    """1, 2, ... for the transparent spheres, the smallest the largest number and of equal ones the
    first; 0 for the others. (n,) int64."""
    where = np.flatnonzero(transparent)
    found = np.zeros(len(radius), np.int64)
    found[where[np.argsort(radius[where], kind="stable")]] = np.arange(len(where), 0, -1)
    return found


def around(camera: Camera, spheres: Spheres, transparent: Array) -> Array:
    """Indices of the transparent spheres that a camera is inside of."""
    if camera.orthographic:
        return np.zeros(0, np.int64)
    where = np.flatnonzero(transparent)
    center, radius = spheres.center[where], spheres.radius[where]
    wide = np.longdouble if len(where) <= SWEEP else np.float64
    away = np.linalg.norm(center - np.array(camera.position, wide), axis=1)
    inside: Array = where[away < radius]
    return inside


def is_nothing(material: Material) -> bool:
    """Whether a sphere of it alone is as if it were not there."""
    colors = (material.ambient, material.diffuse, material.specular)
    clear = material.transmission == 1 and material.ior == 1 and material.reflection == 0
    return clear and not any(map(any, colors))


def splits(material: Material) -> bool:
    """Whether a ray that meets it can go two ways."""
    return material.transmission > 0 and (material.reflection > 0 or material.fresnel)
