"""Molecules: atoms as PDB and CIF files list them, which elements they are and which are drawn."""

from typing import NamedTuple

import numpy as np

from clrt.errors import SceneError
from clrt.files.particles import rules
from clrt.files.particles.columns import distinct, particles
from clrt.particles import elements
from clrt.particles.particles import Particles, bonds_among
from clrt.particles.texts import Text
from clrt.particles.texts import distinct as texts
from clrt.values import Array

ALTLOCS = ("most", "all")
"""Which of an atom's alternate locations there are: the most occupied, or all."""
SAME = 1e-3
"""Angstroms; atoms nearer than about this are at one site."""


class Options(NamedTuple):
    """What can be asked of a file of molecules."""

    altloc: str = "most"
    """One of ALTLOCS."""
    assembly: str | None = None
    """The name of a biological assembly; None: the atoms as listed."""


def molecule(
    columns: dict[str, Array],
    symbols: Array,
    source: str,
    cell: Array | None,
    altloc: str = "most",
    bonds: Array | None = None,
) -> Particles:
    """The particles of a list of atoms, in its order.

    Args:
        columns: positions, name, residue, residue_id, chain, altloc, occupancy, and others.
        symbols: (n,) text: the elements that the file names, "" where it names none.
    """
    n = len(columns["positions"])
    if n == 0:
        raise SceneError(f"{source}: expected atoms, got none")
    columns = dict(columns)
    numbers = _numbers(columns, symbols, source)
    types = None
    if numbers is None:
        types, columns["types"] = distinct(columns["name"])
    else:
        columns["numbers"] = numbers
    kept = np.ones(n, bool)
    if altloc != "all" and "altloc" in columns:
        kept &= _most_occupied(columns)
        _say_left(source, int(n - np.count_nonzero(kept)), n, "another location has more occupancy")
    if "occupancy" in columns and (columns["occupancy"] < 1).any():
        alone = _larger(columns, numbers, kept)
        left = int(np.count_nonzero(kept & ~alone))
        _say_left(source, left, n, "a larger atom is at their site, which they share")
        kept &= alone
    for name in ("altloc", "insertion"):
        if name in columns and (columns[name] == b"").all():
            del columns[name]
    if not kept.all():
        columns = {name: column[kept] for name, column in columns.items()}
        bonds = None if bonds is None else bonds_among(bonds, kept)
    columns = {name: _text(one) for name, one in columns.items()}
    return particles(columns, source, cell, type_names=types, bonds=bonds, unit="angstrom")


def _text(column: Array) -> Array:
    return column.astype("S1") if column.dtype == "S0" else column


def _say_left(source: str, left: int, n: int, why: str) -> None:
    if left:
        rules.say(source, f"{left} of {n} particles are left out: {why}")


def _numbers(columns: dict[str, Array], symbols: Array, source: str) -> Array | None:
    """(n,) uint8: the elements by their symbols, and where there are none by their names; None:
    the names are no elements'."""
    kinds = texts(symbols)
    known = [elements.NUMBERS.get(kind.capitalize(), -1) for kind in kinds.kinds]
    numbers: Array = np.array(known, np.int64)[kinds.which]
    unknown = np.flatnonzero((numbers < 0) | (symbols == b"X") | (symbols == b""))
    if len(unknown) == 0:
        return numbers.astype(np.uint8)
    pairs, which, counts = _pairs(columns, unknown)
    names = [name for name, _ in pairs]
    residues = [residue for _, residue in pairs]
    found = elements.each_of_names(names, residues)
    why = elements.doubt(names, found, counts.tolist(), residues)
    nameless = int(counts[[number is None for number in found]].sum())
    if why is None and nameless * elements.MANY > len(unknown):
        odd = sorted({name for name, number in zip(names, found, strict=True) if number is None})
        why = f"names as {', '.join(odd[:4])} are no elements: they are types"
    if why is not None:
        rules.say(source, why)
        return None
    if nameless:
        rules.say(source, f"{nameless} of {len(numbers)} particles are of no known element")
    numbers[unknown] = np.array([number or 0 for number in found])[which]
    return numbers.astype(np.uint8)


def _pairs(columns: dict[str, Array], rows: Array) -> tuple[list[tuple[str, str]], Array, Array]:
    """The pairs of an atom's and a residue's name in these rows, which each has, and how many."""
    names: Text = texts(columns["name"][rows])
    if "residue" not in columns:
        counts = np.bincount(names.which, minlength=len(names.kinds))
        return [(name, "") for name in names.kinds], names.which, counts
    residues = texts(columns["residue"][rows])
    keys = names.which.astype(np.int64) * len(residues.kinds) + residues.which
    kinds, which, counts = np.unique(keys, return_inverse=True, return_counts=True)
    pairs = [divmod(key, len(residues.kinds)) for key in kinds.tolist()]
    return [(names.kinds[i], residues.kinds[j]) for i, j in pairs], which.reshape(-1), counts


def _most_occupied(columns: dict[str, Array]) -> Array:
    """(n,) bool: not the locations of an atom of which another one has more occupancy, and of a
    residue of two kinds not the less occupied kind. Of equal ones the first stays."""
    kept = np.ones(len(columns["altloc"]), bool)
    rows = np.flatnonzero(columns["altloc"] != b"")
    occupancy = columns.get("occupancy", np.ones(len(kept)))
    order = rows[np.argsort(-occupancy[rows], kind="stable")].tolist()
    keys = [
        columns[name] for name in ("chain", "residue_id", "insertion", "copy") if name in columns
    ]
    residue_of = dict[tuple[object, ...], object]()
    taken = set[tuple[object, ...]]()
    for row in order:
        place = tuple(key[row] for key in keys)
        residue = columns["residue"][row] if "residue" in columns else b""
        atom = (*place, columns["name"][row])
        kept[row] = residue_of.setdefault(place, residue) == residue and atom not in taken
        taken.add(atom)
    return kept


def _larger(columns: dict[str, Array], numbers: Array | None, kept: Array) -> Array:
    """(n,) bool: not the smaller one of two atoms at one site, both of occupancy below 1. Atoms
    that have names of locations are no such ones."""
    rows = np.flatnonzero(kept & (columns["occupancy"] < 1))
    if "altloc" in columns:
        rows = rows[columns["altloc"][rows] == b""]
    radii = np.zeros(len(rows)) if numbers is None else elements.VAN_DER_WAALS[numbers[rows]]
    order = rows[np.lexsort((-columns["occupancy"][rows], -radii))]
    alone = np.ones(len(kept), bool)
    places = np.rint(columns["positions"][order] / SAME)
    _, first = np.unique(places, axis=0, return_index=True)
    alone[order] = False
    alone[order[first]] = True
    return alone | ~np.isfinite(columns["positions"]).all(axis=1)
