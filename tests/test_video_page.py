"""Videos in a browser: each pixel of a figure has the colour that the picture has."""

import html
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import clrt
from benchmarks import chromium
from benchmarks.chromium import Chromium
from clrt.files import video
from clrt.film import develop
from clrt.film.decor import canvas, panel

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(chromium.PROGRAM is None, reason="no chromium"),
]

FLAT = (200, 40, 40)
READY = "(e => e && (e.readyState >= 2 || e.complete))(document.getElementById('shown'))"
Array = np.ndarray[Any, Any]


@pytest.fixture(scope="module")
def browser(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Chromium]:
    with Chromium(tmp_path_factory.mktemp("profile")) as found:
        yield found


def figure(width: int, height: int) -> tuple[Array, Any]:
    """A ramp of grays over a flat colour, a colour bar beside both, and the bar's rectangle."""
    picture = np.empty((height, width, 3), np.uint8)
    picture[:] = FLAT
    picture[: height // 3] = np.linspace(0, 255, width).astype(np.uint8)[:, np.newaxis]
    look = clrt.Film(colorbar="v (Å)", colorbar_clim=(0, 1), colorbar_room=True)
    drawing = panel.drawing(look, (width, height))
    marks = canvas.marks(drawing, (0, 0, width, height), (0, 0, 0), (1, 1, 1))
    bar = develop.marked(np.ones((height, width, 4), np.float32), 0, marks)
    left = drawing.room[0] if drawing.room else width
    whole = develop.integers(develop.on_background(bar, (1, 1, 1)), np.dtype(np.uint8), "srgb")
    picture[:, left:] = whole[:, left:]
    return picture, drawing.shapes[0]


@pytest.mark.parametrize("size", [(640, 360), (1920, 1080)], ids=str)
@pytest.mark.parametrize("suffix", [".mp4", ".webp", ".apng", ".gif"])
def test_colours(browser: Chromium, tmp_path: Path, suffix: str, size: tuple[int, int]) -> None:
    """Each within 3 of 255; the bar, whose colours are for 2 x 2 pixels, on average. A GIF has 256
    colours for all."""
    width, height = size
    picture, bar = figure(width, height)
    file = tmp_path / f"a{suffix}"
    video.save(file, [picture] * 2, 30)
    kind = "video muted" if suffix in video.CONTAINERS else "img"
    page_file = tmp_path / "a.html"
    page_file.write_text(
        f'<body style="margin:0"><{kind} id=shown src="{html.escape(file.name)}"></{kind}>'
    )
    page = browser.open(page_file.as_uri())
    try:
        page.resize(width, height)
        page.wait(READY)
        inside = np.s_[bar.top + 6 : bar.bottom - 6, bar.left + 2 : bar.right - 2]
        for _ in range(20):  # until it is painted
            off = abs(page.screenshot().astype(int) - picture)
            if off[height // 2, 10].max() < 50:
                break
            time.sleep(0.1)
    finally:
        page.close()
    assert off[height // 2 : height - 9, 9 : width // 2].max() <= 3  # flat
    assert off[9 : height // 3 - 9, 9 : width // 2].max() <= 3  # the ramp
    assert off[inside].mean() <= 3
