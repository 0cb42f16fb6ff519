"""PLY: a header that names the columns of its vertices, which are text or binary.

G. Turk, The PLY Polygon File Format (1998); https://paulbourke.net/dataformats/ply
"""

import math
import os
import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from clrt import memory
from clrt.errors import SceneError
from clrt.files.particles import rules
from clrt.files.particles.columns import particles
from clrt.files.particles.text import MOST_COLUMNS, Column, Lines, table
from clrt.particles.particles import Particles
from clrt.values import Array

KINDS = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8", "bool": "u1",
    "int64": "i8", "uint64": "u8", "long": "i8", "ulong": "u8", "half": "f2", "float16": "f2",
    "byte": "i1", "ubyte": "u1",
}  # fmt: skip
"""The first sixteen are the format's; others that programs write have names that tell."""
SPLAT = {*(f"{name}_{i}" for name in ("f_dc", "scale") for i in range(3)), "x", "y", "z"}
HARMONIC = 0.5 / math.sqrt(math.pi)
"""Y00, the zeroth spherical harmonic."""
ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}


class Element(NamedTuple):
    """What the header says of vertices, or of something else."""

    name: str
    rows: int
    kinds: dict[str, str]
    """Those of NumPy by the columns' names; "" for a list, whose size nobody knows."""
    lists: dict[str, tuple[str, str]]
    """Those of a list's length and of what is in it."""


def read(lines: Lines) -> Particles:
    """The vertices of a file.

    Raises:
        SceneError: naming file, line or row, and what was expected.
        OutputError: they do not fit into memory.
    """
    form, elements = header(lines)
    at = next((i for i, element in enumerate(elements) if element.name == "vertex"), None)
    if at is None:
        raise lines.error("an element vertex before", "end_header")
    before, vertices = elements[:at], elements[at]
    if "" in vertices.kinds.values():
        raise lines.error("vertices without lists before", "end_header")
    if form == "ascii":
        lines.skip(sum(element.rows for element in before))
    else:
        if any("" in element.kinds.values() for element in before):
            raise lines.error("no lists before the vertices", "end_header")
        for element in before:
            lines.file.seek(element.rows * _dtype(form, element).itemsize, os.SEEK_CUR)
    columns, line_of = columns_of(lines, form, vertices)
    return _drawn(columns, str(lines.path), elements, line_of)


def columns_of(
    lines: Lines, form: str, element: Element
) -> tuple[dict[str, Array], Callable[[int], int] | None]:
    """The columns of an element without lists, which comes next, and, of text, the number of a
    row's line.

    Raises:
        SceneError: naming file, line or row, and what was expected.
        OutputError: they do not fit into memory.
    """
    if form != "ascii":
        rows = _rows(lines, element.rows, _dtype(form, element))
        return {name: rows[name] for name in element.kinds}, None
    kinds = {name: kind if kind[0] == "f" else "i8" for name, kind in element.kinds.items()}
    asked = [Column(name, kind) for name, kind in kinds.items()]
    found, line_of = table(lines, asked, element.rows)
    for name, kind in element.kinds.items():
        found[name] = _fitting(found[name], name, kind, str(lines.path), line_of)
    return found, line_of


def _fitting(
    column: Array, name: str, kind: str, source: str, line_of: Callable[[int], int]
) -> Array:
    """A column of text as the kind that the header says, whose range says what a colour is to.

    Raises:
        SceneError: a value is not of that kind.
    """
    if kind[0] == "f":
        return column
    limits = np.iinfo(kind)
    if len(wrong := np.flatnonzero((column < limits.min) | (column > limits.max))):
        line, got = line_of(int(wrong[0])), column[wrong[0]]
        expected = f"expected {name} from {limits.min} to {limits.max}, got {got}"
        raise SceneError(f"{source}: line {line}: {expected}")
    return column.astype(kind)


