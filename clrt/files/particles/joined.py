"""Joined: a file of atoms and a trajectory of their places, read by MDAnalysis
(https://www.mdanalysis.org), the extra clrt[traj]."""

from collections.abc import Sequence
from pathlib import Path

from clrt.errors import RequestError, SceneError
from clrt.files.particles import objects
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

    def frame(self, k: int) -> Particles | None:
        """Frame k, or None after the last one."""
        if k >= self.count():
            return None
        self.universe.trajectory[k]
        return objects.of_atoms(self.universe.atoms, self.source)

    def count(self) -> int:
        return len(self.universe.trajectory)

    def close(self) -> None:
        self.universe.trajectory.close()
