"""What legends say of elements and types."""

import numpy as np

import clrt
from clrt.film import color
from clrt.film.decor import legend
from clrt.particles import elements, palette


def srgb(entry: clrt.LegendEntry) -> list[int]:
    """Its colour, as a byte on the curve."""
    found: list[int] = np.rint(255 * color.to_srgb(np.array(entry.color))).astype(int).tolist()
    return found


def test_elements() -> None:
    found = legend.of_elements([0, 1, 6, 8])
    assert [entry.name for entry in found] == ["X", "H", "C", "O"]
    assert [srgb(entry) for entry in found] == elements.COLORS[[0, 1, 6, 8]].tolist()
    assert legend.of_elements([]) == ()


def test_types() -> None:
    found = legend.of_types([-1, 3, 9])
    assert [entry.name for entry in found] == ["-1", "3", "9"]
    assert [srgb(entry) for entry in found] == palette.OKABE_ITO[[7, 3, 1]].tolist()
    named = legend.of_types([0, 2], ("water", "ion", "lipid"))
    assert [entry.name for entry in named] == ["water", "lipid"]
    assert [srgb(entry) for entry in named] == palette.OKABE_ITO[[0, 2]].tolist()
