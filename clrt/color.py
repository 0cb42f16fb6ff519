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


def linear(srgb: ArrayLike) -> NDArray[np.float32]:
    """Linear colours of sRGB ones (IEC 61966-2-1), of any shape.

    Args:
        srgb: uint8, or floats from 0 to 1.
    """
    given = np.asarray(srgb)
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
    from PIL import ImageColor

    try:
        srgb = np.array(ImageColor.getrgb(text)[:3]) / 255
    except ValueError:
        raise RequestError(f"expected a colour's name, #rgb or #rrggbb, got {text!r}") from None
    red, green, blue = map(float, to_linear(srgb))
    return red, green, blue
