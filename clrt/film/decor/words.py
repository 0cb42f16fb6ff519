"""Words: title, label, scale bar and axes, as drawings."""

import warnings
from math import ceil, floor, log10

import numpy as np

from clrt.errors import SceneWarning
from clrt.film.decor import panel
from clrt.film.decor.drawing import Drawing, Rule, Shape, Stroke, Words, em_of, thin
from clrt.film.decor.lettering import width
from clrt.scene.camera import Camera
from clrt.scene.film import Film
from clrt.values import Array

TITLE = 1.25
"""Of the title, an em, in ems."""
MARGIN = 1.0
"""In ems."""
TRIPOD = 2.4
"""Length of its longest axis, in ems."""
SHARE = 0.2
"""Of the picture's width, at most: a scale bar whose length is not given."""
TICK = 0.25
"""Half the height of a scale bar's ends, in ems."""
ROUND = (1, 2, 5, 10)


def title_rows(look: Film, size: tuple[int, int]) -> int:
    """How many rows at the top of a picture the title takes."""
    return ceil((TITLE + 2 * MARGIN) * em_of(look, size)) if look.title else 0


def drawings(look: Film, camera: Camera, size: tuple[int, int]) -> list[Drawing]:
    """The title, the label, the scale bar and the axes that a film asks for."""
    em = em_of(look, size)
    aside, below = panel.room(look, size) if look.colorbar else (0, 0)
    free = size[0] - aside, size[1] - below
    found: list[list[Shape]] = []
    if look.title:
        large = panel.fitting(look.title, TITLE * em, free[0] - 2 * MARGIN * em)
        y = (MARGIN + TITLE / 2) * em
        found.append([Words(look.title, free[0] / 2, y, large, "m")])
    if look.label:
        text = look.label.format()
        small = panel.fitting(text, em, free[0] - 2 * MARGIN * em)
        y = title_rows(look, size) + (0.5 + (not look.title) * MARGIN) * em
        found.append([Words(text, round(MARGIN * em), y, small)])
    if look.scalebar is not None and camera.height is not None:
        found.append(_scalebar(look, camera.height, size, free, em))
    if look.axes:
        found.append(_axes(look, camera, free[1], em))
    return [Drawing(tuple(shapes), em) for shapes in found if shapes]


def _scalebar(
    look: Film, height: float, size: tuple[int, int], free: tuple[int, int], em: float
) -> list[Shape]:
    """At the lower right, its text above it."""
    # The rays of the first and the last column are as far apart as the screen is wide.
    pixels = max(size[0] - 1, 1) / (height * size[0] / size[1])
    length, text = look.scalebar, look.scalebar_label
    if not isinstance(length, float):
        length = _round(SHARE * size[0] / pixels)
        text = f"{length:g} {text}".strip()
    columns = round(length * pixels)
    if not 1 <= columns <= free[0] - 2 * MARGIN * em:
        said = f"scalebar: a length of {length:g} does not fit into the picture"
        warnings.warn(said, SceneWarning, stacklevel=2)
        return []
    line = max(round(em / 8), 1)
    right, low = round(free[0] - MARGIN * em), round(free[1] - MARGIN * em)
    half = round(TICK * em)
    left, top = right - columns, low - half - line // 2
    ends = [
        Rule(x, top + line // 2 - half, x + line, top + line // 2 + half)
        for x in (left, right - line)
    ]
    middle = (left + right) / 2
    most = right - width(text, em) / 2
    words = [Words(text, min(middle, most), top - 0.9 * em, em, "m")] if text else []
    return [Rule(left, top, right, top + line), *ends, *words]


def _round(most: float) -> float:
    """The largest 1, 2 or 5 times a power of ten that is no more."""
    power = 10.0 ** floor(log10(most))
    found = max(k for k in ROUND if k * power <= most * (1 + 1e-12)) * power
    return float(f"{found:g}")


def _axes(look: Film, camera: Camera, bottom: int, em: float) -> list[Shape]:
    """At the lower left, as long as they look; those that come towards the camera over others."""
    ways, names = np.eye(3), "xyz"
    if look.axes == "abc" and look.axes_edges is not None:
        ways, names = _unit(np.array(look.axes_edges)), "abc"
    seen = ways @ np.array(camera.basis()).T  # right, up, back
    origin = np.array([(MARGIN + 0.9 + TRIPOD) * em, bottom - (MARGIN + 0.9 + TRIPOD) * em])
    low = np.minimum(seen[:, :2].min(axis=0), 0)
    origin[0] += TRIPOD * em * (-1 - low[0])
    origin[1] += TRIPOD * em * (1 + low[1])
    shapes: list[Shape] = []
    for k in np.argsort(seen[:, 2]):
        way = seen[k, :2] * (1, -1)
        length = float(np.hypot(*way))
        tip = origin + TRIPOD * em * way
        x0, y0, x1, y1 = map(float, (*origin, *tip))
        if length * TRIPOD * em >= 1:
            shapes.append(Stroke(x0, y0, x1, y1, 1.5 * thin(em)))
        name = tip + (way / length if length > 0.2 else np.array([0.7, 0.7])) * 0.7 * em
        shapes.append(Words(names[k], float(name[0]), float(name[1]), em, "m"))
    return shapes


def _unit(edges: Array) -> Array:
    length = np.linalg.norm(edges, axis=1, keepdims=True)
    found: Array = edges / np.where(length > 0, length, 1)
    return found
