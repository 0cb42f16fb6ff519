"""POSCAR, CONTCAR and XDATCAR of VASP: https://www.vasp.at/wiki/POSCAR and
https://www.vasp.at/wiki/XDATCAR."""

import numpy as np

from clrt.files.particles.columns import particles
from clrt.files.particles.text import Lines, Mark, is_number
from clrt.particles import elements
from clrt.particles.particles import Particles
from clrt.values import Array

DIRECT = "direct"


class Steps:
    """The frames of a file: one, or in an XDATCAR one after each "Direct configuration="."""

    def __init__(self, lines: Lines) -> None:
        self.lines = lines
        self.kinds: list[str] = []
        self.counts: list[int] = []
        self.cell: Array = np.eye(3)
        self._starts = [self._next()]
        self._is_whole = False

    def frame(self, k: int) -> Particles | None:
        """Frame k, or None after the last one."""
        while len(self._starts) <= k and not self._is_whole:
            self._find()
        if k >= len(self._starts):
            return None
        mark, cell, kinds, counts, scale = self._starts[k]
        self.lines.seek(mark)
        return self._read(cell, kinds, counts, scale)

    def count(self) -> int:
        while not self._is_whole:
            self._find()
        return len(self._starts)

    def close(self) -> None:
        self.lines.file.close()

    def _find(self) -> None:
        """Notes where the frame begins that is behind the last one, if there is one."""
        mark, *_ = self._starts[-1]
        self.lines.seek(mark)
        self._read(*self._starts[-1][1:])
        line = self.lines.peek()
        if line is not None and line.lower().startswith(DIRECT):
            self._starts.append((self.lines.mark(), *self._starts[-1][1:]))
        elif line and self._starts[0][0].line > 0 and self._is_header():
            self._starts.append(self._next())
        else:
            self._is_whole = True

    def _is_header(self) -> bool:
        """Whether a whole header follows, as in the XDATCAR of a cell that changes."""
        mark = self.lines.mark()
        self.lines.line()
        word = (self.lines.line() or "").split()
        edge = (self.lines.line() or "").split()
        self.lines.seek(mark)
        return len(word) == 1 and is_number(word[0]) and len(edge) == 3

    def _next(self) -> tuple[Mark, Array, list[str], list[int], float]:
        """Where the coordinates begin behind the header that is here, and what that says."""
        lines = self.lines
        title = lines.line()
        words = self._floats("a scale", (1, 3))
        cell = np.array([self._floats("an edge of the cell", (3,)) for _ in range(3)])
        scale = np.array(words if len(words) == 3 else words * 3)
        if len(words) == 1 and words[0] < 0:  # a volume
            scale = np.full(3, (-words[0] / abs(np.linalg.det(cell))) ** (1 / 3))
        cell = cell * scale
        line = lines.line()
        names = (line or "").split()
        if names and is_number(names[0]):  # before VASP 5 the title alone has the elements
            counts, known = names, (title or "").split()
            names = known if elements.of_symbols(known) and len(known) == len(counts) else [
                str(k + 1) for k in range(len(counts))]  # fmt: skip
        else:
            line = lines.line()
            counts = (line or "").split()
        if not counts or len(counts) != len(names) or not all(word.isdigit() for word in counts):
            raise lines.error("how many atoms of each kind", line)
        kinds = [name.split("/")[0].split("_")[0] for name in names]
        return lines.mark(), cell, kinds, [int(word) for word in counts], float(scale[0])

    def _read(self, cell: Array, kinds: list[str], counts: list[int], scale: float) -> Particles:
        lines, n = self.lines, sum(counts)
        line = lines.line()
        if (line or "")[:1].lower() == "s":  # selective dynamics
            line = lines.line()
        if line is None:
            raise lines.error("Direct or Cartesian", None)
        places = np.array([self._floats("x, y and z", None)[:3] for _ in range(n)]).reshape(n, 3)
        positions = places * scale if line[:1].lower() in "ck" and line else places @ cell
        names = np.repeat(np.array(kinds, "S"), counts)
        return particles(
            {"positions": positions, "types": names}, str(lines.path), cell, unit="angstrom"
        )

    def _floats(self, what: str, widths: tuple[int, ...] | None) -> list[float]:
        line = self.lines.line()
        words = (line or "").split()
        words = words[: 3 if widths is None else max(widths)]
        good = all(map(is_number, words)) and (len(words) == 3 if widths is None else
                                               len(words) in widths)  # fmt: skip
        if not good:
            raise self.lines.error(what, line)
        return [float(word) for word in words]
