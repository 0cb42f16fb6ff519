"""OBJ: vertices, normals and faces, a line each, that name one another by numbers.

Wavefront Technologies, Advanced Visualizer Manual, appendix B1 (1993);
https://paulbourke.net/dataformats/obj
"""

import re
from math import isfinite
from typing import NamedTuple

import numpy as np

from clrt.errors import SceneError
from clrt.files.meshes.surface import Surface, merged, triangles
from clrt.files.particles import rules
from clrt.files.particles.text import Lines
from clrt.values import Array, some

READ = (b"v", b"vn", b"f")
SILENT = (b"g", b"o", b"s", b"#", b"")
"""Groups are drawn like the rest; smoothing groups say nothing that normals do not."""
TEXTURES = (b"vt", b"mtllib", b"usemtl")
BLANK, LINE = b" \t\r", b"\n"


class Words(NamedTuple):
    """The lines of a file that begin with one word, without it."""

    text: bytes
    counts: Array
    """How many words each line has."""
    numbers: Array
    """(lines,): which line of the file each is, from 1."""


def read(lines: Lines) -> Surface:
    """The faces of a file. Polygons are cut into triangles.

    Raises:
        SceneError: naming file and line, and what was expected.
    """
    whole = lines.file.read().replace(b"\\\n", b"  ").replace(b"\\\r\n", b"   ")
    found, others = _sorted(whole)
    _say_what_is_not_read(str(lines.path), others)
    vertices = _rows(lines, found[b"v"], "v", (3, 4, 6, 7))
    normals = _rows(lines, found[b"vn"], "vn", (3,))
    per_corner, corners = _corners(lines, found[b"f"])
    faces = found[b"f"]
    where = np.repeat(faces.numbers, faces.counts)
    place = _absolute(lines, corners[:, 0], found[b"v"], where, "v")
    starts = np.cumsum(faces.counts) - faces.counts
    colors = vertices[:, 3:6] if vertices.shape[1] >= 6 else None
    points = vertices[:, :3]
    if per_corner < 3 or not len(normals):
        if per_corner == 3:
            raise lines.error("normals vn, which faces name", "none")
        return Surface(points, triangles(place, starts, faces.counts)[0], None, colors)
    turned = _absolute(lines, corners[:, 2], found[b"vn"], where, "vn")
    if (place == turned).all() and len(normals) == len(points):
        return Surface(points, triangles(place, starts, faces.counts)[0], normals, colors)
    # A vertex is one for each normal that it has.
    pairs, which = merged(np.stack([place, turned], axis=1))
    split = None if colors is None else colors[pairs[:, 0]]
    cut = triangles(which, starts, faces.counts)[0]
    return Surface(points[pairs[:, 0]], cut, normals[pairs[:, 1]], split)


def _sorted(whole: bytes) -> tuple[dict[bytes, Words], dict[bytes, int]]:
    """Lines by the words that they begin with, and how many there are of each other word."""
    letters = np.frombuffer(bytearray(whole + LINE), np.uint8)
    ends = np.flatnonzero(letters == LINE[0])
    starts = np.append(0, ends[:-1] + 1)
    one, two, three = (letters[np.minimum(starts + k, ends)] for k in range(3))
    if (np.isin(one, list(BLANK)) & (ends > starts + 1)).any():  # lines begin with blanks
        return _sorted(LINE.join(line.strip() for line in whole.split(LINE)))
    blank = np.zeros(256, bool)
    blank[list(BLANK + LINE)] = True
    kind = np.zeros(len(ends), np.uint8)
    kind[(one == ord("v")) & blank[two]] = 1
    kind[(one == ord("v")) & (two == ord("n")) & blank[three]] = 2
    kind[(one == ord("f")) & blank[two]] = 3
    letters[starts[kind > 0]] = letters[starts[kind == 2] + 1] = BLANK[0]
    changes = np.flatnonzero(np.diff(kind)) + 1
    runs = list(zip(np.append(0, changes), np.append(changes, len(kind)), strict=True))
    found = {}
    for k, key in enumerate(READ, 1):
        parts = [
            letters[starts[first] : ends[last - 1] + 1].tobytes()
            for first, last in runs
            if kind[first] == k
        ]
        text = b"".join(parts)
        text = re.sub(rb"#[^\n]*", b"", text) if b"#" in text else text
        found[key] = Words(text, _counts(text), np.flatnonzero(kind == k) + 1)
    others: dict[bytes, int] = {}
    for first, last in runs:
        if kind[first] == 0:
            for line in whole[starts[first] : ends[last - 1]].split(LINE):
                key = (line.split(None, 1) or [b""])[0]
                key = key[:1] if key[:1] == b"#" else key
                others[key] = others.get(key, 0) + 1
    return found, others


