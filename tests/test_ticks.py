"""Ticks: round numbers that are what they say, to the last digit."""

from decimal import Decimal, localcontext
from itertools import pairwise

import numpy as np
import pytest

from clrt.film.decor.ticks import powers, ticks


@pytest.mark.parametrize(
    ("low", "high", "texts", "note"),
    [
        (0, 1, "0.0 0.2 0.4 0.6 0.8 1.0", ""),
        (0, 0.3, "0.00 0.05 0.10 0.15 0.20 0.25 0.30", ""),  # as floats, 0.3 is a little less
        (-5, 5, "-4 -2 0 2 4", ""),
        (3.1, 14.9, "4 6 8 10 12 14", ""),
        (0, 12345, "0 2000 4000 6000 8000 10000 12000", ""),
        (0, 999999, "0 200000 400000 600000 800000", ""),
        (0, 1e6, "0.0 0.2 0.4 0.6 0.8 1.0", "×10⁶"),  # noqa: RUF001
        (0, 0.005, "0.000 0.001 0.002 0.003 0.004 0.005", ""),
        (-3e-12, 2e-11, "0.0 0.5 1.0 1.5 2.0", "×10⁻¹¹"),  # noqa: RUF001
        (1e6, 1e6 + 0.004, "0.000 0.001 0.002 0.003 0.004", "+ 1e6"),
        (-1e6 - 0.005, -1e6, "0.005 0.006 0.007 0.008 0.009 0.010", "- 1000000.01"),
        (299792458, 299792470, "58 60 62 64 66 68 70", "+ 299792400"),
        (1.0, 1 + 2**-52, "0.0 0.5 1.0 1.5 2.0", "×10⁻¹⁶ + 1"),  # noqa: RUF001
        (2011, 2023, "2012 2014 2016 2018 2020 2022", ""),
        (-1.7e308, 1.7e308, "-1.5 -1.0 -0.5 0.0 0.5 1.0 1.5", "×10³⁰⁸"),  # noqa: RUF001
        (0, 5e-324, "0 1 2 3 4 5", "×10⁻³²⁴"),  # noqa: RUF001
        (7, 7, "7", ""),
        (0.1 + 0.2, 0.1 + 0.2, "0.3", ""),
    ],
)
def test_texts(low: float, high: float, texts: str, note: str) -> None:
    found = ticks(float(low), float(high), 8)
    assert " ".join(found.texts) == texts
    assert found.note == note


RANDOM = np.random.default_rng(3)
RANGES = [
    (middle - half, middle + half)
    for middle, half in zip(
        (RANDOM.normal(size=300) * 10.0 ** RANDOM.integers(-12, 12, 300)).tolist(),
        (10.0 ** RANDOM.uniform(-12, 12, 300)).tolist(),
        strict=True,
    )
    if middle - half < middle + half
]


@pytest.mark.parametrize("most", [2, 3, 5, 8, 12, 40])
def test_any_range(most: int) -> None:
    for low, high in RANGES:
        found = ticks(low, high, most)
        with localcontext(prec=60):
            start, end = Decimal(repr(low)), Decimal(repr(high))
            offset = Decimal(found.offset or 0)
            said = [Decimal(text).scaleb(found.power) + offset for text in found.texts]
            # They are where they say they are,
            for number, part in zip(said, found.parts, strict=True):
                assert start <= number <= end
                assert part == pytest.approx(float((number - start) / (end - start)), abs=1e-15)
            # round, as many as go, and short.
            steps = {b - a for a, b in pairwise(said)}
            assert 1 <= len(said) <= most
            if most >= 5:
                assert len(said) > most / 2.5 - 2
                assert len(steps) == 1
            for step in steps:
                assert step.normalize().as_tuple().digits in ((1,), (2,), (5,))
                assert all(number % step == 0 for number in said)
        assert max(map(len, found.texts)) <= 11


@pytest.mark.parametrize(
    ("low", "high", "texts"),
    [
        (-2, 1, "10⁻² 10⁻¹ 10⁰ 10¹"),
        (-1.5, 12.5, "10⁰ 10² 10⁴ 10⁶ 10⁸ 10¹⁰ 10¹²"),
        (-0.5, 0.8, "0.5 1 2 5"),
        (0.1, 1.7, "2 5 10 20 50"),
        (0.1, 0.6, "1.5 2.0 2.5 3.0 3.5"),
        (2.0, 2.01, "100.0 100.5 101.0 101.5 102.0"),
        (1, 2, "10¹ 10²"),
    ],
)
@pytest.mark.parametrize("base", [10, np.e])
def test_of_a_logarithm(low: float, high: float, texts: str, base: float) -> None:
    """The numbers are where their logarithms are."""
    scale = np.log(10) / np.log(base)
    found = powers(low * scale, high * scale, 7, base)
    said = [text for text in found.texts if text]
    assert " ".join(said) == texts
    for part, text in zip(found.parts, found.texts, strict=True):
        if not text:
            continue
        plain = text.translate(str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789"))
        power = float(plain[2:]) if plain != text else np.log10(float(text))
        assert part == pytest.approx((power - low) / (high - low), abs=1e-9)
    minor = len(found.texts) - len(said)
    assert minor == {"10⁻² 10⁻¹ 10⁰ 10¹": 24, "10¹ 10²": 8}.get(texts, 0)
