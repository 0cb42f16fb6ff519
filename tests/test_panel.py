"""Colour bars and legends: their colours are the spheres', their ticks where they belong."""

from typing import Any

import numpy as np
import pytest

import clrt
from clrt.film import color, develop
from clrt.film.decor import canvas, panel
from clrt.film.decor.ticks import ticks
from clrt.particles import palette

BLACK, WHITE = (0.0, 0.0, 0.0), (1.0, 1.0, 1.0)
Array = np.ndarray[Any, Any]


def painted(look: clrt.Film, size: tuple[int, int], **options: Any) -> Array:
    """(height, width, 4) of a picture with nothing else."""
    region = options.pop("region", (0, 0, *size))
    given = {"ink": BLACK, "ground": WHITE} | options
    found = canvas.marks(panel.drawing(look, size), region, **given)
    picture = np.zeros((region[3] - region[1], region[2] - region[0], 4), np.float32)
    assert (np.diff(found.pixel) > 0).all()
    return develop.marked(picture, 0, found)


def bar(low: float = 0, high: float = 1, label: str = " ", **options: Any) -> clrt.Film:
    return clrt.Film(colorbar=label, colorbar_clim=(low, high), **options)


def place(look: clrt.Film, size: tuple[int, int]) -> tuple[int, int, int]:
    """Of a bar: the column right of its middle, its first row and the one after its last."""
    length = round(0.6 * size[1])
    top = (size[1] - length) // 2
    shown = painted(look, size, ground=None)[top : top + length, :, 3]
    columns = np.flatnonzero((shown == 1).all(axis=0))  # and those of its frame
    em = max(min(size) / 36, 7)
    assert len(columns) == pytest.approx(em + 2 * max(round(em / 15), 1), abs=1)
    return int(np.median(columns) + 0.5), top, top + length


@pytest.mark.parametrize("name", [*palette.COLORMAPS, "viridis_r"])
def test_the_colors_are_the_maps(name: str) -> None:
    """In a picture of 427 rows the bar has 256, one for each colour."""
    look, size = bar(-3, 5, colorbar_cmap=name), (640, 427)
    column, top, end = place(look, size)
    shown = painted(look, size)[top:end, column]
    table = palette.colormap(name)
    assert (shown[::-1, :3] == color.linear(table)).all()
    assert (shown[:, 3] == 1).all()
    whole = develop.integers(shown[:, :3], np.dtype(np.uint8), "srgb")
    assert (whole[::-1] == table).all()


@pytest.mark.parametrize("height", [90, 360, 1080, 1217])
@pytest.mark.parametrize("limits", [(-1.7e308, 1.7e308), (5, 5), (0.1, 0.7), (0, 1e-300)])
def test_a_row_has_the_color_of_its_value(height: int, limits: tuple[float, float]) -> None:
    low, high = limits
    look, size = bar(low, high), (2 * height, height)
    column, top, end = place(look, size)
    part = (np.arange(end - top)[::-1] + 0.5) / (end - top)
    values = low + (high - low) * part if high - low < np.inf else (2 * part - 1) * high
    expected = color.linear(palette.of_values(values, clim=limits))
    shown = painted(look, size)[top:end, column]
    # A value that is on the border of two colours can have either.
    assert abs(shown[:, :3] - expected).max() < 0.03
    assert ((shown[:, :3] == expected).all(axis=1)).mean() > 0.98
    assert (shown[:, 3] == 1).all()


@pytest.mark.parametrize("size", [(640, 360), (1920, 1080), (3840, 2160), (400, 700)])
@pytest.mark.parametrize("limits", [(0, 1), (0.13, 0.71), (-7, 11), (3, 3)])
def test_ticks_are_where_they_belong(size: tuple[int, int], limits: tuple[float, float]) -> None:
    """To half a pixel, as many as the height has room for."""
    em = min(size) / 36
    look = bar(*limits)
    column, top, end = place(look, size)
    scale = ticks(float(limits[0]), float(limits[1]), int((end - top) / (2.5 * em)))
    beside = column + round(0.65 * em) + 1
    drawn = painted(look, size, ground=None)[:, beside, 3] == 1
    starts = np.flatnonzero(np.diff(drawn.astype(int)) == 1) + 1
    ends = np.flatnonzero(np.diff(drawn.astype(int)) == -1) + 1
    expected = sorted(top + (1 - part) * (end - top) for part in scale.parts)
    assert (starts + ends) / 2 == pytest.approx(expected, abs=0.51)
    assert set(ends - starts) == {max(round(em / 15), 1)}


def test_it_looks_alike_at_every_size() -> None:
    look = bar(0, 15.2, "speed (m/s)")
    small, large = painted(look, (1920, 1080)), painted(look, (3840, 2160))
    halved = large.reshape(1080, 2, 1920, 2, 4).mean(axis=(1, 3))
    # The bar has every other colour of the larger one, and letters are fitted to pixels.
    assert abs(halved - small)[..., 3].sum() < 0.1 * small[..., 3].sum()
    assert panel.room(look, (3840, 2160))[0] == pytest.approx(
        2 * panel.room(look, (1920, 1080))[0], abs=2
    )


