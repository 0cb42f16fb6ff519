"""Named columns, as all files and objects have them, to Particles.

All that is read passes here, so that the same is left out of every format, and said.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np
from numpy.typing import ArrayLike

from clrt.errors import SceneError
from clrt.files.particles import rules
from clrt.files.particles.naming import (
    ANGLES,
    CENTERS,
    COLOR_TRIPLES,
    COLORS,
    COORDINATES,
    DIAMETERS,
    ELEMENTS,
    LENGTHS,
    MASSES,
    NAMES,
    OPACITIES,
    POSITIONS,
    RADII,
    RESIDUES,
    SEMI_AXES,
    SHAPES,
    TYPES,
    title,
    triple,
)
from clrt.files.particles.text import is_number
from clrt.particles import elements
from clrt.particles.particles import ALONG_ALL, Particles, bonds_among
from clrt.values import Array, RowError, frozen, some

# Of text columns: those that cannot hold names, and those that hold names or whole numbers, which
# are read faster. Of others nobody knows whether a number is a whole one: they can begin with a 0.
NUMBERS = {*COORDINATES, *RADII, *DIAMETERS, *COLOR_TRIPLES[0], *COLOR_TRIPLES[1], *MASSES}
WHOLE = {*ELEMENTS, *TYPES, "id", "mol"}
MOST_PARTS = 64
"""Of a column (n, k) that becomes k columns."""


def kind_of(name: str, word: str) -> str:
    """The kind of a column of text (clrt.files.particles.text.Column) that begins with a word."""
    if word and name.lower() not in NUMBERS and not is_number(word):
        return "S"
    return "i8" if name.lower() in WHOLE and word.lstrip("+-").isdecimal() else "f8"


class Columns:
    """Columns by name, in any case of letters, that are taken one after the other.

    A unit behind a name counts as none of it, see clrt.files.particles.naming.title().
    """

    def __init__(self, columns: Mapping[str, Array]) -> None:
        self.left = {n: column for n, column in columns.items() if not n.startswith(rules.TWICE)}
        self._names: dict[str, str] = {}
        """The names by those in small letters."""
        self._units: dict[str, str | None] = {}
        for name in self.left:
            plain, unit = title(name)
            if plain.lower() not in self._names or plain == plain.lower():
                self._names[plain.lower()] = name
            self._units[name] = unit

    def get(self, *names: str, ndim: int = 1) -> Array | None:
        """The first of these that there is, if it has no fewer dimensions."""
        name = self.find(*names, ndim=ndim)
        return None if name is None else self.left[name]

    def take(self, *names: str, ndim: int = 1) -> Array | None:
        """The same, which then is no longer there."""
        name = self.find(*names, ndim=ndim)
        return None if name is None else self.left.pop(name)

    def take_triple(self, *names: str) -> Array | None:
        """Columns side by side as one of (n, 3), or fewer, if all are there."""
        found = [self._names.get(name, name) for name in names]
        if not all(name in self.left for name in found):
            return None
        return frozen(np.stack([self.left.pop(name) for name in found], axis=1))

    def take_parts(self, *bases: str, least: int = 3) -> Array | None:
        """The columns that are the parts of one of these, as NAME_x, NAME:0 or NAME[1]."""
        names = [name for name, full in self._names.items() if full in self.left]
        for parts in triple(names, bases):
            if len(parts) >= least:
                return self.take_triple(*parts)
        return None

    def find(self, *names: str, ndim: int = 1) -> str | None:
        """The name of the first of these that there is."""
        found = (self._names.get(name, name) for name in names)
        return next((n for n in found if n in self.left and self.left[n].ndim >= ndim), None)

    def unit_of(self, *names: str) -> str | None:
        """The unit of length of the first of these that there is or was, or None."""
        found = (self._names[name] for name in names if name in self._names)
        return next((self._units[name] for name in found), None)


def particles(
    columns: Mapping[str, Array],
    source: str,
    cell: ArrayLike | None = None,
    origin: ArrayLike = (0.0, 0.0, 0.0),
    type_names: tuple[str, ...] | None = None,
    line_of: Callable[[int], int] | None = None,
    *,
    bonds: ArrayLike | None = None,
    unit: str | None = None,
    periodic: Sequence[bool] = ALONG_ALL,
    facts: Mapping[str, float] | None = None,
) -> Particles:
    """Particles of columns of numbers or names.

    Args:
        columns: (n,) each, or (n, k): positions and colours, and others, which become k columns.
            Those that have no meaning here are values if they are numbers, and texts if they are
            text.
        source: the file's name, for messages.
        type_names: those that a column of types counts.
        line_of: the line of a row, for errors; None: rows are named.
        bonds, unit, periodic, facts: as Particles has them.

    Particles without a finite position, and those whose radius is 0 or not finite, are left out.
    Warnings (ParticleWarning) count them, and name whatever is not used.

    Raises:
        SceneError: naming source, line or row, column and what was expected.
    """
    left = Columns(columns)
    positions = _positions(left)
    if positions is None:
        got = some((name[:20] for name in columns), 8)
        raise SceneError(f"{source}: expected columns x, y and z or positions (n, 3), got {got}")
    unit = left.unit_of("x", *POSITIONS) or unit
    colors = _colors(left)
    radii = _radii(left, positions, source, unit)
    numbers, types, type_names = _elements_and_types(left, type_names, source)
    values, texts = _others(left, source, len(positions))
    opacities = _opacities(values, colors is not None, source)
    mask, said = rules.kept(positions, radii)
    for text in said:
        rules.say(source, text)
    rows = None if mask is None else np.flatnonzero(mask)

    def part(array: Array | None) -> Array | None:
        if mask is None or array is None or array.shape[:1] != mask.shape:
            return array
        return frozen(array[mask])

    try:
        found = Particles(
            part(positions),  # type: ignore[arg-type]
            part(radii),
            None if colors is None else rules.bytes_of(part(colors)),  # type: ignore[arg-type]
            part(numbers),
            part(types),
            type_names,
            {name: part(column) for name, column in values.items()},  # type: ignore[misc]
            cell,
            origin,
            {name: part(column) for name, column in texts.items()},  # type: ignore[misc]
            bonds
            if mask is None or bonds is None
            else bonds_among(np.asarray(bonds).reshape(-1, 2), mask),
            unit,
            periodic,
            facts,
            part(opacities),
        )
    except RowError as error:
        if error.row is None or error.key == "bonds" or line_of is None:
            raise SceneError(f"{source}: {error}") from None
        line = line_of(error.row if rows is None else int(rows[error.row]))
        raise SceneError(f"{source}: line {line}: {error.key}: {error.expected}") from None
    except SceneError as error:
        raise SceneError(f"{source}: {error}") from None
    if (crowded := rules.crowded(found.positions)) is not None:
        rules.say(source, crowded)
    return found


def _positions(left: Columns) -> Array | None:
    """(n, 3), or (n, 2) where nothing says z."""
    found = left.take(*POSITIONS, ndim=2)
    for names in (("x", "y", "z"), ("xu", "yu", "zu")):
        found = left.take_triple(*names) if found is None else found
    found = left.take_parts(*POSITIONS, *CENTERS) if found is None else found
    found = left.take_triple("x", "y") if found is None else found
    return left.take_parts(*POSITIONS, *CENTERS, least=2) if found is None else found


def _colors(left: Columns) -> Array | None:
    """(n, 3); what stands beside them as opacity becomes a column of its own."""
    found = left.take(*COLORS, ndim=2)
    if found is not None and found.shape[1] == 4 and left.find(*OPACITIES) is None:
        found, left.left["alpha"] = found[:, :3], found[:, 3]
    for names in COLOR_TRIPLES:
        found = left.take_triple(*names) if found is None else found
    return left.take_parts(*COLORS) if found is None else found


def _radii(left: Columns, positions: Array, source: str, unit: str | None) -> Array | None:
    """(n,), or one for all."""
    name, n = left.find(*RADII, ndim=0), len(positions)
    if name is not None and name.lower() == "r" and left.left[name].shape == (n,):
        angle = left.find(*ANGLES)
        if angle is not None:
            rules.say(source, f"{name}: is no radius beside {angle}: it is a column")
        elif rules.is_distance(left.left[name], positions):
            rules.say(source, f"{name}: is the distance from the origin: it is a column, no radius")
        else:
            return left.left.pop(name)
        name = None
    if name is not None:
        found, own = left.left.pop(name), left.unit_of(title(name).name.lower())
    elif (name := left.find(*DIAMETERS, ndim=0)) is not None:
        found, own = left.left.pop(name), left.unit_of(title(name).name.lower())
        found = found if _are_names(found) else frozen(np.asarray(found / 2))
    else:
        return _enclosing(left, source)
    if own is not None and unit is not None and own != unit and not _are_names(found):
        return frozen(np.asarray(found * (LENGTHS[own] / LENGTHS[unit])))
    return found


def _enclosing(left: Columns, source: str) -> Array | None:
    """(n,) radii of the spheres around ellipsoids."""
    for names in (*SHAPES, *SEMI_AXES):
        found = [left.get(name) for name in names]
        columns = [one for one in found if one is not None and one.dtype.kind in "iuf"]
        if len(columns) == 3:
            part = 2 if names in SHAPES and left.find("blockiness1") is None else 1
            rules.say(source, f"{' '.join(names)}: are drawn as the spheres around them")
            return frozen(np.maximum.reduce(columns) / part)
    return None


def _elements_and_types(
    left: Columns, type_names: tuple[str, ...] | None, source: str
) -> tuple[Array | None, Array | None, tuple[str, ...] | None]:
    """The elements that a column has; or those of the types' names, the names or the masses."""
    is_sure = type_names is not None
    numbers, types = left.take(*ELEMENTS), left.take(*TYPES)
    if numbers is not None and _are_names(numbers):
        species, numbers = numbers, _of_symbols(numbers)
        if numbers is None:
            numbers, _ = _of_names(species, None, source)
        if numbers is None and types is None:
            types = species
    if types is not None and _are_names(types):
        type_names, types = distinct(types)
    if numbers is None and type_names is not None and types is not None:
        known = elements.of_symbols(type_names)
        numbers = None if known is None else np.take(np.array(known, np.uint8), types, mode="clip")
    names = left.get(*NAMES)
    if numbers is None and names is not None and _are_names(names) and not is_sure:
        numbers, is_doubtful = _of_names(names, left.get(*RESIDUES), source)
        if is_doubtful and types is None:
            type_names, types = distinct(names)
    if numbers is None and (masses := left.get(*MASSES)) is not None and not _are_names(masses):
        numbers = elements.of_masses(masses)
    return numbers, types, type_names


