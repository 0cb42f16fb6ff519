"""Particles by a file's name or of an object: which of the readers reads it."""

import operator
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import partial
from itertools import count
from pathlib import Path
from typing import IO, Any, Self

from clrt.errors import ClrtError, RequestError, SceneError
from clrt.files.particles import (
    arrays,
    cif,
    csv,
    gro,
    hoomd,
    joined,
    lammps,
    lammps_data,
    objects,
    opened,
    pdb,
    ply,
    poscar,
    series,
    suffix,
    vtk,
    xyz,
)
from clrt.files.particles.molecules import ALTLOCS, Options
from clrt.files.particles.text import Lines
from clrt.files.particles.trajectory import Frames, Single, Trajectory
from clrt.particles.particles import Particles

Source = str | os.PathLike[str] | Sequence[str | os.PathLike[str]]


def read(
    source: Any,
    frame: int = 0,
    format: str | None = None,
    altloc: str = "most",
    assembly: str | int | None = None,
) -> Particles:
    """One frame of a file of particles, or an object's particles.

    Args:
        source: a file's name; docs/particles.md has the formats. "-" is stdin. Several names, or a
            pattern as "dump.*", are one file a frame, in the order of their timestep if each has
            one, or else of the numbers in their names. Or ASE's Atoms, MDAnalysis's AtomGroup,
            gsd's Frame, OVITO's DataCollection, an array (n, 2) or (n, 3), or (n, 4) with the
            radius last, or a dict of arrays with the keys of an .npz file.
        frame: which one, from 0; -1 is the last one.
        format: a name of clrt.files.particles.suffix.FORMATS, for a file whose name does not tell.
        altloc: of PDB and mmCIF: "most", the most occupied of an atom's alternate locations, or
            "all" of them.
        assembly: of PDB and mmCIF: the name of a biological assembly, as 1.

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
        raise RequestError(f"frame: expected a whole number, got {frame!r}") from None
    if not is_source(source):
        if k not in (0, -1):
            raise RequestError(f"frame: expected 0 for what is no file, got {k}")
        if assembly is not None:
            raise _no_assembly(type(source).__name__)
        return objects.read(source)
    with Reader(source, format, altloc, assembly) as file:
        found = file.frame(file.count() + k if k < 0 else k)
        if found is None:
            last = file.count() - 1
            raise RequestError(f"{file.name}: expected a frame from 0 to {last}, got {k}")
    return found


def read_frames(
    path: Source,
    format: str | None = None,
    altloc: str = "most",
    assembly: str | int | None = None,
) -> Iterator[Particles]:
    """All frames of a file, or of files with a frame each, one after the other, and no more than
    one in memory.

    Raises:
        as read(), when the frame is due.
    """
    with Reader(path, format, altloc, assembly) as file:
        for k in count():
            if (particles := file.frame(k)) is None:
                return
            yield particles


def _options(altloc: str, assembly: str | int | None) -> Options:
    if altloc not in ALTLOCS:
        raise RequestError(f"altloc: expected one of {', '.join(ALTLOCS)}, got {altloc!r}")
    return Options(altloc, None if assembly is None else str(assembly))


def is_source(given: Any) -> bool:
    """Whether this is a file's name, or several."""
    if isinstance(given, list | tuple) and given:
        return all(isinstance(one, str | os.PathLike) for one in given)
    return isinstance(given, str | os.PathLike)


class Reader:
    """A file of particles, or some with a frame each, open.

    Args:
        as of read().

    Raises:
        as read(), from all that it does.
    """

    def __init__(
        self,
        source: Source,
        format: str | None = None,
        altloc: str = "most",
        assembly: str | int | None = None,
    ) -> None:
        options = _options(altloc, assembly)
        given = [source] if isinstance(source, str | os.PathLike) else list(source)
        paths = [path for one in given for path in series.files_of(Path(one))]
        self.name = str(given[0]) if len(given) == 1 else f"{given[0]} and others"
        with _told(self.name):
            if joined.are_joined(paths):
                if assembly is not None:
                    raise _no_assembly(self.name)
                self._frames: Frames = joined.Universe(paths)
            elif len(paths) == 1:
                self._frames = _open(paths[0], format, options)
            else:
                for path in paths:
                    _check(path, format)
                self._frames = series.Series(paths, lambda path: _open(path, format, options))

    def frame(self, k: int) -> Particles | None:
        """Frame k, from 0, or None after the last one."""
        with _told(self.name):
            found = self._frames.frame(k) if k >= 0 else None
            if found is not None:
                found.facts["frame"] = k
            return found

    def count(self) -> int:
        """How many frames there are. A text file is read to its end for that, once."""
        with _told(self.name):
            return self._frames.count()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *error: object) -> None:
        self._frames.close()


