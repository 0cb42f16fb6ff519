"""Text: lines that are counted, and tables of them, with errors that name the line."""

import csv
import io
import os
import re
from collections.abc import Callable, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from clrt import memory
from clrt.errors import CutError, SceneError
from clrt.values import Array, some

LONGEST = 1 << 20  # bytes of a line of a header, or of one that is wrong
MOST_COLUMNS = 1000
MOST_ROWS = 2**31 - 1
CUTS_FRACTIONS = np.lib.NumpyVersion(np.__version__) < "2.3.0"
"""Whether NumPy reads 1.5 as the whole number 1."""
NAME_BYTES = (8, 64)  # of names: most have less than 8, and those are told apart as integers


FORTRAN = re.compile(r"(?<![^\s,;])([-+]?(?:\d+\.\d*|\.\d+))[dD]([-+]?\d+)(?![^\s,;])")
"""A number whose exponent stands behind a D."""
FORTRAN_BYTES = re.compile(FORTRAN.pattern.encode())


class Mark(NamedTuple):
    """A place between two lines of a file."""

    offset: int
    line: int
    """How many lines are before it."""


class Column(NamedTuple):
    """A column of a table, or `width` of them side by side."""

    name: str
    kind: str
    """"f8", "f4", "i8" or, for names, "S"."""
    width: int = 1


class Table(NamedTuple):
    """What was read of a table."""

    columns: dict[str, Array]
    """(rows,), or (rows, count) where a Column's width is above 1."""
    line_of: Callable[[int], int]
    """The number of a row's line, as long as the file is open."""


class Lines:
    """The lines of a file. What is wrong with one is a SceneError that names it."""

    def __init__(self, path: Path, file: io.BufferedReader, is_packed: bool = False) -> None:
        self.path, self.file = path, file
        self.is_packed = is_packed
        self.wrong: int | None = None
        """That of the line that error() spoke of last."""
        self.number = 0
        """That of the last line that was read, from 1."""

    def line(self) -> str | None:
        """The next line without the blanks around it, or None after the last one."""
        found = self.file.readline(LONGEST + 1)
        if not found:
            return None
        self.number += 1
        if len(found) > LONGEST:
            raise self.error(f"a line of at most {LONGEST >> 20} MB", "a longer one")
        return found.decode("utf-8-sig" if self.number == 1 else "utf-8", "replace").strip()

    def filled_line(self) -> str | None:
        """The next line that is not blank, or None after the last one."""
        line = self.line()
        while line == "":
            line = self.line()
        return line

    def peek(self) -> str | None:
        """The line that line() gives next."""
        mark = self.mark()
        line = self.line()
        self.seek(mark)
        return line

    def skip_blank(self) -> None:
        """Goes on to the next line that is not blank, or to the end."""
        while self.peek() == "":
            self.line()

    def mark(self) -> Mark:
        return Mark(self.file.tell(), self.number)

    def seek(self, mark: Mark) -> None:
        self.file.seek(mark.offset)
        self.number = mark.line

    def skip(self, count: int) -> None:
        """Goes on by so many lines."""
        before = self.number
        self.number += sum(1 for _ in islice(self.file, count))
        if self.number < before + count:
            raise self.error(f"{count} lines after line {before}", None)

    def count(self, text: str | None, least: int = 6) -> int:
        """How many particles there are, as the text says, which is of the line that was read last.

        Args:
            least: bytes that one takes; three digits and what is behind each.
        """
        if text is None or not re.fullmatch("[0-9]{1,10}", text) or int(text) > MOST_ROWS:
            raise self.error("a number of particles", text)
        count = int(text)
        if not self.is_packed and least * count > os.fstat(self.file.fileno()).st_size + 1:
            raise self.error("a number of particles that the file has room for", text)
        return count

    def is_cut(self) -> bool:
        """Whether the line that error() spoke of last is the file's last, and does not end."""
        return self.wrong == self.number and not self.ends_with_a_line() and self.peek() is None

    def ends_with_a_line(self) -> bool:
        """Whether the last line ends as others do."""
        if self.is_packed:
            return not getattr(self.file.raw, "is_cut", False)
        mark = self.mark()
        self.file.seek(0, os.SEEK_END)
        self.file.seek(max(self.file.tell() - 1, 0))
        last = self.file.read(1)
        self.seek(mark)
        return last in (b"\n", b"\r", b"")

    def error(self, expected: str, got: str | None) -> SceneError:
        """An error in the line that was read last; None: the file ends after it."""
        if got is None:
            where = f"after line {self.number}" if self.number else "at once"
            return CutError(f"{self.path}: expected {expected}, the file ends {where}")
        self.wrong = self.number
        said = repr(got[:80])
        said = said if len(got) <= 80 >= len(said) else f"{said[:60]}..."
        return SceneError(f"{self.path}: line {self.number}: expected {expected}, got {said}")


def is_number(word: str, kind: str = "f8") -> bool:
    try:
        int(word) if kind == "i8" else float(word)
    except ValueError:
        return False
    return True


def split(line: str, delimiter: str | None) -> list[str]:
    """The words of a line, without blanks and quotes around them; None: blanks are between."""
    if delimiter is None:
        return line.split()
    words = next(csv.reader([line], delimiter=delimiter, skipinitialspace=True))
    return [word.strip() for word in words]


