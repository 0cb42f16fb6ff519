"""Drawing: words and shapes over a picture, before they are pixels or lines of a file.

Places are in pixels of the whole picture, right and down of its upper left corner.
"""

from typing import NamedTuple, TypeAlias

from clrt.scene.film import Film
from clrt.values import Color

LEAST = 7.0
"""Of an em, pixels: less cannot be read."""


class Words(NamedTuple):
    """A text in ink."""

    text: str
    x: float
    """Where it starts, or what its anchor says."""
    y: float
    """The middle of its digits."""
    em: float
    anchor: str = "l"
    """"l": x is where it starts; "m": its middle; "r": its end."""
    upward: bool = False
    """It runs upward: x is the middle of its digits, and y its own middle."""


class Rule(NamedTuple):
    """A rectangle of ink, its sides at whole pixels."""

    left: int
    top: int
    right: int
    bottom: int


class Stroke(NamedTuple):
    """A line in ink with round ends."""

    x0: float
    y0: float
    x1: float
    y1: float
    width: float


class Box(NamedTuple):
    """A rectangle of colours, its sides at whole pixels, with a frame of ink around it."""

    left: int
    top: int
    right: int
    bottom: int
    colors: tuple[Color, ...]
    """Linear: one for all, or one for each of its rows, or of its columns if it is `across`."""
    thin: int
    """Of the frame, pixels."""
    across: bool = False


class Wedge(NamedTuple):
    """A triangle of a colour, two of its sides in ink: those that meet in its tip."""

    base0: tuple[float, float]
    tip: tuple[float, float]
    base1: tuple[float, float]
    color: Color
    """Linear."""
    thin: int


Shape: TypeAlias = Words | Rule | Stroke | Box | Wedge
Area: TypeAlias = tuple[int, int, int, int]
"""Columns x0 <= x < x1 and rows y0 <= y < y1: (x0, y0, x1, y1)."""


class Drawing(NamedTuple):
    """Shapes that are drawn together."""

    shapes: tuple[Shape, ...]
    em: float
    """Pixels; the rim around ink is a part of it."""
    room: Area | None = None
    """Nothing else is there; None: they lie over what is there."""


class Overlay(NamedTuple):
    """What is drawn over a picture, and how."""

    drawings: list[Drawing]
    """One over the other."""
    ink: Color
    """Linear."""
    ground: Color | None
    """The background, linear, of which ink has a rim; None: it is not known."""


def em_of(film: Film, size: tuple[int, int]) -> float:
    """How many pixels an em has in a picture of this size."""
    return max(min(size) * film.font_size, LEAST)


def thin(em: float) -> int:
    """How wide fine lines are, pixels."""
    return max(round(em / 15), 1)
