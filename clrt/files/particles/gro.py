"""GROMACS's .gro: https://manual.gromacs.org/current/reference-manual/file-formats.html#gro"""

import re
from itertools import pairwise

import numpy as np

from clrt import memory
from clrt.files.particles import rules
from clrt.files.particles.columns import particles
from clrt.files.particles.text import Lines, is_number
from clrt.particles.particles import Particles
from clrt.values import Array

TOUCHING = re.compile(r"-?\d+\.\d{5}")
"""Numbers of the box, which have 5 digits behind the point."""
FACT = re.compile(r"\b(t|step)= *(\S+)")
"""What GROMACS writes at the end of a title."""
NAMES = 20
"""Bytes before the numbers of a line: residue's number and name, atom's name and number."""


def skip(lines: Lines) -> None:
    """Goes on to the next frame."""
    lines.line()
    lines.skip(lines.count(lines.line(), NAMES) + 1)


def read(lines: Lines) -> Particles:
    """The frame that begins here. Lengths are nm.

    Raises:
        SceneError: naming file, line and what was expected.
    """
    title = lines.line() or ""
    n = lines.count(lines.line(), NAMES)
    memory.require(200 * n, f"{lines.path}: {n} particles", "take fewer")
    start = lines.number
    rows = list[bytes]()
    for _ in range(n):
        row = lines.file.readline()
        lines.number += 1
        if not row:
            raise lines.error(f"{n} particles from line {start + 1} on", None)
        rows.append(row.rstrip(b"\r\n"))
    cell = _box(lines)
    width = _width(lines, rows[0], start + 1) if n else 8
    positions = np.array(
        [_numbers(lines, row, width, start + i + 1) for i, row in enumerate(rows)]
    ).reshape(n, 6)
    names = np.array([row[:NAMES].ljust(NAMES) for row in rows], f"S{NAMES}")

    def field(first: int, last: int) -> Array:
        found: Array = np.char.strip(
            np.array([name[first:last] for name in names.tolist()], f"S{last - first}")
        )
        return found

    columns = {
        "positions": positions[:, :3],
        "name": field(10, 15),
        "residue": field(5, 10),
        "residue_id": np.array([int(word) if word.isdigit() else -1 for word in
                                field(0, 5).tolist()], np.int64),
    }  # fmt: skip
    for i, axis in enumerate("xyz" if np.isfinite(positions[:, 3:]).any() else ""):
        columns[f"v{axis}"] = positions[:, 3 + i]
    known = {{"t": "time"}.get(name, name): word for name, word in FACT.findall(title)}
    facts = rules.facts(known)
    return particles(columns, str(lines.path), cell, unit="nm", facts=facts)


def _width(lines: Lines, row: bytes, number: int) -> int:
    """The bytes of a number: as many as lie between two points."""
    points = [i for i in range(NAMES, len(row)) if row[i : i + 1] == b"."]
    if len(points) < 3:
        lines.number = number
        raise lines.error("x, y and z in columns", row.decode("utf-8", "replace"))
    return points[1] - points[0]


def _numbers(lines: Lines, row: bytes, width: int, number: int) -> list[float]:
    """Three coordinates, and three velocities, NaN where there are none."""
    ends = [NAMES + width * k for k in range(4)]
    words = [row[a:b] for a, b in pairwise(ends)]
    if len(row.rstrip()) >= ends[3] + 3 * width:
        words += [row[a : a + width] for a in range(ends[3], ends[3] + 3 * width, width)]
    try:
        found = [float(word) for word in words]
        return found + [np.nan] * (6 - len(found))
    except ValueError:
        lines.number = number
        raise lines.error("numbers in columns", row.decode("utf-8", "replace")) from None


def _box(lines: Lines) -> Array | None:
    """(3, 3), a row for each edge; 0 stands for none."""
    line = lines.line()
    words = (line or "").split()
    if len(words) not in (3, 9):  # large numbers touch
        words = TOUCHING.findall(line or "")
    if len(words) not in (3, 9) or not all(map(is_number, words)):
        raise lines.error("3 or 9 numbers of the box", line)
    x = [float(word) for word in words] + [0.0] * (9 - len(words))
    cell = np.array([[x[0], x[3], x[4]], [x[5], x[1], x[6]], [x[7], x[8], x[2]]])
    return cell if cell.any() else None
