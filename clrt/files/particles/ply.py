"""PLY: a header that names the columns of its vertices, which are text or binary.

G. Turk, The PLY Polygon File Format (1998); https://paulbourke.net/dataformats/ply
"""

import os
from typing import Any, NamedTuple

import numpy as np

from clrt import memory
from clrt.errors import SceneError
from clrt.files.particles.columns import particles
from clrt.files.particles.text import MOST_COLUMNS, Column, Lines, table
from clrt.particles.particles import Particles
from clrt.values import Array

KINDS = {
    "char": "i1", "uchar": "u1", "short": "i2", "ushort": "u2", "int": "i4", "uint": "u4",
    "float": "f4", "double": "f8", "int8": "i1", "uint8": "u1", "int16": "i2", "uint16": "u2",
    "int32": "i4", "uint32": "u4", "float32": "f4", "float64": "f8",
}  # fmt: skip
ORDERS = {"ascii": "=", "binary_little_endian": "<", "binary_big_endian": ">"}


class Element(NamedTuple):
    """What the header says of vertices, or of something else."""

    name: str
    rows: int
    kinds: dict[str, str]
    """Those of NumPy by the columns' names; "" for a list, whose size nobody knows."""


def read(lines: Lines) -> Particles:
    """The vertices of a file.

    Raises:
        SceneError: naming file, line or row, and what was expected.
        OutputError: they do not fit into memory.
    """
    form, elements = _header(lines)
    at = next((i for i, element in enumerate(elements) if element.name == "vertex"), None)
    if at is None:
        raise lines.error("an element vertex before", "end_header")
    before, vertices = elements[:at], elements[at]
    if "" in vertices.kinds.values():
        raise lines.error("vertices without lists before", "end_header")
    source = str(lines.path)
    if form == "ascii":
        lines.skip(sum(element.rows for element in before))
        kinds = {name: kind if kind[0] == "f" else "i8" for name, kind in vertices.kinds.items()}
        columns = [Column(name, kind) for name, kind in kinds.items()]
        read, line_of = table(lines, columns, vertices.rows)
        return particles(read, source, line_of=line_of)
    if any("" in element.kinds.values() for element in before):
        raise lines.error("no lists before the vertices", "end_header")
    for element in before:
        lines.file.seek(element.rows * _dtype(form, element).itemsize, os.SEEK_CUR)
    rows = _rows(lines, vertices.rows, _dtype(form, vertices))
    return particles({name: rows[name] for name in vertices.kinds}, source)


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


def _header(lines: Lines) -> tuple[str, list[Element]]:
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
                elements.append(Element(name, lines.count(count, least), {}))
            case ["property", "list", _, _, name] if elements:
                _add(lines, elements[-1], name, "")
            case ["property", kind, name] if elements and kind in KINDS:
                _add(lines, elements[-1], name, KINDS[kind])
            case _:
                raise lines.error("a line of a PLY header", line)
    if form is None:
        raise lines.error("a format before", line)
    return form, elements


def _add(lines: Lines, element: Element, name: str, kind: str) -> None:
    if name in element.kinds or len(element.kinds) == MOST_COLUMNS:
        raise lines.error(f"another name for each of at most {MOST_COLUMNS} properties", name)
    element.kinds[name] = kind
