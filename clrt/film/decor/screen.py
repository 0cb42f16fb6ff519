"""Screen: where points of the world are in a picture."""

import numpy as np

from clrt.scene import lens
from clrt.scene.camera import Camera
from clrt.values import Array

NEAR = 1e-5
"""How far before a perspective camera an edge begins, of the farthest corner's distance."""


class Screen:
    """Where points are in a picture, in pixels right and down of the middle of the first one."""

    def __init__(self, camera: Camera, size: tuple[int, int]) -> None:
        self.flat = camera.orthographic
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
