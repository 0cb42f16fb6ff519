"""CIF and mmCIF, parsed by gemmi (https://gemmi.readthedocs.io), the extra clrt[mol]: molecules
(atom_site in angstroms), crystals (in parts of the cell) and ligands (chem_comp_atom)."""

from collections import defaultdict
from collections.abc import Callable
from functools import partial
from itertools import count, pairwise
from pathlib import Path
from typing import Any

import numpy as np

from clrt.errors import RequestError, SceneError
from clrt.files.particles import rules
from clrt.files.particles.molecules import Options, molecule
from clrt.files.particles.pdb import assembled
from clrt.particles.particles import Particles
from clrt.values import Array

COVALENT = ("covale", "disulf", "metalc")
"""How the kinds of struct_conn begin that are bonds."""
LABELS = ("asym_id", "comp_id", "seq_id", "atom_id")
SETS = ("model_Cartn_{}", "pdbx_model_Cartn_{}_ideal", "{}")
"""Coordinates of a ligand: those of a model, ideal ones, and those of restraints."""


class Blocks:
    """The frames of a CIF file: each block that has atoms, and each model in one.

    Raises:
        RequestError: gemmi is not installed, or there is no such assembly.
        SceneError: there are no atoms in it.
    """

    def __init__(self, path: Path, options: Options = Options()) -> None:  # noqa: B008
        try:
            import gemmi
        except ImportError:
            raise RequestError(f"{path}: needs gemmi: pip install 'clrt[mol]'") from None
        self.source, self.options, self.gemmi = str(path), options, gemmi
        self.frames = list[Callable[[], Particles]]()
        for block in gemmi.cif.read(self.source):
            self._add(block)
        if not self.frames:
            raise SceneError(f"{path}: expected atoms, got none")

    def frame(self, k: int) -> Particles | None:
        """Frame k, or None after the last one."""
        return self.frames[k]() if k < self.count() else None

    def count(self) -> int:
        return len(self.frames)

    def close(self) -> None:
        self.frames = []

    def _add(self, block: Any) -> None:
        ends = ("Cartn_x", "fract_x")
        if block.find_values("_atom_site.Cartn_x"):
            columns, symbols, models = _macromolecule(block, self.gemmi)
            bounds = [0, *(np.flatnonzero(np.diff(models)) + 1).tolist(), len(models)]
            for a, b in pairwise(bounds):
                self.frames.append(partial(self._model, block, columns, symbols, slice(a, b)))
        elif any(block.find_values(f"_atom_site{dot}{end}") for end in ends for dot in "_."):
            self.frames.append(partial(_crystal, block, self.gemmi, self.source))
        elif block.find_values("_chem_comp_atom.atom_id"):
            self.frames.append(partial(_ligand, block, self.gemmi, self.source))

    def _model(
        self, block: Any, columns: dict[str, Array], symbols: Array, rows: slice
    ) -> Particles:
        columns = {name: column[rows] for name, column in columns.items()}
        symbols = symbols[rows]
        cell = _cell(block, self.gemmi)
        bonds = _connected(block, columns)
        if self.options.assembly is not None:
            structure = _assemblies(block, self.gemmi)
            columns, symbols, bonds = assembled(
                columns, symbols, bonds, structure, self.options.assembly, self.source
            )
        for name in ("subchain", "label_seq"):  # those of the authors are columns
            columns.pop(name, None)
        return molecule(columns, symbols, self.source, cell, self.options.altloc, bonds)


def _assemblies(block: Any, gemmi: Any) -> Any:
    """A gemmi.Structure of no atoms with the assemblies of a block."""
    document = gemmi.cif.Document()
    part = document.add_new_block(block.name)
    generators, operators = (
        block.get_mmcif_category(f"_pdbx_struct_{name}.", True)
        for name in ("assembly_gen", "oper_list")
    )
    names = list(dict.fromkeys(generators.get("assembly_id", [])))
    # gemmi 0.7 reads none where one of these columns is missing.
    known = ("details", "method_details", "oligomeric_details", "oligomeric_count")
    unknown = ["?"] * max(len(names), len(operators.get("id", [])))
    for name, table in (
        ("assembly", {"id": names} | {key: unknown[: len(names)] for key in known}),
        ("assembly_gen", generators),
        ("oper_list", {"type": unknown[: len(operators.get("id", []))]} | operators),
    ):
        part.set_mmcif_category(f"_pdbx_struct_{name}.", table, True)
    return gemmi.make_structure_from_block(part)


def _cell(block: Any, gemmi: Any) -> Array | None:
    """(3, 3), a row for each edge; None: there is none, or it stands for none (1 Å)."""
    names = ["length_a", "length_b", "length_c", "angle_alpha", "angle_beta", "angle_gamma"]
    for dot in "._":
        found = [block.find_value(f"_cell{dot}{name}") for name in names]
        if all(found):
            sides = [gemmi.cif.as_number(word) for word in found]
            cell = gemmi.UnitCell(*sides)
            if np.isfinite(sides).all() and cell.is_crystal() and min(sides[:3]) > 1:
                return np.transpose(cell.orth.mat.tolist())
    return None


