"""LAMMPS's text dumps, and those of its relatives: ITEM after ITEM, columns by name.

https://docs.lammps.org/dump.html and https://docs.lammps.org/Howto_triclinic.html
"""

import re
from typing import NamedTuple

import numpy as np

from clrt.files.particles import rules
from clrt.files.particles.columns import kind_of, particles
from clrt.files.particles.text import Column, Lines, is_number, table
from clrt.particles.particles import ALONG_ALL, Particles
from clrt.values import Array, frozen

AHEAD = "ITEM: "
LINES = ("TIMESTEP", "TIME", "UNITS")
"""Items of one line each."""
FACTS = {"TIMESTEP": "step", "TIME": "time"}
# The first that there is: coordinates as they are, unwrapped, as parts of the cell, and both.
PLAIN = (("x", "y", "z"), ("xu", "yu", "zu"))
SCALED = (("xs", "ys", "zs"), ("xsu", "ysu", "zsu"))


LENGTHS = {"real": "angstrom", "metal": "angstrom", "si": "m", "cgs": "cm", "electron": "bohr",
           "micro": "um", "nano": "nm"}  # fmt: skip
"""The unit of length of each of LAMMPS's units; in those of lj there is none."""


class Header(NamedTuple):
    """What a frame says before its rows."""

    rows: int
    names: list[str]
    cell: Array | None
    origin: Array
    units: str | None
    periodic: tuple[bool, ...]
    facts: dict[str, float]


def skip(lines: Lines) -> None:
    """Goes on to the next frame."""
    lines.skip(_header(lines).rows)


def read(lines: Lines) -> Particles:
    """The frame that begins here.

    Raises:
        SceneError: naming file, line and what was expected.
    """
    header = _header(lines)
    names = rules.first_of_each(header.names, str(lines.path))
    first = (lines.peek() or "").split() if header.rows else []
    words = first if len(first) == len(names) else ["0"] * len(names)
    kinds = map(kind_of, names, words)
    columns = [Column(name, kind) for name, kind in zip(names, kinds, strict=True)]
    read, line_of = table(lines, columns, header.rows)
    cell, origin = header.cell, header.origin
    for axes in (*PLAIN, *SCALED):
        there = [axis for axis in axes if axis in read]
        if there[:2] == list(axes[:2]):  # a run in two dimensions need not write z
            positions = np.stack([read.pop(axis) for axis in there], axis=1)
            if axes in SCALED:
                if cell is None:
                    raise lines.error("ITEM: BOX BOUNDS for scaled coordinates", " ".join(axes))
                positions = (positions @ cell[: len(there)] + origin)[:, : len(there)]
            read["positions"] = frozen(positions)
            break
    unit = LENGTHS.get(header.units or "")
    return particles(
        read,
        str(lines.path),
        cell,
        origin,
        line_of=line_of,
        unit=unit,
        periodic=header.periodic,
        facts=header.facts,
    )


def _header(lines: Lines) -> Header:
    rows, cell, origin, units, periodic = None, None, np.zeros(3), None, ALONG_ALL
    facts = dict[str, float]()
    while True:
        line = lines.filled_line()
        if line is None or not line.startswith(AHEAD):
            raise lines.error("'ITEM: ...'", line)
        item = line.removeprefix(AHEAD)
        if item.split()[:1] == ["ATOMS"]:
            break
        if item == "NUMBER OF ATOMS":
            rows = lines.count(lines.line())
        elif item.startswith("BOX BOUNDS"):
            cell, origin = _box(lines, item)
            flags = [word for word in item.split() if re.fullmatch("[pfsm]{2}", word)]
            periodic = tuple(flag == "pp" for flag in flags) if len(flags) == 3 else ALONG_ALL
        elif item in LINES:
            said = lines.line()
            facts |= rules.facts({FACTS.get(item, ""): said or ""})
            units = said if item == "UNITS" else units
        else:
            raise lines.error("ITEM: TIMESTEP, NUMBER OF ATOMS, BOX BOUNDS or ATOMS", line)
    names = item.split()[1:]
    if rows is None:
        raise lines.error("ITEM: NUMBER OF ATOMS before", line)
    if not names:
        raise lines.error("ITEM: ATOMS with the names of the columns", line)
    return Header(rows, names, cell, origin, units, periodic, facts)


def _box(lines: Lines, item: str) -> tuple[Array, Array]:
    """The cell (3, 3), a row for each edge, and its origin (3,)."""
    words = item.split()[2:]
    is_general = words[:2] == ["abc", "origin"]
    is_tilted = words[:3] == ["xy", "xz", "yz"]
    width = 4 if is_general else 3 if is_tilted else 2
    rows = []
    for _ in range(3):
        line = lines.line()
        row = (line or "").split()
        if len(row) != width or not all(map(is_number, row)):
            raise lines.error(f"{width} numbers of the box", line)
        rows.append([float(word) for word in row])
    box = np.array(rows)
    if is_general:
        return box[:, :3], box[:, 3]
    low, high = box[:, 0], box[:, 1]
    tilt = box[:, 2] if is_tilted else np.zeros(3)
    if is_tilted:  # the bounds are those of the tilted box
        xy, xz, yz = tilt
        low = low - [min(0.0, xy, xz, xy + xz), min(0.0, yz), 0.0]
        high = high - [max(0.0, xy, xz, xy + xz), max(0.0, yz), 0.0]
    return lower_triangle(high - low, tilt), low


def lower_triangle(sides: Array, tilt: Array) -> Array:
    """The cell (3, 3) of LAMMPS's lengths along the axes and tilt factors xy, xz and yz."""
    cell = np.diag(sides)
    cell[1, 0], cell[2, 0], cell[2, 1] = tilt
    return cell
