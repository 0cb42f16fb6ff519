"""What is drawn over a picture, in which ink, and that it costs nothing where there is none."""

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import clrt
from clrt.film import develop
from clrt.film.decor import canvas, decorations, lettering
from clrt.values import BLACK, WHITE

CAMERA = clrt.Camera((0, 0, 9), (0, 0, 0), projection="orthographic", height=4)
CELL = clrt.Cell(((1, 0, 0), (0, 1, 0), (0, 0, 1)))
SIZE = 80, 60
NOTHING = develop.Seen(np.full((60, 80), -1), np.full((60, 80), np.inf), np.zeros(0), np.s_[:, :])


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


def shapes(camera: clrt.Camera = CAMERA, size: tuple[int, int] = (960, 540), **film: Any) -> Any:
    scene = clrt.Scene(camera, film=clrt.Film(**film))
    nothing = NOTHING._replace(depth=np.full(size[::-1], np.inf))
    return [one.shapes for one in decorations.drawings(scene, size, nothing)]


WORDS: dict[str, Any] = {
    "title": "Φ = 0.25 ± 0.01",
    "label": "{{t}} = 3 ps",
    "scalebar": 1.0,
    "scalebar_label": "1 nm",
    "axes": "xyz",
    "labels": [clrt.Label("Na⁺", (0.5, 0.2, 0), 0.1)],
    "colorbar": "v (Å/ps)",
    "colorbar_clim": (0, 1),
    "colorbar_ends": (True, True),
}


def test_words() -> None:
    ((name,), _, title, label, scalebar, axes) = shapes(**WORDS)
    assert [words.text for words in (name, title[0], label[0])] == ["Na⁺", WORDS["title"],
                                                                         "{t} = 3 ps"]  # fmt: skip
    # The camera's screen is 4 high, with rays through its ends: at x = 0.5 of 7.1 from the middle.
    assert name.x == pytest.approx(0.5 + (0.5 / (4 * 16 / 9) + 0.5) * 959)
    assert name.y == pytest.approx(0.5 + (0.5 - 0.2 / 4) * 539)
    line, *_, words = scalebar
    assert line.right - line.left == pytest.approx(959 / (4 * 16 / 9), abs=0.5)
    assert words.text == "1 nm"
    ways = {one.text: one for one in axes if hasattr(one, "text")}
    x0, y0 = next((one.x0, one.y0) for one in axes if hasattr(one, "x0"))
    assert ways["x"].x > x0 + 20
    assert ways["y"].y < y0 - 20
    assert abs(ways["z"].x - x0) < 20  # it comes towards the camera


def test_a_scale_bar_by_itself_is_round() -> None:
    for height, expected in ((4, "1 nm"), (3, "1 nm"), (2.7, "0.5 nm"), (4000, "1000 nm")):
        camera = clrt.Camera((0, 0, 9), (0, 0, 0), projection="orthographic", height=height)
        (bar,) = shapes(camera, scalebar="auto", scalebar_label="nm")
        assert bar[-1].text == expected
        assert bar[0].right - bar[0].left <= 960 / 5
    with pytest.warns(clrt.SceneWarning, match="a length of 9 does not fit into the picture"):
        assert shapes(scalebar=9.0) == []
    with pytest.raises(clrt.SceneError, match=r"film.scalebar: expected none with a perspective"):
        shapes(clrt.Camera((0, 0, 9), (0, 0, 0), fov=40), scalebar=1.0)


def test_axes_of_a_box() -> None:
    (found,) = shapes(axes="abc", axes_edges=((5, 0, 0), (3, 3, 0), (0, 0, 2)))
    lines = [one for one in found if hasattr(one, "x0")]
    ways = sorted((round((s.x1 - s.x0) / (2.4 * 15), 2), round((s.y0 - s.y1) / (2.4 * 15), 2))
                  for s in lines)  # fmt: skip
    assert ways == [(0.71, 0.71), (1, 0)]  # c is a point
    with pytest.raises(clrt.SceneError, match=r"film.axes_edges: expected three rows"):
        shapes(axes="abc")


def test_labels_are_at_what_is_seen_and_apart() -> None:
    """Those that something is before are not there, nor those that have no room."""
    size = 200, 150
    depth = np.full((150, 200), np.inf)
    depth[:, :100] = 8.0  # the camera stands at z = 9

    def found(*labels: clrt.Label) -> list[str]:
        scene = clrt.Scene(CAMERA, film=clrt.Film(labels=labels))
        seen = NOTHING._replace(depth=depth)
        drawn: list[Any] = [*decorations.drawings(scene, size, seen)]
        boxes = [(w.x - lettering.width(w.text, w.em) / 2, w.y - w.em / 2,
                  w.x + lettering.width(w.text, w.em) / 2, w.y + w.em / 2)
                 for one in drawn for w in one.shapes]  # fmt: skip
        for i, a in enumerate(boxes):
            for b in boxes[:i]:
                assert a[2] < b[0] or b[2] < a[0] or a[3] < b[1] or b[3] < a[1]
        return [w.text for one in drawn for w in one.shapes]

    assert found(clrt.Label("a", (-1, 0, 0.5))) == []
    assert found(clrt.Label("a", (-1, 0, 1.5))) == ["a"]
    assert found(clrt.Label("a", (-1, 0, 0.5), 0.6)) == ["a"]  # its own front is what is seen
    assert found(clrt.Label("a", (1, 0, 0.5))) == ["a"]
    assert found(clrt.Label("a", (9, 0, 0.5))) == []  # beside the picture
    with pytest.warns(clrt.SceneWarning, match="labels: some of what is seen have none"):
        many = found(*(clrt.Label(f"n{k}", (1, 0, k / 100)) for k in range(20)))
    assert many[0] == "n19"  # the nearest
    assert len(many) == 5  # on it, and at its four sides


@pytest.mark.parametrize("factor", [2, 4])
def test_words_look_alike_at_every_size(factor: int) -> None:
    one, more = shapes(**WORDS), shapes(size=(960 * factor, 540 * factor), **WORDS)
    for a, b in zip(one, more, strict=True):
        assert [type(x) for x in a if not hasattr(x, "thin")][-2:] == \
               [type(x) for x in b if not hasattr(x, "thin")][-2:]  # fmt: skip
        for x, y in zip([w for w in a if hasattr(w, "em")], [w for w in b if hasattr(w, "em")],
                        strict=False):  # fmt: skip
            assert y.em == pytest.approx(factor * x.em, rel=0.06)
            assert (y.x, y.y) == pytest.approx((factor * x.x, factor * x.y), abs=3 * factor)


def test_regions_do_not_show() -> None:
    scene, size = clrt.Scene(CAMERA, film=clrt.Film(**WORDS)), (320, 180)
    seen = NOTHING._replace(depth=np.full((180, 320), np.inf))

    def picture(region: tuple[int, int, int, int]) -> np.ndarray:
        found = np.zeros((region[3] - region[1], region[2] - region[0], 4), np.float32)
        for marks in decorations.marks(scene, size, region, False, seen):
            found = develop.marked(found, 0, marks)
        return found

    whole = picture((0, 0, *size))
    assert (whole[..., 3] > 0).mean() > 0.02
    for region in [(0, 0, 9, 9), (3, 120, 200, 171), (150, 70, 320, 180), (170, 80, 190, 100)]:
        x0, y0, x1, y1 = region
        assert (picture(region) == whole[y0:y1, x0:x1]).all()
    canvas.marks.cache_clear()
