"""Colours: the curve of sRGB against figures of the standard, names against Pillow's."""

import numpy as np
import pytest

from clrt.errors import RequestError
from clrt.film import color


def test_the_curve() -> None:
    """The figures are those that tables of sRGB give, to their last digit."""
    assert color.to_linear(np.array([0, 128, 255]) / 255) == pytest.approx([0, 0.2158605, 1])
    assert color.to_srgb(np.array([0, 0.18, 0.5, 1])) == pytest.approx([0, 0.4613561, 0.7353569, 1])
    assert color.to_srgb(np.array([0.001])) == pytest.approx([0.01292])


def test_there_and_back() -> None:
    values = np.linspace(0, 1, 10_001)
    assert abs(color.to_linear(color.to_srgb(values)) - values).max() < 1e-7  # where curves meet
    steps = np.arange(256) / 255
    assert (np.rint(255 * color.to_srgb(color.to_linear(steps))) == np.arange(256)).all()
    rows = np.broadcast_to(steps[1:4], (5, 3))  # one row, many times
    assert (color.linear(rows) == color.linear(rows.copy())).all()
    assert (np.diff(color.to_srgb(values)) > 0).all()


@pytest.mark.parametrize("text", ["white", "#fff", "#ffffff", "rgb(255, 255, 255)"])
def test_names(text: str) -> None:
    assert color.named(text) == (1.0, 1.0, 1.0)


def test_a_name_is_srgb() -> None:
    assert color.named("#800000") == pytest.approx((0.2158605, 0, 0))


@pytest.mark.parametrize("text", ["", "whiter", "#12", "0.5"])
def test_no_name(text: str) -> None:
    with pytest.raises(RequestError, match=r"expected a colour's name, #rgb or #rrggbb, got"):
        color.named(text)