def _numbers(words: Any, gemmi: Any) -> Array:
    """(n,), NaN where a file has ? or a dot. Figures in brackets are how uncertain one is."""
    try:
        return np.fromiter(map(float, words), np.float64, len(words))
    except ValueError:
        return np.array([gemmi.cif.as_number(word) for word in words], np.float64)


def _text(words: Any, gemmi: Any) -> Array:
    """(n,) of kind S; "" where a file has ? or a dot."""
    kinds = defaultdict[str, int](count().__next__)  # each new word gets the next number
    which = np.fromiter(map(kinds.__getitem__, words), np.intp, len(words))
    found: Array = np.array([gemmi.cif.as_string(word).encode() for word in kinds], "S")[which]
    return found


def _macromolecule(block: Any, gemmi: Any) -> tuple[dict[str, Array], Array, Array]:
    """The columns of atoms in angstroms, their symbols, and the models (n,) that they are of."""

    def values(*names: str) -> Any:
        found = (block.find_values(f"_atom_site.{name}") for name in names)
        return next((one for one in found if one), None)

    axes = [_numbers(values(f"Cartn_{axis}"), gemmi) for axis in "xyz"]
    columns: dict[str, Array] = {"positions": np.stack(axes, axis=1)}
    n = len(columns["positions"])
    for name, tags in (
        ("name", ("auth_atom_id", "label_atom_id", "id")),
        ("residue", ("auth_comp_id", "label_comp_id")),
        ("chain", ("auth_asym_id", "label_asym_id")),
        ("subchain", ("label_asym_id",)),
        ("label_seq", ("label_seq_id",)),
        ("insertion", ("pdbx_PDB_ins_code",)),
        ("altloc", ("label_alt_id",)),
    ):
        if (words := values(*tags)) is not None:
            columns[name] = _text(words, gemmi)
    if (words := values("auth_seq_id", "label_seq_id")) is not None:
        found = _numbers(words, gemmi)
        columns["residue_id"] = np.where(np.isfinite(found), found, -1).astype(np.int64)
    for name, tag in (("occupancy", "occupancy"), ("b_factor", "B_iso_or_equiv")):
        if (words := values(tag)) is not None:
            columns[name] = _numbers(words, gemmi)
    if (words := values("group_PDB")) is not None:
        columns["hetero"] = _text(words, gemmi) == b"HETATM"
    words = values("type_symbol")
    symbols = np.zeros(n, "S1") if words is None else _text(words, gemmi)
    words = values("pdbx_PDB_model_num")
    models = np.zeros(n) if words is None else _numbers(words, gemmi)
    return columns, symbols, models


def _connected(block: Any, columns: dict[str, Array]) -> Array | None:
    """(m, 2): the bonds of struct_conn within the asymmetric unit, or None."""
    tags = [f"ptnr{k}_label_{name}" for k in (1, 2) for name in LABELS]
    table = block.find(
        "_struct_conn.", ["conn_type_id", *tags, "?ptnr1_symmetry", "?ptnr2_symmetry"]
    )
    keys = [columns.get(name) for name in ("subchain", "residue", "label_seq", "name")]
    if len(table) == 0 or any(key is None for key in keys):
        return None
    row_of = dict[tuple[bytes, ...], int]()
    for row, key in enumerate(zip(*(k.tolist() for k in keys if k is not None), strict=True)):
        row_of.setdefault(key, row)
    found = list[tuple[int, int]]()
    for row in table:
        words = [row[i] if row.has(i) else "1_555" for i in range(11)]
        same = words[9] == words[10] or "?" in words[9:] or "." in words[9:]
        if not words[0].startswith(COVALENT) or not same:
            continue
        plain = [b"" if word in ("?", ".") else word.strip("'\"").encode() for word in words[1:9]]
        two = row_of.get(tuple(plain[:4])), row_of.get(tuple(plain[4:]))
        if two[0] is not None and two[1] is not None and two[0] != two[1]:
            found.append((two[0], two[1]))
    return np.array(found, np.int64).reshape(-1, 2)


def _crystal(block: Any, gemmi: Any, source: str) -> Particles:
    """The atoms of a unit cell, by its symmetry; without a cell those that are listed."""

    def values(name: str) -> Any:
        return next((f for dot in "_." if (f := block.find_values(f"_atom_site{dot}{name}"))), None)

    cell = _cell(block, gemmi)
    parts = [values(f"fract_{axis}") for axis in "xyz"]
    cartesian = [values(f"Cartn_{axis}") for axis in "xyz"]
    is_listed = cell is None or any(part is None for part in parts)
    if is_listed and any(axis is None for axis in cartesian):
        raise SceneError(f"{source}: expected a cell (_cell_length_a …) for atoms in parts of one")
    axes = [_numbers(axis, gemmi) for axis in (cartesian if is_listed else parts)]
    places = np.stack(axes, axis=1)
    n = len(places)
    words = {name: values(name) for name in ("label", "type_symbol", "occupancy")}
    label = _text(words["label"], gemmi) if words["label"] else np.zeros(n, "S1")
    columns: dict[str, Array] = {"name": label}
    if words["occupancy"]:
        occupancy = _numbers(words["occupancy"], gemmi)
        columns["occupancy"] = np.where(np.isfinite(occupancy), occupancy, 1.0)
    symbols = _symbols(words["type_symbol"], label, gemmi)
    row = np.arange(n)
    if is_listed:
        columns["positions"] = places
    else:
        assert cell is not None
        row, inside = _images(places, cell, _operations(block, gemmi, source))
        columns = {name: column[row] for name, column in columns.items()}
        columns["positions"] = inside @ cell
    return molecule(columns, symbols[row], source, cell)


