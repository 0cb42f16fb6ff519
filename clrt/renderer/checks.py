"""Checks: which size, region, dtype and passes a picture may be asked for."""

import operator
from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

from clrt.errors import RequestError
from clrt.renderer.pack.structs import PASSES

Region: TypeAlias = tuple[int, int, int, int]
Array: TypeAlias = NDArray[Any]
Passes: TypeAlias = dict[str, Array]
MAX_SIDE = 1 << 24  # pixels of a row or a column that float32 can number


def film_dtype(dtype: DTypeLike | None, out: Array | None = None) -> np.dtype[Any]:
    """The dtype of a picture: float32, the default, uint8 or uint16.

    Raises:
        RequestError: it is none of these, or not that of `out`.
    """
    try:
        wanted = np.dtype(np.float32 if dtype is None else dtype)
    except TypeError:
        wanted = np.dtype(object)
    if out is not None:
        if not isinstance(out, np.ndarray):
            raise RequestError(f"out: expected an array, got {type(out).__name__}")
        if dtype is not None and wanted != out.dtype:
            raise RequestError(f"dtype: expected that of out, {out.dtype}, got {dtype!r}")
        wanted = out.dtype
    if wanted not in (np.float32, np.uint8, np.uint16):
        got = wanted if dtype is None else repr(dtype)
        raise RequestError(f"dtype: expected float32, uint8 or uint16, got {got}")
    return wanted


def check_passes(passes: Sequence[str] | None) -> Sequence[str] | None:
    """Names of passes, each once; None stays so.

    Raises:
        RequestError: there is no such pass.
    """
    if passes is None:
        return None
    known = PASSES.names or ()
    wanted = [passes] if isinstance(passes, str) else list(passes)
    for name in wanted:
        if name not in known:
            raise RequestError(f"passes: expected some of {', '.join(known)}, got {name!r}")
    return list(dict.fromkeys(wanted))


def check_size(width: int, height: int) -> tuple[int, int]:
    """Whole numbers of pixels that float32 can count.

    Raises:
        RequestError: they are not.
    """
    try:
        size = operator.index(width), operator.index(height)
    except TypeError:
        size = 0, 0
    if not all(1 <= pixels <= MAX_SIDE for pixels in size):
        expected = f"1 to {MAX_SIDE} pixels each way"
        raise RequestError(f"size: expected {expected}, got {width}x{height}")
    return size


def check_region(region: Region | None, width: int, height: int) -> Region:
    """The region, or all of the picture.

    Raises:
        RequestError: it is empty or not inside the picture.
    """
    if region is None:
        return 0, 0, width, height
    try:
        left, top, right, bottom = map(operator.index, region)
        good = 0 <= left < right <= width and 0 <= top < bottom <= height
    except (TypeError, ValueError):
        good = False
    if not good:
        expected = f"X0 Y0 X1 Y1 with 0 <= X0 < X1 <= {width} and 0 <= Y0 < Y1 <= {height}"
        raise RequestError(f"region: expected {expected}, got {region}")
    return left, top, right, bottom
