"""Series: files that have a frame each, in the order of their time."""

import re
from collections.abc import Callable, Iterable, Sequence
from contextlib import closing, suppress
from glob import glob, has_magic
from pathlib import Path

from clrt.errors import ClrtError, RequestError
from clrt.files.particles import opened, rules
from clrt.files.particles.trajectory import Frames
from clrt.particles.particles import Particles

STEP = re.compile(r"""(?i)\b(?:time_?step|step|time)\s*=\s*["']?([-+.\deE]+)""")
"""Of a comment of XYZ."""


def files_of(source: str | Path) -> list[Path]:
    """The file of this name, or those that a pattern as dump.* means.

    Raises:
        RequestError: there are none.
    """
    path = Path(source)
    with suppress(OSError, ValueError):
        if not has_magic(str(source)) or path.exists():
            return [path]
    found = sorted(map(Path, glob(str(source))))
    if not found:
        raise RequestError(f"{source}: no such files")
    return found


def in_order(paths: Iterable[Path]) -> list[Path]:
    """Files in the order of their timestep, or if one has none, of the numbers in their names."""
    every = list(paths)
    steps = [step_of(path) for path in every]
    if None not in steps and len(set(steps)) == len(steps):
        return [path for _, path in sorted(zip(steps, every, strict=True))]
    return sorted(every, key=_by_numbers)


def _by_numbers(path: Path) -> tuple[str, list[int], str]:
    """A key that has the numbers in a name as numbers: d.9 before d.10."""
    numbers = [int(word) for word in re.findall(r"\d+", path.name)]
    return re.sub(r"\d+", "0", path.name), numbers, str(path)


def step_of(path: Path) -> float | None:
    """The timestep of a LAMMPS dump or an XYZ file, by its first lines; None: it has none."""
    with suppress(ClrtError, OSError, ValueError, EOFError), opened.binary(path) as file:
        lines = [file.readline(1 << 12).decode("ascii", "replace").strip() for _ in range(6)]
        if "ITEM: TIMESTEP" in lines[:5]:
            return float(lines[lines.index("ITEM: TIMESTEP") + 1])
        if re.fullmatch(r"\d+", lines[0]) and (found := STEP.search(lines[1])):
            return float(found[1])
    return None


class Series:
    """Files as frames, one open at a time.

    Args:
        open_file: opens one.
    """

    def __init__(self, paths: Sequence[Path], open_file: Callable[[Path], Frames]) -> None:
        self.paths, self._open = in_order(paths), open_file

    def frame(self, k: int) -> Particles | None:
        """The first frame of file k, or None after the last one."""
        if k >= len(self.paths):
            return None
        with closing(self._open(self.paths[k])) as frames:
            found = frames.frame(0)
            if found is not None and frames.frame(1) is not None:
                rules.say(str(self.paths[k]), "of several files the first frame each is read")
        return found

    def count(self) -> int:
        return len(self.paths)

    def close(self) -> None: ...
