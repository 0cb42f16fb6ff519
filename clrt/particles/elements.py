"""Elements: their colours, radii and masses, and which one a particle is by its name or mass.

The arrays have a row for each atomic number; row 0 is a particle that is no atom.
clrt/tables/elements.csv names the sources.
"""

import functools
import re
from collections.abc import Iterable, Sequence

import numpy as np

from clrt import storage
from clrt.values import Array

_TABLE = (storage.folder("tables") / "elements.csv").read_text().splitlines()
_ROWS = [line.split(",") for line in _TABLE if not line.startswith("#")]

SYMBOLS = tuple(row[0] for row in _ROWS)
COLORS = np.array([list(bytes.fromhex(row[1])) for row in _ROWS], np.uint8)
"""(119, 3) sRGB."""
VAN_DER_WAALS = np.array([float(row[2]) for row in _ROWS])
"""(119,) angstroms."""
COVALENT = np.array([float(row[3]) for row in _ROWS])
"""(119,) angstroms."""
MASSES = np.array([float(row[4]) for row in _ROWS])
"""(119,) daltons."""

NUMBERS = {symbol: number for number, symbol in enumerate(SYMBOLS)} | {"D": 1, "T": 1}

# Names of atoms in force fields whose first letter is not their element's.
_TWO_LETTERS = ("Cl", "Br", "Na", "Mg", "Zn", "Fe", "Mn", "Cu", "Si", "Se", "Li")
_UPPER = {symbol.upper(): NUMBERS[symbol] for symbol in _TWO_LETTERS}
# Ions of CHARMM, Amber and GROMACS.
_IONS = {
    "SOD": "Na", "NIO": "Na", "CIP": "Na", "CIO": "Na", "CLA": "Cl", "CIM": "Cl", "POT": "K",
    "CAL": "Ca", "CES": "Cs", "RUB": "Rb", "LIT": "Li", "BAR": "Ba", "IOD": "I", "CAD": "Cd",
}  # fmt: skip
_ION_NUMBERS = {name: NUMBERS[symbol] for name, symbol in _IONS.items()}
_UPPER |= _ION_NUMBERS
_ORGANIC = "HCNOPSFK"
_SITES = ("MW", "LP", "EP", "EPW", "M")
"""Names of places beside the atoms of a model of water, which are no atoms."""
_BEADS = re.compile(r"BB\d?|SC[1-6]|W|WF|PW|WP|NC3|PO4|GL\d|P[1-6]|Q([0-5]|da?|a)|Nda")
"""Names of what stands for several atoms in Martini, https://cgmartini.nl."""
MANY = 20
"""Names are no elements' if one in so many is a bead's, or a rare element's."""
COMMON = 54
"""Elements of larger atomic numbers are rare."""

MASS_TOLERANCE = 0.1  # daltons; force fields round to 0.1, and Ar and Ca are 0.13 apart
DEUTERIUM = 2.014
LIGHTEST = 4.1
"""Masses that are all at most so much, as 1 and 4, are in reduced units."""


def of_symbols(symbols: Iterable[str]) -> list[int] | None:
    """Their atomic numbers, in any case of letters, or None if one is no element's symbol."""
    found = [NUMBERS.get(symbol.capitalize()) for symbol in symbols]
    return None if None in found else found  # type: ignore[return-value]


def each_of_names(names: Iterable[str], residues: Iterable[str] | None = None) -> list[int | None]:
    """The atomic numbers that names of atoms speak of, as CA, 1HB2, OW, Fe2+ or C12; None where one
    says nothing, for what is no atom has names as well.

    residues: the name of each one's residue: CA is a carbon in ALA, and calcium in CA.
    """
    if residues is None:
        return [_of_name(name) for name in names]
    return [_in_residue(name, residue) for name, residue in zip(names, residues, strict=True)]


def doubt(
    names: Sequence[str],
    numbers: Sequence[int | None],
    counts: Sequence[int] | None = None,
    residues: Sequence[str] | None = None,
) -> str | None:
    """Why names are taken for no elements, or None: more than one in MANY is a bead's, or that of
    an element above COMMON, as W, which is Martini's water more often than tungsten. Ions are
    known by their residues."""
    counts = [1] * len(names) if counts is None else counts
    of = [""] * len(names) if residues is None else residues
    odd = dict[str, int]()
    for name, number, count, residue in zip(names, numbers, counts, of, strict=True):
        is_ion = name.upper() in _ION_NUMBERS or _residues().get(residue.upper()) == "ions"
        is_bead = _BEADS.fullmatch(name) is not None
        if not is_ion and ((number or 0) > COMMON or is_bead):
            odd[name] = odd.get(name, 0) + count
    if MANY * sum(odd.values()) <= sum(counts):
        return None
    return f"names as {', '.join(sorted(odd)[:4])} are taken for types, not for elements"


def _of_name(name: str) -> int | None:
    letters = re.match(r"\d*([A-Za-z]*)", name)
    word = letters[1] if letters else ""
    if not word.isupper():  # two letters only where they are written as an element's
        return NUMBERS.get(word[:2], NUMBERS.get(word[:1]))
    if word in _UPPER:
        return _UPPER[word]
    if word in _SITES:
        return 0
    if len(word) == 1 or word[0] in _ORGANIC:
        return NUMBERS.get(word[0])
    return None


def _in_residue(name: str, residue: str) -> int | None:
    kind, word = _residues().get(residue.upper()), re.sub("[^A-Z]", "", name.upper())
    if kind in ("protein", "nucleic"):
        return NUMBERS["Se"] if word == "SE" else NUMBERS.get(word[:1])
    if kind == "water" and word != "W" and word != "PW":
        return NUMBERS.get(word[:1], 0) if word[:1] in ("O", "H", "D") else 0
    if word in _ION_NUMBERS:
        return _ION_NUMBERS[word]
    if (kind == "ions" and len(word) == 2) or word == re.sub("[^A-Z]", "", residue.upper()):
        return NUMBERS.get(word.capitalize(), _of_name(name))
    return _of_name(name)


@functools.cache
def _residues() -> dict[str, str]:
    """What residues are, by their names."""
    rows = (storage.folder("tables") / "residues.csv").read_text().splitlines()
    split = [row.split(",") for row in rows if row.startswith("residue,")]
    return {name: what for _, what, names in split for name in names.split()}


def of_masses(masses: Array) -> Array | None:
    """(n,) uint8: atomic numbers by mass in g/mol, or None if one has no such mass, as united
    atoms, or all are at most LIGHTEST or whole numbers, as in reduced units."""
    kinds, which = np.unique(masses, return_inverse=True)
    if len(kinds) == 0 or len(kinds) > len(MASSES):
        return None
    if (kinds <= LIGHTEST).all() or (kinds == np.rint(kinds)).all():
        return None
    away = np.abs(kinds[:, np.newaxis] - MASSES[1:])
    numbers = away.argmin(axis=1) + 1
    good = away.min(axis=1) <= MASS_TOLERANCE
    heavy = np.abs(kinds - DEUTERIUM) <= MASS_TOLERANCE
    if not (good | heavy).all():
        return None
    numbers[heavy] = 1
    found: Array = numbers.astype(np.uint8)[which]
    return found