def _of_symbols(names: Array) -> Array | None:
    """(n,) uint8: the elements whose symbols these are, or None: one is no symbol."""
    kinds, which = distinct(names)
    known = elements.of_symbols(kinds)
    return None if known is None else frozen(np.array(known, np.uint8)[which])


def _of_names(names: Array, residues: Array | None, source: str) -> tuple[Array | None, bool]:
    """(n,) uint8: the elements that names of atoms speak of, or None; and whether they may be names
    of elements and are taken for none, which a warning says."""
    kinds, which = distinct(names)
    known: list[str] = list(kinds)
    of = None
    if residues is not None and _are_names(residues):
        others, whose = distinct(residues)
        pairs, which = np.unique(which * len(others) + whose, return_inverse=True)
        two = [divmod(pair, len(others)) for pair in pairs.tolist()]
        known, of = [kinds[i] for i, _ in two], [others[j] for _, j in two]
    found = elements.each_of_names(known, of)
    why = elements.doubt(known, found, np.bincount(which).tolist(), of)
    if why is not None:
        rules.say(source, why)
        return None, True
    if None in found or not found:
        return None, False
    return frozen(np.array(found, np.uint8)[which]), False


def _others(left: Columns, source: str, n: int) -> tuple[dict[str, Array], dict[str, Array]]:
    """The columns that are left: of numbers, and of text."""
    values, texts = dict[str, Array](), dict[str, Array]()
    for name, column in left.left.items():
        column = _plain(column)
        found = values if column.dtype.kind in "biuf" else texts
        if column.shape == (n,) and column.dtype.kind in "biufSU":
            found[name] = column
        elif column.shape[:1] == (n,) and column.ndim == 2 and column.dtype.kind in "biufSU":
            if column.shape[1] > MOST_PARTS:
                rules.say(
                    source, f"{name}: is not used, expected at most {MOST_PARTS} numbers each"
                )
                continue
            axes = "xyz" if column.shape[1] == 3 else range(1, column.shape[1] + 1)
            found |= {f"{name}_{axis}": column[:, i] for i, axis in enumerate(axes)}
        else:
            rules.say(source, f"{name}: is not used, expected numbers or text of shape ({n},)")
    return values, texts


