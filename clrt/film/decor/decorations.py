"""Decorations: the boxes, and the colour bar or legend, that a scene's film asks for."""

from clrt.film.develop import Marks
from clrt.scene.scene import Scene
from clrt.values import BLACK, WHITE, Array, Color

BRIGHTNESS = (0.2126, 0.7152, 0.0722)
"""Of linear red, green and blue, to the eye (IEC 61966-2-1)."""

BETWEEN = (1.05 * 0.05) ** 0.5 - 0.05
"""As far from black as from white, both of which have a contrast of 4.6 with it (WCAG 2)."""


def marks(
    scene: Scene,
    size: tuple[int, int],
    region: tuple[int, int, int, int],
    alpha: bool,
    depth: Array | None,
) -> list[Marks]:
    """The marks over a region of a picture, one after the other.

    Args:
        size: of the whole picture, columns and rows.
        region: (x0, y0, x1, y1) of it.
        alpha: whether the picture has no background.
        depth: (y1 - y0, x1 - x0), as of the pass; needed if the film has cells.
    """
    look, found = scene.film, []
    ground = None if alpha else look.background
    if look.cells and depth is not None:
        from clrt.film.decor import cell

        found.append(cell.marks(look.cells, scene.camera, size, region, ink(ground), depth))
    if look.colorbar:
        from clrt.film.decor import panel

        found.append(panel.marks(look, size, region, ink(ground), ground))
    return found


def ink(ground: Color | None) -> Color:
    """The colour of text and lines, linear: black or white, whichever is farther from the ground.
    Where the ground is not known it is a gray that can be read on both."""
    if ground is None:
        return (BETWEEN, BETWEEN, BETWEEN)
    bright = sum(part * one for part, one in zip(BRIGHTNESS, ground, strict=True))
    return BLACK if bright > BETWEEN else WHITE