def table(lines: Lines, columns: Sequence[Column], rows: int) -> Table:
    """The next `rows` lines, with blanks between the columns.

    Raises:
        SceneError: there are fewer, or a line has fewer or more columns, or no number in one.
        OutputError: they do not fit into memory.
    """
    first = lines.number + 1
    size = rows * 8 * sum(column.width for column in columns)
    memory.require(2 * size, f"{lines.path}: {rows} particles", "take fewer")
    return Table(_read(lines, columns, rows, None), lambda row: first + row)


def rest(lines: Lines, columns: Sequence[Column], delimiter: str | None) -> Table:
    """All lines that are left but blank ones and comments (#), as table() reads them."""
    start = lines.mark()

    def line_of(row: int) -> int:
        lines.seek(start)
        for _ in range(row + 1):
            filled_row(lines)
        return lines.number

    return Table(_read(lines, columns, None, delimiter), line_of)


def filled_row(lines: Lines) -> str | None:
    """The next line that is not blank and no comment."""
    line = lines.filled_line()
    while line is not None and line.startswith("#"):
        line = lines.filled_line()
    return line


def _read(
    lines: Lines, columns: Sequence[Column], rows: int | None, delimiter: str | None
) -> dict[str, Array]:
    if len(columns) > MOST_COLUMNS:
        raise lines.error(f"at most {MOST_COLUMNS} columns", f"{len(columns)} of them")
    start = lines.mark()
    for size in NAME_BYTES:
        lines.seek(start)
        kinds = [f"S{size}" if column.kind == "S" else column.kind for column in columns]
        fields = [(f"{i}", kinds[i], (column.width,)) for i, column in enumerate(columns)]
        try:
            found = _parsed(lines, np.dtype(fields), rows, delimiter)
        except ValueError as error:
            lines.seek(start)
            try:
                found = _parsed(lines, np.dtype(fields), rows, delimiter, _of_fortran)
            except ValueError:
                lines.seek(start)
                raise _wrong_line(lines, columns, rows, delimiter, str(error)) from None
        lines.number = start.line + len(found)
        names = [found[f"{i}"] for i, column in enumerate(columns) if column.kind == "S"]
        if not any(_has_long(column, size) for column in names):
            return {
                column.name: found[f"{i}"] if column.width > 1 else found[f"{i}"][:, 0]
                for i, column in enumerate(columns)
            }
    raise lines.error(f"names of less than {size} bytes", "a longer one before it")


def _of_fortran(line: bytes) -> bytes:
    return FORTRAN_BYTES.sub(rb"\1e\2", line)


def _parsed(
    lines: Lines,
    dtype: "np.dtype[Any]",
    rows: int | None,
    delimiter: str | None,
    mended: Callable[[bytes], bytes] | None = None,
) -> Array:
    """(rows,) of that dtype.

    Args:
        mended: what a line should be.

    Raises:
        ValueError: there are fewer, or they are something else.
    """
    names = dtype.names or ()
    whole = [name for name in names if CUTS_FRACTIONS and dtype[name].base.kind == "i"]
    asked = [(name, ("f8", dtype[name].shape) if name in whole else dtype[name]) for name in names]
    if rows is not None and (rows == 0 or not lines.peek()):
        found = np.empty(0, dtype)
    else:
        given = islice(lines.file, rows)
        found = np.loadtxt(
            given if mended is None else map(mended, given),
            np.dtype(asked),
            comments="#" if rows is None else None,
            delimiter=delimiter,
            quotechar='"' if rows is None else None,
            encoding="latin1",
            ndmin=1,
        )
    if rows is not None and len(found) < rows:
        raise ValueError("a blank line")
    if any((np.rint(found[name]) != found[name]).any() for name in whole):
        raise ValueError("a fraction")
    return found.astype(dtype, copy=False)


def _has_long(names: Array, size: int) -> bool:
    """Whether one fills all the bytes that it has, and may have been cut."""
    letters = np.ascontiguousarray(names).view(np.uint8).reshape(-1, size)
    return bool(letters[:, -1].any())


def _wrong_line(
    lines: Lines,
    columns: Sequence[Column],
    rows: int | None,
    delimiter: str | None,
    reason: str,
) -> SceneError:
    """What is wrong with the first line that is."""
    every = [column for column in columns for _ in range(column.width)]
    names = some((column.name[:20] for column in every), 8)
    first = lines.number + 1
    while rows is None or lines.number < first + rows - 1:
        line = lines.line() if rows is not None else filled_row(lines)
        if line is None:
            break
        words = split(line, delimiter)
        if len(words) != len(every):
            return lines.error(f"{len(every)} columns ({names})", line)
        for column, word in zip(every, words, strict=True):
            if column.kind != "S" and not is_number(word, column.kind):
                what = "a whole number" if column.kind == "i8" else "a number"
                return lines.error(f"{what} as {column.name}", word)
    if rows is not None and lines.number < first + rows - 1:
        return lines.error(f"{rows} particles from line {first} on", None)
    return SceneError(f"{lines.path}: after line {first - 1}: {reason}")
