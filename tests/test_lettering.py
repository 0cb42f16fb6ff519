"""Text: every letter that labels of figures have, and what is said of those that are lacking."""

import string
import sys
import warnings
from typing import Any

import numpy as np
import pytest
from PIL import ImageFont

from clrt.errors import RequestError, SceneError, SceneWarning
from clrt.film.decor import lettering
from clrt.scene.film import Film, is_math

WANTED = (
    string.ascii_letters + string.digits + string.punctuation + " ",
    "".join(map(chr, [*range(0xA0, 0x100)])),
    "ΑΒΓΔΕΖΗΘΙΚΛΜΝΞΟΠΡΣΤΥΦΧΨΩαβγδεζηθικλμνξοπρςστυφχψω",
    "Åµ°±×√∞−–—·≤≥≈∂∇∫∑∏→ₓₐħℓ′″‰",  # noqa: RUF001
    "АБВГДЕЖЗИЙКЛМНОПРСТУФХЦЧШЩЪЫЬЭЮЯабвгдежзийклмнопрстуфхцчшщъыьэюяёіїєў",
    "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻₀₁₂₃₄₅₆₇₈₉₊₋",
)


@pytest.fixture
def plain(monkeypatch: pytest.MonkeyPatch):
    """Without matplotlib."""
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    lettering._whole.cache_clear()
    yield
    lettering._whole.cache_clear()


@pytest.mark.parametrize("text", WANTED)
def test_what_figures_have_is_all_there(text: str, plain: None) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert lettering.legible(text) == (text, False)
    letters = {c: bytes(lettering.font(40.0).getmask(c)) for c in text if c not in " \xa0\xad"}
    assert all(letters.values())  # none is empty


def test_others_are_said_with_what_brings_them(plain: None) -> None:
    with pytest.warns(
        SceneWarning, match=r"水 ቀ ﬁ: not in .*clrt\[text\].*left out of '水 ቀ q ﬁ'"
    ) as said:
        assert lettering.legible("水 ቀ q ﬁ")[0] == "? ? q fi"
    assert len(said) == 1


def test_the_whole_font_has_more() -> None:
    pytest.importorskip("matplotlib")
    assert lettering.legible("⁂ ☂ Ѣ") == ("⁂ ☂ Ѣ", True)
    with pytest.warns(SceneWarning, match="水: not in DejaVu Sans, left out of 'a 水'"):
        assert lettering.legible("a 水") == ("a ?", True)
    same = [lettering.font(50.0, whole).getlength("speed (Å/ps)") for whole in (False, True)]
    assert same[0] == pytest.approx(same[1], rel=0.02)  # hints fit letters to pixels


def test_no_library_of_the_systems_lays_it_out() -> None:
    assert lettering.font(20.0).layout_engine == ImageFont.Layout.BASIC


@pytest.mark.parametrize(
    ("text", "expected"),
    [("$x$", True), ("v ($m^2$)", True), ("5 $", False), (r"\$5 $x", False), ("$a$b$", False)],
)
def test_formulas_are_between_pairs_of_signs(text: str, expected: bool) -> None:
    assert is_math(text) == expected


def test_a_formula() -> None:
    """Its letters stand on the line that others stand on, and it is larger the larger an em is."""
    pytest.importorskip("matplotlib")
    one, two = (lettering.lettered("$x$", em) for em in (20.0, 40.0))
    assert two.width == pytest.approx(2 * one.width, rel=0.1)
    for em, found in ((20.0, one), (40.0, two)):
        rows = np.flatnonzero(found.coverage.max(axis=1) > 127)
        assert found.top + rows[-1] == pytest.approx(-1, abs=1.5)
        assert len(rows) == pytest.approx(0.55 * em, rel=0.2)
    with pytest.raises(RequestError, match=r"'\$\\\\frac\$' has no formula"):
        lettering.lettered(r"$\frac$", 20.0)
    assert lettering.legible(r"5 \$")[0] == "5 $"


def test_formulas_need_matplotlib(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("clrt.scene.film.find_spec", lambda name: None)
    for key in ("title", "label", "colorbar", "scalebar_label"):
        given: dict[str, Any] = {key: "$x$"}
        with pytest.raises(
            SceneError, match=rf"{key}: .* needs matplotlib: pip install 'clrt\[text"
        ):
            Film(**given)
    Film(title="5 $")
