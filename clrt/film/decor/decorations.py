"""Decorations: the boxes, the colour bar or legend and the words that a scene's film asks for."""

from typing import TYPE_CHECKING

from clrt.film.develop import Marks, Seen
from clrt.scene.scene import Scene
from clrt.values import BLACK, WHITE, Color

if TYPE_CHECKING:
    from clrt.film.decor.drawing import Drawing

BRIGHTNESS = (0.2126, 0.7152, 0.0722)
"""Of linear red, green and blue, to the eye (IEC 61966-2-1)."""

BETWEEN = (1.05 * 0.05) ** 0.5 - 0.05
"""As far from black as from white, both of which have a contrast of 4.6 with it (WCAG 2)."""


def drawings(scene: Scene, size: tuple[int, int], seen: Seen | None) -> "list[Drawing]":
    """The words, and the colour bar or legend, in the order in which they lie over each other.

    Args:
        size: of the picture, columns and rows.
        seen: in all of it; None: without labels.

    Raises:
        RequestError: a text has a formula that is none.
    """
    look = scene.film
    found: list[Drawing] = []
    if look.labels and seen is not None:
        from clrt.film.decor import labels

        found += labels.drawings(look, scene.camera, size, seen.depth)
    if look.colorbar:
        from clrt.film.decor import panel

        found.append(panel.drawing(look, size))
    if look.title or look.label or look.scalebar is not None or look.axes:
        from clrt.film.decor import words

        found += words.drawings(look, scene.camera, size)
    return found


def marks(
    scene: Scene,
    size: tuple[int, int],
    region: tuple[int, int, int, int],
    alpha: bool,
    seen: Seen | None,
) -> list[Marks]:
    """The marks over a region of a picture, one after the other.

    Args:
        size: of the whole picture, columns and rows.
        region: (x0, y0, x1, y1) of it.
        alpha: whether the picture has no background.
        seen: in the region, or if the film has labels in the whole picture; needed if the film has
            cells or labels.

    Raises:
        RequestError: as drawings().
    """
    look, found = scene.film, list[Marks]()
    ground = None if alpha else look.background
    if look.cells and seen is not None:
        from clrt.film.decor import cell

        there = seen.depth[seen.picture]
        where = look.cells, scene.camera, size, region
        found.append(cell.marks(*where, ink(ground), there, look.line_width))
    if drawn := drawings(scene, size, seen):
        from clrt.film.decor import canvas

        found += [canvas.marks(one, region, ink(ground), ground) for one in drawn]
    return found


def ink(ground: Color | None) -> Color:
    """The colour of text and lines, linear: black or white, whichever is farther from the ground.
    Where the ground is not known it is a gray that can be read on both."""
    if ground is None:
        return (BETWEEN, BETWEEN, BETWEEN)
    bright = sum(part * one for part, one in zip(BRIGHTNESS, ground, strict=True))
    return BLACK if bright > BETWEEN else WHITE