def _plain(column: Array) -> Array:
    """Text that is Python's objects as NumPy's."""
    if column.dtype == object and all(isinstance(one, str) for one in column.flat):
        return column.astype(str)
    return column


def _opacities(values: Mapping[str, Array], colored: bool, source: str) -> Array | None:
    """(n,) from 0 to 1, of the first column that speaks of opacity; None: all are opaque.

    colored: there are colours beside it; else "alpha" can be anything.
    """
    for name, column in values.items():
        what = name.lower()
        if what not in OPACITIES or not len(column):
            continue
        if what == "alpha" and not colored:
            rules.say(source, f"{name}: is a column, no opacity beside no colours: not drawn")
            continue
        full = _full(column)
        found = column / full if what != "transparency" else 1 - column / full
        if not ((found >= 0) & (found <= 1)).all():
            rules.say(source, f"{name}: is a column, no opacity from 0 to 1: not drawn")
        elif not found.any():
            rules.say(source, f"{name}: says that no particle is seen: all are drawn opaque")
        elif (found < 1).any():
            return frozen(found)
    return None


def _full(column: Array) -> float:
    """What stands for 1 in a column: 255 or 65535 of whole numbers, if there are larger ones than
    1."""
    if column.dtype.kind not in "iu" or column.max() <= 1:
        return 1.0
    return 65535.0 if column.dtype == np.uint16 or column.max() > 255 else 255.0


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


def _are_names(array: Array) -> bool:
    return array.dtype.kind in "SU"
