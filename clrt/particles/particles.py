"""What a file of particles holds: positions, and what is known of each."""

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from clrt.errors import RequestError
from clrt.particles import derived, elements
from clrt.particles.texts import Text
from clrt.values import Array, check_rows, did_you_mean, floats, frozen, owned, require, some

HEAVIEST = 118
"""The largest atomic number."""
ALONG_ALL: tuple[bool, ...] = (True, True, True)
ANGSTROMS = {"angstrom": 1.0, "nm": 10.0, "pm": 0.01, "bohr": 0.529177210903, "m": 1e10}
"""Of a unit of length."""


class Particles:
    """n particles, kept as arrays that nobody can change. None stands for what is not known.

    Args:
        positions: (n, 3), in any unit of length; (n, 2) lie at z = 0. float32 and float64 are kept
            as they are; others become float64.
        radii: (n,), or one for all; above 0.
        colors: (n, 3) sRGB: whole numbers to 255, or floats from 0 to 1. `clrt.color.linear` makes
            them linear.
        elements: (n,) atomic numbers; 0 is a particle that is no atom.
        types: (n,) whole numbers.
        type_names: that of type t is type_names[t]; None: types are but numbers.
        values: columns of numbers by name, (n,) each; NaN where nothing is known.
        cell: (3, 3), a row for each edge of the box that they are in.
        origin: (3,), the corner of the box that its edges start from.
        texts: columns of text by name, (n,) str each; none has the name of a column of values.
        bonds: (m, 2) indices of two different particles each.
        unit: that of all lengths, as "angstrom" or "nm".
        periodic: along which edges of the box there are images of the particles.
        facts: what is known of all of them, by name: numbers, as of "frame", "time" and "step".
        opacities: (n,), or one for all, from 0 to 1.

    An array is kept as it is if nobody else can write to it; else it is copied.

    Raises:
        SceneError: naming the first value that is wrong.
    """

    def __init__(
        self,
        positions: ArrayLike,
        radii: ArrayLike | None = None,
        colors: ArrayLike | None = None,
        elements: ArrayLike | None = None,
        types: ArrayLike | None = None,
        type_names: tuple[str, ...] | None = None,
        values: Mapping[str, ArrayLike] | None = None,
        cell: ArrayLike | None = None,
        origin: ArrayLike = (0.0, 0.0, 0.0),
        texts: Mapping[str, ArrayLike] | None = None,
        bonds: ArrayLike | None = None,
        unit: str | None = None,
        periodic: Sequence[bool] = ALONG_ALL,
        facts: Mapping[str, float] | None = None,
        opacities: ArrayLike | None = None,
    ) -> None:
        self.positions: Array = floats("positions", _spatial(positions), 3)
        self.radii = None if radii is None else self._radii(radii)
        """(n,) float32 or float64."""
        self.colors = None if colors is None else self._rows("colors", _colors(colors))
        """(n, 3) uint8, float32 or float64; sRGB."""
        self.elements = None if elements is None else self._elements(elements)
        """(n,) uint8."""
        self.types = None if types is None else self._types(types, type_names)
        """(n,) int32."""
        self.type_names = type_names
        self.values = {name: self._column(name, one) for name, one in (values or {}).items()}
        self.cell = None if cell is None else _box("cell", cell, (3, 3))
        """(3, 3) float64."""
        self.origin = _box("origin", origin, (3,))
        """(3,) float64."""
        self.texts = {name: self._text(name, one) for name, one in (texts or {}).items()}
        """(n,) str each, of NumPy's kind U."""
        self.bonds = None if bonds is None else self._bonds(bonds)
        """(m, 2) int32."""
        good = unit is None or (isinstance(unit, str) and unit != "")
        require(good, "unit", "the name of a unit of length", unit)
        self.unit = unit
        self.opacities = None if opacities is None else self._opacities(opacities)
        """(n,) float32 or float64."""
        self.periodic = tuple(map(bool, periodic))
        require(len(self.periodic) == 3, "periodic", "three times True or False", periodic)
        self.facts = dict(facts or {})

    def __len__(self) -> int:
        return len(self.positions)

    def __repr__(self) -> str:
        return f"Particles(n={len(self)}, columns={list(self.values)})"

    @property
    def angstroms(self) -> float:
        """Of the unit of all lengths, as far as radii of elements need it: 1 if it is unknown."""
        return ANGSTROMS.get(self.unit or "angstrom", 1.0)

    @property
    def columns(self) -> Mapping[str, Array | Text]:
        """All that expressions can name: "x", "y", "z", "radius", "index", "element" (symbols) and
        "type"; `values` and `texts`; and what clrt.particles.derived makes of them."""
        made: dict[str, Any] = {axis: self.positions[:, i] for i, axis in enumerate("xyz")}
        if self.radii is not None:
            made["radius"] = self.radii
        if self.opacities is not None:
            made["opacity"] = self.opacities
        made["index"] = np.arange(len(self))
        if self.elements is not None:
            made["element"] = partial(Text.of, elements.SYMBOLS, self.elements)
        if self.types is not None:
            names = self.type_names
            made["type"] = self.types if names is None else partial(Text.of, names, self.types)
        return derived.with_derived({**self.values, **made}, self.texts, self.elements)

    def column(self, name: str) -> Array:
        """(n,): one of `columns`.

        Raises:
            RequestError: there is none of this name.
        """
        columns = self.columns
        if name not in columns:
            expected = f"expected a column that there is ({some(columns, 20)})"
            raise RequestError(f"{expected}, got {name!r}{did_you_mean(name, columns)}")
        found = columns[name]
        return found.array() if isinstance(found, Text) else found

    def where(self, mask: ArrayLike) -> "Particles":
        """Those of which mask (n,) is True, with the bonds between them.

        Raises:
            SceneError: it is no such mask.
        """
        kept = self.checked_mask(mask)

        def part(array: Array | None) -> Array | None:
            return None if array is None else frozen(array[kept])

        return self.replaced(
            positions=frozen(self.positions[kept]),
            radii=part(self.radii),
            colors=part(self.colors),
            opacities=part(self.opacities),
            elements=part(self.elements),
            types=part(self.types),
            values={name: frozen(column[kept]) for name, column in self.values.items()},
            texts={name: frozen(column[kept]) for name, column in self.texts.items()},
            bonds=None if self.bonds is None else bonds_among(self.bonds, kept),
        )

    def checked_mask(self, mask: ArrayLike) -> Array:
        """(n,) bool.

        Raises:
            SceneError: it is no such mask.
        """
        kept = np.asarray(mask)
        good = kept.dtype == bool and kept.shape == (len(self),)
        require(good, "mask", f"{len(self)} times True or False", mask)
        return kept

    def replaced(self, **changes: Any) -> "Particles":
        """The same with other arrays, by the names of Particles()'s arguments.

        Raises:
            SceneError: as Particles().
        """
        return Particles(**{**vars(self), **changes})

    def _rows(self, key: str, array: Array) -> Array:
        n = len(self)
        require(array.shape[:1] == (n,), key, f"{n} of them, as positions", array.shape)
        return array

    def _radii(self, given: ArrayLike) -> Array:
        radii = floats("radii", given, 1)
        check_rows("radii", radii > 0, radii, "a finite number above 0")
        return self._rows("radii", np.broadcast_to(radii, radii.shape or len(self)))

    def _opacities(self, given: ArrayLike) -> Array:
        found = floats("opacities", given, 1)
        check_rows("opacities", (found >= 0) & (found <= 1), found, "a number from 0 to 1")
        return self._rows("opacities", np.broadcast_to(found, found.shape or len(self)))

    def _elements(self, given: ArrayLike) -> Array:
        expected = f"an atomic number from 0 to {HEAVIEST}"
        found = self._whole("elements", given, (0, HEAVIEST), expected)
        return owned(found.astype(np.uint8, copy=False))

    def _types(self, given: ArrayLike, names: tuple[str, ...] | None) -> Array:
        if names is None:
            found = self._whole("types", given, (-(2**31), 2**31 - 1), "a whole number")
        else:
            found = self._whole("types", given, (0, len(names) - 1), "one that has a name")
        return owned(found.astype(np.int32, copy=False))

    def _whole(self, key: str, given: ArrayLike, limits: tuple[int, int], expected: str) -> Array:
        array = np.asarray(given)
        require(array.ndim == 1 and array.dtype.kind in "biuf", key, "whole numbers", array)
        array = self._rows(key, array)
        good = (array >= limits[0]) & (array <= limits[1])
        if array.dtype.kind == "f":
            good &= np.floor(array) == array
        check_rows(key, good, array, expected)
        return array

    def _column(self, name: str, given: ArrayLike) -> Array:
        array = np.asarray(given)
        require(array.ndim == 1 and array.dtype.kind in "biuf", name, "numbers (n,)", given)
        return owned(self._rows(name, array))

    def _text(self, name: str, given: ArrayLike) -> Array:
        array = np.asarray(given)
        if array.dtype.kind == "O" and all(isinstance(one, str) for one in array.flat):
            array = array.astype(str)
        require(array.ndim == 1 and array.dtype.kind in "SU", name, "text (n,)", given)
        require(name not in self.values, name, "either numbers or text", "both")
        if array.dtype.kind == "S":
            array = np.ascontiguousarray(array, f"S{max(array.dtype.itemsize, 1)}")
            letters = array.view(np.uint8)
            if letters.max(initial=0) < 128:  # ASCII, 20 times as fast as to decode it
                array = letters.astype(np.uint32).view(f"U{array.dtype.itemsize}")
            else:
                array = np.char.decode(array, "utf-8", "replace")
        return owned(self._rows(name, array))

    def _bonds(self, given: ArrayLike) -> Array:
        array, n = np.asarray(given), len(self)
        good = array.shape[1:] == (2,) and array.dtype.kind in "iu"
        require(good or array.size == 0, "bonds", "whole numbers of shape (m, 2)", given)
        array = array.reshape(-1, 2)
        inside = (array >= 0) & (array < n)
        check_rows("bonds", inside, array, f"indices of particles from 0 to {n - 1}")
        two = array[:, 0] != array[:, 1]
        check_rows("bonds", two, array, "two different particles")
        return owned(array.astype(np.int32, copy=False))


