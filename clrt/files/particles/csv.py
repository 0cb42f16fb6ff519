"""CSV: a header that names the columns, and a line for each particle."""

from clrt.files.particles.columns import kind_of, particles
from clrt.files.particles.text import (
    Column,
    Lines,
    Mark,
    filled_row,
    is_number,
    rest,
    split,
    table,
)
from clrt.particles.particles import Particles

DELIMITERS = (",", ";", "\t")
HEADERS = {3: ["x", "y", "z"], 4: ["x", "y", "z", "radius"]}  # where the file has none


def read(lines: Lines) -> Particles:
    """The particles of a file.

    The first line names the columns; it may be a comment, as NumPy writes it. A file of three or
    four columns of numbers needs none: they are x, y, z and the radius.

    Raises:
        SceneError: naming file, line and what was expected.
    """
    start, names, delimiter = _header(lines)
    lines.seek(start)
    first = filled_row(lines)
    words = split(first, delimiter) if first else []
    if len(words) != len(names):
        words = [""] * len(names)
    columns = [Column(name, kind_of(name, word)) for name, word in zip(names, words, strict=True)]
    lines.seek(start)
    read, line_of = rest(lines, columns, delimiter) if first else table(lines, columns, 0)
    read.pop("", None)  # the index that pandas writes
    return particles(read, str(lines.path), line_of=line_of)


def _header(lines: Lines) -> tuple[Mark, list[str], str | None]:
    """Where the rows begin, the columns' names, and what is between them."""
    start, line, comment = lines.mark(), lines.filled_line(), None
    while line is not None and line.startswith("#"):
        start, comment, line = lines.mark(), line.lstrip("# "), lines.filled_line()
    expected = "a header that names x, y and z"
    if line is None:
        if comment is None:
            raise lines.error(expected, None)
        line = comment
    delimiter = next((mark for mark in DELIMITERS if mark in line), None)
    names = split(line, delimiter)
    if not all(map(is_number, names)):
        start = lines.mark()
    elif comment is not None and len(split(comment, delimiter)) == len(names):
        names = split(comment, delimiter)
    elif len(names) in HEADERS:
        names = HEADERS[len(names)]
    else:
        raise lines.error(expected, line)
    if len(set(names)) < len(names):
        raise lines.error("another name for each column", line)
    return start, names, delimiter
