"""Other libraries' objects that hold particles, known by their shape: none is imported."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from clrt.errors import SceneError
from clrt.files.particles import arrays, hoomd
from clrt.files.particles.columns import particles
from clrt.particles import elements
from clrt.particles.particles import ALONG_ALL, Particles
from clrt.values import Array


def read(source: Any) -> Particles:
    """Particles of what is none of clrt's.

    ASE's Atoms, MDAnalysis's AtomGroup, gsd's Frame, OVITO's DataCollection; arrays (n, 3), or
    (n, 4) with the radius last; a dict of arrays, as an .npz file; anything with `.positions`.

    Raises:
        SceneError: it is nothing of the kind, or a value is wrong.
    """
    name = type(source).__name__
    if isinstance(source, Particles):
        return source
    if isinstance(source, Mapping):
        return arrays.of_mapping(source, name)
    if hasattr(source, "atoms") and hasattr(source, "trajectory"):
        source = source.atoms  # MDAnalysis's Universe
    inner = getattr(source, "particles", None)
    if hasattr(inner, "positions"):
        return _of_ovito(source, name)
    if hasattr(inner, "position"):
        return hoomd.of_frame(source, name)
    if hasattr(source, "arrays") and hasattr(source, "numbers"):
        return _of_ase(source, name)
    if hasattr(source, "positions"):
        return of_atoms(source, name)
    if isinstance(source, np.ndarray | list | tuple):
        return arrays.of_array(source, name)
    expected = "a file's name, arrays, or an object with positions"
    raise SceneError(f"particles: expected {expected}, got {name}")


def _of_ase(atoms: Any, source: str) -> Particles:
    columns = {name: np.asarray(given) for name, given in atoms.arrays.items()}
    numbers, types = columns.get("numbers"), columns.get("type")
    if types is not None and numbers is not None and ((numbers == 0) | (numbers == types)).any():
        del columns["numbers"]  # ASE guesses those of a dump by types or masses
    cell = np.asarray(atoms.cell)
    origin = np.asarray(atoms.info.get("Origin", atoms.get_celldisp()), np.float64).reshape(-1)
    if not cell.any() or origin.shape != (3,):
        origin = np.zeros(3)
    bonds = None
    if (given := columns.get("bonds")) is not None and given.dtype.kind in "UO":
        bonds = _bonds_of_ase(columns.pop("bonds"))
    return particles(
        columns,
        source,
        cell if cell.any() else None,
        origin,
        bonds=bonds,
        unit="angstrom",
        periodic=np.broadcast_to(getattr(atoms, "pbc", True), 3).tolist(),
    )


def _bonds_of_ase(words: Array) -> Array:
    """(m, 2), of the text that ASE makes of the bonds in a file of LAMMPS's: "2(1),5(1)" of an atom
    that is bonded to atoms 2 and 5."""
    pairs = [
        (i, int(other))
        for i, word in enumerate(words.tolist())
        for other in re.findall(r"(\d+)\(", word)
    ]
    return np.array(pairs, np.int64).reshape(-1, 2)


def of_atoms(group: Any, source: str) -> Particles:
    """MDAnalysis's AtomGroup, and what is like it: what it lacks raises AttributeError there."""
    columns = {"positions": np.array(group.positions)}
    for name, called in GROUP.items():
        given = _attribute(group, name)
        if given is not None and np.shape(given) == (len(columns["positions"]),):
            columns[called] = _plain(np.asarray(given))
    if "elements" in columns and not all(columns["elements"]):
        del columns["elements"]
    if "radii" in columns and not (columns["radii"] > 0).all():
        del columns["radii"]
    types = columns.get("types")
    if types is not None and (
        not all(types)
        or ("name" in columns and elements.of_symbols(set(map(str, types.tolist()))) is not None)
    ):
        del columns["types"]  # MDAnalysis made them of the names
    given = _attribute(group, "velocities")
    if given is not None and np.shape(given) == columns["positions"].shape:
        columns |= {f"v{axis}": np.asarray(given)[:, i] for i, axis in enumerate("xyz")}
    cell, bonds = None, _bonds_of_group(group)
    if getattr(group, "dimensions", None) is not None:
        trajectory = group.universe.trajectory
        cell = np.asarray(trajectory.ts.triclinic_dimensions)
        if str(getattr(trajectory, "filename", "")).endswith(".gsd"):
            return _of_gsd(columns, source, trajectory, bonds)
    return particles(columns, source, cell, bonds=bonds, unit="angstrom")


