"""Particles by a file's name or of an object: which of the readers reads it."""

import gzip
import io
import operator
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import IO, Any, Self, cast

from clrt.errors import ClrtError, RequestError, SceneError
from clrt.files.particles import (
    arrays,
    csv,
    hoomd,
    lammps,
    molecules,
    objects,
    ply,
    suffix,
    xyz,
)
from clrt.files.particles.text import Lines
from clrt.files.particles.trajectory import Frames, Single, Trajectory
from clrt.particles.particles import Particles

BUFFER = 1 << 20  # bytes


def read(source: Any, frame: int = 0) -> Particles:
    """One frame of a file of particles, or an object's particles.

    Args:
        source: a file's name: .npz .npy .csv .ply .xyz .extxyz .dump .lammpstrj, and with an extra
            .pdb .cif .gsd; all but .gsd may be gzipped (.gz). Or ASE's Atoms, MDAnalysis's
            AtomGroup, gsd's Frame, OVITO's DataCollection, an array (n, 3), or (n, 4) with the
            radius last, or a dict of arrays with the keys of an .npz file.
        frame: which one, from 0.

    Returns:
        what the file has, in its own units. Colours are sRGB, as in the file.

    Raises:
        SceneError: it cannot be read; the message names file, line and what was expected.
        RequestError: the suffix is of no format, an extra is missing, or there is no such frame.
        OutputError: it does not fit into memory.
    """
    try:
        k = operator.index(frame)
    except TypeError:
        k = -1
    if k < 0:
        raise RequestError(f"frame: expected a whole number from 0 on, got {frame!r}")
    if not isinstance(source, str | os.PathLike):
        if k > 0:
            raise RequestError(f"frame: expected 0 for what is no file, got {k}")
        return objects.read(source)
    with Reader(Path(source)) as file:
        if (particles := file.frame(k)) is None:
            last = file.count() - 1
            raise RequestError(f"{source}: expected a frame from 0 to {last}, got {k}")
    return particles


def read_frames(path: str | os.PathLike[str]) -> Iterator[Particles]:
    """All frames of a file, one after the other, and no more than one in memory.

    Raises:
        as read(), when the frame is due.
    """
    with Reader(Path(path)) as file:
        for k in count():
            if (particles := file.frame(k)) is None:
                return
            yield particles


class Reader:
    """A file of particles, open.

    Raises:
        as read(), from all that it does.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with _told(path):
            self._frames = _opener(path)(path)

    def frame(self, k: int) -> Particles | None:
        """Frame k, from 0, or None after the last one."""
        with _told(self.path):
            return self._frames.frame(k)

    def count(self) -> int:
        """How many frames there are. A text file is read to its end for that, once."""
        with _told(self.path):
            return self._frames.count()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._frames.close()


def _opener(path: Path) -> "Callable[[Path], Frames]":
    kind, is_packed = suffix.split(path)
    if kind not in READERS or (is_packed and kind == ".gsd"):
        raise RequestError(f"{path}: expected a name that ends in one of {' '.join(READERS)}")
    if not path.is_file():
        if path.exists():
            raise SceneError(f"{path}: is a folder or a device, expected a file")
        raise SceneError(f"{path}: no such file")
    return READERS[kind]


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """Makes one line of what goes wrong."""
    try:
        yield
    except ClrtError:
        raise
    except Exception as error:  # what a spoilt file makes of NumPy, gzip and gemmi has no end
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise SceneError(f"{path}: cannot be read: {' '.join(reason.split())}") from None


def _lines(path: Path) -> Lines:
    is_packed = suffix.split(path)[1]
    raw = cast(io.RawIOBase, gzip.GzipFile(path)) if is_packed else io.FileIO(path)
    return Lines(path, io.BufferedReader(raw, BUFFER), is_packed)


def _text(read: Callable[[Lines], Particles]) -> Callable[[Path], Frames]:
    def single(path: Path) -> Frames:
        lines = _lines(path)
        return Single(lambda: read(lines), lines.file.close)

    return single


def _arrays(read: Callable[[str, IO[bytes]], Particles]) -> Callable[[Path], Frames]:
    def single(path: Path) -> Frames:
        # NumPy would read a BufferedReader of gzip's past it, from the file below.
        file = cast(IO[bytes], gzip.GzipFile(path)) if suffix.split(path)[1] else path.open("rb")
        return Single(lambda: read(str(path), file), file.close)

    return single


def _xyz(path: Path) -> Frames:
    return Trajectory(_lines(path), xyz.read, xyz.skip)


def _lammps(path: Path) -> Frames:
    return Trajectory(_lines(path), lammps.read, lammps.skip)


READERS: dict[str, Callable[[Path], Frames]] = {
    ".npz": _arrays(arrays.read_npz),
    ".npy": _arrays(arrays.read_npy),
    ".csv": _text(csv.read),
    ".ply": _text(ply.read),
    ".xyz": _xyz,
    ".extxyz": _xyz,
    ".dump": _lammps,
    ".lammpstrj": _lammps,
    ".pdb": molecules.Models,
    ".cif": molecules.Models,
    ".gsd": hoomd.Frames,
}
