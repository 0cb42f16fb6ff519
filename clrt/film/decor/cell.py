"""Cell: the edges of boxes, as lines over a picture that end where spheres hide them."""

from collections.abc import Sequence
from itertools import combinations

import numpy as np

from clrt.film.develop import Marks
from clrt.scene import lens
from clrt.scene.camera import Camera
from clrt.scene.film import Cell
from clrt.values import Array, Color

SIDE = 540
"""The picture's smaller side, in widths of a line."""

NEAR = 1e-5
"""How far before a perspective camera an edge begins, of the farthest corner's distance."""

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
) -> Marks:
    """Their edges in a region of a picture.

    Args:
        size: of the whole picture, columns and rows.
        region: (x0, y0, x1, y1) of it.
        ink: linear.
        depth: (y1 - y0, x1 - x0), the pass `depth`.
    """
    screen = _Screen(camera, size)
    covered = np.zeros(depth.shape, np.float32)
    for cell in cells:
        corners = screen.seen(corners_of(cell))
        for a, b in EDGES:
            if (ends := screen.in_front(corners[[a, b]])) is not None:
                _draw(covered, screen, ends, region, depth)
    pixel = np.flatnonzero(covered)
    share = covered.reshape(-1)[pixel, np.newaxis]
    return Marks(pixel, share * np.array((*ink, 1), np.float32))


class _Screen:
    """Where points are in a picture, in pixels right and down of the middle of the first one."""

    def __init__(self, camera: Camera, size: tuple[int, int]) -> None:
        self.flat = camera.orthographic
        self.line = min(size) / SIDE
        self._basis = np.array(camera.basis())
        self._position = np.array(camera.position)
        self._half = lens.half_screen(camera, *size).astype(np.float64)
        self._last = np.array(size) - 1.0

    def seen(self, points: Array) -> Array:
        """Of points (n, 3): how far right, up and ahead of the camera they are."""
        found: Array = (points - self._position) @ self._basis.T * (1, 1, -1)
        return found

    def in_front(self, ends: Array) -> Array | None:
        """The part of an edge that can be seen; None if there is none.

        ends: (2, 3), as seen.
        """
        near = NEAR * np.abs(ends).max()
        behind = ends[:, 2] <= near
        if self.flat or not behind.any():
            return ends
        if behind.all():
            return None
        back, front = ends[behind][0], ends[~behind][0]
        part = (front[2] - near) / (front[2] - back[2])
        return np.where(behind[:, np.newaxis], front + part * (back - front), ends)

    def pixels(self, seen: Array) -> Array:
        """(n, 2), of points as seen."""
        at = seen[:, :2] if self.flat else seen[:, :2] / seen[:, 2:]
        found: Array = (at / self._half * (1, -1) + 1) / 2 * self._last
        return found

    def depth(self, ahead: Array, part: Array, column: Array, row: Array) -> Array:
        """How far along the rays of pixels a line is, some part of its way on the screen from its
        start to its end.

        ahead: of its start and its end, (2,).
        """
        start, end = ahead if self.flat else 1 / ahead  # which is straight on the screen
        found: Array = start + part * (end - start)
        if not self.flat:
            x, y = (np.stack([column, row], 1) / np.maximum(self._last, 1) * 2 - 1).T
            found = np.sqrt(1 + (x * self._half[0]) ** 2 + (y * self._half[1]) ** 2) / found
        return found


def _draw(
    covered: Array,
    screen: _Screen,
    ends: Array,
    region: tuple[int, int, int, int],
    depth: Array,
) -> None:
    """Adds how much of each pixel is on an edge, by its distance from the pixel's middle.

    A pixel's value depends on the whole picture only, so that regions do not show.
    """
    start, end = screen.pixels(ends)
    reach = max(screen.line, 1) / 2 + 0.5
    column, row = _pixels_near(start, end, reach, region)
    way, x, y = end - start, column - start[0], row - start[1]
    length2 = max(way @ way, np.finfo(float).tiny)
    part = np.clip((x * way[0] + y * way[1]) / length2, 0, 1)
    away = np.hypot(x - part * way[0], y - part * way[1])
    # A line that is thinner than a pixel is pale.
    share = np.clip(reach - away, 0, 1) * min(screen.line, 1)
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
