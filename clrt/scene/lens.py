"""Lens: the spheres that a camera sees, where they show, and where its rays start.

A point's place here is as the camera has it: x to the right, y up, z back.
"""

from collections.abc import Iterator, Sequence
from typing import Any, TypeAlias

import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

from clrt.scene.camera import Camera
from clrt.scene.capsules import Capsule, Capsules
from clrt.scene.mesh import Mesh
from clrt.scene.spheres import Sphere, Spheres
from clrt.values import median

Array: TypeAlias = NDArray[Any]

BLOCK = 1 << 14  # spheres that are looked at at a time: their arrays stay in the cache
LOOKED_AT = 2000  # things that stand for many


def blocks(n: int) -> Iterator[slice]:
    """Slices of n things, BLOCK at a time."""
    return (slice(start, start + BLOCK) for start in range(0, n, BLOCK))


def some(n: int) -> slice:
    """Every kth of n things, LOOKED_AT at most."""
    return slice(None, None, -(-n // LOOKED_AT) or 1)


def is_long(camera: Camera) -> bool:
    """Whether things that fill the picture may be far away against their size."""
    return camera.fov is not None and camera.fov < 14


def half_screen(camera: Camera, width: int, height: int) -> Array:
    """Half the screen's width and height, (2,) of long double: of a perspective camera's, which
    stands one unit ahead, or in world units."""
    wide = np.longdouble
    if camera.height is not None:
        top = camera.height / wide(2)
        return np.array([top * width / height, top])
    # The paper's screen has 1, and tan(pi / 4) is a rounding below it.
    fov = wide(camera.fov or 0)
    half: Any = wide(1) if fov == 90 else np.tan(np.radians(fov) / 2)
    return np.array([half, half * (wide(height) / width)])


def middle_size(
    camera: Camera, spheres: Sequence[Sphere], capsules: Sequence[Capsule] = ()
) -> float:
    """How much of half a picture's width the radius of a sphere or a capsule takes: the median over
    those before the camera, of 16:9 if it is orthographic; infinity if there are none."""
    every = some(len(spheres) + len(capsules))
    balls, others = Spheres.of(spheres[every]), Capsules.of(capsules[every])
    center = np.concatenate([balls.center, others.start / 2 + others.end / 2])
    radius = np.concatenate([balls.radius, others.radius])
    right = half_screen(camera, 16, 9)[0].astype(np.float64)
    width = np.full(len(radius), right)
    if not camera.orthographic:
        width *= (np.array(camera.position) - center) @ np.array(camera.basis()[2])
    ahead = width > 0
    if not ahead.any():
        return np.inf
    return median(radius[ahead] / width[ahead])


def start(
    camera: Camera,
    spheres: Spheres,
    capsules: Capsules,
    meshes: Sequence[Mesh],
    screen: Array,
    real: type[np.floating[Any]],
) -> Any:
    """How far ahead of the camera rays start, just before the first thing.

    Rays of an orthographic camera are whole lines: the distance may be negative. Spheres that are
    larger than the picture do not count there unless there are no others, as such a sphere can be
    met far before all others.

    screen: as half_screen() gives it.
    real: np.longdouble, or np.float64 of many.
    """
    if camera.has_lens:  # its rays lie in a wider pyramid, whose tip is behind the camera
        radius = real(camera.aperture_radius)
        screen = screen + radius / real(camera.focus_distance or 1)
        back = np.min(radius / screen)
        place = np.array(camera.position) + back * np.array(camera.basis()[2])
        whole = replace(
            camera, position=tuple(place.tolist()), aperture_radius=0.0, focus_distance=None
        )
        return max(start(whole, spheres, capsules, meshes, screen, real) - back, real(0))
    firsts = _firsts(camera, spheres, screen, real)
    corner = np.hypot(*screen.astype(real))  # the distance of the screen's corners from its middle
    # The best that there is: of those that count, then of all.
    best = next(filter(np.isfinite, firsts), np.inf)
    # From there a perspective view is as wide as far, as through a lens of 90 degrees.
    best = best - corner / 8 if camera.orthographic else max(best * (1 - corner), real(0))
    best = min(best, _first_of_capsules(camera, capsules, screen.astype(np.float64)))
    best = min(best, _first_of_meshes(camera, meshes, screen.astype(np.float64)))
    return real(best if np.isfinite(best) else 0)


def meets(camera: Camera, spheres: Spheres, capsules: Capsules | None, screen: Array) -> bool:
    """Whether a sphere or a capsule is in the picture of a camera without a lens."""
    if np.isfinite(_firsts(camera, spheres, screen, np.float64)).any():
        return True
    return capsules is not None and np.isfinite(_first_of_capsules(camera, capsules, screen))


def _first_of_capsules(camera: Camera, capsules: Capsules, screen: Array) -> float:
    """Where a camera can meet the first of some capsules, a little before; infinity if none.

    No point of a capsule is nearer than the nearest point of what the sides of the picture leave of
    its axis, less the radius. The sides are a radius farther out.
    """
    basis, found = np.array(camera.basis()), float(np.inf)
    for block in blocks(len(capsules)):
        ends = [
            (end[block] - np.array(camera.position)) @ basis.T
            for end in (capsules.start, capsules.end)
        ]
        radius = capsules.radius[block]
        first, last = np.zeros(len(radius)), np.ones(len(radius))  # parts of the axis
        for axis, half in enumerate(1.001 * screen):
            for side in (-1, 1):
                slope, wide = (0.0, half) if camera.orthographic else (half, 0.0)
                beyond = [
                    (side * end[:, axis] + slope * end[:, 2] - wide) / np.hypot(1, slope) - radius
                    for end in ends
                ]
                with np.errstate(invalid="ignore", divide="ignore"):
                    crossing = beyond[0] / (beyond[0] - beyond[1])
                enters, leaves = beyond[0] > 0, beyond[1] > 0
                first = np.where(enters, np.where(leaves, np.inf, np.fmax(first, crossing)), first)
                last = np.where(leaves & ~enters, np.fmin(last, crossing), last)
        seen = first <= last
        ahead = -ends[0][seen, 2], -ends[1][seen, 2]
        parts = (ahead[0] + part[seen] * (ahead[1] - ahead[0]) for part in (first, last))
        found = min(found, float((np.minimum(*parts) - radius[seen]).min(initial=np.inf)))
    corner = float(np.hypot(*screen))
    return found - corner / 8 if camera.orthographic else max(found * (1 - corner), 0)


def _first_of_meshes(camera: Camera, meshes: Sequence[Mesh], screen: Array) -> float:
    """What no face of some meshes is before, a little nearer; infinity if there are none."""
    found, back = np.inf, np.array(camera.basis()[2])
    for mesh in meshes:
        ahead = (np.array(camera.position) - mesh.vertices) @ back
        found = min(found, float(ahead.min(initial=np.inf)))
    corner = np.hypot(*screen)
    return float(found - corner / 8 if camera.orthographic else max(found * (1 - corner), 0))


def _firsts(camera: Camera, spheres: Spheres, screen: Array, real: type[np.floating[Any]]) -> Array:
    """How far ahead a camera can meet the first of some spheres, infinity if it meets none: a
    perspective one (1,); an orthographic one (2,), of those that are smaller than the picture, and
    of all."""
    find = _first_beside if camera.orthographic else _first_ahead
    basis, origin = np.array(camera.basis(), real), np.array(camera.position, real)
    firsts: Array = np.full(2 if camera.orthographic else 1, np.inf, real)
    for block in blocks(len(spheres)):
        apart = _apart(spheres.center[block], origin)
        radius = spheres.radius[block].astype(real)
        # Most cannot be nearer than the nearest so far, wherever they are beside the axis.
        if camera.orthographic:
            away = -_along(apart, basis[2])
        else:
            away = np.sqrt(_along(apart, apart)) * real(1 - 1e-9)  # safe from find()'s rounding
        near = np.flatnonzero(away - 1.001 * radius < firsts[0])
        center = np.array([_along(apart[:, near], axis) for axis in basis])
        firsts = np.minimum(firsts, find(center, radius[near], screen.astype(real)))
    return firsts


def _apart(center: Array, origin: Array) -> Array:
    """(3, n): from a point to centres (n, 3). Each axis by itself is twice as fast as rows of
    three."""
    return np.array([center[:, axis] - origin[axis : axis + 1] for axis in range(3)])


def _along(apart: Array, axis: Array) -> Array:
    """Scalar products. No product of matrices: its rounding depends on how they lie in memory."""
    found: Array = apart[0] * axis[0] + apart[1] * axis[1] + apart[2] * axis[2]
    return found


def _first_ahead(center: Array, radius: Array, screen: Array) -> Array:
    """Where a perspective camera can meet the first of some spheres, (1,)."""
    corner = np.hypot(*screen)
    distance = np.sqrt(_along(center, center))
    outside = distance > radius  # from inside a sphere cannot be seen
    z, radius, distance = center[2, outside], radius[outside], distance[outside]
    # A sphere is met first by the ray closest to its centre. `off` is the angle between them.
    off = np.arccos(np.clip(-z / distance, -1, 1)) - np.arctan(corner)
    off = np.clip(off, 0, np.pi / 2)
    half_chord2 = radius**2 - (distance * np.sin(off)) ** 2
    met = half_chord2 > 0
    first: Array = (distance * np.cos(off))[met] - np.sqrt(half_chord2[met])
    found: Array = first.min(initial=np.inf, keepdims=True)
    return found


def _first_beside(center: Array, radius: Array, screen: Array) -> Array:
    """Where an orthographic camera can meet the first of some spheres: of those that are smaller
    than the picture, and of all: (2,)."""
    met, entry = _entries(center, radius, screen)
    small = radius[met] <= 2 * np.hypot(*screen)
    found: Array = np.array([one.min(initial=np.inf) for one in (entry[small], entry)])
    return found


def _entries(center: Array, radius: Array, screen: Array) -> tuple[Array, Array]:
    """Which spheres lines through the screen meet, and how far ahead of it they first can."""
    x, y = (np.maximum(abs(center[axis]) - 1.001 * screen[axis], 0) for axis in (0, 1))
    half_chord2 = radius * radius - x * x - y * y
    met: Array = half_chord2 > 0
    return met, -center[2, met] - np.sqrt(half_chord2[met])


def behind(camera: Camera, spheres: Spheres, screen: Array, ahead: Any) -> Array:
    """Indices of the spheres that an orthographic camera's lines can meet before they have come so
    far ahead."""
    if spheres.radius.max(initial=0) <= 2 * np.hypot(*screen.astype(np.float64)):
        # All count in start(), which is before them by an eighth of that.
        return np.zeros(0, np.int64)
    basis = np.array(camera.basis())
    origin = np.array(camera.position) - np.float64(ahead) * basis[2]
    found = []
    for block in blocks(len(spheres)):
        apart = _apart(spheres.center[block], origin)
        center = np.array([_along(apart, axis) for axis in basis])
        radius = spheres.radius[block].astype(np.float64)
        met, entry = _entries(center, radius, screen.astype(np.float64))
        found.append(block.start + np.flatnonzero(met)[entry <= 0])
    return np.concatenate(found)


def bounds(camera: Camera, center: Array, radius: Array) -> Array:
    """Where each sphere can show on the screen: left, right, bottom, top, (n, 4)."""
    return (_shadow_bounds if camera.orthographic else _screen_bounds)(center, radius)


def _screen_bounds(center: Array, radius: Array) -> Array:
    """On that one unit ahead.

    Along each axis a sphere lies between two angles as seen from the camera, which is at the
    origin. The margin of 1e-6 is more than the 4 * 2^-24 (1 + r/D) that float32 moves a silhouette.
    """
    view = np.empty((len(radius), 4))
    forward = np.pi / 2
    for axis in (0, 1):
        away = np.hypot(center[:, axis], center[:, 2])
        outside = away > radius
        middle = np.arctan2(center[:, axis], -center[:, 2])
        half = np.where(outside, np.arcsin(radius / np.where(outside, away, radius)), np.inf)
        for end, angle in enumerate((middle - half, middle + half)):
            ahead = abs(angle) < forward
            position = np.tan(np.where(ahead, angle, 0))
            position += (2 * end - 1) * 1e-6 * (1 + abs(position))
            view[:, 2 * axis + end] = np.where(ahead, position, np.copysign(np.inf, angle))
    return view


def _shadow_bounds(center: Array, radius: Array) -> Array:
    """Where it throws its shadow along the view, with the same margin, in units of about the
    scene's extent."""
    view = np.empty((len(radius), 4))
    for axis in (0, 1):
        for end, side in enumerate((-1, 1)):
            position = center[:, axis] + side * radius
            view[:, 2 * axis + end] = position + side * 1e-6 * (1 + abs(position) + radius)
    return view
