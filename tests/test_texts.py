"""Columns of text as numbers: the same texts again, in order, whatever their letters."""

import numpy as np
import pytest

from clrt.particles import texts
from clrt.particles.texts import Text, distinct

RANDOM = np.random.default_rng(1)
NAMES = {
    "few": ["C", "Ca", "H", "", "12345678"],
    "long": ["a", "Zz", "b" * 40, "b" * 39],
    "accents": ["é", "e", "É", "日本語", "z\U0001f600"],
    "many": [f"ATOM{i}" for i in range(3000)],
}


@pytest.mark.parametrize("kind", NAMES)
@pytest.mark.parametrize("encoded", [False, True])
def test_texts_are_told_apart(kind: str, encoded: bool) -> None:
    names = NAMES[kind]
    array = np.array(names)[RANDOM.permutation(np.arange(6000) % len(names))]
    found = distinct(np.char.encode(array, "utf-8") if encoded else array)
    assert list(found.kinds) == sorted(names)
    assert (found.array() == array).all()


def test_texts_of_one_hash(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two slots for three texts."""
    monkeypatch.setattr(texts, "SLOTS", 1)
    array = np.array(["A", "B", "C"])[RANDOM.integers(0, 3, 100)]
    assert distinct(array).kinds == ("A", "B", "C")
    assert (distinct(array).array() == array).all()


def test_no_texts_and_other_byte_orders() -> None:
    assert distinct(np.zeros(0, "U3")).kinds == ()
    assert distinct(np.zeros(0, "U3")).array().tolist() == []
    big = np.array(["b", "a", "b"]).astype(">U1")
    assert distinct(big).kinds == ("a", "b")
    assert distinct(np.array(["", ""])).kinds == ("",)


def test_names_that_are_there() -> None:
    found = Text.of(("Z", "B", "none", "B", "A"), np.array([0, 4, 1, 3, 0]))
    assert found.kinds == ("A", "B", "Z")
    assert found.array().tolist() == ["Z", "A", "B", "B", "Z"]