def _drawn(
    columns: dict[str, Array],
    source: str,
    elements: list[Element],
    line_of: Callable[[int], int] | None,
) -> Particles:
    """The vertices, and what is said of the rest."""
    for element in elements:
        if element.name not in ("vertex", "edge", "camera") and element.rows:
            rules.say(source, f"element {element.name}: is not used: its vertices are drawn")
        elif element.name == "face" and not element.rows:
            rules.say(source, "element face: has no rows: the vertices are drawn")
    if columns.keys() >= SPLAT:
        columns = _of_splats(columns, source)
    return particles(columns, source, line_of=line_of)


def _of_splats(columns: dict[str, Array], source: str) -> dict[str, Array]:
    """Gaussian splats (Kerbl et al., 2023) as spheres of 2 exp of their mean scale, in the colour
    of their zeroth spherical harmonic, and with their opacity as a column."""
    names = [f"f_dc_{i}" for i in range(3)], [f"scale_{i}" for i in range(3)]
    red_green_blue, scales = (
        np.stack([columns[name].astype(np.float64) for name in part], axis=1) for part in names
    )
    kept = {name: columns[name] for name in "xyz"}
    kept["radius"] = 2 * np.exp(scales.mean(axis=1))
    kept["colors"] = np.clip(0.5 + HARMONIC * red_green_blue, 0, 1)
    used = {*kept, *names[0], *names[1], "opacity"}
    if "opacity" in columns:
        kept["opacity"] = 1 / (1 + np.exp(-columns["opacity"].astype(np.float64)))
    more = sorted({re.sub(r"_?\d+$", "", name) for name in columns.keys() - used})
    named = f", without {' '.join(more)}" if more else ""
    rules.say(source, f"Gaussian splats are drawn as spheres of 2 exp(mean scale){named}")
    return kept


def _rows(lines: Lines, count: int, dtype: "np.dtype[Any]") -> Array:
    """(count,) of that dtype, in the machine's order of bytes."""
    size = count * dtype.itemsize
    memory.require(3 * size, f"{lines.path}: {count} particles", "take fewer")
    found = lines.file.read(size)
    if len(found) < size:
        there = len(found) // dtype.itemsize
        raise SceneError(f"{lines.path}: expected {count} vertices, the file ends after {there}")
    rows = np.frombuffer(found, dtype)
    return rows.astype(dtype.newbyteorder("="), copy=False)


def _dtype(form: str, element: Element) -> "np.dtype[Any]":
    return np.dtype([(name, ORDERS[form] + kind) for name, kind in element.kinds.items()])


def header(lines: Lines) -> tuple[str, list[Element]]:
    """The format, and the elements in their order."""
    if (line := lines.line()) != "ply":
        raise lines.error("'ply'", line)
    form, elements = None, list[Element]()
    while (line := lines.line()) != "end_header":
        match (line or "").split():
            case ["format", word, "1.0"] if word in ORDERS:
                form = word
            case ["comment" | "obj_info", *_]:
                pass
            case ["element", name, count]:
                least = 6 if name == "vertex" else 0
                elements.append(Element(name, lines.count(count, least), {}, {}))
            case ["property", "list", length, kind, name] if elements:
                _add(lines, elements[-1], name, "")
                elements[-1].lists[name] = KINDS.get(length, ""), KINDS.get(kind, "")
            case ["property", kind, name] if elements and kind in KINDS:
                _add(lines, elements[-1], name, KINDS[kind])
            case ["property", kind, _] if elements:
                raise lines.error(f"one of the types {' '.join(KINDS)}", kind)
            case _:
                raise lines.error("a line of a PLY header", line)
    if form is None:
        raise lines.error("a format before", line)
    return form, elements


def _add(lines: Lines, element: Element, name: str, kind: str) -> None:
    if len(element.kinds) == MOST_COLUMNS:
        raise lines.error(f"at most {MOST_COLUMNS} properties", name)
    if name in element.kinds:
        rules.say(str(lines.path), f"{name}: two properties have this name: the first is used")
        name = f"{rules.TWICE}{len(element.kinds)}"
    element.kinds[name] = kind
