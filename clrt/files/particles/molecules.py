"""PDB, mmCIF and CIF, read by gemmi (https://gemmi.readthedocs.io), the extra clrt[mol]."""

from pathlib import Path
from typing import Any

import numpy as np

from clrt.errors import RequestError, SceneError
from clrt.files.particles.columns import particles
from clrt.particles.particles import Particles
from clrt.values import Array


class Models:
    """The models of a file, which are its frames. All of them are in memory.

    A CIF file without coordinates in angstroms is a crystal: its one frame is its unit cell.

    Raises:
        RequestError: gemmi is not installed.
        SceneError: there are no atoms in it.
    """

    def __init__(self, path: Path) -> None:
        try:
            import gemmi
        except ImportError:
            raise RequestError(f"{path}: needs gemmi: pip install 'clrt[mol]'") from None
        self.source = str(path)
        structure = gemmi.read_structure(self.source)
        flat = gemmi.FlatStructure(structure)
        self.cell = structure.cell
        self.columns: dict[str, Array] = {
            "positions": np.array(flat.pos),  # they lie in gemmi's memory
            "numbers": np.minimum(flat.elements, 119),
            "b_factor": np.array(flat.b_iso),
            "occupancy": np.array(flat.occ),
        }
        ends = np.flatnonzero(np.diff(flat.model_num)) + 1
        if len(flat.pos) == 0 and ".cif" in path.suffixes:
            self.cell, self.columns = _unit_cell(self.source, gemmi)
        n = len(self.columns["positions"])
        if n == 0:
            raise SceneError(f"{path}: expected atoms, got none")
        self.columns["numbers"][self.columns["numbers"] == 119] = 1  # gemmi's deuterium
        self.bounds = [0, *ends.tolist(), n]

    def frame(self, k: int) -> Particles | None:
        """Frame k, or None after the last one."""
        if k >= self.count():
            return None
        rows = slice(self.bounds[k], self.bounds[k + 1])
        columns = {name: column[rows] for name, column in self.columns.items()}
        cell = np.transpose(self.cell.orth.mat.tolist()) if self.cell.is_crystal() else None
        return particles(columns, self.source, cell)

    def count(self) -> int:
        return len(self.bounds) - 1

    def close(self) -> None:
        self.columns = {}


def _unit_cell(source: str, gemmi: Any) -> tuple[Any, dict[str, Array]]:
    """The cell of a crystal, and the atoms in it, by its symmetry."""
    crystal = gemmi.read_small_structure(source)
    sites = list(crystal.get_all_unit_cell_sites()) if crystal.sites else []
    inside = np.array([site.fract.tolist() for site in sites]).reshape(-1, 3) % 1.0
    return crystal.cell, {
        "positions": inside @ np.transpose(crystal.cell.orth.mat.tolist()),
        "numbers": np.array([site.element.atomic_number for site in sites], int),
        "occupancy": np.array([site.occ for site in sites], float),
    }
