"""Legend: what elements and types are called, and their colours.

A scene file has no need of it where particles are coloured by element or type: what reads them
asks here, and puts it into the scene's film.
"""

import numpy as np

from clrt.film import color
from clrt.particles import elements, palette
from clrt.scene.film import LegendEntry
from clrt.values import Array


def of_elements(numbers: Array) -> tuple[LegendEntry, ...]:
    """One for each element that there is, lightest first.

    numbers: (n,) atomic numbers.
    """
    there = np.flatnonzero(np.bincount(numbers, minlength=1))
    return _entries([elements.SYMBOLS[k] for k in there], elements.COLORS[there])


def of_types(types: Array, names: tuple[str, ...] | None = None) -> tuple[LegendEntry, ...]:
    """One for each type that there is, in order.

    Args:
        types: (n,) whole numbers.
        names: that of type t is names[t]; None: types are but numbers.
    """
    there = np.unique(types)
    called = [str(t) if names is None else names[t] for t in there]
    return _entries(called, palette.of_types(there))


def _entries(names: list[str], srgb: Array) -> tuple[LegendEntry, ...]:
    colors = color.linear(srgb).tolist()
    return tuple(LegendEntry(name, one) for name, one in zip(names, colors, strict=True))
