"""Capsules: where rays meet them. A capsule is a tube with a ball at either end."""

from collections.abc import Iterator

import numpy as np

from clrt.truth.rays import Array, Rays, dot, norm, unit
from clrt.truth.spheres import BLOCK_PAIRS
from clrt.truth.world import World


def meetings(world: World, rays: Rays) -> Iterator[tuple[slice, Array, Array]]:
    """Where rays meet capsules: as spheres.meetings(), none of them is of glass.

    A capsule is convex, so a line is inside of it from the first of the points on where it enters
    the tube, between the ends, or one of the two balls.
    """
    first = len(world.radius)
    block = max(1, BLOCK_PAIRS // max(rays.pixel.size, 1))
    for start in range(0, len(world.thickness), block):
        some = slice(start, min(start + block, len(world.thickness)))
        origin, direction = rays.origin[:, :, np.newaxis], rays.direction[:, :, np.newaxis]
        radius = world.thickness[some]
        distance = np.minimum(
            _enters_ball(origin - world.start[:, np.newaxis, some], direction, radius),
            _enters_ball(origin - world.end[:, np.newaxis, some], direction, radius),
        )
        axis = (world.end - world.start)[:, np.newaxis, some]
        from_start = origin - world.start[:, np.newaxis, some]
        distance = np.minimum(distance, _enters_tube(from_start, direction, axis, radius))
        ids = np.arange(first + some.start, first + some.stop)
        line = world.orthographic and rays.bounce == 0
        met = (line | (distance > 0)) & (rays.leaves[:, np.newaxis] != ids)
        distance[~met | (world.opacity[ids] == 0)] = np.inf
        yield slice(first + some.start, first + some.stop), np.zeros(met.shape, bool), distance


def normal(world: World, capsule: Array, point: Array) -> Array:
    """Outwards, of unit length, at points (3, n) of capsules: away from the nearest point of the
    axis."""
    start, end = world.start[:, capsule], world.end[:, capsule]
    axis, from_start = end - start, point - start
    length2 = dot(axis, axis)
    part = dot(from_start, axis) / np.where(length2 > 0, length2, 1)
    return unit(from_start - np.clip(part, 0, 1) * axis)


def _enters_ball(from_center: Array, direction: Array, radius: Array) -> Array:
    """How far along lines a ball begins, (rays, balls); infinity where they miss it."""
    b = dot(from_center, direction)
    across = from_center - b * direction
    half_chord2 = radius**2 - dot(across, across)
    found: Array = np.where(half_chord2 > 0, -b - np.sqrt(np.maximum(half_chord2, 0)), np.inf)
    return found


def _enters_tube(from_start: Array, direction: Array, axis: Array, radius: Array) -> Array:
    """How far along lines the side of a tube begins, where it is one between its ends; infinity
    where it is not, or where a line is along it."""
    length = norm(axis)
    along = unit(axis)
    there, speed = dot(from_start, along), dot(direction * np.ones_like(along), along)
    # The parts across the axis: where |across + t turn| = radius.
    across, turn = from_start - there * along, direction - speed * along
    a, b = dot(turn, turn), dot(across, turn)
    # b^2 - a c of the quadratic, as a radius^2 less the square of the lines' distance times a.
    beside = np.cross(across, turn, axis=0)
    delta = a * radius**2 - dot(beside, beside)
    met = (delta > 0) & (a > 0)
    distance = (-b - np.sqrt(np.where(met, delta, 0))) / np.where(met, a, 1)
    place = there + distance * speed
    found: Array = np.where(met & (place >= 0) & (place <= length), distance, np.inf)
    return found
