"""Capsules: one, and many as arrays. A capsule is a ball that is moved along a line."""

from collections.abc import Sequence

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from clrt.scene.rows import Rows, colors_of, materials_of, own_colors, radii_of, triple
from clrt.values import Array, Color, Vec3, floats, number, require, vectors


class Capsule(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """All points that are no farther than its radius from the line between two ends, seen from
    outside only. Where the ends are one it is a sphere."""

    start: Vec3
    end: Vec3
    radius: float
    material: str
    color: Color | None = None
    """Multiplies the material's ambient and diffuse."""

    def __post_init__(self) -> None:
        vectors(self, "start", "end", *["color"] * (self.color is not None))
        number(self, "radius", "a finite number above 0", lambda radius: radius > 0)
        require(isinstance(self.material, str), "material", "a material's name", self.material)


class Capsules(Rows[Capsule]):
    """Many capsules, kept as arrays. Immutable, and equal to another by value.

    Args:
        start, end: (n, 3) each, world units: the middles of the balls at their ends. float32 and
            float64 are kept as they are; others become float64.
        radius: (n,), or one for all; above 0.
        material: a material's name, or n names, or n indices into the scene's materials.
        color: (n, 3), linear RGB, multiplies the materials' ambient and diffuse; None: white.

    An array is kept as it is if nobody else can write to it, as those of clrt.Spheres.

    Raises:
        SceneError: naming the first value that is wrong.
    """

    KEY = "capsules"
    ARRAYS = ("start", "end", "radius", "color")

    def __init__(
        self,
        start: ArrayLike,
        end: ArrayLike,
        radius: ArrayLike,
        material: str | Sequence[str] | Sequence[int] | Array,
        color: ArrayLike | None = None,
    ) -> None:
        self.start = floats("capsules.start", start, 3)
        self.end = floats("capsules.end", end, 3)
        n = len(self.start)
        require(len(self.end) == n, "capsules.end", f"{n} points", self.end)
        self.radius = radii_of("capsules.radius", radius, n)
        self.color = colors_of("capsules.color", color, n)
        self.material_index, self.names = materials_of("capsules.material", material, n)

    def _row(self, i: int, material: str) -> Capsule:
        color = None if self.color is None else triple(self.color[i])
        ends = triple(self.start[i]), triple(self.end[i])
        return Capsule(*ends, float(self.radius[i]), material, color)

    @staticmethod
    def of(capsules: "Sequence[Capsule]") -> "Capsules":
        """Any sequence of capsules as arrays."""
        if isinstance(capsules, Capsules):
            return capsules
        return Capsules(
            np.array([capsule.start for capsule in capsules]).reshape(-1, 3),
            np.array([capsule.end for capsule in capsules]).reshape(-1, 3),
            np.array([capsule.radius for capsule in capsules], float),
            [capsule.material for capsule in capsules],
            own_colors(capsules),
        )
