"""LAMMPS's data files: a header, and sections of atoms, bonds, masses and more.

https://docs.lammps.org/read_data.html
"""

import io
import re
from collections.abc import Callable
from itertools import islice
from typing import NamedTuple

import numpy as np

from clrt.errors import SceneError
from clrt.files.particles import rules
from clrt.files.particles.columns import particles
from clrt.files.particles.lammps import LENGTHS, lower_triangle
from clrt.files.particles.text import Column, Lines, Table, is_number, table
from clrt.particles.particles import Particles
from clrt.values import Array

STYLES = {
    "atomic": "id type x y z",
    "charge": "id type q x y z",
    "dpd": "id type theta x y z",
    "dipole": "id type q x y z mux muy muz",
    "sphere": "id type diameter density x y z",
    "ellipsoid": "id type ellipsoidflag density x y z",
    "bond": "id mol type x y z",
    "angle": "id mol type x y z",
    "molecular": "id mol type x y z",
    "full": "id mol type q x y z",
    "template": "id mol template-index template-atom type x y z",
    "line": "id mol type lineflag density x y z",
    "tri": "id mol type triangleflag density x y z",
    "body": "id type bodyflag mass x y z",
    "peri": "id type volume density x y z",
    "electron": "id type q spin eradius x y z",
    "hybrid": "id type x y z",
}
WHOLE = {"id", "mol", "type", "ellipsoidflag", "lineflag", "triangleflag", "bodyflag"}
SECTION = re.compile(r"([A-Z][A-Za-z/]*(?: [A-Z][A-Za-z]*)?(?: Coeffs)?)\s*(?:#\s*(\S+).*)?")
COUNTS = {"Atoms": "atoms", "Bonds": "bonds", "Masses": "atom types", "Velocities": "atoms",
          "Ellipsoids": "ellipsoids"}  # fmt: skip
VELOCITY = "vx vy vz wx wy wz"
"""The last three of spheres only; ellipsoids have their angular momentum there."""
SHAPE = "shapex shapey shapez quatw quati quatj quatk"
LOOKS = {"Bodies", "Lines", "Triangles"}
"""Sections of shapes that are not drawn."""


class Header(NamedTuple):
    """What a file says before its sections."""

    counts: dict[str, int]
    cell: Array
    origin: Array
    units: str | None


def read(lines: Lines) -> Particles:
    """The atoms of a file.

    Raises:
        SceneError: naming file, line and what was expected.
    """
    source = str(lines.path)
    header, title = _header(lines)
    columns: dict[str, Array] = {}
    names: dict[int, str] = {}
    masses: dict[int, float] = {}
    more: dict[str, dict[str, Array]] = {}
    pairs: dict[str, Array] | None = None
    line_of: Callable[[int], int] | None = None
    while title is not None:
        found = SECTION.fullmatch(title)
        if found is None:
            raise lines.error("the name of a section", title)
        name, style = found.groups()
        if name in LOOKS:
            rules.say(source, f"section {name}: is not used: spheres are drawn")
        if name not in COUNTS:
            title = _next_title(lines)
            continue
        rows = header.counts.get(COUNTS[name], 0)
        lines.skip_blank()
        if name == "Masses":
            for _ in range(rows):
                words, _, comment = (lines.line() or "").partition("#")
                kind, mass, *_ = [*words.split(), "", ""]
                if not (kind.isdecimal() and is_number(mass)):
                    raise lines.error("a type and its mass", words)
                masses[int(kind)] = float(mass)
                if comment.strip():
                    names[int(kind)] = comment.split()[0]
        elif name == "Atoms":
            columns, line_of = _atoms(lines, rows, style)
        elif name == "Bonds":
            pairs = _table(lines, ["id", "type", "a", "b"], rows)[0]
        else:
            axes = (VELOCITY if name == "Velocities" else SHAPE).split()
            width = len((lines.peek() or "").partition("#")[0].split()) - 1
            more[name] = _table(lines, ["id", *(axes if rows == 0 else axes[:width])], rows)[0]
        title = _next_title(lines)
    if not columns:
        raise lines.error("a section Atoms", None)
    ids, types = columns["id"], columns["type"]
    order = np.argsort(ids)
    for part in more.values():
        at = _found(ids, order, part.pop("id"), source)
        for name, given in part.items():
            columns[name] = np.full(len(ids), np.nan)
            columns[name][at] = given
    if masses and set(types.tolist()) <= masses.keys():
        columns["mass"] = np.array([masses[kind] for kind in types.tolist()])
    bonds = None
    if pairs is not None:
        ends = np.stack([_found(ids, order, pairs[end], source) for end in "ab"], axis=1)
        bonds = ends[ends[:, 0] != ends[:, 1]]
    kinds = sorted(names)
    type_names = None
    if kinds and set(types.tolist()) <= names.keys():
        type_names = tuple(names[kind] for kind in kinds)
        columns["type"] = np.searchsorted(kinds, types)
    return particles(
        columns,
        source,
        header.cell,
        header.origin,
        type_names,
        line_of,
        bonds=bonds,
        unit=LENGTHS.get(header.units or ""),
    )


