"""Palette: colour maps for columns, and colours of types.

clrt/tables/colormaps.csv has the maps and names their sources.
"""

import functools

import numpy as np
from numpy.typing import ArrayLike

from clrt import storage
from clrt.errors import RequestError
from clrt.values import Array, frozen

COLORMAPS = ("viridis", "plasma", "turbo", "coolwarm")
"""The maps that are always there; matplotlib brings more."""

UNKNOWN = (128, 128, 128)
"""The colour of NaN, sRGB."""

OKABE_ITO = np.array(
    [
        (230, 159, 0),
        (86, 180, 233),
        (0, 158, 115),
        (240, 228, 66),
        (0, 114, 178),
        (213, 94, 0),
        (204, 121, 167),
        (0, 0, 0),
    ],
    np.uint8,
)
"""(8, 3) sRGB, which the colour-blind can tell apart: M. Okabe and K. Ito, Color Universal Design
(2002), https://jfly.uni-koeln.de/color."""


GOLDEN_ANGLE = (3 - 5**0.5) / 2
"""In turns: of so many as there are none is near another."""


def of_types(types: Array) -> Array:
    """(n, 3) uint8, sRGB, of types (n,), by the palette, over and over."""
    found: Array = OKABE_ITO[types % len(OKABE_ITO)]
    return found


def of_kinds(n: int) -> Array:
    """(n, 3) uint8, sRGB, all different: the palette, and then hues a golden angle apart, in three
    shades."""
    import colorsys

    found = np.empty((n, 3), np.uint8)
    found[: len(OKABE_ITO)] = OKABE_ITO[:n]
    for k in range(len(OKABE_ITO), n):
        hue, shade = k * GOLDEN_ANGLE % 1, (0.9, 0.65, 0.8)[k % 3]
        found[k] = np.rint(255 * np.array(colorsys.hsv_to_rgb(hue, (0.75, 0.6, 0.4)[k % 3], shade)))
    return found


def of_values(
    values: ArrayLike, cmap: str = "viridis", clim: tuple[float, float] | None = None
) -> Array:
    """(n, 3) uint8, sRGB, of numbers (n,), by a colour map.

    Values outside `clim` take the map's ends, NaN takes gray, and if `clim` has no width the value
    in it takes the map's middle.

    Args:
        cmap: one of COLORMAPS, or of matplotlib's if it is there; _r behind it turns it round.
        clim: the values of the map's ends; None: the least and the largest finite value.

    Raises:
        RequestError: there is no such map, or clim is no range.
    """
    table = colormap(cmap)
    numbers = np.asarray(values, np.float64)
    low, high = limits(numbers, clim)
    unknown = np.isnan(numbers)
    if low == high:
        part = np.where(numbers < low, 0, np.where(numbers > high, 1, 0.5))
    else:
        scale = 0.5 if np.isinf(high - low) else 1.0
        part = np.clip(numbers, low, high) * scale - low * scale
        part /= high * scale - low * scale
        part[unknown] = 0
    found: Array = table[np.minimum(part * len(table), len(table) - 1).astype(np.intp)]
    found[unknown] = UNKNOWN
    return found


def limits(values: Array, clim: tuple[float, float] | None = None) -> tuple[float, float]:
    """The range `clim`, or if it is None that of the finite values; (0, 1) if there is none.

    Raises:
        RequestError: clim is no range.
    """
    if clim is None:
        finite = values[np.isfinite(values)]
        return (float(finite.min()), float(finite.max())) if finite.size else (0.0, 1.0)
    return check_limits(clim)


def check_limits(clim: tuple[float, float]) -> tuple[float, float]:
    """The range `clim`.

    Raises:
        RequestError: it is none.
    """
    try:
        low, high = map(float, clim)
        good = bool(np.isfinite([low, high]).all()) and low <= high
    except (TypeError, ValueError):
        good = False
    if not good:
        raise RequestError(f"clim: expected two finite numbers, the lower one first, got {clim!r}")
    return low, high


@functools.cache
def colormap(name: str) -> Array:
    """(m, 3) uint8, sRGB, from the lowest value to the highest.

    Raises:
        RequestError: there is none of this name.
    """
    plain = name.removesuffix("_r")
    if plain in COLORMAPS:
        lines = (storage.folder("tables") / "colormaps.csv").read_text().splitlines()
        names, *rows = (line.split(",") for line in lines if not line.startswith("#"))
        column = names.index(plain)
        table = np.array([list(bytes.fromhex(row[column])) for row in rows], np.uint8)
        return frozen(table if name == plain else table[::-1].copy())
    try:
        from matplotlib import colormaps
    except ImportError:
        known = ", ".join(COLORMAPS)
        raise RequestError(
            f"cmap: expected one of {known}, got {name!r}: pip install matplotlib for more"
        ) from None
    if name not in colormaps:
        known = ", ".join(COLORMAPS)
        raise RequestError(f"cmap: expected one of {known} or of matplotlib's, got {name!r}")
    found = colormaps[name]
    return frozen(np.rint(255 * found(np.arange(found.N))[:, :3]).astype(np.uint8))
