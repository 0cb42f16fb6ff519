"""Choose: which particles there are, where their periodic images are, and which columns and kinds a
key means."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from clrt.errors import RequestError, warn
from clrt.particles import expression
from clrt.particles.particles import Particles
from clrt.particles.texts import Text
from clrt.values import Array, did_you_mean, some


def selected(
    columns: Mapping[str, Array | Text],
    n: int,
    select: str | None,
    hide: str | None,
    may_be_none: bool = False,
) -> Array | None:
    """(n,) bool: those of which `select` is true and `hide` is not; None: all.

    Raises:
        RequestError: an expression is none, or nothing is left; it names the key.
    """
    kept: Array | None = None
    for key, text in (("select", select), ("hide", hide)):
        if text is not None:
            found = _condition(key, text, columns, n)
            found = found if key == "select" else ~found
            kept = found if kept is None else kept & found
    if kept is not None and not may_be_none and not kept.any():
        key = "select" if select is not None else "hide"
        there = "".join(
            f"; {name} is {_range(columns[name])}"
            for text in (select, hide)
            if text is not None
            for name in expression.columns_of(text, columns)
        )
        raise RequestError(
            f"{key}: expected to keep at least one of {n} particles, got none{there}"
        )
    return kept


def _condition(key: str, text: str, columns: Mapping[str, Array | Text], n: int) -> Array:
    try:
        found = expression.evaluate(text, columns)
    except RequestError as error:
        raise RequestError(f"{key}: {error}") from None
    if isinstance(found, Text) or not (found.dtype == bool or np.isin(found, (0, 1)).all()):
        raise RequestError(f"{key}: expected a condition, as x > 0, got {text!r}")
    return np.broadcast_to(found != 0, (n,))


def _range(column: Array | Text) -> str:
    if isinstance(column, Text):
        return f"one of {some(column.kinds)}"
    finite = column[np.isfinite(column)]
    if not finite.size:
        return "not a number"
    return f"from {finite.min():.6g} to {finite.max():.6g}"


def wrapped(particles: Particles) -> Particles:
    """The particles, each moved into the box by whole edges.

    Raises:
        RequestError: there is no box.
    """
    cell = _cell(particles, "wrap")
    positions = np.asarray(particles.positions, np.float64)
    edges = np.floor((positions - particles.origin) @ np.linalg.inv(cell))
    # What lies in the box stays as it is, to the bit.
    outside: Array = np.asarray(edges.any(axis=1))
    moved = np.where(outside[:, np.newaxis], positions - edges @ cell, particles.positions)
    return particles.replaced(positions=moved.astype(particles.positions.dtype, copy=False))


def images(particles: Particles, counts: Sequence[int]) -> Array:
    """How far the images of particles are moved: (images, 3), the first one's by nothing.

    counts: along each edge of the box.

    Raises:
        RequestError: there is no box.
    """
    edges = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    found: Array = edges @ _cell(particles, "replicate")
    return found


def _cell(particles: Particles, key: str) -> Array:
    if particles.cell is None:
        raise RequestError(f"{key}: expected particles in a box, got none")
    if np.linalg.matrix_rank(particles.cell) < 3:
        raise RequestError(f"{key}: expected a box of three edges, got {particles.cell.tolist()}")
    return particles.cell


def kinds_of(particles: Particles) -> dict[str, Text]:
    """What particles can be called by: "type" (numbers as text), "element" and "name"."""
    found: dict[str, Text] = {}
    for name in ("type", "element", "name"):
        column = particles.columns.get(name)
        if isinstance(column, Text):
            found[name] = column
        elif name == "type" and particles.types is not None:
            numbers, which = np.unique(particles.types, return_inverse=True)
            found[name] = Text(tuple(map(str, numbers.tolist())), which.reshape(-1))
    return found


def matching(keys: Mapping[Any, Any], kinds: Mapping[str, Text]) -> str | None:
    """The first of `kinds` that knows the most of some keys; None if none knows one."""
    known = {name: sum(str(key) in text.kinds for key in keys) for name, text in kinds.items()}
    best = max(known, key=lambda name: known[name], default=None)
    return best if best is not None and known[best] else None


def say_absent(key: str, name: str, kinds: Mapping[str, Text]) -> None:
    """Warns that something is given to a kind of which there is no particle."""
    there = [kind for text in kinds.values() for kind in text.kinds]
    hint = did_you_mean(name, there)
    warn(key, f"no particle is called {name!r}, there are {some(there, 12)}{hint}")


def column(
    key: str, given: str, columns: Mapping[str, Array | Text], beside: Sequence[str] = ()
) -> Array | Text:
    """The column, or the expression of columns, that a key is given.

    Args:
        beside: what else could have been given.

    Raises:
        RequestError: it is none; it names the key.
    """
    if given not in columns and given.replace("_", "a").isalnum():
        known = list(dict.fromkeys([*beside, *columns]))
        hint = did_you_mean(given, known)
        raise RequestError(f"{key}: expected one of {some(known, 20)}, got {given!r}{hint}")
    try:
        return expression.evaluate(given, columns)
    except RequestError as error:
        raise RequestError(f"{key}: {error}") from None
