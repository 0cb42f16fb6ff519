"""Spheres as arrays: a sequence of Sphere for those who have many.

Nothing is copied that nobody else can change, and everything is checked once, when it is made.
"""

from collections.abc import Iterator, Sequence
from typing import Any, overload

import msgspec
import numpy as np
from numpy.typing import ArrayLike, NDArray

from clrt.errors import SceneError
from clrt.values import Color, Vec3, number, require, vectors

Array = NDArray[Any]


class Sphere(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A sphere, seen from outside only."""

    center: Vec3
    radius: float
    material: str
    color: Color | None = None
    """Multiplies the material's ambient and diffuse."""

    def __post_init__(self) -> None:
        vectors(self, "center", *["color"] * (self.color is not None))
        number(self, "radius", "a finite number above 0", lambda radius: radius > 0)
        require(isinstance(self.material, str), "material", "a material's name", self.material)


class Spheres(Sequence[Sphere]):
    """Many spheres, kept as arrays. Immutable, and equal to another by value.

    Args:
        center: (n, 3), world units. float32 and float64 are kept as they are; others become
            float64.
        radius: (n,), or one for all; above 0.
        material: a material's name, or n names, or n indices into the scene's materials.
        color: (n, 3), linear RGB, multiplies the materials' ambient and diffuse; None: white.

    An array is kept as it is if nobody else can write to it: it and what it is a view of are not
    writeable. Else it is copied.

    Raises:
        SceneError: naming the first value that is wrong.
    """

    def __init__(
        self,
        center: ArrayLike,
        radius: ArrayLike,
        material: str | Sequence[str] | Sequence[int] | Array,
        color: ArrayLike | None = None,
    ) -> None:
        self.center = _floats("center", center, 3)
        n = len(self.center)
        radii = _floats("radius", radius, 1)
        require(radii.ndim == 0 or len(radii) == n, "spheres.radius", f"{n} numbers", radii.shape)
        _first_bad("radius", radii > 0, radii, "a finite number above 0")
        self.radius = np.broadcast_to(radii, n)
        self.color = None if color is None else _floats("color", color, 3)
        good = self.color is None or len(self.color) == n
        require(good, "spheres.color", f"{n} colours", getattr(self.color, "shape", None))
        self.names: tuple[str, ...] | None = None
        """Of the materials that `material_index` counts; None: the scene's."""
        self.material_index, self.names = _materials(material, n)
        self.materials = self.names if self.names is not None else int(
            self.material_index.max(initial=-1)
        )
        """The names of materials that are used, or the largest index."""

    def __len__(self) -> int:
        return len(self.center)

    @overload
    def __getitem__(self, i: int) -> Sphere: ...

    @overload
    def __getitem__(self, i: slice) -> "Spheres": ...

    def __getitem__(self, i: int | slice) -> "Sphere | Spheres":
        index = self.material_index[i]
        color = None if self.color is None else self.color[i]
        if isinstance(i, slice):
            material: Any = index
            if self.names is not None:
                material = [self.names[k] for k in index]
            return Spheres(self.center[i], self.radius[i], material, color)
        if self.names is None:
            raise SceneError("spheres: their materials are indices: ask a Scene for one of them")
        return Sphere(
            tuple(map(float, self.center[i])),
            float(self.radius[i]),
            self.names[index],
            None if color is None else tuple(map(float, color)),
        )
