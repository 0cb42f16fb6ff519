"""Rows: what many spheres and many capsules have in common: an array of each of their values.

Nothing is copied that nobody else can change, and everything is checked once, when it is made.
"""

import copy
from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from typing import Any, ClassVar, Self, TypeVar, overload

import numpy as np
from numpy.typing import ArrayLike

from clrt.values import Array, Vec3, check_rows, floats, frozen, owned, require

T = TypeVar("T")


class Rows(Sequence[T]):
    """Many things of one kind, kept as arrays. Immutable, and equal to another by value."""

    KEY: ClassVar[str]
    """How a scene calls them."""
    ARRAYS: ClassVar[tuple[str, ...]]
    """The names of their arrays, each of a row a thing. Some may be None: all ones."""

    color: Array | None
    material_index: Array
    names: tuple[str, ...] | None
    """What material_index counts; None: the scene's materials."""

    @abstractmethod
    def _row(self, i: int, material: str) -> T:
        """One of them."""

    def __len__(self) -> int:
        return len(self.material_index)

    @overload
    def __getitem__(self, i: int) -> T: ...

    @overload
    def __getitem__(self, i: slice) -> Self: ...

    def __getitem__(self, i: int | slice) -> T | Self:
        index = self.material_index[i]
        if not isinstance(i, slice):
            return self._row(i, str(index) if self.names is None else self.names[index])
        part = copy.copy(self)
        part.material_index = index
        for name, array in self._given():
            setattr(part, name, owned(array[i]))
        return part

    def __iter__(self) -> Iterator[T]:
        return (self[i] for i in range(len(self)))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, type(self)):
            return NotImplemented
        if self.names != other.names or len(self) != len(other):
            return False
        mine, theirs = dict(self._given()), dict(other._given())
        if mine.keys() != theirs.keys():
            return False
        pairs = [(mine[name], theirs[name]) for name in mine]
        pairs.append((self.material_index, other.material_index))
        return all(a is b or np.array_equal(a, b) for a, b in pairs)

    def __hash__(self) -> int:
        return hash((len(self), self.names))

    def __repr__(self) -> str:
        return f"{type(self).__name__}(n={len(self)})"

    def _given(self) -> Iterator[tuple[str, Array]]:
        """The arrays that there are."""
        for name in self.ARRAYS:
            if (array := getattr(self, name)) is not None:
                yield name, array

    @property
    def used(self) -> list[str]:
        """The names of their materials, if these have names."""
        there = np.flatnonzero(np.bincount(self.material_index))
        return [(self.names or ())[i] for i in there]

    def with_names(self, names: tuple[str, ...]) -> Self:
        """These, with the scene's names of materials if they have but indices.

        Raises:
            SceneError: an index is too large.
        """
        if self.names is not None:
            return self
        index = self.material_index
        check_rows(
            f"{self.KEY}.material", index < len(names), index, f"an index below {len(names)}"
        )
        named = copy.copy(self)
        named.names = names
        return named

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """One after the other, if their materials have names. A part that lacks an array which
        others have is of ones there: white, opaque."""
        if len(parts) == 1:
            return parts[0]
        names = tuple(dict.fromkeys(name for part in parts for name in part.names or ()))
        places = [np.array([names.index(name) for name in p.names or ()], np.int32) for p in parts]
        index = [place[p.material_index] for place, p in zip(places, parts, strict=True)]
        found = copy.copy(parts[0])
        found.names, found.material_index = names, frozen(np.concatenate(index))
        for name in cls.ARRAYS:
            setattr(found, name, _joined([getattr(p, name) for p in parts], list(map(len, parts))))
        return found


def _joined(arrays: Sequence[Array | None], lengths: Sequence[int]) -> Array | None:
    """One array after the other; ones, as many as `lengths` says, for those that are not there."""
    given = next((array for array in arrays if array is not None), None)
    if given is None:
        return None
    one = np.ones(given.shape[1:], np.float32)
    every = [
        np.broadcast_to(one, (n, *one.shape)) if array is None else array
        for array, n in zip(arrays, lengths, strict=True)
    ]
    return frozen(np.concatenate(every))


def triple(vector: Array) -> Vec3:
    """A row as a struct has it."""
    x, y, z = map(float, vector)
    return x, y, z


def _one_each(
    key: str, given: ArrayLike, n: int, good: Callable[[Array], Array], expected: str
) -> Array:
    """(n,) of good, finite numbers, of n or of one for all.

    Raises:
        SceneError: they are not.
    """
    found = floats(key, given, 1)
    require(found.ndim == 0 or len(found) == n, key, f"{n} numbers", found.shape)
    check_rows(key, good(found), found, expected)
    return np.broadcast_to(found, n)


def radii_of(key: str, given: ArrayLike, n: int) -> Array:
    """(n,) of radii, of n or of one for all.

    Raises:
        SceneError: they are not.
    """
    return _one_each(key, given, n, lambda radii: radii > 0, "a finite number above 0")


def opacities_of(key: str, given: ArrayLike, n: int) -> Array:
    """(n,) of opacities, of n or of one for all.

    Raises:
        SceneError: they are not.
    """
    return _one_each(key, given, n, lambda part: (part >= 0) & (part <= 1), "a number from 0 to 1")


def colors_of(key: str, given: ArrayLike | None, n: int) -> Array | None:
    """(n, 3) of colours, or None.

    Raises:
        SceneError: they are not.
    """
    if given is None:
        return None
    found = floats(key, given, 3)
    require(len(found) == n, key, f"{n} colours", found.shape)
    return found


def own_colors(things: Sequence[Any]) -> list[Vec3] | None:
    """The colours of structs that may have one, white where another's has; None: none has one."""
    if all(thing.color is None for thing in things):
        return None
    return [thing.color or (1, 1, 1) for thing in things]


def materials_of(key: str, given: Any, n: int) -> tuple[Array, tuple[str, ...] | None]:
    """Indices (n,) int32, and the names that they count, or None if they count the scene's.

    Raises:
        SceneError: it is no name, nor n names, nor n indices.
    """
    if isinstance(given, str):
        return np.broadcast_to(np.int32(0), n), (given,)
    array = np.asarray(given)
    good = array.shape == (n,) and (array.dtype.kind in "iuU" or n == 0)
    require(good, key, f"a name, {n} names or {n} indices", given)
    if array.dtype.kind == "U":
        names, index = np.unique(array, return_inverse=True)
        return frozen(index.astype(np.int32)), tuple(map(str, names))
    check_rows(key, array >= 0, array, "an index of at least 0")
    return frozen(array.astype(np.int32)), None
