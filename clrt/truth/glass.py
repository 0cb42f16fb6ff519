"""Glass: the media that rays are in, Snell's law and Fresnel's part (section 8)."""

import numpy as np
from numpy.typing import NDArray

from clrt.truth.rays import Array, dot
from clrt.truth.world import World


def medium(world: World, inside: NDArray[np.bool_]) -> Array:
    """The index of refraction around rays: that of the smallest sphere they are in, 1 in none."""
    if len(world.panes) == 0:
        return np.ones(len(inside), world.dtype)
    size = np.where(inside, world.size, len(world.panes))
    smallest = world.panes[size.argmin(axis=1)]
    ior = world.ior[world.material[smallest]]
    found: Array = np.where(inside.any(axis=1), ior, world.dtype.type(1))
    return found


def refracted(
    direction: Array, normal: Array, before: Array, after: Array
) -> tuple[Array, NDArray[np.bool_], Array]:
    """Where rays go that meet a surface, `normal` towards them, between two media (section 8):
    Snell's law, or total reflection; where that is, and Fresnel's mirrored part of unpolarised
    light."""
    cosine = -dot(direction, normal)
    eta = before / after
    k = 1 - eta**2 * (1 - cosine**2)
    total = k < 0
    other = np.sqrt(np.where(total, 0, k))  # the cosine on the other side
    through = eta * direction + (eta * cosine - other) * normal
    back = direction + 2 * cosine * normal
    with np.errstate(invalid="ignore"):
        across = (before * cosine - after * other) / (before * cosine + after * other)
        aligned = (before * other - after * cosine) / (before * other + after * cosine)
    mirrored = np.fmin((across**2 + aligned**2) / 2, 1)
    return np.where(total, back, through), total, mirrored
