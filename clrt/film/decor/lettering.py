"""Lettering: text as Pillow draws it with the font that it brings, on every machine alike."""

import functools
import unicodedata
import warnings
from typing import TYPE_CHECKING

from clrt.errors import SceneWarning

if TYPE_CHECKING:
    from PIL.ImageFont import FreeTypeFont

INSTEAD = {"µ": "u", "μ": "u", "×": "x", "−": "-", "–": "-", "—": "-"}  # noqa: RUF001
"""Of characters that the font lacks and that units and names have."""


@functools.lru_cache(4)
def font(size: float) -> "FreeTypeFont":
    """Pillow's own, Aileron.

    size: of an em, pixels.
    """
    from PIL import ImageFont

    found = ImageFont.load_default(size)
    assert isinstance(found, ImageFont.FreeTypeFont)  # Pillow's wheels have FreeType
    # The other layout needs a library of the system's, and is there or not.
    return found.font_variant(layout_engine=ImageFont.Layout.BASIC)


def legible(text: str) -> str:
    """The text, with others for characters that the font lacks, and a SceneWarning."""
    found = "".join(c if _is_there(c) else _other(c) for c in text)
    if found != text:
        message = f"the font of legends cannot write {text!r}: it is {found!r}"
        warnings.warn(message, SceneWarning, stacklevel=2)
    return found


def _other(character: str) -> str:
    """As A of a ring over it."""
    plain = INSTEAD.get(character, unicodedata.normalize("NFKD", character)[0])
    return plain if _is_there(plain) else "?"


@functools.cache
def _is_there(character: str) -> bool:
    letters = font(20.0)
    none = letters.getmask("\uffff")
    found = letters.getmask(character)
    return character == " " or found.size != none.size or bytes(found) != bytes(none)
