"""PDB: https://www.wwpdb.org/documentation/file-format. Atoms are read by their columns, in the
order of the file; cells and assemblies by gemmi (https://gemmi.readthedocs.io), the extra
clrt[mol]."""

import re
from pathlib import Path
from typing import Any

import numpy as np

from clrt.errors import RequestError, SceneError
from clrt.files.particles import rules
from clrt.files.particles.molecules import Options, molecule
from clrt.particles.particles import Particles, bonds_among
from clrt.values import Array, some

WIDTH = 80
ATOMS = (b"ATOM  ", b"HETATM")
OTHERS = np.array([b"C", b"E", b"H", b"M", b"R"])
"""How the names of other lines that are read begin."""
DOTS = (34, 42, 50)
"""Where the points of the coordinates are."""
THREE = re.compile(rb"(-?\d+\.\d{3})\s*(-?\d+\.\d{3})\s*(-?\d+\.\d{3})")
SERIAL = re.compile(rb"(?:ATOM  |HETATM)(\d{6,8})(?= )")


class Models:
    """The frames of a PDB file: what stands between MODEL and ENDMDL, or before an END. All of them
    are in memory.

    Raises:
        RequestError: gemmi is not installed, or there is no such assembly.
        SceneError: there are no atoms, or a coordinate is no number.
    """

    def __init__(self, path: Path, options: Options = Options()) -> None:  # noqa: B008
        try:
            import gemmi
        except ImportError:
            raise RequestError(f"{path}: needs gemmi: pip install 'clrt[mol]'") from None
        self.source, self.options = str(path), options
        self.gemmi = gemmi
        self.lines = _Lines(path.read_bytes())
        self.frames, self.head, self.conect = _frames(self.lines)
        if not self.frames:
            raise SceneError(f"{path}: expected atoms, got none")

    def frame(self, k: int) -> Particles | None:
        """Frame k, or None after the last one."""
        if k >= self.count():
            return None
        rows, cryst = self.frames[k]
        columns, symbols, serials = _columns(self.source, self.lines, rows)
        bonds = _bonds(self.conect, serials)
        head = [*self.head, *([] if cryst is None else [cryst])]
        structure = self.gemmi.read_pdb_string(b"\n".join(head).decode("latin1"))
        cell = structure.cell
        if self.options.assembly is not None:
            columns, symbols, bonds = assembled(
                columns, symbols, bonds, structure, self.options.assembly, self.source
            )
        unit = cell.is_crystal() and min(cell.a, cell.b, cell.c) > 1  # 1 Å stands for none
        box = np.transpose(cell.orth.mat.tolist()) if unit else None
        return molecule(columns, symbols, self.source, box, self.options.altloc, bonds)

    def count(self) -> int:
        return len(self.frames)

    def close(self) -> None:
        self.lines, self.frames = _Lines(b""), []


class _Lines:
    """The lines of a file, any of which can be had as rows of an array."""

    def __init__(self, text: bytes) -> None:
        if b"\r" in text:
            text = text.replace(b"\r\n", b"\n").replace(b"\r", b"\n")
        self.text = text + b"\n" + b" " * WIDTH
        ends = np.flatnonzero(np.frombuffer(self.text, np.uint8) == ord("\n"))
        self.begins = np.concatenate([[0], ends[:-1] + 1])
        self.lengths = ends - self.begins

    def __getitem__(self, i: int) -> bytes:
        begin = int(self.begins[i])
        return self.text[begin : begin + int(self.lengths[i])]

    def starts(self, width: int, rows: Array | slice = slice(None)) -> Array:
        """(n,) of kind S: what is in some lines, and behind the shorter ones, up to a width."""
        # Numbers of NumPy's kind S that begin at every byte, of which those at lines are copied.
        n = len(self.text) - width + 1
        found: Array = np.ndarray((n,), f"S{width}", self.text, strides=(1,))[self.begins[rows]]
        return found

    def letters(self, rows: Array) -> Array:
        """(n, WIDTH) of uint8: some lines, which blanks make as long as that."""
        found: Array = self.starts(WIDTH, rows).view(np.uint8).reshape(-1, WIDTH)
        lengths = self.lengths[rows]
        least = int(lengths.min())
        if least < WIDTH:
            found[:, least:][np.arange(least, WIDTH) >= lengths[:, np.newaxis]] = ord(" ")
        return found


