"""Other libraries' objects that hold particles, known by their shape: none is imported."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from clrt.errors import SceneError
from clrt.files.particles import arrays, hoomd
from clrt.files.particles.columns import particles
from clrt.particles.particles import Particles
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
    inner = getattr(source, "particles", None)
    if hasattr(inner, "positions"):
        return _of_ovito(source, name)
    if hasattr(inner, "position"):
        return hoomd.of_frame(source, name)
    if hasattr(source, "arrays") and hasattr(source, "numbers"):
        return _of_ase(source, name)
    if hasattr(source, "positions"):
        return _of_atoms(source, name)
    if isinstance(source, np.ndarray | list | tuple):
        return arrays.of_array(source, name)
    expected = "a file's name, arrays, or an object with positions"
    raise SceneError(f"particles: expected {expected}, got {name}")


def _of_ase(atoms: Any, source: str) -> Particles:
    columns = {name: np.asarray(given) for name, given in atoms.arrays.items()}
    cell = np.asarray(atoms.cell)
    return particles(columns, source, cell if cell.any() else None)


def _of_atoms(group: Any, source: str) -> Particles:
    """MDAnalysis's AtomGroup, and what is like it: what it lacks raises AttributeError there."""
    columns = {"positions": np.array(group.positions)}
    for name in ("radii", "elements", "names", "masses", "charges"):
        given = getattr(group, name, None)
        if given is not None and np.shape(given) == (len(columns["positions"]),):
            columns[name] = _plain(np.asarray(given))
    if "elements" in columns and not all(columns["elements"]):
        del columns["elements"]
    if "radii" in columns and not (columns["radii"] > 0).all():
        del columns["radii"]
    cell = None
    if getattr(group, "dimensions", None) is not None:
        cell = np.asarray(group.universe.trajectory.ts.triclinic_dimensions)
    return particles(columns, source, cell)


def _plain(array: Array) -> Array:
    """Names that are Python's objects as NumPy's."""
    return array.astype(str) if array.dtype == object else array


def _of_ovito(collection: Any, source: str) -> Particles:
    """OVITO's DataCollection: "Particle Type" is its name, and vectors have three columns."""
    part = collection.particles
    columns: dict[str, Array] = {}
    for name in part:
        array = np.asarray(part[name])
        if name not in ("Position", "Color") and array.ndim == 2 and array.shape[1] == 3:
            columns |= {f"{name}.{axis}": array[:, i] for i, axis in enumerate("XYZ")}
        else:
            columns[name] = array
    type_names = None
    types = columns.pop("Particle Type", None)
    if types is not None:
        kinds = sorted(part.particle_types.types, key=lambda kind: kind.id)
        names, radii = [kind.name for kind in kinds], np.array([kind.radius for kind in kinds])
        which = np.searchsorted([kind.id for kind in kinds], types)
        columns["types"] = types
        if all(names):
            type_names, columns["types"] = tuple(names), which
        if "Radius" not in columns and len(radii) and (radii > 0).all():
            columns["Radius"] = radii[which]
    if collection.cell is None:
        return particles(columns, source, type_names=type_names)
    matrix = np.asarray(collection.cell)  # edges and origin are its columns
    return particles(columns, source, matrix[:, :3].T, matrix[:, 3], type_names)
