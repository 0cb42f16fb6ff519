"""NumPy's files, and the same arrays in a dict or alone."""

from collections.abc import Mapping
from typing import IO

import numpy as np
from numpy.typing import ArrayLike

from clrt.errors import SceneError
from clrt.files.particles.columns import Columns, particles
from clrt.particles.particles import Particles
from clrt.values import Array, frozen


def read_npz(source: str, file: IO[bytes]) -> Particles:
    """The particles of an .npz file; docs/particles.md names its keys.

    Raises:
        SceneError: naming file, key and what was expected.
    """
    _check(source, file, b"PK")
    with np.load(file, allow_pickle=False) as arrays:
        return of_mapping({name: frozen(arrays[name]) for name in arrays.files}, source)


def read_npy(source: str, file: IO[bytes]) -> Particles:
    """The particles of an .npy file: (n, 2) or (n, 3), or (n, 4) with the radius last.

    Raises:
        SceneError: it has another shape, or a value is wrong.
    """
    _check(source, file, b"\x93NUMPY")
    return of_array(frozen(np.load(file, allow_pickle=False)), source)


def _check(source: str, file: IO[bytes], begin: bytes) -> None:
    """What NumPy says of a file that is something else nobody can use."""
    got = file.read(len(begin))
    if got != begin:
        raise SceneError(f"{source}: expected NumPy's file, which begins {begin!r}, got {got!r}")
    file.seek(0)


def of_array(given: ArrayLike, source: str) -> Particles:
    """Positions (n, 2) or (n, 3), or (n, 4) with the radius last.

    Raises:
        SceneError: it has another shape, or a value is wrong.
    """
    array = _array(given, source)
    if array.ndim != 2 or array.shape[1] not in (2, 3, 4) or array.dtype.kind not in "iuf":
        expected = "numbers of shape (n, 3), or (n, 4) with the radius last"
        raise SceneError(f"{source}: expected {expected}, got {array.dtype} of {array.shape}")
    columns = {"positions": array[:, :3]}
    if array.shape[1] == 4:
        columns["radii"] = array[:, 3]
    return particles(columns, source)


def of_mapping(arrays: Mapping[str, ArrayLike], source: str) -> Particles:
    """Arrays by name, those of an .npz file.

    Raises:
        SceneError: naming the key and what was expected.
    """
    columns = Columns({name: _array(given, f"{source}: {name}") for name, given in arrays.items()})
    cell, origin = columns.take("cell", ndim=0), columns.take("origin", ndim=0)
    if cell is not None and cell.shape == (3,):
        cell = np.diag(cell)
    bonds = columns.take("bonds", ndim=2)
    corner = np.zeros(3) if origin is None else origin
    return particles(columns.left, source, cell, corner, bonds=bonds)


def _array(given: ArrayLike, source: str) -> Array:
    try:
        return np.asarray(given)
    except ValueError:
        raise SceneError(f"{source}: expected an array, got rows of several lengths") from None