def _symbols(words: Any, label: Array, gemmi: Any) -> Array:
    """(n,) of kind S: Na of Na1+, and of labels as Na1 where there is no column of symbols."""
    given = label if words is None else _text(words, gemmi)
    kinds = {kind: gemmi.Element("X") for kind in set(given.tolist())}
    for kind in kinds:
        letters = "".join(c if c.isalpha() else " " for c in kind.decode()).split()
        word = letters[0] if letters and kind[:1].isalpha() else ""
        both, one = gemmi.Element(word[:2]), gemmi.Element(word[:1])
        kinds[kind] = both if both.atomic_number and word[1:2].islower() else (
            both if both.atomic_number and len(word) == 2 and words is not None else one
        )  # fmt: skip
    named = {kind: b"" if e.atomic_number == 0 else e.name.encode() for kind, e in kinds.items()}
    return np.array([named[kind] for kind in given.tolist()], "S2")


def _operations(block: Any, gemmi: Any, source: str) -> list[tuple[Array, Array]]:
    """The turns (3, 3) and steps (3,) of a space group: of the list, or else of the name or number
    that the file has. A list that is no group is applied as it is, which a warning says."""
    small = gemmi.make_small_structure_from_block(block)
    small.determine_and_set_spacegroup("S.H2")
    listed = list(small.symops)
    group = small.spacegroup
    if group is None and listed:
        rules.say(source, "the list of symmetry operations is no space group: applied as listed")
        ops = [gemmi.Op(word) for word in listed]
    else:
        if group is None and small.spacegroup_number:
            group = gemmi.find_spacegroup_by_number(small.spacegroup_number)
        if group is None:
            if small.spacegroup_hm or small.spacegroup_hall:
                name = small.spacegroup_hm or small.spacegroup_hall
                rules.say(source, f"{name!r}: is no space group: only the atoms listed are drawn")
            return [(np.eye(3), np.zeros(3))]
        ops = list(group.operations())
    den = gemmi.Op.DEN
    return [(np.array(op.rot) / den, np.array(op.tran) / den) for op in ops]


def _images(
    places: Array, cell: Array, operations: list[tuple[Array, Array]]
) -> tuple[Array, Array]:
    """The rows and the places in the cell (m, 3) of all images; those of one atom that are nearer
    to each other than NEAR are one: it is on an element of symmetry."""
    rows, found = list[int](), list[Array]()
    for row, place in enumerate(places):
        if not np.isfinite(place).all():
            rows.append(row)
            found.append(place)
            continue
        here = list[Array]()
        for turn, step in operations:
            image = (turn @ place + step) % 1.0
            image[image > 1 - 1e-9] = 0.0
            apart = [image - other for other in here]
            if all(np.linalg.norm((d - np.rint(d)) @ cell) > NEAR for d in apart):
                here.append(image)
        rows += [row] * len(here)
        found += here
    return np.array(rows, np.int64), np.array(found).reshape(-1, 3)


NEAR = 0.1
"""Angstroms."""


def _ligand(block: Any, gemmi: Any, source: str) -> Particles:
    """The atoms of a chemical component: a ? makes all of them go to the next set of places."""

    def values(name: str) -> Any:
        return block.find_values(f"_chem_comp_atom.{name}") or None

    chosen: Array | None = None
    for name in SETS:
        words = [values(name.format(axis)) for axis in "xyz"]
        if all(word is not None for word in words):
            places = np.stack([_numbers(word, gemmi) for word in words], axis=1)
            whole = bool(np.isfinite(places).all())
            chosen = places if chosen is None or whole else chosen
            if whole:
                break
    if chosen is None:
        raise SceneError(f"{source}: expected coordinates of the component's atoms, got none")
    columns: dict[str, Array] = {"positions": chosen, "name": _text(values("atom_id"), gemmi)}
    if (words := values("comp_id")) is not None:
        columns["residue"] = _text(words, gemmi)
    words = values("type_symbol")
    symbols = np.zeros(len(chosen), "S1") if words is None else _text(words, gemmi)
    row_of = {name: row for row, name in enumerate(columns["name"].tolist())}
    table = block.find("_chem_comp_bond.", ["atom_id_1", "atom_id_2"])
    pairs = [[row_of.get(gemmi.cif.as_string(w).encode()) for w in row] for row in table]
    bonds = np.array([two for two in pairs if None not in two], np.int64).reshape(-1, 2)
    return molecule(columns, symbols, source, None, bonds=bonds if len(bonds) else None)
