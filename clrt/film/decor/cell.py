"""Cell: the edges of boxes, as lines over a picture that end where spheres hide them."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from clrt.film.decor.screen import Screen
from clrt.film.develop import Marks
from clrt.scene.camera import Camera
from clrt.scene.film import Cell
from clrt.values import Array, Color

WIDTH = 1 / 540
"""Of a line, of the picture's smaller side."""

# A corner's number has a bit for each edge that leads to it.
CORNERS = np.array([(i & 1, i >> 1 & 1, i >> 2) for i in range(8)])
EDGES = [(a, b) for a, b in combinations(range(8), 2) if (a ^ b).bit_count() == 1]


def corners_of(cell: Cell) -> Array:
    """(8, 3), in world space."""
    found: Array = np.array(cell.origin) + CORNERS @ np.array(cell.edges)
    return found


def marks(
    cells: Sequence[Cell],
    camera: Camera,
    size: tuple[int, int],
    region: tuple[int, int, int, int],
    ink: Color,
    depth: Array,
    width: float = WIDTH,
) -> Marks:
    """Their edges in a region of a picture.

    Args:
        size: of the whole picture, columns and rows.
        region: (x0, y0, x1, y1) of it.
        ink: linear.
        depth: (y1 - y0, x1 - x0), the pass `depth`.
        width: of a line, of the picture's smaller side.
    """
    screen, line = Screen(camera, size), width * min(size)
    covered = np.zeros(depth.shape, np.float32)
    for cell in cells:
        corners = screen.seen(corners_of(cell))
        for a, b in EDGES:
            if (ends := screen.in_front(corners[[a, b]])) is not None:
                _draw(covered, screen, ends, line, region, depth)
    pixel = np.flatnonzero(covered)
    share = covered.reshape(-1)[pixel, np.newaxis]
    return Marks(pixel, share * np.array((*ink, 1), np.float32))


def _draw(
    covered: Array,
    screen: Screen,
    ends: Array,
    line: float,
    region: tuple[int, int, int, int],
    depth: Array,
) -> None:
    """Adds how much of each pixel is on an edge, by its distance from the pixel's middle.

    A pixel's value depends on the whole picture only, so that regions do not show.
    """
    start, end = screen.pixels(ends)
    reach = max(line, 1) / 2 + 0.5
    column, row = _pixels_near(start, end, reach, region)
    way, x, y = end - start, column - start[0], row - start[1]
    length2 = max(way @ way, np.finfo(float).tiny)
    part = np.clip((x * way[0] + y * way[1]) / length2, 0, 1)
    away = np.hypot(x - part * way[0], y - part * way[1])
    # A line that is thinner than a pixel is pale.
    share = np.clip(reach - away, 0, 1) * min(line, 1)
    there = row - region[1], column - region[0]
    share[screen.depth(ends[:, 2], part, column, row) > depth[there]] = 0
    covered[there] = np.maximum(covered[there], share.astype(np.float32))


def _pixels_near(
    start: Array, end: Array, reach: float, region: tuple[int, int, int, int]
) -> tuple[Array, Array]:
    """Columns and rows of a region that can be as near to a line, some more, and none twice."""
    axis = int(abs(end - start).argmax())  # along which it is longer
    other = 1 - axis
    low, high = sorted((start[axis], end[axis]))
    first = max(np.floor(low - reach), region[axis])
    last = min(np.ceil(high + reach), region[axis + 2] - 1)
    along = np.arange(first, last + 1)
    rise = (end - start)[other] / (end - start)[axis] if high > low else 0.0
    spread = int(1.5 * reach) + 2  # across a line of 45 degrees it is wider
    across = start[other] + rise * (along - start[axis])
    across = np.rint(np.clip(across, region[other] - 2 * spread, region[other + 2] + 2 * spread))
    wide = across[:, np.newaxis] + np.arange(-spread, spread + 1)
    inside = (wide >= region[other]) & (wide < region[other + 2])
    found = np.broadcast_to(along[:, np.newaxis], wide.shape)[inside], wide[inside]
    column, row = (one.astype(np.int64) for one in (found[axis], found[other]))
    return column, row
