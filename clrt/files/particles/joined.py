"""Joined: a file of atoms and a trajectory of their places, read by MDAnalysis
(https://www.mdanalysis.org), the extra clrt[traj]."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from clrt.errors import RequestError, SceneError
from clrt.files.particles import objects, rules
from clrt.files.particles.suffix import PLACES
from clrt.particles.particles import Particles


def are_joined(paths: Sequence[Path]) -> bool:
    """Whether these are a file of atoms, and files of their places."""
    places = [path.suffix.lower() in PLACES for path in paths]
    return len(places) > 1 and not places[0] and all(places[1:])


class Universe:
    """The frames of a trajectory, one in memory at a time.

    Raises:
        RequestError: MDAnalysis is not installed.
        SceneError: a file is not there.
    """

    def __init__(self, paths: Sequence[Path]) -> None:
        try:
            import MDAnalysis
        except ImportError:
            needs = "needs MDAnalysis: pip install 'clrt[traj]'"
            raise RequestError(f"{paths[1]}: {needs}") from None
        for path in paths:  # MDAnalysis would print a traceback of its own as well
            if not path.is_file():
                raise SceneError(f"{path}: no such file")
        self.source = str(paths[1])
        self.universe = MDAnalysis.Universe(*map(str, paths))
        trajectory = self.universe.trajectory
        self._count = len(trajectory) - _lost(getattr(trajectory, "readers", [trajectory])[-1])

    def frame(self, k: int) -> Particles | None:
        """Frame k, or None after the last one."""
        if k >= self.count():
            return None
        step = self.universe.trajectory[k]
        found = objects.of_atoms(self.universe.atoms, self.source)
        given = {"time": step.time, "step": step.data.get("step")}
        return found.replaced(facts={key: one for key, one in given.items() if one is not None})

    def count(self) -> int:
        return self._count

    def close(self) -> None:
        self.universe.trajectory.close()


def _lost(reader: Any) -> int:
    """How many of the frames that MDAnalysis counts in an .xtc file are cut short, which is one at
    most, the last. It says nothing of it, nor of one that it does not count, which a warning does.

    https://manual.gromacs.org/current/reference-manual/file-formats.html#xtc
    """
    offsets = getattr(getattr(reader, "_xdr", None), "offsets", None)
    path = Path(reader.filename)
    if path.suffix.lower() != ".xtc" or offsets is None or not len(offsets):
        return 0
    last, size = int(offsets[-1]), path.stat().st_size
    with path.open("rb") as file:
        file.seek(last)
        head = file.read(96)
    magic, atoms = (int.from_bytes(head[at : at + 4], "big") for at in (0, 4))
    if atoms <= FEW:
        end = last + 56 + 12 * atoms
    else:
        wide = 8 if magic == WIDE else 4  # bytes that count those of the compressed places
        end = last + 88 + wide + -(-int.from_bytes(head[88 : 88 + wide], "big") // 4) * 4
    lost = int(end > size)
    if end != size:
        whole = len(offsets) - lost
        rules.say(str(path), f"frame {whole} is cut short: there are {whole} whole frames")
    return lost


FEW = 9
"""Atoms, at most, whose places .xtc files do not compress."""
WIDE = 2023
"""How a frame of an .xtc file begins whose size has 8 bytes; that of others has 4."""
