"""What is drawn over a picture, in which ink, and that it costs nothing where there is none."""

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.film.decor import decorations
from clrt.values import BLACK, WHITE

CAMERA = clrt.Camera((0, 0, 9), (0, 0, 0), projection="orthographic", height=4)
CELL = clrt.Cell(((1, 0, 0), (0, 1, 0), (0, 0, 1)))
NOTHING = np.full((60, 80), np.inf)


def contrast(one: float, other: float) -> float:
    """WCAG 2, of two brightnesses."""
    low, high = sorted((one, other))
    return (high + 0.05) / (low + 0.05)


@pytest.mark.parametrize("ground", [BLACK, WHITE, (1, 0, 0), (0, 1, 0), (0.17,) * 3, (0.19,) * 3])
def test_ink_is_what_can_be_read(ground: tuple[float, float, float]) -> None:
    found = decorations.ink(ground)
    bright = float(np.dot((0.2126, 0.7152, 0.0722), ground))
    assert found == (WHITE if contrast(bright, 1) > contrast(bright, 0) else BLACK)
    assert contrast(found[0], bright) > 4.5


def test_ink_on_what_is_not_known() -> None:
    gray = decorations.ink(None)
    assert contrast(gray[0], 0) == pytest.approx(contrast(gray[0], 1))
    assert contrast(gray[0], 0) > 4.5


def test_what_is_drawn() -> None:
    def drawn(alpha: bool = False, **options) -> list[np.ndarray]:
        scene = clrt.Scene(CAMERA, film=clrt.Film(**options))
        found = decorations.marks(scene, (80, 60), (0, 0, 80, 60), alpha, NOTHING)
        return [marks.color for marks in found]

    assert drawn() == []
    bar: dict[str, Any] = {"colorbar": " ", "colorbar_clim": (0, 1)}
    edges, panel = drawn(cells=[CELL], **bar)  # the bar over the edges
    assert (edges[:, :3] == edges[:, 3:]).all()  # white on black
    assert len(np.unique(panel[:, :3], axis=0)) > 20
    (edges,) = drawn(cells=[CELL], background=WHITE)
    assert not edges[:, :3].any()
    assert edges[:, 3].any()
    (edges,) = drawn(cells=[CELL], background=WHITE, alpha=True)
    assert edges[:, 0] == pytest.approx(decorations.BETWEEN * edges[:, 3])


def test_a_scene_without_them_needs_no_font() -> None:
    code = (
        "import sys, clrt\n"
        "from clrt.film.decor import decorations\n"
        "scene = clrt.load_scene('four-spheres')\n"
        "assert decorations.marks(scene, (8, 5), (0, 0, 8, 5), False, None) == []\n"
        "late = 'clrt.film.decor.panel', 'clrt.scene.lens'\n"
        "print([m for m in sys.modules if 'PIL' in m or m in late])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert (done.stdout, done.stderr) == ("[]\n", "")
