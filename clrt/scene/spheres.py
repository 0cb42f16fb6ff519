"""Spheres as arrays: a sequence of Sphere for those who have many.

Nothing is copied that nobody else can change, and everything is checked once, when it is made.
"""

import copy
from collections.abc import Iterator, Sequence
from typing import Any, overload

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from clrt.values import Array, Color, Vec3, check_rows, floats, frozen, number, require, vectors


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


class Spheres(Sequence[Sphere]):
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
        radii = floats("spheres.radius", radius, 1)
        require(radii.ndim == 0 or len(radii) == n, "spheres.radius", f"{n} numbers", radii.shape)
        check_rows("spheres.radius", radii > 0, radii, "a finite number above 0")
        self.radius = np.broadcast_to(radii, n)
        self.color = None if color is None else floats("spheres.color", color, 3)
        good = self.color is None or len(self.color) == n
        require(good, "spheres.color", f"{n} colours", getattr(self.color, "shape", None))
        self.opacity = None if opacity is None else _opacities(opacity, n)
        self.material_index, self.names = _materials(material, n)

    def __len__(self) -> int:
        return len(self.center)

    @overload
    def __getitem__(self, i: int) -> Sphere: ...

    @overload
    def __getitem__(self, i: slice) -> "Spheres": ...

    def __getitem__(self, i: int | slice) -> "Sphere | Spheres":
        center, radius, index = self.center[i], self.radius[i], self.material_index[i]
        color = None if self.color is None else self.color[i]
        opacity = None if self.opacity is None else self.opacity[i]
        if isinstance(i, slice):
            part = Spheres(center, radius, index, color, opacity)
            part.names = self.names
            return part
        name = str(index) if self.names is None else self.names[index]
        own = None if color is None else _triple(color)
        part_seen = 1.0 if opacity is None else float(opacity)
        return Sphere(_triple(center), float(radius), name, own, part_seen)

    def __iter__(self) -> Iterator[Sphere]:
        return (self[i] for i in range(len(self)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Spheres):
            return NotImplemented
        if self.names != other.names or len(self) != len(other):
            return False
        mine, theirs = self._arrays(), other._arrays()
        return all(
            a is b or (a is not None and b is not None and np.array_equal(a, b))
            for a, b in zip(mine, theirs, strict=True)
        )

    def __hash__(self) -> int:
        return hash((len(self), self.names))

    def __repr__(self) -> str:
        return f"Spheres(n={len(self)})"

    def _arrays(self) -> tuple[Array, Array, Array, Array | None, Array | None]:
        return self.center, self.radius, self.material_index, self.color, self.opacity

    def with_names(self, names: tuple[str, ...]) -> "Spheres":
        """These spheres, with the scene's names of materials if they have but indices.

        Raises:
            SceneError: an index is too large.
        """
        if self.names is not None:
            return self
        index = self.material_index
        check_rows("spheres.material", index < len(names), index, f"an index below {len(names)}")
        named = copy.copy(self)
        named.names = names
        return named

    @staticmethod
    def of(spheres: "Sequence[Sphere]") -> "Spheres":
        """Any sequence of spheres as arrays."""
        if isinstance(spheres, Spheres):
            return spheres
        colored = any(sphere.color is not None for sphere in spheres)
        color = [sphere.color or (1, 1, 1) for sphere in spheres] if colored else None
        seen_through = any(sphere.opacity < 1 for sphere in spheres)
        opacity = [sphere.opacity for sphere in spheres] if seen_through else None
        return Spheres(
            np.array([sphere.center for sphere in spheres]).reshape(-1, 3),
            np.array([sphere.radius for sphere in spheres], float),
            [sphere.material for sphere in spheres],
            color,
            opacity,
        )

    @staticmethod
    def joined(parts: "Sequence[Spheres]") -> "Spheres":
        """One after the other, if their materials have names. A part that has no colours is white
        among others that have, and opaque if it has no opacities."""
        if len(parts) == 1:
            return parts[0]
        names = tuple(dict.fromkeys(name for part in parts for name in part.names or ()))
        places = [np.array([names.index(name) for name in p.names or ()], np.int32) for p in parts]
        index = [place[p.material_index] for place, p in zip(places, parts, strict=True)]
        color = None
        if any(part.color is not None for part in parts):
            white = np.ones(3, np.float32)
            color = np.concatenate(
                [np.broadcast_to(white, (len(p), 3)) if p.color is None else p.color for p in parts]
            )
        opacity = None
        if any(part.opacity is not None for part in parts):
            ones = (np.ones(len(p)) if p.opacity is None else p.opacity for p in parts)
            opacity = np.concatenate(list(ones))
        found = Spheres(
            frozen(np.concatenate([part.center for part in parts])),
            frozen(np.concatenate([part.radius for part in parts])),
            np.concatenate(index),
            None if color is None else frozen(color),
            None if opacity is None else frozen(opacity),
        )
        return found.with_names(names)


def _opacities(given: ArrayLike, n: int) -> Array:
    """(n,) of numbers from 0 to 1."""
    found = floats("spheres.opacity", given, 1)
    good = found.ndim == 0 or len(found) == n
    require(good, "spheres.opacity", f"{n} numbers", found.shape)
    check_rows("spheres.opacity", (found >= 0) & (found <= 1), found, "a number from 0 to 1")
    return np.broadcast_to(found, n)


def _triple(vector: Array) -> Vec3:
    x, y, z = map(float, vector)
    return x, y, z


def _materials(given: Any, n: int) -> tuple[Array, tuple[str, ...] | None]:
    """Indices (n,) int32, and the names that they count, or None if they count the scene's."""
    if isinstance(given, str):
        return np.broadcast_to(np.int32(0), n), (given,)
    array = np.asarray(given)
    good = array.shape == (n,) and (array.dtype.kind in "iuU" or n == 0)
    require(good, "spheres.material", f"a name, {n} names or {n} indices", given)
    if array.dtype.kind == "U":
        names, index = np.unique(array, return_inverse=True)
        return frozen(index.astype(np.int32)), tuple(map(str, names))
    check_rows("spheres.material", array >= 0, array, "an index of at least 0")
    return frozen(array.astype(np.int32)), None