def _header(lines: Lines) -> tuple[Header, str | None]:
    """What is before the first section, and the name of that."""
    first = lines.line() or ""  # a comment, whatever it is
    units = re.search(r"units\s*=\s*(\w+)", first)
    counts: dict[str, int] = {}
    low, high, tilt = np.full(3, -0.5), np.full(3, 0.5), np.zeros(3)
    vectors: dict[str, list[float]] = {}
    while (line := lines.filled_line()) is not None:
        words = line.partition("#")[0].split()
        numbers = [float(word) for word in words if is_number(word)]
        match words[len(numbers) :]:
            case ["xlo" | "ylo" | "zlo" as end, _] if len(numbers) == 2:
                low["xyz".index(end[0])], high["xyz".index(end[0])] = numbers
            case ["xy", "xz", "yz"] if len(numbers) == 3:
                tilt[:] = numbers
            case ["avec" | "bvec" | "cvec" as edge] if len(numbers) == 3:
                vectors[edge] = numbers
            case ["abc", "origin"] if len(numbers) == 3:
                vectors["origin"] = numbers
            case [*name] if len(numbers) == 1 and name:
                count = lines.count(words[0], 0)
                counts[" ".join(name)] = count
            case [] if not words:
                pass
            case _ if not numbers and SECTION.fullmatch(line):
                cell, origin = lower_triangle(high - low, tilt), low
                if len(vectors) == 4:
                    cell = np.array([vectors[f"{edge}vec"] for edge in "abc"])
                    origin = np.array(vectors["origin"])
                return Header(counts, cell, origin, units[1] if units else None), line
            case _:
                raise lines.error("a line of the header of a LAMMPS data file", line)
    raise lines.error("a section Atoms", None)


def _atoms(lines: Lines, rows: int, style: str | None) -> Table:
    words = (lines.peek() or "").partition("#")[0].split()
    if style not in STYLES:
        said, style = style, _style_of(words)
        if style is None:
            raise lines.error(f"'Atoms # style', one of {', '.join(STYLES)}, before", lines.line())
        why = "Atoms names no style" if said is None else f"Atoms # {said} is of no known style"
        rules.say(str(lines.path), f"{why}: its columns are read as {STYLES[style]} ({style})")
    names = STYLES[style].split()
    extra = len(words) - len(names)
    if style == "hybrid":
        names += [f"column{i}" for i in range(6, len(words) + 1)]
    elif extra in (3, 4):
        names += ["ix", "iy", "iz"]
    return _table(lines, names, rows)


def _style_of(words: list[str]) -> str | None:
    """The style of a row of atoms whose section does not say: the first that has as many columns,
    and whole numbers where it must."""
    for style in ("atomic", "molecular", "charge", "full", "sphere"):
        names = STYLES[style].split()
        if len(words) in (len(names), len(names) + 3):
            whole = all(
                word.isdecimal() for name, word in zip(names, words, strict=False) if name in WHOLE
            )
            if whole:
                return style
    return None


def _table(lines: Lines, names: list[str], rows: int) -> Table:
    whole = {*WHOLE, "a", "b", "ix", "iy", "iz"}
    columns = [Column(name, "i8" if name in whole else "f8") for name in names]
    start = lines.mark()
    try:
        return table(lines, columns, rows)
    except SceneError:  # comments behind the numbers
        lines.seek(start)
        text = b"".join(
            line.partition(b"#")[0].rstrip() + b"\n" for line in islice(lines.file, rows)
        )
        plain = Lines(lines.path, io.BufferedReader(io.BytesIO(text)), True)
        plain.number = start.line
        found = table(plain, columns, rows)
    # As if they had been read where they stand.
    before, lines.number = start.line, start.line + rows
    return Table(found.columns, lambda row: before + 1 + row)


def _next_title(lines: Lines) -> str | None:
    """The name of the next section."""
    while (line := lines.filled_line()) is not None:
        if line[0].isalpha() and SECTION.fullmatch(line):
            return line
    return None


def _found(ids: Array, order: Array, asked: Array, source: str) -> Array:
    """The indices of the atoms of some ids.

    Raises:
        SceneError: there is no such atom.
    """
    if len(ids) == 0 and len(asked):
        raise SceneError(f"{source}: expected an atom of id {asked[0]}, got none")
    at = order[np.minimum(np.searchsorted(ids, asked, sorter=order), len(ids) - 1)]
    if len(wrong := np.flatnonzero(ids[at] != asked)):
        raise SceneError(f"{source}: expected an atom of id {asked[wrong[0]]}, got none")
    return at
