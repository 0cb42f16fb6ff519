"""GSD, read by gsd (https://gsd.readthedocs.io), the extra clrt[gsd]."""

from pathlib import Path
from typing import Any

import numpy as np

from clrt.errors import RequestError
from clrt.files.particles.columns import particles
from clrt.particles.particles import Particles


class Frames:
    """The frames of a GSD file, one in memory at a time.

    Raises:
        RequestError: gsd is not installed.
    """

    def __init__(self, path: Path) -> None:
        try:
            import gsd.hoomd
        except ImportError:
            raise RequestError(f"{path}: needs gsd: pip install 'clrt[gsd]'") from None
        self.source = str(path)
        self.file = gsd.hoomd.open(self.source, "r")

    def frame(self, k: int) -> Particles | None:
        """Frame k, or None after the last one."""
        return of_frame(self.file[k], f"{self.source}: frame {k}") if k < self.count() else None

    def count(self) -> int:
        return len(self.file)

    def close(self) -> None:
        self.file.close()


def of_frame(frame: Any, source: str) -> Particles:
    """A frame of gsd's, whose box is centred on 0."""
    part = frame.particles
    columns = {
        "positions": part.position,
        "diameter": part.diameter,
        "typeid": part.typeid,
        "mass": part.mass,
        "charge": part.charge,
    }
    columns = {name: np.asarray(given) for name, given in columns.items() if given is not None}
    for i, axis in enumerate("xyz" if part.velocity is not None else ""):
        columns[f"v{axis}"] = np.asarray(part.velocity)[:, i]
    for name, given in frame.log.items():
        if name.startswith("particles/") and np.ndim(given) == 1:
            columns[name.removeprefix("particles/")] = np.asarray(given)
    cell = None
    if frame.configuration.box is not None:
        x, y, z, xy, xz, yz = np.asarray(frame.configuration.box, np.float64)
        cell = np.array([[x, 0, 0], [xy * y, y, 0], [xz * z, yz * z, z]])
    origin = np.zeros(3) if cell is None else -cell.sum(axis=0) / 2
    names = tuple(part.types) if part.types else None
    return particles(columns, source, cell, origin, names)
