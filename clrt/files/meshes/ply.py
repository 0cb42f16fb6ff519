"""PLY: the faces of a file whose vertices clrt.files.particles.ply reads as well."""

from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from clrt import memory
from clrt.errors import SceneError
from clrt.files.meshes.surface import Surface, triangles
from clrt.files.particles import opened, ply, rules
from clrt.files.particles.ply import ORDERS, Element
from clrt.files.particles.text import Lines
from clrt.values import Array

INDICES = ("vertex_indices", "vertex_index")
TEXTURES = {"texcoord", "s", "t", "u", "v", "texture_u", "texture_v", "texnumber"}
COLORS = (
    ("red", "green", "blue"),
    ("r", "g", "b"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
)
NORMALS = ("nx", "ny", "nz")
FORMAL = {
    *"xyz",
    *NORMALS,
    "alpha",
    "a",
    "diffuse_alpha",
    *(name for names in COLORS for name in names),
}


class Lists(NamedTuple):
    """A list a row."""

    counts: Array
    """(rows,)"""
    starts: Array
    """(rows,): where each begins in `values`."""
    values: Array


def has_faces(path: Path) -> bool:
    """Whether a file says that it has polygons."""
    try:
        with opened.lines(path).file as file:
            _, elements = ply.header(Lines(path, file, is_packed=True))
    except (SceneError, OSError, EOFError):
        return False
    return any(element.name == "face" and element.rows for element in elements)


def read(lines: Lines) -> Surface:
    """The faces of a file. Polygons are cut into triangles.

    Raises:
        SceneError: naming file, line or row, and what was expected.
        OutputError: they do not fit into memory.
    """
    source = str(lines.path)
    form, elements = ply.header(lines)
    vertices: dict[str, Array] = {}
    faces: dict[str, Array | Lists] = {}
    for element in elements:
        if element.name == "vertex":
            if element.lists:
                raise lines.error("vertices without lists before", "end_header")
            vertices, _ = ply.columns_of(lines, form, element)
        elif element.name == "face":
            faces = _rows(lines, form, element)
        elif vertices and faces:
            rules.say(source, f"element {element.name}: is not used: its faces are drawn")
        else:
            _rows(lines, form, element)
    lists = next((faces[name] for name in INDICES if name in faces), None)
    if not isinstance(lists, Lists) or not len(lists.counts):
        raise SceneError(f"{source}: expected an element face with lists vertex_indices, got none")
    if not {*"xyz"} <= vertices.keys():
        raise SceneError(f"{source}: expected vertices with x, y and z, got {', '.join(vertices)}")
    if lost := TEXTURES & {*vertices, *faces}:
        rules.say(source, f"textures are not read: {' '.join(sorted(lost))}")
    _say_of_alpha(source, vertices)
    corners, polygon = _cut(lists)
    plain = {name: one for name, one in faces.items() if not isinstance(one, Lists)}
    colors = _three(vertices, *COLORS)
    if colors is None and (of_faces := _three(plain, *COLORS)) is not None:
        colors = of_faces[polygon]
    columns = {name: one[polygon] for name, one in plain.items() if name not in FORMAL}
    columns |= {name: one for name, one in vertices.items() if name not in FORMAL}
    places = np.stack([vertices[axis] for axis in "xyz"], axis=1)
    return Surface(places, corners, _three(vertices, NORMALS), colors, columns)


def _cut(lists: Lists) -> tuple[Array, Array]:
    """Triangles of polygons, and which polygon each is of."""
    if (lists.counts == 3).all():
        return lists.values.reshape(-1, 3), np.arange(len(lists.counts))
    return triangles(lists.values, lists.starts, lists.counts)


def _three(columns: dict[str, Any], *names: tuple[str, str, str]) -> Array | None:
    """(n, 3) of the first three names that are all there."""
    for three in names:
        if all(name in columns for name in three):
            return np.stack([columns[name] for name in three], axis=1)
    return None


def _say_of_alpha(source: str, vertices: dict[str, Array]) -> None:
    for name in ("alpha", "a", "diffuse_alpha"):
        if name in vertices:
            alpha = vertices[name]
            if (alpha < (1 if alpha.dtype.kind == "f" else np.iinfo(alpha.dtype).max)).any():
                rules.say(source, f"{name}: is not read: a mesh has the opacity of its material")


def _rows(lines: Lines, form: str, element: Element) -> dict[str, Array | Lists]:
    """The columns and lists of an element, which comes next."""
    if not element.lists:
        return dict(ply.columns_of(lines, form, element)[0])
    if any("" in kinds for kinds in element.lists.values()):
        raise lines.error(f"lists of the types {' '.join(ply.KINDS)} before", "end_header")
    return (_of_text if form == "ascii" else _of_bytes)(lines, form, element)


def _of_text(lines: Lines, form: str, element: Element) -> dict[str, Array | Lists]:
    first = lines.number + 1
    text = b"".join(islice(lines.file, element.rows))
    lines.number += text.count(b"\n")
    odd = text.translate(None, b"0123456789+-.eE \t\r\n")
    numbers = np.zeros(0) if odd else np.fromstring(text, np.float64, sep=" ")
    at = 0

    def one(_: str) -> float:
        nonlocal at
        at += 1
        return float(numbers[at - 1])

    def many(_: str, count: int) -> Array:
        nonlocal at
        at += count
        if at > len(numbers):
            raise IndexError
        return numbers[at - count : at]

    if element.rows and len(numbers) % element.rows == 0:
        rows = numbers.reshape(element.rows, -1)
        if (found := _alike(element, rows)) is not None:
            return found
    try:
        found = _each(element, one, many)
        if at == len(numbers):
            return found
    except (IndexError, ValueError):
        pass
    said = f"expected {element.rows} rows of {' '.join(element.kinds)} from line {first} on"
    raise SceneError(f"{lines.path}: {said}")


def _alike(element: Element, rows: Array) -> dict[str, Array | Lists] | None:
    """Rows of text whose lists have one length; None: they have not."""
    found: dict[str, Array | Lists] = {}
    at = 0
    for name in element.kinds:
        if at >= rows.shape[1]:
            return None
        if name not in element.lists:
            found[name] = rows[:, at]
            at += 1
            continue
        count = int(rows[0, at])
        end = at + 1 + count
        if count < 0 or end > rows.shape[1] or (rows[:, at] != count).any():
            return None
        found[name] = _even(rows[:, at + 1 : end], element.lists[name][1])
        at = end
    return found if at == rows.shape[1] else None


def _even(table: Array, kind: str) -> Lists:
    """Lists of one length as they are in a table."""
    n, count = table.shape
    values = np.ascontiguousarray(table).reshape(-1)
    return Lists(
        np.full(n, count), count * np.arange(n), values if kind[0] == "f" else _whole(values)
    )


def _whole(values: Array) -> Array:
    return values if values.dtype.kind in "iu" else values.astype(np.int64)


def _of_bytes(lines: Lines, form: str, element: Element) -> dict[str, Array | Lists]:
    start, order = lines.file.tell(), ORDERS[form]
    whole = lines.file.read()
    at = 0

    def many(kind: str, count: int) -> Array:
        nonlocal at
        found = np.frombuffer(whole, order + kind, count, at)
        at += found.nbytes
        return found

    def one(kind: str) -> Any:
        return many(kind, 1)[0]

    try:
        fields: list[tuple[Any, ...]] = []
        if element.rows:
            for name, kind in element.kinds.items():  # as the first row is
                if kind:
                    fields.append((name, order + kind))
                    many(kind, 1)
                else:
                    length, item = element.lists[name]
                    count = int(one(length))
                    fields += [(f"{name} ", order + length), (name, order + item, (count,))]
                    many(item, count)
        dtype = np.dtype(fields)
        memory.require(3 * element.rows * dtype.itemsize, f"{lines.path}: faces", "take fewer")
        if dtype.itemsize * element.rows <= len(whole):
            rows = np.frombuffer(whole, dtype, element.rows)
            if all((rows[f"{n} "] == dtype[n].shape[0]).all() for n in element.lists):
                lines.file.seek(start + rows.nbytes)
                return {
                    name: _even(rows[name].reshape(len(rows), -1), element.lists[name][1])
                    if name in element.lists
                    else rows[name].astype(rows[name].dtype.newbyteorder("="))
                    for name in element.kinds
                }
        at = 0
        found = _each(element, one, many)
    except (ValueError, IndexError):
        said = f"expected {element.rows} rows of element {element.name}, the file ends before"
        raise SceneError(f"{lines.path}: {said}") from None
    lines.file.seek(start + at)
    return found


def _each(element: Element, one: Any, many: Any) -> dict[str, Array | Lists]:
    """Row by row, for lists of different lengths.

    Args:
        one, many: what gives the next number of a kind, and the next so many.
    """
    columns: dict[str, list[Any]] = {name: [] for name in element.kinds}
    for _ in range(element.rows):
        for name, kind in element.kinds.items():
            if kind:
                columns[name].append(one(kind))
            else:
                length, item = element.lists[name]
                count = int(one(length))
                if count < 0:
                    raise ValueError(count)
                columns[name].append(many(item, count))
    return dict(_joined(element, columns))


def _joined(element: Element, columns: dict[str, list[Any]]) -> Iterator[tuple[str, Array | Lists]]:
    for name, given in columns.items():
        if name not in element.lists:
            yield name, np.array(given)
            continue
        counts = np.array([len(one) for one in given], np.int64)
        values = np.concatenate([np.zeros(0, np.int8), *given]) if given else np.zeros(0, np.int64)
        is_real = element.lists[name][1][0] == "f"
        yield name, Lists(counts, np.cumsum(counts) - counts, values if is_real else _whole(values))
