"""Elements: their colours, radii and masses, and which one a particle is by its name or mass.

The arrays have a row for each atomic number; row 0 is a particle that is no atom.
clrt/tables/elements.csv names the sources.
"""

import re
from collections.abc import Iterable

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
_IONS = {"SOD": "Na", "CLA": "Cl", "POT": "K", "CAL": "Ca", "CES": "Cs"}
_UPPER |= {name: NUMBERS[symbol] for name, symbol in _IONS.items()}
_ORGANIC = "HCNOPSFK"

MASS_TOLERANCE = 0.1  # daltons; force fields round to 0.1, and Ar and Ca are 0.13 apart
DEUTERIUM = 2.014


def of_symbols(symbols: Iterable[str]) -> list[int] | None:
    """Their atomic numbers, in any case of letters, or None if one is no element's symbol."""
    found = [NUMBERS.get(symbol.capitalize()) for symbol in symbols]
    return None if None in found else found  # type: ignore[return-value]


def of_names(names: Iterable[str]) -> list[int] | None:
    """The atomic numbers that names of atoms speak of, as CA, 1HB2, OW, Fe2+ or C12.

    None if one says nothing: what is no atom has names as well.
    """
    found = [_of_name(name) for name in names]
    return None if None in found else found  # type: ignore[return-value]


def _of_name(name: str) -> int | None:
    letters = re.match(r"\d*([A-Za-z]*)", name)
    word = letters[1] if letters else ""
    if not word.isupper():  # two letters only where they are written as an element's
        return NUMBERS.get(word[:2], NUMBERS.get(word[:1]))
    if word in _UPPER:
        return _UPPER[word]
    if len(word) == 1 or word[0] in _ORGANIC:
        return NUMBERS.get(word[0])
    return None


def of_masses(masses: Array) -> Array | None:
    """(n,) uint8: atomic numbers by mass, or None if one has no such mass, as united atoms, or all
    are 1, as in reduced units."""
    kinds, which = np.unique(masses, return_inverse=True)
    if len(kinds) == 0 or len(kinds) > len(MASSES) or (kinds == 1).all():
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
