"""Values: checks that the parts of a scene share, and the errors that they report."""

import math
import operator
from collections.abc import Callable, Iterable
from typing import Any, TypeAlias

import msgspec
import numpy as np
from msgspec.structs import force_setattr
from numpy.typing import ArrayLike, NDArray

from clrt.errors import SceneError

Vec3: TypeAlias = tuple[float, float, float]
Color: TypeAlias = tuple[float, float, float]
BLACK: Color = (0.0, 0.0, 0.0)
WHITE: Color = (1.0, 1.0, 1.0)
Array: TypeAlias = NDArray[Any]


class RowError(SceneError):
    """A value of an array is wrong."""

    key: str
    row: int | None
    """Which; None where there is one for all."""
    expected: str
    """The expected value, and the one that was given."""


def require(good: bool, key: str, expected: str, value: object) -> None:
    if not good:
        raise SceneError(f"{key}: expected {expected}, got {_short(value)}")


def _short(value: object) -> str:
    if isinstance(value, np.ndarray) and value.ndim:
        return f"{value.dtype} of {value.shape}"
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:60]}... ({len(text)} characters)"


def all_of(struct: msgspec.Struct, key: str, kind: type | tuple[type, ...], what: str) -> None:
    """Makes a tuple of any sequence of that kind."""
    given = getattr(struct, key)
    try:
        found = tuple(given)
    except TypeError:
        found = (None,)
    for i, one in enumerate(found):
        where = key if not isinstance(given, list | tuple) else f"{key}[{i}]"
        require(isinstance(one, kind), where, what, one if where != key else given)
    force_setattr(struct, key, found)


def vectors(struct: msgspec.Struct, *keys: str) -> None:
    """Makes triples of floats of any sequences of three finite numbers."""
    for key in keys:
        given = getattr(struct, key)
        try:
            good = len(given) == 3 and all(map(math.isfinite, given))
        except (TypeError, OverflowError):
            good = False
        require(good, key, "three finite numbers", given)
        force_setattr(struct, key, tuple(map(float, given)))


def number(
    struct: msgspec.Struct,
    key: str,
    expected: str,
    good: Callable[[float], bool],
    *,
    finite: bool = True,
) -> None:
    """finite=False: it is for `good` to say whether infinity is."""
    given = getattr(struct, key)
    try:
        fine = (math.isfinite(given) or not finite) and good(given)
    except (TypeError, OverflowError):
        fine = False
    require(fine, key, expected, given)
    force_setattr(struct, key, float(given))


def switches(struct: msgspec.Struct, *keys: str) -> None:
    for key in keys:
        given = getattr(struct, key)
        require(isinstance(given, bool), key, "true or false", given)


def count(struct: msgspec.Struct, key: str, least: int, most: int) -> None:
    given = getattr(struct, key)
    try:
        good = least <= operator.index(given) <= most
    except TypeError:
        good = False
    require(good, key, f"a whole number from {least} to {most}", given)
    force_setattr(struct, key, operator.index(given))


def some(names: Iterable[str], most: int = 5) -> str:
    """The first few of them, and how many there are more."""
    found = list(map(repr, names))
    more = [f"{len(found) - most} more"] if len(found) > most else []
    return ", ".join(found[:most] + more) or "none"


def did_you_mean(given: object, known: Iterable[str]) -> str:
    """The end of a sentence that names the nearest of some words; "" if none is near."""
    from difflib import get_close_matches

    words = {word.lower(): word for word in known}
    near = get_close_matches(str(given).lower(), words, 1)
    return f"; did you mean {words[near[0]]!r}?" if near else ""


def floats(key: str, given: ArrayLike, columns: int) -> Array:
    """A finite array of floats that nobody else can change: (n, columns), or (n,) or () for 1.

    float32 and float64 are kept as they are; others become float64.

    Raises:
        SceneError: it is none, or a value is not finite.
    """
    try:
        array = np.asarray(given)
        kind = array.dtype.newbyteorder("=")
        kept = kind in (np.float32, np.float64)
        array = array.astype(kind if kept else np.float64, copy=False)
    except (TypeError, ValueError):
        array = np.zeros((1, 1, 1))
    shape = f"(n, {columns})" if columns > 1 else "(n,) or one number"
    good = array.shape[1:] == (columns,) if columns > 1 else array.ndim <= 1
    require(good, key, f"numbers of shape {shape}", given)
    array = owned(array)
    expected = "finite numbers" if columns > 1 else "a finite number"
    check_rows(key, np.isfinite(array), array, expected)
    return array


def median(values: Array) -> float:
    """Of (n,) finite numbers, one at least. np.median imports masked arrays, which takes 10 ms."""
    low, high = (len(values) - 1) // 2, len(values) // 2
    parts = np.partition(values, (low, high))
    return float(parts[low]) / 2 + float(parts[high]) / 2


def owned(array: Array) -> Array:
    """The array itself if it is contiguous and nobody can write to it, or else a copy."""
    if array.flags.c_contiguous and not _can_change(array):
        return array
    return frozen(array.copy())


def frozen(array: Array) -> Array:
    """The array, which from now on nobody can write to."""
    array.flags.writeable = False
    return array


def _can_change(array: Any) -> bool:
    """Whether somebody can write to it: it, or an array that it is a view of, is writeable."""
    while isinstance(array, np.ndarray):
        if array.flags.writeable:
            return True
        array = array.base
    return array is not None and not isinstance(array, bytes)


def check_rows(key: str, good: Array, values: Array, expected: str) -> None:
    """Finds the first value that is not good.

    Raises:
        RowError: there is one.
    """
    if good.all():
        return
    rows = good if good.ndim <= 1 else good.all(axis=1)
    row = int(np.argmin(rows)) if rows.ndim else None
    value = values if row is None else values[row]
    said = f"expected {expected}, got {_short(value.tolist())}"
    error = RowError(f"{key}: {said}" if row is None else f"{key}[{row}]: {said}")
    error.key, error.row, error.expected = key, row, said  # it can be pickled so
    raise error
