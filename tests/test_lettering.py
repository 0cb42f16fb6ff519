"""Text of legends: what the font cannot write is written otherwise, and said."""

import string
import warnings

import pytest
from PIL import ImageFont

from clrt.errors import SceneWarning
from clrt.film.decor import lettering


def test_ascii_is_all_there() -> None:
    text = string.ascii_letters + string.digits + string.punctuation + " "
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert lettering.legible(text) == text
        assert lettering.legible("") == ""


@pytest.mark.parametrize(
    ("text", "expected"),
    [("speed (Å/ps)", "speed (A/ps)"), ("µm²", "um2"), ("−5 × é", "-5 x e"), ("水 q", "? q")],  # noqa: RUF001
)
def test_others_are_said(text: str, expected: str) -> None:
    with pytest.warns(SceneWarning, match="the font of legends cannot write"):
        assert lettering.legible(text) == expected


def test_no_library_of_the_systems_lays_it_out() -> None:
    assert lettering.font(20.0).layout_engine == ImageFont.Layout.BASIC
