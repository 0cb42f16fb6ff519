"""Named columns, as all files and objects have them, to Particles."""

import functools
import warnings
from collections.abc import Callable, Iterable, Mapping

import numpy as np
from numpy.typing import ArrayLike

from clrt.errors import ParticleWarning, SceneError
from clrt.files.particles.text import is_number
from clrt.particles import elements
from clrt.particles.particles import Particles
from clrt.values import Array, RowError, frozen, some

# Names of columns in small letters; the first that there is counts. All others are values.
POSITIONS = ("positions", "position", "pos", "xyz")
COLORS = ("colors", "color", "rgb")
COLOR_TRIPLES = (("red", "green", "blue"), ("r", "g", "b"))
RADII = ("radii", "radius", "r")
DIAMETERS = ("diameters", "diameter")
ELEMENTS = ("numbers", "elements", "element", "species", "symbols", "symbol")
TYPES = ("types", "type", "typeid")
NAMES = ("names", "name")
MASSES = ("masses", "mass")
# Of text columns: those that cannot hold names, and those that hold names or whole numbers, which
# are read faster. Of others nobody knows whether a number is a whole one: they can begin with a 0.
COORDINATES = {"x", "y", "z", "xu", "yu", "zu", "xs", "ys", "zs", "xsu", "ysu", "zsu"}
NUMBERS = {*COORDINATES, *RADII, *DIAMETERS, *COLOR_TRIPLES[0], *COLOR_TRIPLES[1], *MASSES}
WHOLE = {*ELEMENTS, *TYPES, "id", "mol"}


def kind_of(name: str, word: str) -> str:
    """The kind of a column of text (clrt.files.particles.text.Column) that begins with a word."""
    if word and name.lower() not in NUMBERS and not is_number(word):
        return "S"
    return "i8" if name.lower() in WHOLE and word.lstrip("+-").isdecimal() else "f8"


class Columns:
    """Columns by name, in any case of letters, that are taken one after the other."""

    def __init__(self, columns: Mapping[str, Array]) -> None:
        self.left = dict(columns)
        self._names = {name.lower(): name for name in columns}
        self._names |= {name: name for name in columns if name.lower() == name}

    def get(self, *names: str, ndim: int = 1) -> Array | None:
        """The first of these that there is, if it has no fewer dimensions."""
        name = self._find(names, ndim)
        return None if name is None else self.left[name]

    def take(self, *names: str, ndim: int = 1) -> Array | None:
        """The same, which then is no longer there."""
        name = self._find(names, ndim)
        return None if name is None else self.left.pop(name)

    def take_triple(self, *names: str) -> Array | None:
        """Three columns as one of (n, 3), if all are there."""
        found = [self._names.get(name, name) for name in names]
        if not all(name in self.left for name in found):
            return None
        return frozen(np.stack([self.left.pop(name) for name in found], axis=1))

    def _find(self, names: Iterable[str], ndim: int) -> str | None:
        found = (self._names.get(name, name) for name in names)
        return next((n for n in found if n in self.left and self.left[n].ndim >= ndim), None)


def particles(
    columns: Mapping[str, Array],
    source: str,
    cell: ArrayLike | None = None,
    origin: ArrayLike = (0.0, 0.0, 0.0),
    type_names: tuple[str, ...] | None = None,
    line_of: Callable[[int], int] | None = None,
) -> Particles:
    """Particles of columns of numbers or names.

    Args:
        columns: (n,), or (n, 3) for positions and colours; what is left is a value if it is (n,)
            numbers, and not used otherwise.
        source: the file's name, for messages.
        type_names: those that a column of types counts.
        line_of: the line of a row, for errors; None: rows are named.

    Raises:
        SceneError: naming source, line or row, column and what was expected.
    """
    left = Columns(columns)
    positions = left.take(*POSITIONS, ndim=2)
    if positions is None:
        positions = left.take_triple("x", "y", "z")
    if positions is None:
        got = some((name[:20] for name in columns), 8)
        raise SceneError(f"{source}: expected columns x, y and z or positions (n, 3), got {got}")
    colors = left.take(*COLORS, ndim=2)
    for triple in COLOR_TRIPLES:
        colors = left.take_triple(*triple) if colors is None else colors
    radii = left.take(*RADII, ndim=0)
    if radii is None and (diameters := left.take(*DIAMETERS, ndim=0)) is not None:
        radii = diameters if _are_names(diameters) else frozen(np.asarray(diameters / 2))
    numbers, types, type_names = _elements_and_types(left, type_names)
    values = _values(left, source, len(positions))
    try:
        colors = None if colors is None else _bytes(colors)
        return Particles(positions, radii, colors, numbers, types, type_names, values, cell, origin)
    except RowError as error:
        if error.row is None or line_of is None:
            raise SceneError(f"{source}: {error}") from None
        line = line_of(error.row)
        raise SceneError(f"{source}: line {line}: {error.key}: {error.expected}") from None
    except SceneError as error:
        raise SceneError(f"{source}: {error}") from None


