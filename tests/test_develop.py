"""The steps on the film, each against what it is to be, and their order."""

from typing import Any

import numpy as np
import pytest

from clrt.film import color, develop
from clrt.scene.film import Cell, Film

Array = np.ndarray[Any, Any]
RANDOM = np.random.default_rng(5)
NOTHING = np.inf


def premultiplied(shape: tuple[int, int] = (7, 9)) -> Array:
    alpha = RANDOM.choice([0, 0.25, 1], (*shape, 1))
    return np.concatenate([alpha * RANDOM.random((*shape, 3)), alpha], 2).astype(np.float32)


def developed(
    exposed: Array,
    kind: Any,
    channels: int,
    seen: develop.Seen | None = None,
    marks: Any = (),
    **options: Any,
) -> Array:
    out = np.zeros((*exposed.shape[:2], channels), kind)
    develop.develop(exposed, Film(**options), out, seen, marks)
    return out


def test_depth_cue() -> None:
    picture = premultiplied((1, 5))
    depth = np.array([[-1, 2, 3, 5, NOTHING]], np.float32)
    share = np.array([1, 1, 0.75, 0.25, 0])[:, np.newaxis]
    assert develop.depth_cued(picture, depth, (2, 6)) == pytest.approx(share * picture)


def test_background_is_seen_through_what_is_not_there() -> None:
    picture = np.array([[[0.1, 0.2, 0.3, 1], [0.1, 0.2, 0.3, 0.5], [0, 0, 0, 0]]])
    found = develop.on_background(picture, (1, 0.5, 0))
    assert found == pytest.approx(np.array([[[0.1, 0.2, 0.3], [0.6, 0.45, 0.3], [1, 0.5, 0]]]))
    assert (develop.on_background(picture, (0, 0, 0)) == picture[..., :3]).all()


def test_drawn_over() -> None:
    picture = np.array([[[0.4, 0.4, 0.4, 1], [0, 0, 0, 0], [0.4, 0.4, 0.4, 1]]])
    found = develop.drawn_over(picture, np.array([[1, 0.5, 0]]), (1, 0, 0))
    expected = [[[1, 0, 0, 1], [0.5, 0, 0, 0.5], [0.4, 0.4, 0.4, 1]]]
    assert found == pytest.approx(np.array(expected))


def marks(pixels: dict[int, Any]) -> develop.Marks:
    pixel, colors = zip(*sorted(pixels.items()), strict=True)
    return develop.Marks(np.array(pixel), np.array(colors, np.float32))


def test_marks_cover_what_is_behind() -> None:
    picture = np.full((2, 3, 4), (0.5, 0, 0, 1), np.float32)
    over = marks({3: (0, 1, 0, 1), 7: (0, 0, 0.25, 0.25), 8: (0, 0, 0, 0), 9: (9, 9, 9, 1)})
    found = develop.marked(picture, 3, over)
    expected = picture.copy()
    expected[0, 0], expected[1, 1] = (0, 1, 0, 1), (0.375, 0, 0.25, 1)
    assert (found == expected).all()
    assert (picture == (0.5, 0, 0, 1)).all()
    assert develop.marked(picture, 10, over) is picture
    # On nothing they bring their own alpha.
    assert (develop.marked(0 * picture, 3, over)[1, 1] == (0, 0, 0.25, 0.25)).all()


@pytest.mark.parametrize("kind", [np.uint8, np.uint16])
def test_integers_are_rounded_and_clipped(kind: Any) -> None:
    most = np.iinfo(kind).max
    exact = np.array([-1, np.nan, 0, 0.5 / most, 0.7 / most, 1.5 / most, 1, 2, np.inf])
    picture = np.repeat(exact, 3).reshape(1, -1, 3)
    found = develop.integers(picture, np.dtype(kind), "linear")
    assert found.dtype == kind
    assert found[0, :, 1].tolist() == [0, 0, 0, 0, 1, 2, most, most, most]  # ties to even


def test_every_integer_is_met() -> None:
    """float32 would round c * 65535 a second time."""
    near = np.nextafter(np.float32(0.5 + np.arange(65535)) / np.float32(65535), np.float32(1))
    found = develop.integers(np.repeat(near, 3).reshape(1, -1, 3), np.dtype(np.uint16), "linear")
    assert (found[0, :, 0] == np.rint(near.astype(np.longdouble) * 65535)).all()


