"""Spheres: one, and many as arrays."""

from collections.abc import Sequence
from functools import cached_property

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from clrt.scene.rows import (
    Rows,
    colors_of,
    materials_of,
    opacities_of,
    own_colors,
    radii_of,
    triple,
)
from clrt.values import Array, Color, Vec3, floats, median, number, require, vectors


class Sphere(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A sphere, seen from outside only."""

    center: Vec3
    radius: float
    material: str
    color: Color | None = None
    """Multiplies the material's ambient and diffuse."""
    opacity: float = 1.0
    """Multiplies the material's, in [0, 1]."""

    def __post_init__(self) -> None:
        vectors(self, "center", *["color"] * (self.color is not None))
        number(self, "radius", "a finite number above 0", lambda radius: radius > 0)
        require(isinstance(self.material, str), "material", "a material's name", self.material)
        number(self, "opacity", "a number from 0 to 1", lambda part: 0 <= part <= 1)


class Spheres(Rows[Sphere]):
    """Many spheres, kept as arrays. Immutable, and equal to another by value.

    Args:
        center: (n, 3), world units. float32 and float64 are kept as they are; others become
            float64.
        radius: (n,), or one for all; above 0.
        material: a material's name, or n names, or n indices into the scene's materials.
        color: (n, 3), linear RGB, multiplies the materials' ambient and diffuse; None: white.
        opacity: (n,), or one for all, from 0 to 1, multiplies the materials'; None: 1.

    An array is kept as it is if nobody else can write to it: neither it nor the array that it is a
    view of is writeable. Else it is copied.

    Raises:
        SceneError: naming the first value that is wrong.
    """

    KEY = "spheres"
    ARRAYS = ("center", "radius", "color", "opacity")

    def __init__(
        self,
        center: ArrayLike,
        radius: ArrayLike,
        material: str | Sequence[str] | Sequence[int] | Array,
        color: ArrayLike | None = None,
        opacity: ArrayLike | None = None,
    ) -> None:
        self.center = floats("spheres.center", center, 3)
        n = len(self.center)
        self.radius = radii_of("spheres.radius", radius, n)
        self.color = colors_of("spheres.color", color, n)
        self.opacity = None if opacity is None else opacities_of("spheres.opacity", opacity, n)
        self.material_index, self.names = materials_of("spheres.material", material, n)

    @cached_property
    def median_radius(self) -> float:
        """In world units; of at least one sphere."""
        return median(self.radius)

    def _row(self, i: int, material: str) -> Sphere:
        color = None if self.color is None else triple(self.color[i])
        opacity = 1.0 if self.opacity is None else float(self.opacity[i])
        return Sphere(triple(self.center[i]), float(self.radius[i]), material, color, opacity)

    @staticmethod
    def of(spheres: "Sequence[Sphere]") -> "Spheres":
        """Any sequence of spheres as arrays."""
        if isinstance(spheres, Spheres):
            return spheres
        seen_through = any(sphere.opacity < 1 for sphere in spheres)
        opacity = [sphere.opacity for sphere in spheres] if seen_through else None
        return Spheres(
            np.array([sphere.center for sphere in spheres]).reshape(-1, 3),
            np.array([sphere.radius for sphere in spheres], float),
            [sphere.material for sphere in spheres],
            own_colors(spheres),
            opacity,
        )
