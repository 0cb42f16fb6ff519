"""CSV and its dialects: a header that names the columns, and a line for each particle."""

import re
from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np

from clrt.errors import SceneError
from clrt.files.particles import rules
from clrt.files.particles.columns import NUMBERS, kind_of, particles
from clrt.files.particles.naming import POSITIONS, title
from clrt.files.particles.text import (
    FORTRAN,
    MOST_COLUMNS,
    Column,
    Lines,
    Mark,
    Table,
    filled_row,
    is_number,
    rest,
    split,
    table,
)
from clrt.particles.particles import Particles
from clrt.values import Array, some

DELIMITERS = (";", "\t", "|", ",", None)
"""The first of those that give the most columns counts; None: blanks."""
HEADERS = {2: ["x", "y"], 3: ["x", "y", "z"], 4: ["x", "y", "z", "radius"]}  # if there is none
MISSING = {"", "na", "n/a", "#n/a", "null", "none", "-", "--", "?", ".", "1.#qnan", "-nan(ind)"}
"""Cells without a number, in small letters: NaN."""
COMMA = re.compile(r"[-+]?\d*,\d+(?:[eE][-+]?\d+)?")
"""A number with a decimal comma."""
CHUNK = 1 << 16  # rows


def read(lines: Lines) -> Particles:
    """The particles of a file.

    The first line names the columns; it may be a comment, as NumPy writes it. A file of two to four
    columns of numbers needs none: they are x, y, z and the radius.

    Raises:
        SceneError: naming file, line and what was expected.
    """
    start, names, delimiter = _header(lines)
    lines.seek(start)
    first = filled_row(lines)
    words = split(first, delimiter) if first else []
    if len(words) == len(names) + 1 and not words[-1]:
        names.append("")  # a comma at the ends of the lines, but not of the header's
    elif len(words) == len(names) - 1 and not names[-1]:
        names.pop()
    columns = [
        Column(name, kind_of(title(name).name, word) if name else "S")
        for name, word in zip(names, words if len(words) == len(names) else names, strict=True)
    ]
    if len(columns) > MOST_COLUMNS:
        raise lines.error(f"at most {MOST_COLUMNS} columns", f"{len(columns)} of them")
    lines.seek(start)
    try:
        read, line_of = rest(lines, columns, delimiter) if first else table(lines, columns, 0)
    except SceneError:  # slower, but what it does not read is wrong
        read, line_of = _loose(lines, start, columns, delimiter)
    read.pop("", None)  # the index that pandas writes, or what is behind the last comma
    return particles(read, str(lines.path), line_of=line_of)


def _header(lines: Lines) -> tuple[Mark, list[str], str | None]:
    """Where the rows begin, the columns' names, and what is between them."""
    start, line, comment = lines.mark(), lines.filled_line(), None
    if line is not None and (found := re.fullmatch("sep=(.)", line)):  # of Excel
        start, line = lines.mark(), lines.filled_line()
        if line is not None and found[1] not in line:
            raise lines.error(f"columns with {found[1]!r} between", line)
    while line is not None and line.startswith("#"):
        start, comment, line = lines.mark(), line.lstrip("# "), lines.filled_line()
    expected = "a header that names x, y and z"
    if line is None:
        if comment is None:
            raise lines.error(expected, None)
        line = comment
    after = lines.mark()
    delimiter = _delimiter(line, filled_row(lines))
    lines.seek(after)
    names = split(line, delimiter)
    if not all(is_number(name) or COMMA.fullmatch(name) for name in names if name):
        start = after
    elif comment is not None and len(split(comment, delimiter)) == len(names):
        names = split(comment, delimiter)
    elif len(names) in HEADERS:
        names = list(HEADERS[len(names)])
    else:
        raise lines.error(expected, line)
    return start, rules.first_of_each(names, str(lines.path)), delimiter


def _delimiter(header: str, row: str | None) -> str | None:
    """What is between the columns of a header and of the row behind it."""
    best, most = None, 1
    for delimiter in DELIMITERS:
        if delimiter is not None and delimiter not in header:
            continue
        count = len(split(header, delimiter))
        same = row is None or abs(len(split(row, delimiter)) - count) <= 1
        if same and count > most and delimiter is not None:
            best, most = delimiter, count
    return best


def _loose(lines: Lines, start: Mark, columns: Sequence[Column], delimiter: str | None) -> Table:
    """All lines that are left: with cells that have no number, with decimal commas, with Fortran's
    exponents, and with columns that begin with a number and are text.

    Raises:
        SceneError: a line has fewer or more columns, or one that must be of numbers is not.
    """
    rows = _rows(lines, start, columns, delimiter)
    texts = {column.name for column in columns if column.kind == "S"}
    for at, words in rows:
        for column, word in zip(columns, words, strict=True):
            if column.name in texts or is_number(_plain(word, delimiter)):
                continue
            name = title(column.name).name.lower()
            if name in NUMBERS or name in POSITIONS:
                lines.number = at
                raise lines.error(f"a number as {column.name}", word)
            texts.add(column.name)
    parts: list[list[Array]] = [[] for _ in columns]
    numbers = list[int]()
    rows = _rows(lines, start, columns, delimiter)
    while chunk := list(islice(rows, CHUNK)):
        numbers += [at for at, _ in chunk]
        for i, column in enumerate(columns):
            words = [words[i] for _, words in chunk]
            if column.name not in texts:
                found = np.array([float(_plain(word, delimiter)) for word in words])
            else:
                found = np.array(words)
            parts[i].append(found)
    read = {
        column.name: np.concatenate(part) if part else np.empty(0)
        for column, part in zip(columns, parts, strict=True)
    }
    return Table(read, numbers.__getitem__)


def _rows(
    lines: Lines, start: Mark, columns: Sequence[Column], delimiter: str | None
) -> Iterator[tuple[int, list[str]]]:
    """The number of each line that is left, and its words."""
    lines.seek(start)
    while (line := filled_row(lines)) is not None:
        words = split(line, delimiter)
        if len(words) == len(columns) + 1 and not words[-1]:
            words.pop()
        if len(words) != len(columns):
            names = some((column.name[:20] for column in columns), 8)
            raise lines.error(f"{len(columns)} columns ({names})", line)
        yield lines.number, words


def _plain(word: str, delimiter: str | None) -> str:
    """A word as Python writes the number that it is."""
    if word.lower() in MISSING:
        return "nan"
    if delimiter != "," and COMMA.fullmatch(word):
        return word.replace(",", ".")
    return FORTRAN.sub(r"\1e\2", word)
