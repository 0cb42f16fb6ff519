"""Values: what the parts of a scene check, and how they report what is wrong."""

import math
import operator
from collections.abc import Callable, Iterable
from typing import TypeAlias

import msgspec
from msgspec.structs import force_setattr

from clrt.errors import SceneError

Vec3: TypeAlias = tuple[float, float, float]
Color: TypeAlias = tuple[float, float, float]
BLACK: Color = (0.0, 0.0, 0.0)
WHITE: Color = (1.0, 1.0, 1.0)


def require(good: bool, key: str, expected: str, value: object) -> None:
    if not good:
        raise SceneError(f"{key}: expected {expected}, got {_short(value)}")


def _short(value: object) -> str:
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


def number(struct: msgspec.Struct, key: str, expected: str, good: Callable[[float], bool]) -> None:
    given = getattr(struct, key)
    try:
        fine = math.isfinite(given) and good(given)
    except (TypeError, OverflowError):
        fine = False
    require(fine, key, expected, given)
    force_setattr(struct, key, float(given))


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