def _check(path: Path, format: str | None) -> str:
    """The format of a file that is there.

    Raises:
        RequestError: it is of none, or is not there.
    """
    if format is not None and format not in READERS:
        raise RequestError(f"format: expected one of {', '.join(READERS)}, got {format!r}")
    form = format or suffix.format_of(path)
    if str(path) == suffix.STDIN:
        if form is None:
            raise RequestError(f"-: stdin needs --format NAME, one of {', '.join(READERS)}")
        return form
    if form is None:
        raise RequestError(f"{path}: {suffix.reads_it(path)}")
    if not path.is_file():
        if path.exists():
            raise SceneError(f"{path}: is a folder or a device, expected a file")
        raise SceneError(f"{path}: no such file")
    return form


def _no_assembly(name: str) -> RequestError:
    return RequestError(f"{name}: assembly: expected a file of {' or '.join(MOLECULES)}")


def _open(path: Path, format: str | None, options: Options) -> Frames:
    form = _check(path, format)
    if form in MOLECULES:
        return _library(form, partial(MOLECULES[form], options=options))(path)
    if options.assembly is not None:
        raise _no_assembly(str(path))
    return READERS[form](path)


@contextmanager
def _told(name: str) -> Iterator[None]:
    """Makes one line of what goes wrong."""
    try:
        yield
    except ClrtError:
        raise
    except Exception as error:  # what a spoilt file makes of NumPy, gzip and gemmi has no end
        reason = getattr(error, "strerror", None) or str(error) or type(error).__name__
        raise SceneError(f"{name}: cannot be read: {' '.join(reason.split())}") from None


def _text(read: Callable[[Lines], Particles]) -> Callable[[Path], Frames]:
    def single(path: Path) -> Frames:
        lines = opened.lines(path)
        return Single(lambda: read(lines), lines.file.close)

    return single


def _arrays(read: Callable[[str, IO[bytes]], Particles]) -> Callable[[Path], Frames]:
    def single(path: Path) -> Frames:
        file = opened.binary(path)  # NumPy would read a BufferedReader of gzip's past it
        return Single(lambda: read(str(path), file), file.close)

    return single


def _xyz(path: Path) -> Frames:
    return Trajectory(opened.lines(path), xyz.read, xyz.skip)


def _lammps(path: Path) -> Frames:
    return Trajectory(opened.lines(path), lammps.read, lammps.skip)


def _gro(path: Path) -> Frames:
    return Trajectory(opened.lines(path), gro.read, gro.skip)


class _OnDisk:
    """Frames of a library that opens files by their names: of an unpacked file."""

    def __init__(self, path: Path, form: str, open_file: Callable[[Path], Frames]) -> None:
        self._stack = ExitStack()
        with self._stack:
            self._frames = open_file(self._stack.enter_context(opened.on_disk(path, form)))
            self._stack.callback(self._frames.close)
            self._stack = self._stack.pop_all()
        self.frame, self.count = self._frames.frame, self._frames.count

    def close(self) -> None:
        self._stack.close()


def _library(form: str, open_file: Callable[[Path], Frames]) -> Callable[[Path], Frames]:
    return lambda path: (
        _OnDisk(path, form, open_file) if opened.is_packed(path) else open_file(path)
    )


MOLECULES: dict[str, Callable[..., Frames]] = {"pdb": pdb.Models, "cif": cif.Blocks}

READERS: dict[str, Callable[[Path], Frames]] = {
    "npz": _arrays(arrays.read_npz),
    "npy": _arrays(arrays.read_npy),
    "csv": _text(csv.read),
    "ply": _text(ply.read),
    "xyz": _xyz,
    "dump": _lammps,
    "data": _text(lammps_data.read),
    **{form: _library(form, open_file) for form, open_file in MOLECULES.items()},
    "gsd": _library("gsd", hoomd.Frames),
    "gro": _gro,
    "poscar": lambda path: poscar.Steps(opened.lines(path)),
    "vtk": _library("vtk", lambda path: Single(lambda: vtk.read(path), lambda: None)),
}
"""By the names of clrt.files.particles.suffix.FORMATS."""
