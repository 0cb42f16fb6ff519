"""Error figures against values worked out by hand."""

import numpy as np
import pytest

from clrt.errors import RequestError
from clrt.film import metrics


def test_figures() -> None:
    a = np.zeros((10, 10, 3))
    b = a.copy()
    b[0, 0, 1] = 0.5  # one channel of one pixel
    b[0, 1] = 1 / 500
    found = metrics.difference(a, b)
    square = (0.25 + 3 / 500**2) / 300
    assert found.pixels == 100
    assert found.max == 0.5
    assert found.rmse == pytest.approx(np.sqrt(square))
    assert found.psnr == pytest.approx(-10 * np.log10(square))
    assert found.p50 == 0
    assert found.over_255 == 1
    assert found.over_1020 == found.flips == 2
    assert found.interior_flips == 0  # a lone pixel is its own edge
    assert found.max_off_flips == 0


def test_flips_are_told_by_paths_where_they_are_known() -> None:
    a = np.zeros((6, 6, 3))
    b = a.copy()
    b[0, 0] = 0.5
    b[5, 5] = 0.25
    ours, truth = np.zeros((6, 6), np.uint32), np.zeros((6, 6), np.uint32)
    truth[5, 5] = 7
    found = metrics.difference(a, b, ours, truth)
    assert (found.flips, found.interior_flips) == (1, 0)
    assert found.max_off_flips == 0.5
    ours[0, 0] = 3
    found = metrics.difference(a, b, ours, truth)
    assert (found.flips, found.interior_flips) == (2, 1)
    assert found.max_off_flips == 0


def test_without_paths_a_flip_at_a_step_of_colour_is_at_an_edge() -> None:
    b = np.zeros((8, 8, 3))
    b[:, 4:] = 0.8
    a = b.copy()
    a[2, 4] = 0
    found = metrics.difference(a, b)
    assert (found.flips, found.interior_flips) == (1, 0)


def test_equal_clipped_and_nan() -> None:
    bright = np.full((2, 2, 3), 7.0)
    assert metrics.difference(bright, np.ones((2, 2, 3))).psnr == float("inf")
    bright[0, 0, 0] = np.nan
    found = metrics.difference(bright, np.ones((2, 2, 3)))
    assert found.max == 1
    assert found.over_255 == 1


def test_sizes_must_agree() -> None:
    with pytest.raises(RequestError, match="differ in size: 2x3 and 3x2"):
        metrics.difference(np.zeros((3, 2, 3)), np.zeros((2, 3, 3)))


def test_alpha_is_a_channel() -> None:
    a, b = np.zeros((2, 2, 4)), np.zeros((2, 2, 4))
    a[0, 0, 3] = 0.5
    assert metrics.pixel_error(a, b).tolist() == [[0.5, 0], [0, 0]]
    assert metrics.difference(a, b).max == 0.5
    with pytest.raises(RequestError, match="one of the pictures has alpha, the other has not"):
        metrics.pixel_error(a, b[..., :3])
    b[:, 1, 3] = 1  # an edge that only alpha shows
    a = b.copy()
    a[0, 1, 0] = 0.5
    found = metrics.difference(a, b)
    assert (found.flips, found.interior_flips) == (1, 0)


def test_edges() -> None:
    paths = np.zeros((5, 6), np.uint32)
    paths[1, 4] = 9
    expected = np.zeros((5, 6), bool)
    expected[0:3, 3:6] = True
    assert (metrics.edges(paths) == expected).all()
    assert not metrics.edges(np.zeros((1, 1), np.uint32)).any()


def test_heatmap_grows_with_the_error() -> None:
    error = np.array([[0.0, 1e-7, 1e-5, 1e-3, 1e-2, 1.0]])
    brightness = metrics.heatmap(error).sum(axis=2)[0]
    assert brightness[0] == brightness[1] == 0
    assert (np.diff(brightness[1:]) >= 0).all()
    assert brightness[-1] > 2
