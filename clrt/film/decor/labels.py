"""Labels: texts at what is seen, the nearest first, and none over another."""

import warnings
from collections.abc import Iterator, Sequence

import numpy as np

from clrt.errors import SceneWarning
from clrt.film.decor.drawing import Drawing, Words, em_of
from clrt.film.decor.lettering import width
from clrt.film.decor.screen import Screen
from clrt.scene.camera import Camera
from clrt.scene.film import Film, Label
from clrt.values import Array

HIGH = 1.1
"""How much room a text has upward, in ems."""
GAP = 0.3
"""Between two texts side by side, in ems."""
BESIDE = (
    *((0, 0), (0.5, 0), (-0.5, 0), (0, -1), (0, 1), (1, 0), (-1, 0)),
    *((0.5, -1), (-0.5, -1), (0.5, 1), (-0.5, 1)),
)
"""How far a text may be from its place, in its widths and heights: the first that is free."""
HIDDEN = 1e-4
"""How much nearer than a label something is that hides it, of the label's distance: more than the
error of a depth of float32, and less than anything that can be seen."""


def drawings(look: Film, camera: Camera, size: tuple[int, int], depth: Array) -> list[Drawing]:
    """The labels of a film that have room.

    Args:
        size: of the picture, columns and rows.
        depth: (rows, columns), the pass `depth` of all of it.
    """
    em, shapes, left_out = em_of(look, size), list[Words](), 0
    taken = np.zeros((size[1], size[0]), bool)
    for label, x, y in _seen(look.labels, camera, size, depth):
        half = (width(label.text, em) + GAP * em) / 2
        for middle, row in _places(x, y, half, em):
            x0, x1 = round(middle - half), round(middle + half)
            y0, y1 = round(row - HIGH * em / 2), round(row + HIGH * em / 2)
            if min(x0, y0) < 0 or x1 > size[0] or y1 > size[1] or taken[y0:y1, x0:x1].any():
                continue
            taken[y0:y1, x0:x1] = True
            shapes.append(Words(label.text, middle, row, em, "m"))
            break
        else:
            left_out += 1
    if left_out:
        said = (
            "labels: some of what is seen have none, for want of room; --zoom or a larger picture"
        )
        warnings.warn(f"{said} shows more", SceneWarning, stacklevel=2)
    return [Drawing((words,), em) for words in shapes]


def _places(x: float, y: float, half: float, em: float) -> Iterator[tuple[float, float]]:
    """Where a text can be whose place in the picture is that: on it, or beside it."""
    wide, high = 2 * half + 1, HIGH * em + 1
    for right, down in BESIDE:
        yield x + right * wide, y + down * high


def _seen(
    labels: Sequence[Label], camera: Camera, size: tuple[int, int], depth: Array
) -> Iterator[tuple[Label, float, float]]:
    """Those that nothing hides, the nearest first, and where they are in the picture, pixels right
    and down of its corner."""
    screen = Screen(camera, size)
    places = screen.seen(np.array([label.position for label in labels], float))
    order = np.argsort(places[:, 2], kind="stable")
    if not screen.flat:
        order = order[places[order, 2] > 0]
    places = places[order]
    ahead = places[:, 2] if screen.flat else np.linalg.norm(places, axis=1)
    with np.errstate(all="ignore"):
        column, row = screen.pixels(places).T
    radius = np.array([labels[k].radius for k in order])
    for k, x, y, far in zip(order, column, row, ahead - radius - HIDDEN * abs(ahead), strict=True):
        i, j = round(min(max(y, -1), size[1])), round(min(max(x, -1), size[0]))
        if 0 <= i < size[1] and 0 <= j < size[0] and depth[i, j] >= far:
            yield labels[k], float(x) + 0.5, float(y) + 0.5