def _frames(
    lines: _Lines,
) -> tuple[list[tuple[Array, bytes | None]], list[bytes], list[bytes]]:
    """For each frame the numbers of its atoms' lines and its CRYST1; what stands in the file's
    head; and the lines of bonds."""
    kinds = lines.starts(6)
    is_atom = (kinds == ATOMS[0]) | (kinds == ATOMS[1])
    rows = np.flatnonzero(is_atom)
    frames = list[tuple[Array, bytes | None]]()
    head, conect, done = list[bytes](), list[bytes](), 0
    cryst: bytes | None = None
    others = np.flatnonzero(~is_atom & np.isin(kinds.astype("S1"), OTHERS))
    before = np.searchsorted(rows, others)
    for i, upto in zip(others.tolist(), before.tolist(), strict=True):
        line = lines[i]
        if line.startswith((b"CRYST1", b"END", b"MODEL")):
            if upto > done:
                frames.append((rows[done:upto], cryst))
                done = upto
            if line.startswith(b"CRYST1"):
                cryst = line
        elif line.startswith(b"CONECT"):
            conect.append(line)
        elif not frames and line.startswith((b"REMARK", b"HEADER")):
            head.append(line)
    if len(rows) > done:
        frames.append((rows[done:], cryst))
    return frames, head, conect


def _columns(source: str, lines: _Lines, rows: Array) -> tuple[dict[str, Array], Array, Array]:
    """The columns, the symbols (n,) of the elements and the numbers (n,) of the atoms."""
    letters = lines.letters(rows)
    odd = np.flatnonzero((letters[:, DOTS] != ord(".")).any(axis=1))
    for i in odd.tolist():
        mended = _mended(source, lines[rows[i]], rows[i] + 1)
        letters[i] = np.frombuffer(mended[:WIDTH].ljust(WIDTH), np.uint8)

    def field(start: int, end: int) -> Array:
        found: Array = np.ascontiguousarray(letters[:, start:end]).view(f"S{end - start}")[:, 0]
        return found

    def numbers(
        start: int, end: int, name: str, decimals: int, blank: float | None = None
    ) -> Array:
        exact = _fixed(letters[:, start:end], decimals)
        if exact is not None:
            return exact
        found = field(start, end)
        if blank is not None:
            empty = (letters[:, start:end] <= 32).all(axis=1)
            found = np.where(empty, str(blank).encode(), found)
        try:
            return found.astype(np.float64)
        except ValueError:
            pass
        for row, word in zip(rows, found.tolist(), strict=True):
            try:
                float(word)
            except ValueError:
                said = word.decode("latin1")
                raise SceneError(
                    f"{source}: line {row + 1}: expected a number as {name}, got {said!r}"
                ) from None
        raise AssertionError

    xyz = [numbers(a, a + 8, axis, 3) for a, axis in ((30, "x"), (38, "y"), (46, "z"))]
    positions = np.stack(xyz, axis=1)
    if len(odd):
        for i in odd.tolist():
            if found := THREE.search(lines[rows[i]], 26):
                positions[i] = [float(word) for word in found.groups()]
    columns = {
        "positions": positions,
        "name": _stripped(field(12, 16)),
        "residue": _stripped(field(17, 21)),
        "residue_id": _whole(letters[:, 22:26]),
        "chain": _stripped(field(21, 22)),
        "insertion": _stripped(field(26, 27)),
        "altloc": _stripped(field(16, 17)),
        "occupancy": numbers(54, 60, "occupancy", 2, blank=1),
        "b_factor": numbers(60, 66, "b_factor", 2, blank=0),
        "hetero": letters[:, 0] == ord("H"),
    }
    return columns, _stripped(field(76, 78)), _whole(letters[:, 6:11])


def _mended(source: str, line: bytes, number: int) -> bytes:
    """A line whose columns are shifted by a number that was too long, with them at their places.

    Raises:
        SceneError: nobody knows where its coordinates are.
    """
    if (found := SERIAL.match(line)) and len(found[1]) > 5:
        moved = line[:6] + line[6 + len(found[1]) - 5 :]
        if all(moved[at : at + 1] == b"." for at in DOTS):
            return moved
        line = moved
    if found := THREE.search(line, 26):
        shift = found.end() - 54
        numbers = b"".join(b"   0.000" for _ in range(3))
        return line[: min(30, found.start())].ljust(30) + numbers + line[54 + shift :]
    fields = [line[a : a + 8].strip() for a in (30, 38, 46)]
    if line[30:54].split() == fields and all(map(_is_number, fields)):
        return line
    said = line[30:54].decode("latin1").strip()
    raise SceneError(f"{source}: line {number}: expected coordinates x, y and z, got {said!r}")


def _is_number(word: bytes) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _stripped(column: Array) -> Array:
    """Text without the blanks around it."""
    found: Array = np.char.strip(column)
    return found


def _fixed(letters: Array, decimals: int) -> Array | None:
    """(n,): numbers that all have their point at one place and end at the field's end; None: one is
    written in another way. In a tenth of the time these are what float() makes of them: a whole
    number by a power of ten is rounded once.

    letters: (n, width) of uint8, width at most 9.
    """
    n, width = letters.shape
    point = width - decimals - 1 if decimals else width
    whole = np.zeros(n, np.int32)
    begun, is_negative = np.zeros(n, bool), np.zeros(n, bool)
    for i, column in enumerate(np.ascontiguousarray(letters.T)):
        if i == point:
            if (column != ord(".")).any():
                return None
            continue
        digits = column - np.uint8(ord("0"))
        is_good = is_digit = digits < 10
        if i < point and i < width - 1:
            is_minus = column == ord("-")
            is_good = is_digit | (~begun & (is_minus | (column == ord(" "))))
            begun |= is_digit | is_minus
            is_negative |= is_minus
        if not is_good.all():
            return None
        whole *= 10
        whole += digits * is_digit
    found = whole / 10.0**decimals
    return np.where(is_negative, -found, found)


