"""Legend: the names of elements and types, and their colours.

A scene file has no need of it where particles are coloured by element or type: what reads them
asks here, and puts it into the scene's film.
"""

from collections.abc import Sequence

import numpy as np

from clrt.film import color
from clrt.particles import elements, palette
from clrt.scene.film import LegendEntry
from clrt.values import Array


def of_elements(numbers: Sequence[int]) -> tuple[LegendEntry, ...]:
    """One for each.

    numbers: atomic ones.
    """
    return _entries([elements.SYMBOLS[k] for k in numbers], elements.COLORS[list(numbers)])


def of_types(types: Sequence[int], names: tuple[str, ...] | None = None) -> tuple[LegendEntry, ...]:
    """One for each.

    names: that of type t is names[t]; None: types are but numbers.
    """
    called = [str(t) if names is None else _line(names[t]) for t in types]
    return _entries(called, palette.of_types(np.array(types, np.int64)))


def of_kinds(kinds: Sequence[str], srgb: Array) -> tuple[LegendEntry, ...]:
    """One for each text.

    srgb: (kinds, 3).
    """
    return _entries([_line(kind) for kind in kinds], srgb)


def _line(text: str) -> str:
    return "".join(c if c.isprintable() else " " for c in text) or "(none)"


def _entries(names: list[str], srgb: Array) -> tuple[LegendEntry, ...]:
    colors = color.linear(srgb).tolist()
    return tuple(LegendEntry(name, one) for name, one in zip(names, colors, strict=True))
