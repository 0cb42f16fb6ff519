"""How far one picture is from another."""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from clrt.errors import RequestError

Array: TypeAlias = NDArray[Any]

QUARTER_STEP = 1 / 1020
"""A quarter of an 8-bit step: an error that no 8-bit picture shows, but for a rounding."""


@dataclass(frozen=True)
class Difference:
    """Error figures of a picture against another, over colours clipped to [0, 1].

    A pixel's error is the largest of its channels'.
    """

    pixels: int
    max: float
    rmse: float
    """Over all channels."""
    psnr: float
    """Decibels, of a peak of 1; infinity for equal pictures."""
    p50: float
    p99: float
    p999: float
    over_255: int
    """Pixels off by more than 1/255, one step of an 8-bit picture."""
    over_1020: int
    """Pixels off by more than QUARTER_STEP."""
    flips: int
    """Pixels whose paths differ; where paths are not known, as over_1020."""
    interior_flips: int
    """Flips that are not within a pixel of an edge of the other picture."""
    max_off_flips: float


def pixel_error(a: Array, b: Array) -> NDArray[np.float64]:
    """Each pixel's error: (height, width) from two pictures (height, width, 3) of [0, 1], or 4 with
    alpha, premultiplied.

    NaN counts as the largest error, 1.

    Raises:
        RequestError: they differ in size, or one has alpha.
    """
    if a.shape[:2] == b.shape[:2] and a.shape[2] != b.shape[2]:
        raise RequestError("one of the pictures has alpha, the other has not")
    if a.shape != b.shape:
        raise RequestError(f"the pictures differ in size: {_size(a)} and {_size(b)}")
    worst: NDArray[np.float64] = abs(_clipped(a) - _clipped(b)).max(axis=2)
    return np.nan_to_num(worst, nan=1.0)


def difference(
    a: Array, b: Array, paths_a: Array | None = None, paths_b: Array | None = None
) -> Difference:
    """The error figures of picture `a` against picture `b`, both (height, width, 3 or 4).

    paths_a, paths_b: (height, width), as from Renderer.paths() and reference.trace(). Without them
    flips are told by the error and edges by the colours of `b`.
    """
    error = pixel_error(a, b)
    square = np.nan_to_num((_clipped(a) - _clipped(b)) ** 2, nan=1.0).mean()
    p50, p99, p999 = np.percentile(error, (50, 99, 99.9))
    if paths_a is None or paths_b is None:
        flips = error > QUARTER_STEP
        steps = np.rint(32 * _clipped(b)).astype(np.int64)
        interior = ~edges(steps @ 64 ** np.arange(b.shape[2]))
    else:
        flips = paths_a != paths_b
        interior = ~edges(paths_b)
    return Difference(
        pixels=error.size,
        max=float(error.max()),
        rmse=float(np.sqrt(square)),
        psnr=float(-10 * np.log10(square)) if square > 0 else float("inf"),
        p50=float(p50),
        p99=float(p99),
        p999=float(p999),
        over_255=int((error > 1 / 255).sum()),
        over_1020=int((error > QUARTER_STEP).sum()),
        flips=int(flips.sum()),
        interior_flips=int((flips & interior).sum()),
        max_off_flips=float(error[~flips].max(initial=0)),
    )


def edges(paths: Array) -> NDArray[np.bool_]:
    """The pixels that differ from a neighbour, diagonals included.

    paths: (height, width), as from reference.trace().
    """
    edge = np.zeros(paths.shape, bool)
    for down, right in ((0, 1), (1, 0), (1, 1), (1, -1)):
        rows = slice(None, -1) if down else slice(None)
        below = slice(1, None) if down else slice(None)
        if right == 1:
            columns, beside = slice(None, -1), slice(1, None)
        elif right == -1:
            columns, beside = slice(1, None), slice(None, -1)
        else:
            columns = beside = slice(None)
        differs = paths[rows, columns] != paths[below, beside]
        edge[rows, columns] |= differs
        edge[below, beside] |= differs
    return edge


def heatmap(error: NDArray[np.float64]) -> NDArray[np.float32]:
    """Errors as colours: black below 1e-7, then blue, red, yellow and white at 1.

    error: (height, width). Returns (height, width, 3) in [0, 1].
    """
    decade = np.log10(np.maximum(error, 1e-7)) + 7
    levels = [0, 1, 3, 5, 6, 7]
    red = np.interp(decade, levels, [0, 0, 0.5, 1, 1, 1])
    green = np.interp(decade, levels, [0, 0, 0, 0.1, 0.8, 1])
    blue = np.interp(decade, levels, [0, 0.4, 0.6, 0.3, 0.1, 1])
    return np.stack([red, green, blue], axis=2).astype(np.float32)


def _clipped(image: Array) -> NDArray[np.float64]:
    return np.clip(image.astype(np.float64), 0, 1)


def _size(image: Array) -> str:
    return f"{image.shape[1]}x{image.shape[0]}"