def _whole(column: Array) -> Array:
    """Whole numbers, also hybrid-36 (https://cci.lbl.gov/hybrid_36); -1 where there is none.

    column: (n, width) of uint8.
    """
    exact = _fixed(column, 0)
    if exact is not None:
        return exact.astype(np.int64)
    column = np.ascontiguousarray(column).view(f"S{column.shape[1]}")[:, 0]
    try:
        return column.astype(np.int64)
    except ValueError:
        return np.array([_of_36(word.decode("latin1").strip()) for word in column.tolist()])


def _of_36(word: str) -> int:
    if re.fullmatch(r"[+-]?\d+", word):
        return int(word)
    width = len(word)
    if width in (4, 5) and re.fullmatch("[A-Z][A-Z0-9]*|[a-z][a-z0-9]*", word):
        plain, ten = int(word, 36), int(10 * 36 ** (width - 1))
        upper = int(plain - ten + 10**width)
        return upper if word[0].isupper() else upper + int(26 * 36 ** (width - 1))
    return -1


def _bonds(conect: list[bytes], serials: Array) -> Array | None:
    """(m, 2): the bonds of CONECT between atoms that are there."""
    if not conect:
        return None
    row_of = {serial: row for row, serial in reversed([*enumerate(serials.tolist())])}
    found = set[tuple[int, int]]()
    for line in conect:
        words = [line[a : a + 5].decode("latin1").strip() for a in range(6, 31, 5)]
        rows = [row_of.get(_of_36(word)) for word in words if word]
        for other in rows[1:]:
            if rows[0] is not None and other is not None and rows[0] != other:
                found.add((min(rows[0], other), max(rows[0], other)))
    return np.array(sorted(found), np.int64).reshape(-1, 2)


def assembled(
    columns: dict[str, Array],
    symbols: Array,
    bonds: Array | None,
    structure: Any,
    name: str,
    source: str,
) -> tuple[dict[str, Array], Array, Array | None]:
    """The atoms of a biological assembly, those of some chains moved by its operators, and the
    bonds between those that are moved alike. A warning counts bonds that have no such ends.

    Raises:
        RequestError: there is none of this name.
    """
    every = {one.name: one for one in structure.assemblies}
    if name not in every:
        raise RequestError(f"{source}: assembly: expected one of {some(every, 20)}, got {name!r}")
    # Chains of several generators that are moved alike are one copy.
    copies = dict[tuple[float, ...], Array]()
    for generator in every[name].generators:
        chains = np.array([one.encode() for one in generator.chains], "S")
        units = np.array([one.encode() for one in generator.subchains], "S")
        inside = np.isin(columns["subchain"], units) if len(units) and "subchain" in columns else (
            np.isin(columns["chain"], chains))  # fmt: skip
        for operator in generator.operators:
            turn, step = operator.transform.mat.tolist(), operator.transform.vec.tolist()
            key = (*(number for row in turn for number in row), *step)
            copies[key] = copies[key] | inside if key in copies else inside
    rows, moved = list[Array](), list[Array]()
    for key, inside in copies.items():
        here = np.flatnonzero(inside)
        turn, step = np.reshape(key[:9], (3, 3)), np.array(key[9:])
        rows.append(here)
        moved.append(columns["positions"][here] @ turn.T + step)
    row = np.concatenate(rows) if rows else np.zeros(0, np.int64)
    copied = {key: column[row] for key, column in columns.items()}
    copied["positions"] = np.concatenate(moved) if moved else np.zeros((0, 3))
    # Copies of one atom are no alternate locations of each other.
    copied["copy"] = np.repeat(np.arange(len(rows)), [len(one) for one in rows])
    return copied, symbols[row], _copied(bonds, list(copies.values()), source)


def _copied(bonds: Array | None, copies: list[Array], source: str) -> Array | None:
    """(m, 2): the bonds of each copy, of which (n,) bool says which atoms are in it."""
    if bonds is None or not copies:
        return None
    found, first = list[Array](), 0
    kept = np.zeros(len(bonds), bool)
    for inside in copies:
        kept |= inside[bonds].all(axis=1)
        found.append(bonds_among(bonds, inside) + first)
        first += int(np.count_nonzero(inside))
    there = np.logical_or.reduce(copies)[bonds].all(axis=1)
    if left := int(np.count_nonzero(there & ~kept)):
        rules.say(source, f"{left} of {len(bonds)} bonds are left out: their ends are moved apart")
    return np.concatenate(found)
