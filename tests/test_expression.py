"""Expressions: each says what Python says of every particle by itself, and nothing else is run."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from clrt.errors import RequestError
from clrt.particles.expression import columns_of, evaluate
from clrt.particles.texts import Text, distinct

N = 50
RANDOM = np.random.default_rng(4)
ROWS: dict[str, np.ndarray] = {
    "x": RANDOM.normal(size=N),
    "y": RANDOM.normal(size=N).astype(np.float32).astype(float),
    "type": RANDOM.integers(1, 4, N).astype(np.int32),
    "small": RANDOM.integers(0, 250, N).astype(np.uint8),
    "water": RANDOM.integers(0, 2, N).astype(bool),
    "chain": np.array(["A", "B", "é"])[RANDOM.integers(0, 3, N)],
    "altloc": np.array(["", "A"])[RANDOM.integers(0, 2, N)],
}
COLUMNS: dict[str, Any] = {
    name: distinct(column) if column.dtype.kind == "U" else column for name, column in ROWS.items()
}
ALLOWED = {"abs": abs, "sqrt": math.sqrt, "log10": math.log10, "min": min, "max": max}


@pytest.mark.parametrize(
    "text",
    [
        "x > 0",
        "0 < x <= 1",
        "x > 0 and not y > 0 or type == 2",
        "not (x < y or water)",
        "water and type != 1",
        "type in (1, 3) and type not in [3]",
        "type in {2}",
        "type in ()",
        "abs(x) ** 2 + y * 3 - x / 2 > -0.5",
        "sqrt(abs(x)) < max(y, x, 0.1) and min(x, 1) == x",
        "type % 2 == 1 and type // 2 == 0",
        "-type < -1 and +type < 3",
        "small - 100 > 0 and -small < -5",
        "water + water == 2",
        'chain == "A"',
        'chain != "A" and "B" != chain',
        'chain in ("A", "é") and chain not in ("B",)',
        'chain < "B" and chain >= "A" > ""',
        "chain == altloc",
        'altloc == ""',
        '"A" == "A" and 1 < 2',
        "True and x > 0",
        "log10(abs(x)) < 0",
        "x > 99999999999999999999",
        "x\n > 0",
    ],
)
def test_as_python_says_of_each(text: str) -> None:
    found = np.broadcast_to(evaluate(text, COLUMNS), N)  # type: ignore[arg-type]
    for row in range(N):
        one = {name: column[row].item() for name, column in ROWS.items()}
        expected = eval(" ".join(text.split()), {"__builtins__": ALLOWED}, one)
        assert found[row] == expected, (row, one)


NUMBERS = st.sampled_from(["x", "y", "type", "small", "0", "1.5", "-2"])
SUMS = st.recursive(
    NUMBERS,
    lambda inner: st.builds("({} {} {})".format, inner, st.sampled_from(["+", "-", "*"]), inner),
    max_leaves=4,
)
CONDITIONS = st.recursive(
    st.one_of(
        st.builds("{} {} {}".format, SUMS, st.sampled_from(["<", ">=", "==", "!="]), SUMS),
        st.sampled_from(["water", 'chain == "A"', 'altloc in ("A", "B")', "type in (1, 2)"]),
    ),
    lambda inner: st.one_of(
        st.builds("({} {} {})".format, inner, st.sampled_from(["and", "or"]), inner),
        st.builds("not ({})".format, inner),
    ),
    max_leaves=6,
)


@settings(deadline=None)
@given(CONDITIONS)
def test_any_as_python_says(text: str) -> None:
    test_as_python_says_of_each(text)


def test_over_all_particles() -> None:
    assert evaluate("min(x)", COLUMNS) == ROWS["x"].min()
    assert evaluate("max(x)", {"x": np.array([1, np.nan])}) == 1
    assert (evaluate("x - min(x) < 0.5", COLUMNS) == (ROWS["x"] - ROWS["x"].min() < 0.5)).all()
    assert math.isnan(evaluate("min(x)", {"x": np.zeros(0)}))  # type: ignore[arg-type]


def test_nothing_is_warned_of() -> None:
    zero = {"x": np.zeros(2)}
    assert np.isnan(evaluate("sqrt(x - 1) / 0", zero)).all()  # type: ignore[arg-type]
    assert np.all(evaluate("10 ** 400 > x", zero))  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("c_stress[1]", "c_stress[1] > 0"),
        ("X (nm)", 'column("X (nm)") > 0'),
        ("class", 'column("class") > 0'),
    ],
)
def test_names_that_are_none_of_pythons(name: str, text: str) -> None:
    columns = {name: ROWS["x"]}
    assert np.array_equal(np.asarray(evaluate(text, columns)), ROWS["x"] > 0)
    assert evaluate(name, columns) is ROWS["x"]
    assert columns_of(name, columns) == [name]


def test_which_columns_are_named() -> None:
    assert columns_of('x > 0 and chain == "A" and x < 5', COLUMNS) == ["x", "chain"]


def test_text_is_text() -> None:
    found = evaluate("chain", COLUMNS)
    assert isinstance(found, Text)
    assert (found.array() == ROWS["chain"]).all()


THERE = "; the columns are 'x', 'y', 'type', 'small', 'water', 'chain', 'altloc'"
LANGUAGE = "expected comparisons, and, or, not, in, arithmetic, abs, sqrt, log10, min, max"


@pytest.mark.parametrize(
    ("text", "said", "place"),
    [
        ("chian == 'A'", "no column is called 'chian'", "1: >>>chian<<< == 'A'"),
        ("x > 0 and chain == A", "no column is called 'A'", "20: x > 0 and chain == >>>A<<<"),
        ("é == 1", "no column is called 'é'", "1: >>>é<<< == 1"),
        ("'é' == chain and q", "no column is called 'q'", "18: 'é' == chain and >>>q<<<"),
        ("x > 0 && y > 0", "expected 'and'", "7: x > 0 >>>&&<<< y > 0"),
        ("x > 0 | y > 0", "expected 'or' between or before conditions", "5: x > >>>0 | y<<< > 0"),
        ("chain = 'A'", "expected '=='", "7: chain >>>=<<< 'A'"),
        ("(x > 0", "'(' was never closed", "1: >>>(<<<x > 0"),
        ("x > 0 and", "invalid syntax", "10: x > 0 and>>><<<"),
        ("type == '1'", "expected a number", "9: type == >>>'1'<<<"),
        ("chain == 1", "expected text, as 'A', 'B', 'é'", "10: chain == >>>1<<<"),
        ("x and y", "expected a condition, as x > 0", "1: >>>x<<< and y"),
        ("chain + 1 > 0", "expected numbers, got text", "1: >>>chain<<< + 1 > 0"),
        ("chain in 'A'", "expected values in brackets, as (1, 2)", "10: chain in >>>'A'<<<"),
        ("x in (y, 1)", "expected a number or text in quotes", "7: x in (>>>y<<<, 1)"),
        ("x == (1, 2)", "expected one value", "6: x == >>>(1, 2)<<<"),
        ("abs(x, y)", "abs takes one argument", "1: >>>abs(x, y)<<<"),
        ("min()", "min takes at least one argument", "1: >>>min()<<<"),
        ("x > 1j", "expected a number or text in quotes", "5: x > >>>1j<<<"),
        ("__import__('os')", "expected one of the functions abs,", "1: >>>__import__<<<('os')"),
        ("eval('x')", "expected one of the functions abs,", "1: >>>eval<<<('x')"),
        ("x.tofile('a')", "expected one of the functions abs,", "1: >>>x.tofile<<<('a')"),
        ("(lambda: x)()", "expected one of the functions abs,", "2: (>>>lambda: x<<<)()"),
        ("sqrt(*x)", "sqrt takes one argument", "1: >>>sqrt(*x)<<<"),
        ("abs(x=1)", "expected one of the functions abs,", "1: >>>abs<<<(x=1)"),
        ("x.dtype", LANGUAGE, "1: >>>x.dtype<<<"),
        ("x[0]", "no column is called 'x[0]'", "1: >>>x[0]<<<"),
        ("[i for i in x]", LANGUAGE, "1: >>>[i for i in x]<<<"),
        ("f'{x}' == chain", LANGUAGE, "1: >>>f'{x}'<<< == chain"),
        ("x if y else y", LANGUAGE, "1: >>>x if y else y<<<"),
        ("(x := 1) > 0", LANGUAGE, "2: (>>>x := 1<<<) > 0"),
        ("x is 1", LANGUAGE, "1: >>>x is 1<<<"),
        ("x @ y", LANGUAGE, "1: >>>x @ y<<<"),
        ("'A'", LANGUAGE, "1: >>>'A'<<<"),
        ("(1, 2)", LANGUAGE, "1: >>>(1, 2)<<<"),
        ("column('xq')", "no column is called 'xq'", "8: column(>>>'xq'<<<)"),
        ("column(x)", "expected a column's name in quotes", "8: column(>>>x<<<)"),
        ("1" + 400 * "0" + " > x", "expected a number below 1.8e308", "1: >>>1000"),
    ],
)  # fmt: skip
def test_a_wrong_one_marks_the_place(text: str, said: str, place: str) -> None:
    with pytest.raises(RequestError) as error:
        evaluate(text, COLUMNS)
    found = str(error.value)
    assert found.startswith(said)
    assert f", at character {place}" in found
    assert THERE in found
    assert "\n" not in found


def test_near_names_are_proposed() -> None:
    for text, end in (("chian > 0", "; did you mean 'chain'?"), ("qq > 0", "; text stands in quo")):
        with pytest.raises(RequestError) as error:
            evaluate(text, COLUMNS)
        assert end in str(error.value)


@pytest.mark.parametrize(
    "text",
    ["", "  ", "-" * 9000 + "x", "(" * 300 + "x" + ")" * 300, "x\0", "1" * 5000, "x" * 10_001,
     "not " * 2000 + "water", "x" + "+x" * 4000],
    ids=len,
)  # fmt: skip
def test_what_is_no_expression_is_one_line(text: str) -> None:
    with pytest.raises(RequestError) as error:
        evaluate(text, {**COLUMNS})
    assert len(str(error.value)) < 500
    assert "\n" not in str(error.value)
