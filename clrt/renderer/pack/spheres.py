"""Spheres: as the kernel tests them, one by one or in a tree."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from clrt.renderer import glass
from clrt.renderer.pack.structs import MAX_RADIUS, VEIL, Array, Real, glass_dtype, sphere_dtype
from clrt.scene import lens
from clrt.scene.material import Material
from clrt.scene.spheres import Spheres

GIANT = 4.0
"""A sphere is a giant if its radius is over this many times the camera's distance from its surface.

Near the surface of any other sphere |f|^2 - r^2 is off by up to 3 * 2^-24 r^2, which moves it by
1.5 * 2^-24 r: at most 6 units in the last place of that distance.
"""


def _is_giant(center: Array, radius: Array) -> Array:
    """Which spheres are giants, of their centres from the camera."""
    giant: Array = radius > GIANT * abs(np.linalg.norm(center, axis=1) - radius)
    return giant


def extent(center: Array, radius: Array) -> Any:
    """How far the spheres reach from the camera; of giants, the distance of their anchors."""
    distance = np.linalg.norm(center, axis=1)
    reach = np.where(_is_giant(center, radius), abs(distance - radius), distance + radius)
    return reach.max(initial=0)


def _apart(center: Array, origin: Array, axis: int) -> Array:
    """How far centres are from the origin along an axis, (n,) float64. Each axis by itself is twice
    as fast as rows of three."""
    found: Array = center[:, axis] - origin[axis : axis + 1]  # a scalar would leave them float32
    return found


def reach(spheres: Spheres, origin: Array) -> tuple[float, Array]:
    """How far many spheres reach from the origin, as extent(), and which are giants."""
    farthest, giants = 0.0, [np.zeros(0, np.int64)]
    for block in lens.blocks(len(spheres)):
        radius = spheres.radius[block].astype(np.float64)
        x, y, z = (_apart(spheres.center[block], origin, axis) for axis in range(3))
        with np.errstate(over="ignore"):  # then it is infinite, and refused with all that is so far
            distance = np.sqrt(x * x + y * y + z * z)
        surface = abs(distance - radius)
        giant = radius > GIANT * surface
        farthest = max(farthest, float(np.where(giant, surface, distance + radius).max(initial=0)))
        giants.append(np.flatnonzero(giant) + block.start)
    return farthest, np.concatenate(giants)


def pack_spheres(
    center: Array,
    radius: Array,
    bias: float,
    real: Real,
    literal: bool = False,
) -> Array:
    """Spheres from centres (n, 3) in camera space and radii (n,), of about unit extent.

    The rounding of a giant's anchor moves it off the surface. c0 takes that up: it is computed from
    the rounded anchor, before it is rounded itself.
    """
    giant = _is_giant(center, radius) & (not literal)
    distance = np.linalg.norm(center, axis=1)
    toward = np.where(giant, (distance - radius) / np.where(giant, distance, 1), 1)
    anchor = (toward[:, np.newaxis] * center).astype(real)
    offset = np.where(giant[:, np.newaxis], anchor - center, 0)
    flat = np.minimum(radius, MAX_RADIUS)

    spheres = np.zeros(len(radius), sphere_dtype(real))
    spheres["anchor"] = anchor
    spheres["offset"] = (flat / radius)[:, np.newaxis] * offset
    above = np.linalg.norm(offset, axis=1) - radius  # the anchor, above the surface
    spheres["c0"] = above * (2 * flat + above)
    above = distance - radius  # the camera
    spheres["camera_c"] = above * (2 * flat + above)
    spheres["inv_radius"] = 1 / np.maximum(flat, np.finfo(real).tiny)
    # A point lifted by `bias` off its sphere sees a light past the sphere down to this cosine: the
    # paper's shadow test, without a sphere tested against its own rounding.
    horizon = -np.sqrt(bias * (2 * radius + bias)) / (radius + bias)
    spheres["horizon"] = -2 if literal else horizon
    spheres["giant"] = giant
    return spheres


def beads(spheres: Spheres, origin: Array, scale: float, real: Real) -> Array:
    """(spheres, 4) of real: centre from the origin, and radius, scaled."""
    found = np.empty((len(spheres), 4), real)
    for block in lens.blocks(len(spheres)):
        for axis in range(3):
            found[block, axis] = _apart(spheres.center[block], origin, axis) * scale
        found[block, 3] = spheres.radius[block] * np.float64(scale)
    return found


def tree_keys(spheres: Spheres) -> Array:
    """What a tree is ordered by, (spheres, 4) float32: centre and twice the radius, in units of the
    box around the centres, from about the middle one: so a ball of radius 1e9 as a ground leaves
    the others their digits."""
    ends = [(side.min(), side.max()) for side in spheres.center.T]
    half = float(max(np.float64(high) / 2 - np.float64(low) / 2 for low, high in ends)) or 1.0
    some = spheres.center[lens.some(len(spheres))].astype(np.float64, copy=False)
    middle = np.sort(some, axis=0)[len(some) // 2]
    keys = np.empty((len(spheres), 4), np.float32)
    for block in lens.blocks(len(spheres)):
        # Halves, lest two centres be farther apart than any number.
        for axis in range(3):
            keys[block, axis] = _apart(spheres.center[block] / 2, middle / 2, axis) / half
        keys[block, 3] = np.minimum(spheres.radius[block] / np.float64(half), 1e30)
    return keys


def opacities(materials: Sequence[Material], material_of: Array, spheres: Spheres) -> Array | None:
    """(things,), what each sphere and its material say, and those of capsules and faces after them;
    None: all are opaque."""
    of_materials = np.array([m.opacity for m in materials], np.float64)
    if spheres.opacity is None and not (of_materials < 1).any():
        return None
    found = of_materials[material_of] if len(materials) else of_materials
    if spheres.opacity is not None:
        found[: len(spheres)] *= spheres.opacity
    return found if (found < 1).any() else None


def panes(
    materials: Sequence[Material],
    material_of: Array,
    spheres: Spheres,
    opacity: Array | None,
    real: Real,
) -> tuple[Array | None, int, Array]:
    """What concerns rays through each thing of these materials, the spheres first, how many they
    can be inside of, and which are as if they were not there; None, 0 and none if nothing lets
    light through.

    opacity: see opacities(); then no sphere is of glass.
    """
    none = np.zeros(0, np.int64)
    if opacity is not None:
        found = np.zeros(len(material_of), glass_dtype(real, opacity=True))
        found["veil"], found["opacity"] = _veils(1 - opacity, real), opacity
        return found, 0, np.flatnonzero(opacity == 0)
    transmission = np.array([m.transmission for m in materials], np.float64)
    if not (transmission > 0).any():
        return None, 0, none
    transparent = (transmission > 0)[material_of]
    where = np.flatnonzero(transparent)
    if len(where) == 0:
        return None, 0, none
    met = glass.meetings(spheres.center[where].astype(np.float64), spheres.radius[where])
    nothing = np.array([glass.is_nothing(m) for m in materials], bool)[material_of[where]]
    n = len(spheres)
    found = np.zeros(len(material_of), glass_dtype(real))
    found["order"][:n] = glass.orders(spheres.radius, transparent[:n])
    found["veil"] = _veils(transmission, real)[material_of]
    return found, int(min(1 + met.max(), glass.MOST)), where[nothing & (met == 0)]


def _veils(left: Array, real: Real) -> Array:
    """As whole numbers, see veiled() of sphere.cl: what takes all but these parts of the light."""
    unit = VEIL[real]
    with np.errstate(divide="ignore"):
        veil = np.minimum(-np.log2(left) * unit, 128 * unit - 1)
    found: Array = np.rint(veil).astype(np.int64)
    return found
