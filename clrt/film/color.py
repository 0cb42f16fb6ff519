"""Colours: from linear light to sRGB and back (IEC 61966-2-1), and their names."""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from clrt.errors import RequestError
from clrt.values import Color

Array = NDArray[Any]


def to_srgb(linear: Array) -> Array:
    """The sRGB value of each linear one from 0 to 1."""
    curved: Array = 1.055 * np.power(linear, 1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, curved)


def to_linear(srgb: Array) -> Array:
    """The linear value of each one of sRGB from 0 to 1."""
    curved: Array = np.power((srgb + 0.055) / 1.055, 2.4)
    return np.where(srgb <= 0.04045, srgb / 12.92, curved)


def to_srgb_and_back(linear: Array) -> Array:
    """The sRGB value of each linear one that to_linear() makes it of. The standard's two curves do
    not meet: between 0.0031308 and 0.0031308050 this is not to_srgb()."""
    return np.where(12.92 * linear <= 0.04045, 12.92 * linear, to_srgb(linear))


def linear(srgb: ArrayLike) -> NDArray[np.float32]:
    """Linear colours of sRGB ones (IEC 61966-2-1), of any shape.

    Args:
        srgb: uint8, or floats from 0 to 1.
    """
    given = np.asarray(srgb)
    if given.size and given.ndim and given.strides[0] == 0:  # one row, many times
        return np.broadcast_to(linear(given[0]), given.shape).copy()
    if given.dtype == np.uint8:
        found: NDArray[np.float32] = linear(np.arange(256) / 255)[given]
        return found
    with np.errstate(invalid="ignore"):
        return to_linear(given.astype(np.float64)).astype(np.float32)


def named(text: str) -> Color:
    """A colour as Pillow's ImageColor reads it, a name, #rgb or #rrggbb, in linear light.

    Raises:
        RequestError: it is none.
    """
    red, green, blue = map(float, to_linear(_srgb(text)))
    return red, green, blue


def srgb(key: str, one: str | ArrayLike) -> Array:
    """(3,) float64: a colour as named() takes it, or of three numbers, uint8 or from 0 to 1.

    Args:
        key: the argument's name, for the error.

    Raises:
        RequestError: it is none.
    """
    try:
        found = _srgb(one) if isinstance(one, str) else np.asarray(one)
        if found.dtype == np.uint8:
            found = found / 255
        good = found.shape == (3,) and bool(((found >= 0) & (found <= 1)).all())
    except (RequestError, TypeError, ValueError):
        good = False
    if not good:
        expected = "a colour's name, #rgb, #rrggbb or three numbers from 0 to 1"
        raise RequestError(f"{key}: expected {expected}, got {one!r}")
    return found.astype(np.float64)


def _srgb(text: str) -> Array:
    if text == "white":  # the background by default: to import Pillow takes 10 ms
        return np.ones(3)
    from PIL import ImageColor

    try:
        return np.array(ImageColor.getrgb(text)[:3]) / 255
    except ValueError:
        raise RequestError(f"expected a colour's name, #rgb or #rrggbb, got {text!r}") from None