def _bonds_of_group(group: Any) -> Array | None:
    """(m, 2): the bonds between atoms of a group, by their places in it; None: there are none."""
    pairs = getattr(_attribute(group, "bonds"), "indices", None)
    if pairs is None or np.size(pairs) == 0:
        return None
    atoms = np.asarray(group.ix)
    place = np.full(max(int(atoms.max()), int(np.max(pairs))) + 1, -1)
    place[atoms] = np.arange(len(atoms))
    found: Array = place[np.asarray(pairs)]
    return found[(found >= 0).all(axis=1)]


def _of_gsd(
    columns: dict[str, Array], source: str, trajectory: Any, bonds: Array | None
) -> Particles:
    """With the cell of the file, for MDAnalysis 2.10 takes HOOMD's tilts for angles."""
    file = hoomd.Frames(Path(trajectory.filename))
    try:
        cell = hoomd.cell_of(file.file[trajectory.ts.frame].configuration.box)
    finally:
        file.close()
    return particles(columns, source, cell, -cell.sum(axis=0) / 2, bonds=bonds)


GROUP = {
    "radii": "radii", "elements": "elements", "names": "name", "types": "types",
    "masses": "masses", "charges": "charges", "resnames": "residue", "resids": "residue_id",
    "chainIDs": "chain", "altLocs": "altloc", "occupancies": "occupancy",
    "tempfactors": "b_factor", "segids": "segment",
}  # fmt: skip
"""MDAnalysis's attributes, and what clrt calls them."""


def _attribute(group: Any, name: str) -> Any:
    """What a group has of this name, or None: MDAnalysis raises an error of its own."""
    try:
        return getattr(group, name, None)
    except Exception:
        return None


def _plain(array: Array) -> Array:
    """Names that are Python's objects as NumPy's."""
    return array.astype(str) if array.dtype == object else array


def _of_ovito(collection: Any, source: str) -> Particles:
    """OVITO's DataCollection: "Particle Type" is its name, and vectors have three columns. A
    property of other types, as "Residue Type", is text."""
    part = collection.particles
    columns: dict[str, Array] = {}
    for name in part:
        array = _plain(np.asarray(part[name][:]))  # OVITO gives text as a list, by a slice only
        named = {kind.id: kind.name for kind in getattr(part[name], "types", ())}
        if name != "Particle Type" and array.dtype.kind in "iu" and any(named.values()):
            array = np.array([named.get(kind, "") for kind in array.tolist()])
        name = OVITO.get(name, name)
        if name not in ("Position", "Color") and array.ndim == 2 and array.shape[1] == 3:
            columns |= {f"{name}.{axis}": array[:, i] for i, axis in enumerate("XYZ")}
        else:
            columns[name] = array
    topology = getattr(getattr(part, "bonds", None), "topology", None)
    bonds = None if topology is None else np.asarray(topology)
    type_names = None
    types = columns.pop("Particle Type", None)
    if types is not None:
        kinds = sorted(part.particle_types.types, key=lambda kind: kind.id)
        names, radii = [kind.name for kind in kinds], np.array([kind.radius for kind in kinds])
        which = np.searchsorted([kind.id for kind in kinds], types)
        columns["types"] = types
        if all(names):
            type_names, columns["types"] = tuple(names), which
        if not (columns.get("Radius", np.zeros(0)) > 0).any():
            columns.pop("Radius", None)  # 0 stands for the type's
        if "Radius" not in columns and len(radii) and (radii > 0).all():
            columns["Radius"] = radii[which]
    if collection.cell is None:
        return particles(columns, source, type_names=type_names, bonds=bonds)
    matrix = np.asarray(collection.cell)  # edges and origin are its columns
    periodic = tuple(getattr(collection.cell, "pbc", ALONG_ALL))
    return particles(
        columns,
        source,
        matrix[:, :3].T,
        matrix[:, 3],
        type_names,
        bonds=bonds,
        periodic=periodic,
    )


OVITO = {"Atom Name": "name", "Residue Type": "residue"}
"""OVITO's properties, and what clrt calls them."""