def _elements_and_types(
    left: Columns, type_names: tuple[str, ...] | None
) -> tuple[Array | None, Array | None, tuple[str, ...] | None]:
    """The elements that a column has; or those of the types' names, the names or the masses."""
    numbers, types = left.take(*ELEMENTS), left.take(*TYPES)
    if numbers is not None and _are_names(numbers):
        species, numbers = numbers, _numbers(numbers, elements.of_symbols, elements.of_names)
        if numbers is None and types is None:
            types = species
    if types is not None and _are_names(types):
        type_names, types = distinct(types)
    if numbers is None and type_names is not None and types is not None:
        known = elements.of_symbols(type_names)
        numbers = None if known is None else np.take(np.array(known, np.uint8), types, mode="clip")
    if numbers is None and (names := left.get(*NAMES)) is not None and _are_names(names):
        numbers = _numbers(names, elements.of_names)
    if numbers is None and (masses := left.get(*MASSES)) is not None and not _are_names(masses):
        numbers = elements.of_masses(masses)
    return numbers, types, type_names


def _numbers(names: Array, *ways: Callable[[tuple[str, ...]], list[int] | None]) -> Array | None:
    """(n,) uint8: the elements by the first way that knows all names, or None."""
    kinds, which = distinct(names)
    for way in ways:
        if (known := way(kinds)) is not None:
            found: Array = np.array(known, np.uint8)[which]
            return found
    return None


def _values(left: Columns, source: str, n: int) -> dict[str, Array]:
    """The columns of numbers that are left."""
    values = {}
    for name, column in left.left.items():
        if column.shape == (n,) and column.dtype.kind in "biuf":
            values[name] = column
        elif not (_are_names(column) and name.lower() in (*ELEMENTS, *NAMES)):
            _say_unused(source, name, n)
    return values


def distinct(names: Array) -> tuple[tuple[str, ...], Array]:
    """The names that there are, in order, and the index (n,) of each particle's."""
    if names.dtype.kind == "U":
        try:
            names = names.astype("S")
        except UnicodeEncodeError:
            names = np.char.encode(names, "utf-8")
    if names.dtype.itemsize <= 8:  # they are told apart faster as integers
        packed = np.ascontiguousarray(names.astype("S8")).view(np.uint64).byteswap()
        keys, which = np.unique(packed, return_inverse=True)
        keys = keys.byteswap().view("S8")
    else:
        keys, which = np.unique(names, return_inverse=True)
    return tuple(key.decode("utf-8", "replace") for key in keys.tolist()), which.reshape(-1)


@functools.cache  # once for a file, however many frames it has
def _say_unused(source: str, name: str, n: int) -> None:
    message = f"{source}: {name}: is not used, expected numbers of shape ({n},)"
    warnings.warn(message, ParticleWarning, stacklevel=2)


def _are_names(array: Array) -> bool:
    return array.dtype.kind in "SU"


def _bytes(colors: Array) -> Array:
    """Colours that are floats in name only: whole numbers, and one is above 1."""
    if colors.dtype.kind == "f" and (colors > 1).any():
        with np.errstate(invalid="ignore"):
            found = colors.astype(np.uint8)
        return frozen(found) if (found == colors).all() else colors
    return colors