def test_bytes_of_the_curve_are_those_of_the_formula() -> None:
    """Which a table has for most: near every value where one byte ends, at every step of the table,
    and at what is no colour."""
    ends = color.to_linear((np.arange(255) + 0.5) / 255).astype(np.float32)
    near = (ends.view(np.uint32)[:, np.newaxis] + np.arange(-500, 501)).astype(np.uint32)
    steps = np.arange(0, np.float32(1.1).view(np.uint32), 2047, dtype=np.uint32)
    odd = np.array([np.nan, np.inf, -np.inf, -1, -0.0, 1, 1e-40, np.nextafter(1, 2), 3e38])
    odd = odd.astype(np.float32).view(np.uint32)
    given = np.concatenate([near.ravel(), steps, odd]).view(np.float32)
    given = given[: len(given) // 3 * 3].reshape(1, -1, 3)
    exact = np.clip(np.nan_to_num(given.astype(np.float64), nan=0), 0, 1)
    expected = np.rint(255 * color.to_srgb(exact))
    assert np.array_equal(develop.integers(given, np.dtype(np.uint8), "srgb"), expected)


def test_integers_with_alpha_are_straight() -> None:
    picture = np.array([[[0.25, 0.125, 0, 0.5], [0, 0, 0, 0], [3, 0, 0, 0.5]]], np.float32)
    found = develop.integers(picture, np.dtype(np.uint8), "linear")
    assert found.tolist() == [[[128, 64, 0, 128], [0, 0, 0, 0], [255, 0, 0, 128]]]
    found = develop.integers(picture, np.dtype(np.uint8), "srgb")
    assert found.tolist() == [[[188, 137, 0, 128], [0, 0, 0, 0], [255, 0, 0, 128]]]


def squares() -> dict[str, Any]:
    """A square before another one before nothing."""
    sphere = np.full((12, 30), -1, np.int32)
    depth = np.full((12, 30), NOTHING, np.float32)
    sphere[:, 6:24], depth[:, 6:24] = 0, 5
    sphere[:, 12:18], depth[:, 12:18] = 1, 4
    return {"sphere": sphere, "depth": depth, "radius": np.array([1.0, 1.0])}


@pytest.mark.parametrize(
    ("width", "columns"),
    [
        (0.25, []),
        (0.5, []),
        (1, [6, 12, 17, 23]),
        (2, [5, 6, 11, 12, 17, 18, 23, 24]),
        (3, [5, 6, 7, 11, 12, 13, 16, 17, 18, 22, 23, 24]),
    ],
)
def test_a_line_is_as_wide_as_it_is_to_be(width: float, columns: list[int]) -> None:
    """An odd one has its middle pixel on the nearer side."""
    share = develop.outline(**squares(), width=width)
    assert np.flatnonzero((share > 0.5)[5]).tolist() == columns
    assert (share == share[0]).all()
    assert share[0].sum() == pytest.approx(4 * width)


def test_a_line_may_be_turned() -> None:
    upright = squares()
    turned = {"radius": upright["radius"]}
    turned |= {name: np.ascontiguousarray(upright[name].T) for name in ("sphere", "depth")}
    assert (develop.outline(**upright, width=2.5) == develop.outline(**turned, width=2.5).T).all()
    back = {"radius": upright["radius"]}
    back |= {name: upright[name][::-1, ::-1] for name in ("sphere", "depth")}
    assert (
        develop.outline(**back, width=3)[::-1, ::-1] == develop.outline(**upright, width=3)
    ).all()


def test_a_small_step_is_no_edge() -> None:
    """Half the smaller radius is the least that counts."""
    for radius, lines in (((9.0, 2.1), 2), ((2.1, 9.0), 2), ((9.0, 1.9), 4)):
        found = squares() | {"radius": np.array(radius)}
        assert (develop.outline(**found, width=1)[0] > 0.5).sum() == lines
    alike = squares()
    alike["sphere"][:, 12:18] = 0
    assert (develop.outline(**alike, width=1)[0] > 0.5).sum() == 2


def test_a_slanting_line_is_smooth() -> None:
    """Along one of 45 degrees the share of a pixel depends on its distance from the line only."""
    down, right = np.indices((40, 40))
    sphere = np.where(down > right, 0, -1)
    depth = np.where(down > right, 1.0, NOTHING)
    share = develop.outline(sphere, depth, np.ones(1), 3.0)[8:-8, 8:-8]
    for k in range(-5, 6):
        assert np.ptp(np.diagonal(share, k)) < 1e-6
    assert share[12].sum() / np.sqrt(2) == pytest.approx(3, abs=0.1)


def test_nothing_has_no_line() -> None:
    empty = np.full((3, 4), -1), np.full((3, 4), NOTHING)
    assert not develop.outline(*empty, np.zeros(0), 5.0).any()
    assert not develop.outline(np.zeros((1, 1), int), np.ones((1, 1)), np.ones(1), 5.0).any()


@pytest.mark.parametrize("width", [0.3, 1, 1.5, 2, 3.4, 7, 10])
def test_the_halo_is_as_wide_as_a_line_needs(width: float) -> None:
    sphere = RANDOM.integers(-1, 3, (30, 40))
    depth = np.where(sphere < 0, NOTHING, RANDOM.random((30, 40)))
    radius = np.full(3, 0.5)
    margin = develop.halo(Film(outline=width))
    width = max(width, 1.0)  # see line_width()
    whole = develop.outline(sphere, depth, radius, width)
    around = slice(15 - margin, 16 + margin), slice(20 - margin, 21 + margin)
    part = develop.outline(sphere[around], depth[around], radius, width)
    assert part[margin, margin] == whole[15, 20]
    # No wider: a pixel of a line can stand that far away, and one of its edge one further.
    rim = np.full(sphere.shape, -1)
    rim[15, 20 + margin - 1] = 0
    assert develop.outline(rim, np.where(rim < 0, NOTHING, 1), radius, width)[15, 20] > 0


def test_no_halo_without_a_line() -> None:
    assert develop.halo(Film(depth_cue=(1, 2))) == develop.line_width(Film()) == 0
    assert develop.line_width(Film(outline=0.1)) == 1
    assert develop.line_width(Film(outline=1.5)) == 1.5
    assert not develop.needs_passes(Film(background=(1, 1, 1), transparent=True, transfer="srgb"))
    assert develop.needs_passes(Film(depth_cue=(1, 2)))
    assert develop.needs_passes(Film(outline=1))
    assert develop.needs_passes(Film(cells=(CELL,)))
    assert not develop.needs_passes(Film(colorbar="speed"))


CELL = Cell(((1, 0, 0), (0, 1, 0), (0, 0, 1)))


def test_what_is_drawn_over_is_a_step() -> None:
    floats, byte = np.dtype(np.float32), np.dtype(np.uint8)
    for look in (Film(colorbar=" "), Film(cells=(CELL,))):
        assert develop.has_marks(look)
        for alpha in (False, True):
            assert develop.has_steps(look, floats, alpha)
            assert develop.has_steps(look, byte, alpha)
    assert not develop.has_marks(Film(outline=1, transfer="srgb", colorbar_cmap="turbo"))


def test_floats_are_neither_clipped_nor_curved() -> None:
    exposed = 3 * premultiplied()
    assert (developed(exposed, np.float32, 4, transfer="srgb") == exposed).all()
    assert (developed(exposed, np.float32, 3, transfer="srgb") == exposed[..., :3]).all()


def test_alpha_has_no_background() -> None:
    exposed = premultiplied()
    assert (developed(exposed, np.float32, 4, background=(1, 1, 1)) == exposed).all()


@pytest.mark.parametrize("transfer", ["linear", "srgb"])
def test_blocks_do_not_show(monkeypatch: pytest.MonkeyPatch, transfer: str) -> None:
    exposed = premultiplied((40, 9))
    whole = developed(exposed, np.uint16, 4, transfer=transfer)
    over = [marks(dict(zip(range(60, 200, 3), premultiplied((47, 1))[:, 0], strict=True)))]
    marked = developed(exposed, np.uint16, 4, marks=over, transfer=transfer)
    assert (marked != whole).any()
    monkeypatch.setattr(develop, "BLOCK", 7)
    assert (developed(exposed, np.uint16, 4, transfer=transfer) == whole).all()
    assert (developed(exposed, np.uint16, 4, marks=over, transfer=transfer) == marked).all()


def test_the_order() -> None:
    """A line is not pale where it is far, and shines through nothing; what it hides is gone. What
    is drawn over the picture comes after it, in its order, and before the background."""
    looks = squares()
    seen = develop.Seen(**looks, picture=np.s_[:, :])
    there = (looks["sphere"] >= 0)[..., np.newaxis]
    exposed = np.where(there, [0.5, 0.5, 0.5, 1], 0).astype(np.float32)
    steps = {"depth_cue": (4, 6), "outline": 1, "outline_color": (1, 0, 0)}
    found = developed(exposed, np.uint8, 3, background=(0, 0, 1), seen=seen, **steps)
    row = found[5]
    assert row[[0, 29]].tolist() == [[0, 0, 255]] * 2
    assert row[[6, 12, 17, 23]].tolist() == [[255, 0, 0]] * 4
    assert row[[8, 20]].tolist() == [[64, 64, 191]] * 2  # half gone
    assert row[15].tolist() == [128, 128, 128]  # at the nearer end
    clear = developed(exposed, np.float32, 4, seen=seen, **steps)[5]
    assert clear[8].tolist() == [0.25, 0.25, 0.25, 0.5]
    assert clear[6].tolist() == [1, 0, 0, 1]
    # Over white, bytes that are straight are what is drawn on white.
    straight = developed(exposed, np.uint8, 4, seen=seen, **steps) / 255
    over = straight[..., :3] * straight[..., 3:] + 1 - straight[..., 3:]
    white = developed(exposed, np.uint8, 3, background=(1, 1, 1), seen=seen, **steps) / 255
    assert abs(over - white).max() <= 1 / 255
    drawing = [
        marks({156: (0, 1, 0, 1), 158: (0, 0.5, 0, 0.5), 179: (0, 0.5, 0, 0.5)}),
        marks({156: (0.5, 0, 0, 0.5), 157: (0, 0, 0, 1)}),
    ]
    drawn = developed(
        exposed, np.uint8, 3, background=(0, 0, 1), seen=seen, marks=drawing, **steps
    )[5]
    assert drawn[[6, 7]].tolist() == [[128, 128, 0], [0, 0, 0]]
    assert drawn[8].tolist() == [32, 159, 96]  # a quarter of the sphere, and of the background
    assert drawn[29].tolist() == [0, 128, 128]
    # The curve comes last.
    curved = developed(exposed, np.uint8, 3, transfer="srgb", seen=seen, **steps)[5, 8]
    assert curved.tolist() == [np.rint(255 * color.to_srgb(np.array(0.25)))] * 3


def test_an_edge_has_the_depth_of_what_it_shows() -> None:
    depth = np.full((3, 4), np.inf)
    depth[1, 0] = 2
    depth[0, 0] = 3
    found = develop.up_to_edges(depth)
    assert found.tolist() == [[3, 2, np.inf, np.inf], [2, 2, np.inf, np.inf], [2, 2, *[np.inf] * 2]]


def test_a_line_is_smooth_with_samples() -> None:
    """A thin one covers a pixel in part; with one sample it is there or not."""
    sphere = np.full((6, 8), -1)
    sphere[:, 4:] = 0
    depth = np.where(sphere == 0, 1.0, np.inf)
    exposed = np.zeros((6, 8, 4), np.float32)
    look = Film(outline=0.5, outline_color=(1, 1, 1))
    shares = []
    for samples in (1, 16):
        out = np.empty((6, 8, 4), np.float32)
        everywhere = (slice(None), slice(None))
        seen = develop.Seen(sphere, depth, np.ones(1), everywhere, samples)
        develop.develop(exposed, look, out, seen)
        shares.append(out[3, :, 3])
    assert set(shares[0]) == {0, 1}
    assert np.isclose(shares[1].sum(), 0.5)