def bonds_among(bonds: Array, kept: Array) -> Array:
    """The bonds between the particles that are kept (n,), by their new indices."""
    index = np.cumsum(kept, dtype=np.int32) - 1
    return frozen(index[bonds[kept[bonds].all(axis=1)]])


def _spatial(given: ArrayLike) -> ArrayLike:
    """Positions (n, 2) with z = 0; others as they are."""
    try:
        array = np.asarray(given)
    except ValueError:  # floats() says what is wrong
        return given
    if array.shape[1:] != (2,):
        return array
    return frozen(np.column_stack([array, np.zeros(len(array), array.dtype)]))


def _colors(given: ArrayLike) -> Array:
    array = np.asarray(given)
    if array.dtype.kind not in "iu":
        found = floats("colors", array, 3)
        check_rows("colors", (found >= 0) & (found <= 1), found, "sRGB from 0 to 1")
        return found
    require(array.shape[1:] == (3,), "colors", "numbers of shape (n, 3)", given)
    check_rows("colors", (array >= 0) & (array <= 255), array, "sRGB from 0 to 255")
    return owned(array.astype(np.uint8, copy=False))


def _box(key: str, given: ArrayLike, shape: tuple[int, ...]) -> Array:
    try:
        array = np.asarray(given, np.float64)
    except (TypeError, ValueError):
        array = np.zeros(0)
    good = array.shape == shape and bool(np.isfinite(array).all())
    require(good, key, f"finite numbers of shape {shape}", given)
    return owned(array)
