"""Lights: where they are from a point, and the part that cones and distance leave (section 2)."""

import numpy as np

from clrt.scene.light import DirectionalLight, Shining, SpotLight
from clrt.truth.rays import Array, dot, norm, unit
from clrt.truth.world import World


def toward(world: World, light: Shining, point: Array) -> tuple[Array, Array]:
    """The direction of a light from some points, and its distance."""
    if isinstance(light, DirectionalLight):
        opposite = -unit(world.column(light.direction))
        return np.repeat(opposite, point.shape[1], axis=1), np.full(point.shape[1], np.inf)
    position = world.column(light.position)
    return unit(position - point), norm(position - point)


def cone(world: World, light: Shining, to_light: Array) -> Array:
    """The part of its light that a spot's cone leaves (section 2)."""
    if not isinstance(light, SpotLight) or light.inner_angle == 180:
        return np.ones(to_light.shape[1], world.dtype)
    axis = unit(world.column(light.look_at) - world.column(light.position))
    outer, inner = np.radians(np.array([light.outer_angle, light.inner_angle], world.dtype))
    # 1 - cosine of the angle from the axis is |L + axis|^2 / 2, which does not cancel.
    versine = dot(to_light + axis, to_light + axis) / 2
    edges = 2 * np.sin(outer / 2) ** 2, 2 * np.sin(inner / 2) ** 2
    if edges[0] == edges[1]:
        return np.where(versine < edges[0], world.dtype.type(1), 0)
    t = np.clip((edges[0] - versine) / (edges[0] - edges[1]), 0, 1)
    smooth: Array = t**2 * (3 - 2 * t)
    return smooth


def left(light: Shining, distance: Array) -> Array | float:
    """The factor of attenuation (section 2), at most 2^50."""
    if isinstance(light, DirectionalLight) or light.attenuation == (1, 0, 0):
        return 1.0
    constant, linear, quadratic = map(distance.dtype.type, light.attenuation)
    with np.errstate(divide="ignore"):
        left = 1 / (constant + linear * distance + quadratic * distance**2)
    most: Array = np.minimum(left, 2.0**50)
    return most
