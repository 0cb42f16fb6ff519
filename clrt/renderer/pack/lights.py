"""Lights: as the kernel sees them, and the spheres that they are inside of."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from clrt.renderer.pack.structs import (
    MAX_COLOR,
    MAX_DISTANCE,
    MAX_STRENGTH,
    Array,
    Real,
    light_dtype,
)
from clrt.scene import lens
from clrt.scene.light import DirectionalLight, Shining, SpotLight

FEW = 48
"""Fewer spheres than these are looked at in long double."""


def pack_lights(
    lights: Sequence[Shining], origin: Array, turn: Array, scale: Any, extent: Any, real: Real
) -> Array:
    """Lights in the kernel's space. A directional one is a point so far that no digit tells.

    turn: the axes of that space; extent: how far the spheres reach in it before it is scaled.
    """
    found = np.zeros(len(lights), light_dtype(real))
    for light, one in zip(lights, found, strict=True):
        if isinstance(light, DirectionalLight):
            place = -MAX_DISTANCE * extent * (turn @ _unit(np.array(light.direction, turn.dtype)))
        else:
            place = turn @ (np.array(light.position, turn.dtype) - origin)
        nearer = 1 / np.maximum(np.linalg.norm(place) / (MAX_DISTANCE * extent), 1)
        one["position"] = scale * nearer * place
        one["radius"] = _light_radius(light, place) * scale * nearer
        one["fade"], one["strength"] = _fade(light, scale * nearer)
        one["axis"], one["edge"] = _cone(light, turn)
    return found


def _light_radius(light: Shining, place: Array) -> Any:
    """Of a ball that fills as much of the sky, in the unit of its place."""
    if isinstance(light, DirectionalLight):
        return np.linalg.norm(place) * np.sin(np.radians(place.dtype.type(light.half_angle)))
    return np.minimum(place.dtype.type(light.radius), MAX_DISTANCE * (1 + np.linalg.norm(place)))


def _fade(light: Shining, scale: Any) -> tuple[Array, Any]:
    """Attenuation's coefficients for scaled distances, the largest of them 1, and 1 / the largest:
    so nothing overflows."""
    if isinstance(light, DirectionalLight):
        return np.array([1, 0, 0]), 1
    found: Array = light.attenuation / scale ** np.arange(3)
    return found / found.max(), np.minimum(1 / found.max(), MAX_STRENGTH)


def _cone(light: Shining, turn: Array) -> tuple[Array, Any]:
    """A spot's axis, and a, b of t = a - b h, see cone() of shading.cl; of other lights t = 2."""
    if not isinstance(light, SpotLight) or light.inner_angle == 180:
        return np.zeros(3), (2, 0)
    axis = turn @ _unit(np.array(light.look_at, turn.dtype) - np.array(light.position))
    angles = np.radians(np.array([light.outer_angle, light.inner_angle], turn.dtype))
    outer, inner = 4 * np.sin(angles / 2) ** 2
    steep = 1 / np.maximum(outer - inner, 1 / MAX_COLOR)
    return axis, (outer * steep, steep)


def _unit(v: Array) -> Array:
    v = v / abs(v).max()  # lest its square overflows
    unit: Array = v / np.linalg.norm(v)
    return unit


def encloses(center: Array, radius: Array, lights: Sequence[Shining]) -> Array:
    """Which spheres lights are inside of: (lights, spheres) uint8."""
    inside = np.zeros((len(lights), len(radius)), np.uint8)
    # In long double for few. Of many a light that is a rounding from a surface is on either side.
    wide = np.longdouble if len(radius) < FEW else np.float64
    for row, light in zip(inside, lights, strict=True):
        if isinstance(light, DirectionalLight):
            continue
        point = np.array(light.position, wide)
        for block in lens.blocks(len(radius)):
            row[block] = np.linalg.norm(point - center[block], axis=1) < radius[block]
    return inside