def _counts(text: bytes) -> Array:
    """(lines,): how many words each line has."""
    letters = np.frombuffer(text, np.uint8)
    is_blank = letters <= BLANK[0]
    begins = ~is_blank
    begins[1:] &= is_blank[:-1]
    found: Array = np.diff(
        np.searchsorted(np.flatnonzero(begins), np.flatnonzero(letters == LINE[0])), prepend=0
    )
    return found


def _say_what_is_not_read(source: str, others: dict[bytes, int]) -> None:
    if textures := [key.decode() for key in TEXTURES if key in others]:
        rules.say(source, f"textures and materials are not read: {' '.join(textures)}")
    known = {*SILENT, *TEXTURES}
    if rest := {
        key.decode("utf-8", "replace")[:20]: n for key, n in others.items() if key not in known
    }:
        rules.say(source, f"lines that are not read begin with {some(rest)}: {sum(rest.values())}")


def _rows(lines: Lines, words: Words, key: str, widths: tuple[int, ...]) -> Array:
    """(lines, columns) of the numbers of lines.

    Raises:
        SceneError: a line has another number of them than the first one has, or something else.
    """
    if not len(words.counts):
        return np.zeros((0, 3))
    width = int(words.counts[0])
    expected = f"{key} and {' or '.join(map(str, widths))} numbers in each line"
    wrong = np.flatnonzero(words.counts != width) if width in widths else np.zeros(1, np.int64)
    if not len(wrong):
        found = np.fromstring(words.text, np.float64, sep=" ") if _is_number(words.text) else None
        if found is not None and len(found) == width * len(words.counts):
            return found.reshape(-1, width)
        wrong = np.array([_first_odd(words.text)])
    raise _error(lines, words, int(wrong[0]), expected)


def _is_number(text: bytes) -> bool:
    """Whether there are but numbers, for NumPy stops at a word without an error."""
    return not text.translate(None, b"0123456789+-.eE" + BLANK + LINE)


def _first_odd(text: bytes) -> int:
    """The first line that has something else than numbers."""
    for k, line in enumerate(text.split(LINE)):
        try:
            if not all(map(isfinite, map(float, line.split()))):
                return k
        except ValueError:
            return k
    return 0


def _error(lines: Lines, words: Words, row: int, expected: str) -> SceneError:
    lines.number = int(words.numbers[row])
    return lines.error(expected, words.text.split(LINE)[row].decode("utf-8", "replace").strip())


def _corners(lines: Lines, faces: Words) -> tuple[int, Array]:
    """How many numbers each corner may have, and (corners, so many) of them; 0: not given.

    Raises:
        SceneError: a face has something else.
    """
    if not len(faces.counts):
        raise lines.error("lines f, of faces", None)
    expected = "f and three or more corners, as 1, 1/2, 1//3 or 1/2/3"
    if (faces.counts < 3).any():
        raise _error(lines, faces, int(np.argmax(faces.counts < 3)), expected)
    if faces.text.translate(None, b"0123456789-/" + BLANK + LINE):
        odd = b"0123456789-/" + BLANK
        rows = faces.text.split(LINE)
        raise _error(
            lines, faces, next(k for k, r in enumerate(rows) if r.translate(None, odd)), expected
        )
    total = int(faces.counts.sum())
    slashes, doubled = faces.text.count(b"/"), faces.text.count(b"//")
    # Without digits a corner is as many slashes one behind the other. All are of one form, or each
    # is looked at.
    bare = faces.text.translate(None, b"0123456789-") if slashes else b""
    runs = next(k for k in range(4) if k == 3 or b"/" * (k + 1) not in bare)
    if slashes == runs * total and doubled in (0, total):
        text = faces.text.replace(b"//", b" 0 ").replace(b"/", b" ")
        numbers = np.fromstring(text, np.int64, sep=" ")
        if len(numbers) == (runs + 1) * total:
            return runs + 1, numbers.reshape(-1, runs + 1)
    found = np.zeros((total, 3), np.int64)
    at = 0
    for row, line in enumerate(faces.text.split(LINE)):
        for word in line.split():
            parts = word.split(b"/")
            try:
                found[at, : len(parts)] = [int(part or 0) for part in parts]  # at most three
            except ValueError:
                raise _error(lines, faces, row, expected) from None
            at += 1
    has_normals = bool((found[:, 2] != 0).all())
    return (3 if has_normals else 1), found


def _absolute(lines: Lines, named: Array, given: Words, where: Array, key: str) -> Array:
    """Indices from 0, of numbers from 1, or from -1 backwards from the line where they are.

    Raises:
        SceneError: there is no such row.
    """
    count = len(given.numbers)
    found = named - 1
    if (backwards := named < 0).any():
        before = np.searchsorted(given.numbers, where[backwards])
        found[backwards] = before + named[backwards]
    wrong = (found < 0) | (found >= count) | (named == 0)
    if wrong.any():
        first = int(np.argmax(wrong))
        lines.number = int(where[first])
        raise lines.error(f"{key} from 1 to {count}", str(int(named[first])))
    return found