@pytest.mark.parametrize("options", [{}, {"legend": (clrt.LegendEntry("Na", (0.5, 0, 1)),)}])
def test_regions_do_not_show(options: dict[str, Any]) -> None:
    look = bar(0, 15.2, "speed", **options)
    whole = painted(look, (640, 360))
    for x0, y0, x1, y1 in [
        (0, 0, 10, 10),
        (500, 30, 640, 200),
        (600, 170, 611, 171),
        (9, 9, 610, 350),
    ]:
        part = painted(look, (640, 360), region=(x0, y0, x1, y1))
        assert (part == whole[y0:y1, x0:x1]).all()


def test_ink_and_ground() -> None:
    """Around what is drawn in ink the ground covers the picture; without one nothing does."""
    look, size = bar(0, 1, "speed"), (1920, 1080)
    with_rim = painted(look, size, ink=(0.25, 0.25, 0.25), ground=(0, 0, 1))
    none = painted(look, size, ink=(0.25, 0.25, 0.25), ground=None)
    left = 1920 - panel.room(look, size)[0]
    numbers = np.s_[:, left + round(2.5 * 30) :]
    text = none[numbers]
    assert (text[..., :3] == 0.25 * text[..., 3:]).all()
    assert text[..., 3].max() == 1
    rim = with_rim[numbers]
    assert ((rim[..., 3] > 0) >= (text[..., 3] > 0)).all()
    only = (rim[..., 3] == 1) & (text[..., 3] == 0)
    assert only.sum() > 1000
    assert (rim[only] == (0, 0, 1, 1)).all()
    bar_alone = np.s_[300:600, left + 35 : left + 55]
    assert (with_rim[bar_alone] == none[bar_alone]).all()


def test_a_long_label_is_made_to_fit() -> None:
    size = 640, 360
    label = "speed of what has fallen, of what is falling and of what will have fallen by then, m/s"
    found = painted(bar(0, 1, label), size, ground=None)[..., 3]
    shown = np.flatnonzero(found[:, -20:].any(axis=1))
    assert 10 <= shown[0] < 40
    assert 320 <= shown[-1] < 350
    assert panel.room(bar(0, 1, label), size) == panel.room(bar(0, 1, "x"), size)


def test_a_note_has_room() -> None:
    """No ink is cut off at the left."""
    look = bar(299792458, 299792458.0000002)
    found = painted(look, (640, 360))
    left = 640 - panel.room(look, (640, 360))[0]
    assert not found[:, : left + 5, 3].any()
    assert found[: 360 // 5, left:, 3].any()


def test_a_legend() -> None:
    entries = tuple(clrt.LegendEntry(name, c) for name, c in (("H", WHITE), ("Na", (0.5, 0, 1))))
    size = 1920, 1080
    look = clrt.Film(colorbar="element", legend=entries)
    found = painted(look, size)
    column = 1920 - panel.room(look, size)[0] + 45  # the middle of the boxes
    middle = 540 + np.array([0, 1]) * panel.LINE * 30  # of three lines, the first is the title
    for y, entry in zip(middle, entries, strict=True):
        inside = found[round(y) - 10 : round(y) + 10, column - 10 : column + 10]
        assert (inside == np.array((*entry.color, 1), np.float32)).all()
        # Frame to frame it is an em, and the frame goes outwards.
        lit = found[round(y) - 25 : round(y) + 25, column, :3].sum(axis=1) > 0
        white = (found[round(y) - 25 : round(y) + 25, column] == 1).all(axis=1)
        assert lit.any() or white.any()
    untitled = clrt.Film(colorbar=" ", legend=entries)
    assert panel.room(untitled, size) < panel.room(look, size)


def test_a_legend_that_is_too_long_says_so() -> None:
    entries = tuple(clrt.LegendEntry(f"kind {k}", (0.5, 0, 1)) for k in range(50))
    for height, wanted in ((180, 12), (360, 19), (1080, 19)):
        look = clrt.Film(colorbar="kinds", legend=entries)
        size = 2 * height, height
        found = painted(look, size)
        em = max(height / 36, 7)
        column = size[0] - panel.room(look, size)[0] + round(1.5 * em)
        boxes = (found[:, column, :3] == np.array((0.5, 0, 1), np.float32)).all(axis=1)
        assert (np.diff(boxes.astype(int)) == 1).sum() == wanted
        rows = np.flatnonzero(found[..., 3].any(axis=1))
        assert rows[0] > 0
        assert rows[-1] < height - 1
    exact = painted(clrt.Film(colorbar="kinds", legend=entries[:20]), (720, 360))
    em, column = (
        10,
        720 - panel.room(clrt.Film(colorbar="kinds", legend=entries[:20]), (720, 360))[0],
    )
    boxes = (exact[:, column + 15, :3] == np.array((0.5, 0, 1), np.float32)).all(axis=1)
    assert (np.diff(boxes.astype(int)) == 1).sum() == 20


@pytest.mark.parametrize("size", [(1, 1), (1, 400), (400, 1), (5, 3), (30, 30)])
def test_a_picture_that_is_too_small_shows_a_part(size: tuple[int, int]) -> None:
    for look in (
        bar(0, 1, "speed"),
        clrt.Film(colorbar="e", legend=(clrt.LegendEntry("H", WHITE),)),
    ):
        found = painted(look, size)
        assert found.shape == (size[1], size[0], 4)
        assert (found[..., 3] <= 1).all()
