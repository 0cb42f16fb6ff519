"""Lettering: text as coverage of pixels, on every machine alike.

The font is a part of DejaVu Sans that comes with clrt (scripts/font). matplotlib, the extra
`text`, brings the whole of it, and sets what lies between dollar signs.
"""

import functools
import unicodedata
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from clrt import storage
from clrt.errors import RequestError, SceneWarning
from clrt.scene.film import EXTRA, is_math
from clrt.values import Array

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

TABLE = "DejaVuSans.ttf"
"""Of the same name in clrt's tables and in matplotlib."""
INCH = 72
"""Points."""


class Lettered(NamedTuple):
    """A text as pixels. Its origin is where its first letter begins on the base line."""

    coverage: Array
    """(height, width) uint8."""
    left: int
    """Of the first column, from the origin."""
    top: int
    """Of the first row, from the origin, downward."""
    width: float
    """How far the next letter would be from the origin."""


@functools.lru_cache(32)
def font(size: float, whole: bool = False) -> "FreeTypeFont":
    """DejaVu Sans.

    Args:
        size: of an em, pixels.
        whole: matplotlib's, which must be there.
    """
    from PIL import ImageFont

    # The other layout needs a library of the system's, and is there or not.
    file = _whole() if whole else storage.folder("tables") / TABLE
    return ImageFont.truetype(str(file), size, layout_engine=ImageFont.Layout.BASIC)


@functools.cache
def digit(em: float) -> int:
    """How high digits are, pixels."""
    found: float = -font(em).getbbox("0", anchor="ls")[1]
    return round(found)


def width(text: str, em: float) -> float:
    """How long a text is, pixels."""
    if is_math(text):
        return lettered(text, em).width
    shown, whole = legible(text)
    return font(em, whole).getlength(shown)


@functools.lru_cache(512)
def lettered(text: str, em: float) -> Lettered:
    """A text as pixels.

    em: pixels.

    Raises:
        RequestError: what lies between dollar signs is no formula.
    """
    if is_math(text):
        return _formula(text, em)
    from PIL import Image, ImageDraw

    shown, whole = legible(text)
    letters = font(em, whole)
    left, top, right, bottom = map(round, letters.getbbox(shown, anchor="ls"))
    strip = Image.new("L", (max(right - left, 1), max(bottom - top, 1)))
    ImageDraw.Draw(strip).text((-left, -top), shown, fill=255, font=letters, anchor="ls")
    return Lettered(np.asarray(strip), left, top, letters.getlength(shown))


def _formula(text: str, em: float) -> Lettered:
    from matplotlib.font_manager import FontProperties
    from matplotlib.mathtext import MathTextParser

    letters = FontProperties(family="DejaVu Sans", size=em)
    try:
        found = MathTextParser("agg").parse(text, INCH, letters)
    except ValueError as error:
        said = str(error).strip().splitlines()[-1]
        raise RequestError(f"text: {text!r} has no formula between its $: {said}") from None
    coverage = np.asarray(found.image, np.uint8)
    return Lettered(coverage, 0, round(found.depth) - len(coverage), found.width)


@functools.cache
def legible(text: str) -> tuple[str, bool]:
    """The text, with others for characters that no font at hand has, and a SceneWarning; and
    whether it needs the whole of DejaVu Sans."""
    text = text.replace(r"\$", "$")
    lacking = _lacking(text, False)
    if not lacking:
        return text, False
    whole = _whole() is not None
    if whole:
        lacking = _lacking(text, True)
    if lacking:
        where = "DejaVu Sans" if whole else f"the font of figures ({EXTRA} brings more)"
        names = " ".join(dict.fromkeys(lacking))
        message = f"{names}: not in {where}, left out of {text!r}"
        warnings.warn(message, SceneWarning, stacklevel=2)
        text = "".join(_other(c, whole) if c in lacking else c for c in text)
    return text, whole


def _other(character: str, whole: bool) -> str:
    """As fi of one letter for both."""
    plain = unicodedata.normalize("NFKD", character)
    return "?" if _lacking(plain, whole) or not plain else plain


def _lacking(text: str, whole: bool) -> str:
    return "".join(c for c in text if not _is_there(c, whole))


@functools.cache
def _is_there(character: str, whole: bool) -> bool:
    letters = font(20.0, whole)
    none = letters.getmask("\uffff")
    found = letters.getmask(character)
    return character.isspace() or found.size != none.size or bytes(found) != bytes(none)


@functools.cache
def _whole() -> Path | None:
    """The file of the whole font; None: matplotlib is not there."""
    try:
        import matplotlib
    except ImportError:
        return None
    return Path(matplotlib.get_data_path()) / "fonts" / "ttf" / TABLE
