"""XYZ, plain or extended: a count, a comment, and a line for each particle, frame after frame.

https://github.com/libAtoms/extxyz says what Properties and Lattice in the comment mean.
"""

import os
import re

import numpy as np

from clrt.files.particles import rules
from clrt.files.particles.columns import kind_of, particles
from clrt.files.particles.text import Column, Lines, Mark, Table, is_number, rest, table
from clrt.particles.particles import ALONG_ALL, Particles
from clrt.values import Array

KINDS = {"R": "f8", "I": "i8", "S": "S", "L": "S"}
TRUE = (b"T", b"True", b"TRUE", b"true", b".TRUE.", b".true.", b"1")
FALSE = (b"F", b"False", b"FALSE", b"false", b".FALSE.", b".false.", b"0")
FAST_FROM = 100_000  # particles; with less it takes longer to import extxyz than to do without
KEY = re.compile(r"""(\w+)\s*=\s*("[^"]*"|'[^']*'|\{[^}]*\}|\[[^=]*\]|\S+)""")


def skip(lines: Lines) -> None:
    """Goes on to the next frame."""
    if _has_no_count(lines):
        while lines.filled_line() is not None:
            pass
        return
    count = lines.count(lines.filled_line())
    lines.line()
    lines.skip(count)


def read(lines: Lines) -> Particles:
    """The frame that begins here.

    Raises:
        SceneError: naming file, line and what was expected.
    """
    if _has_no_count(lines):
        return _points(lines)
    start = lines.mark()
    count = lines.count(lines.line())
    comment = lines.line() or ""
    keys = {name.lower(): text.strip("\"'{}") for name, text in KEY.findall(comment)}
    if "properties" in keys:
        columns = _properties(lines, keys["properties"])
    else:
        columns = _plain(lines, lines.peek() if count else None)
    cell = _numbers(lines, keys, "lattice", 9)
    origin = _numbers(lines, keys, "origin", 3)
    flags = keys.get("pbc", "").split()
    read, line_of = _by_extxyz(lines, start, columns, count) or table(lines, columns, count)
    for name in re.findall(r"(?:^|:)([^:]+):L:", keys.get("properties", "")):
        read[name] = _truths(read[name])
    return particles(
        read,
        str(lines.path),
        None if cell is None else cell.reshape(3, 3),
        (0.0, 0.0, 0.0) if origin is None else origin,
        line_of=line_of,
        periodic=[flag.encode() not in FALSE for flag in flags] if len(flags) == 3 else ALONG_ALL,
        facts=rules.facts(keys),
    )


def _has_no_count(lines: Lines) -> bool:
    """Whether this is a file of points that has a line for each, from its first on."""
    is_first = lines.number == 0
    lines.skip_blank()
    words = (lines.peek() or "").split() if is_first else []
    return len(words) > 1 and sum(map(is_number, words)) >= 3


def _points(lines: Lines) -> Particles:
    """Points without a count: x, y, z and more, or names before them."""
    words = (lines.peek() or "").split()
    if is_number(words[0]):
        rest_of = words[3:]
        names = ["x", "y", "z"]
        whole = len(rest_of) == 3 and all(re.fullmatch(r"[0-9]{1,3}", word) for word in rest_of)
        names += ["red", "green", "blue"] if whole else []
    else:
        names = ["species", "x", "y", "z"]
    names += [f"column{i}" for i in range(len(names) + 1, len(words) + 1)]
    columns = [Column(name, kind_of(name, word)) for name, word in zip(names, words, strict=True)]
    read, line_of = rest(lines, columns, None)
    return particles(read, str(lines.path), line_of=line_of)


def _properties(lines: Lines, text: str) -> list[Column]:
    """The columns that "species:S:1:pos:R:3" speaks of."""
    words = text.split(":")
    columns = []
    for name, kind, width in zip(words[::3], words[1::3], words[2::3], strict=False):
        if kind not in KINDS or not (width.isdecimal() and 0 < int(width[:9]) < 1000):
            break
        columns.append(Column("numbers" if name == "Z" else name, KINDS[kind], int(width)))
    if 3 * len(columns) != len(words):
        raise lines.error("Properties=name:kind:width:..., kinds R I S L", text)
    names = rules.first_of_each([column.name for column in columns], str(lines.path))
    return [column._replace(name=name) for column, name in zip(columns, names, strict=True)]


def _plain(lines: Lines, first: str | None) -> list[Column]:
    """The columns of a frame that does not name them, by its first row."""
    words = first.split() if first is not None else []
    if len(words) == 3 and all(map(is_number, words)):
        return [Column(axis, "f8") for axis in "xyz"]
    # Programs that have types but no elements write those.
    head = "type" if words and is_number(words[0]) else "species"
    names = [head, "x", "y", "z", *(f"column{i}" for i in range(5, len(words) + 1))]
    kinds = ["i8" if head == "type" else "S", "f8", "f8", "f8"]
    kinds += [kind_of(name, word) for name, word in zip(names[4:], words[4:], strict=True)]
    return [Column(name, kind) for name, kind in zip(names, kinds, strict=True)]


def _numbers(lines: Lines, keys: dict[str, str], key: str, count: int) -> Array | None:
    if key not in keys:
        return None
    words = re.sub(r"[\[\],]", " ", keys[key]).split()
    if len(words) != count or not all(map(is_number, words)):
        raise lines.error(f"{key.capitalize()} of {count} numbers", keys[key])
    return np.array(words, np.float64)


def _by_extxyz(lines: Lines, start: Mark, columns: list[Column], count: int) -> Table | None:
    """What table() reads, by the extra clrt[fast].

    None if it is not there or not worth it, or has found a fault; table() says which.
    """
    if lines.is_packed or count < FAST_FROM:
        return None
    try:
        from extxyz import cextxyz
    except ImportError:
        return None
    # Its whole numbers have 32 bits and go round.
    kinds = ["S" if column.kind == "S" else "R" for column in columns]
    properties = [f"{i}:{kinds[i]}:{column.width}" for i, column in enumerate(columns)]
    file = cextxyz.cfopen(str(lines.path), "r")
    if not file:
        return None
    try:
        cextxyz.cfseek(file, start.offset, os.SEEK_SET)
        comment = f"Properties=c{':c'.join(properties)}"
        _, _, arrays = cextxyz.read_frame_dicts(file, comment=comment)
        end = cextxyz.cftell(file)
    except (cextxyz.ExtXYZError, EOFError, UnicodeError):
        return None
    finally:
        cextxyz.cfclose(file)
    read = {}
    for i, column in enumerate(columns):
        given = arrays[f"c{i}"]
        read[column.name] = given.astype(np.int64) if column.kind == "i8" else given
        if column.kind == "i8" and (read[column.name] != given).any():
            return None
    lines.seek(Mark(end, lines.number + count))
    first = start.line + 3
    return Table(read, lambda row: first + row)


def _truths(column: Array) -> Array:
    """T and F as booleans; others as they are."""
    names = column.astype("S")
    true = np.isin(names, TRUE)
    return true if (true | np.isin(names, FALSE)).all() else column
