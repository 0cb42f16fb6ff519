"""Expressions over columns, in Python's syntax: which particles there are, or what colours them.

Python parses the text, and what is walked through is its tree: what is not in the lists here is
refused, so that an expression can do nothing but compute. docs/design.md says why this is no
library.
"""

import ast
import operator
import warnings
from collections.abc import Callable, Mapping
from functools import reduce
from typing import Any, TypeAlias

import numpy as np

from clrt.errors import RequestError
from clrt.particles.texts import Text
from clrt.values import Array, did_you_mean, some

LONGEST = 10_000
"""Letters of an expression."""

Column: TypeAlias = Array | Text
Value: TypeAlias = Any
"""Array of numbers or conditions, one of them, Text, str, or a tuple of those that are but one."""

COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
ARITHMETIC: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
}
FUNCTIONS: dict[str, Callable[[Any], Any]] = {
    "abs": np.abs,
    "sqrt": np.sqrt,
    "log10": np.log10,
}
LEAST: dict[str, tuple[Callable[[Any], Any], Callable[[Any, Any], Any]]] = {
    "min": (np.nanmin, np.minimum),
    "max": (np.nanmax, np.maximum),
}
"""Of one column over all particles, and of several for each particle."""
COLUMN = "column"
"""The function that takes the name of a column that is no name of Python's."""
CALLS = (*FUNCTIONS, *LEAST, COLUMN)
INSTEAD: dict[type[ast.AST], str] = {
    ast.BitAnd: "and",
    ast.BitOr: "or",
    ast.Invert: "not",
    ast.BitXor: "!=",
}
"""What NumPy's users write, and what is written here."""
EXPECTED = "comparisons, and, or, not, in, arithmetic, " + ", ".join(CALLS[:-1])


def evaluate(text: str, columns: Mapping[str, Column]) -> Column:
    """What an expression says of all particles: (n,) numbers or bool, or Text; a number of its own
    is one for all, (). Sums and products are of float64; NaN compares as nothing.

    Args:
        text: as 'x > 0 and chain == "A"'; or the name of a column, whatever it is.
        columns: (n,) each, by name.

    Raises:
        RequestError: it is none. It marks the place, and lists the columns.
    """
    if text in columns:
        return columns[text]
    if len(text) > LONGEST:
        raise RequestError(f"expected at most {LONGEST} letters, got {len(text)}")
    found = _Evaluator(text, columns).all()
    return found if isinstance(found, Text) else np.asarray(found)


def columns_of(text: str, columns: Mapping[str, Column]) -> list[str]:
    """The columns that an expression names."""
    if text in columns:
        return [text]
    named = (
        node.id if isinstance(node, ast.Name) else getattr(node, "value", None)
        for node in ast.walk(ast.parse(text.strip(), mode="eval"))
    )
    return list(dict.fromkeys(name for name in named if isinstance(name, str) and name in columns))


class _Evaluator:
    def __init__(self, text: str, columns: Mapping[str, Column]) -> None:
        self.text, self.columns = " ".join(text.split("\n")).strip(), columns

    def all(self) -> Value:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # of escapes that are none
                tree = ast.parse(self.text, mode="eval")
        except SyntaxError as error:
            raise self._is_no_expression(error) from None
        except (ValueError, RecursionError, MemoryError):
            raise RequestError(f"expected an expression, got {self.text[:40]!r}") from None
        try:
            with np.errstate(all="ignore"):
                found = self._of(tree.body)
        except RecursionError:
            raise RequestError("expected a simpler expression") from None
        if isinstance(found, str | tuple):
            raise self._wrong(tree.body, f"expected {EXPECTED} over columns")
        return found

    def _is_no_expression(self, error: SyntaxError) -> RequestError:
        for wrong, right in (("&&", "and"), ("||", "or")):
            if wrong in self.text:
                start = self.text.index(wrong)
                return self._at(start, start + 2, f"expected {right!r}")
        if not self.text:
            return RequestError("expected an expression, got nothing")
        start = (error.offset or len(self.text) + 1) - 1
        end = max((error.end_offset or 0) - 1, start + 1)
        said = error.msg.partition(".")[0].partition(";")[0]
        if self.text[start:end] == "=":
            said = "expected '=='"
        return self._at(start, end, said[0].lower() + said[1:])

    def _of(self, node: ast.AST) -> Value:
        rule = getattr(self, f"_{type(node).__name__.lower()}", None)
        if rule is None:
            raise self._wrong(node, f"expected {EXPECTED}")
        return rule(node)

    def _constant(self, node: ast.Constant) -> Value:
        if isinstance(node.value, bool | float | str):
            return node.value
        if isinstance(node.value, int):
            # One that int64 does not hold is compared as a float is.
            return node.value if abs(node.value) < 2**63 else self._large(node)
        raise self._wrong(node, "expected a number or text in quotes")

    def _large(self, node: ast.Constant) -> float:
        try:
            return float(node.value)  # type: ignore[arg-type]
        except OverflowError:
            raise self._wrong(node, "expected a number below 1.8e308") from None

    def _name(self, node: ast.Name) -> Value:
        return self._column(node, node.id)

    def _subscript(self, node: ast.Subscript) -> Value:
        """A column of LAMMPS's, as c_stress[1]."""
        return self._column(node, ast.get_source_segment(self.text, node) or "")

    def _column(self, node: ast.AST, name: str) -> Value:
        if name in self.columns:
            return self.columns[name]
        hint = did_you_mean(name, self.columns) or "; text stands in quotes"
        raise self._wrong(node, f"no column is called {name!r}", hint)

    def _tuple(self, node: ast.Tuple | ast.List | ast.Set) -> Value:
        values = tuple(self._of(one) for one in node.elts)
        for one, value in zip(node.elts, values, strict=True):
            if isinstance(value, Text | tuple) or np.ndim(value):
                raise self._wrong(one, "expected a number or text in quotes")
        return values

    _list = _set = _tuple

    def _boolop(self, node: ast.BoolOp) -> Value:
        both = np.logical_and if isinstance(node.op, ast.And) else np.logical_or
        return reduce(both, [self._condition(one) for one in node.values])

    def _unaryop(self, node: ast.UnaryOp) -> Value:
        if isinstance(node.op, ast.Not):
            return np.logical_not(self._condition(node.operand))
        self._write_instead(node, node.op)
        number = self._number(node.operand)
        return -number if isinstance(node.op, ast.USub) else number

    def _binop(self, node: ast.BinOp) -> Value:
        self._write_instead(node, node.op)
        if type(node.op) not in ARITHMETIC:
            raise self._wrong(node, f"expected {EXPECTED}")
        return ARITHMETIC[type(node.op)](self._number(node.left), self._number(node.right))

    def _write_instead(self, node: ast.AST, op: ast.AST) -> None:
        if type(op) in INSTEAD:
            raise self._wrong(node, f"expected {INSTEAD[type(op)]!r} between or before conditions")

    def _call(self, node: ast.Call) -> Value:
        name = node.func.id if isinstance(node.func, ast.Name) else None
        if name not in CALLS or node.keywords:
            raise self._wrong(node.func, f"expected one of the functions {', '.join(CALLS)}")
        starred = any(isinstance(one, ast.Starred) for one in node.args)
        if not node.args or starred or (name not in LEAST and len(node.args) != 1):
            several = "at least one argument" if name in LEAST else "one argument"
            raise self._wrong(node, f"{name} takes {several}")
        if name == COLUMN:
            given = node.args[0]
            if isinstance(given, ast.Constant) and isinstance(given.value, str):
                return self._column(given, given.value)
            raise self._wrong(given, "expected a column's name in quotes")
        numbers = [self._number(one) for one in node.args]
        if name in FUNCTIONS:
            return FUNCTIONS[name](numbers[0])
        of_all, of_each = LEAST[name]
        if len(numbers) > 1:
            return reduce(of_each, numbers)
        return of_all(numbers[0]) if np.size(numbers[0]) else np.nan

    def _compare(self, node: ast.Compare) -> Value:
        found, before, left = [], node.left, self._of(node.left)
        for op, after in zip(node.ops, node.comparators, strict=True):
            right = self._of(after)
            if isinstance(op, ast.In | ast.NotIn):
                inside = self._is_in(before, after, left, right)
                found.append(inside if isinstance(op, ast.In) else np.logical_not(inside))
            elif type(op) in COMPARISONS:
                found.append(self._compared(COMPARISONS[type(op)], before, after, left, right))
            else:
                raise self._wrong(node, f"expected {EXPECTED}")
            before, left = after, right
        return reduce(np.logical_and, found)

    def _is_in(self, before: ast.AST, after: ast.AST, left: Value, right: Value) -> Value:
        if not isinstance(right, tuple):
            raise self._wrong(after, "expected values in brackets, as (1, 2)")
        equal = [self._compared(operator.eq, before, after, left, one) for one in right]
        return reduce(np.logical_or, equal, np.zeros((), bool))

    def _compared(
        self, compare: Callable[[Any, Any], Any], a: ast.AST, b: ast.AST, left: Value, right: Value
    ) -> Value:
        for node, value in ((a, left), (b, right)):
            if isinstance(value, tuple):
                raise self._wrong(node, "expected one value; values in brackets stand after in")
        texts = [isinstance(value, str | Text) for value in (left, right)]
        if all(texts):
            return _compared_texts(compare, left, right)
        if any(texts):
            what, node = ("text", b) if texts[0] else ("a number", b)
            there = ""
            if isinstance(left, Text):
                there = f", as {some(left.kinds)}"
            raise self._wrong(node, f"expected {what}{there}")
        return compare(left, right)

    def _number(self, node: ast.AST) -> Value:
        value = self._of(node)
        if isinstance(value, str | tuple | Text):
            raise self._wrong(node, "expected numbers, got text")
        return np.asarray(value).astype(np.float64, copy=False)[()]

    def _condition(self, node: ast.AST) -> Value:
        """What is True or False, or 1 or 0."""
        value = self._of(node)
        if not isinstance(value, str | tuple | Text):
            array = np.asarray(value)
            if array.dtype == bool:
                return array
            if ((array == 0) | (array == 1)).all():
                return array != 0
        raise self._wrong(node, "expected a condition, as x > 0")

    def _wrong(self, node: Any, said: str, hint: str = "") -> RequestError:
        text = self.text.encode()  # of which Python counts the bytes
        start, end = (
            len(text[:at].decode(errors="replace")) for at in (node.col_offset, node.end_col_offset)
        )
        return self._at(start, end, said, hint)

    def _at(self, start: int, end: int, said: str, hint: str = "") -> RequestError:
        """An error that marks a part of the text."""
        before, part, after = self.text[:start], self.text[start:end], self.text[end:]
        before = before if len(before) <= 60 else f"...{before[-50:]}"
        part = part if len(part) <= 60 else f"{part[:50]}..."
        after = after if len(after) <= 60 else f"{after[:50]}..."
        place = f"at character {start + 1}: {before}>>>{part}<<<{after}"
        return RequestError(f"{said}, {place}; the columns are {some(self.columns, 30)}{hint}")


def _compared_texts(compare: Callable[[Any, Any], Any], left: Value, right: Value) -> Value:
    if isinstance(left, str) and isinstance(right, str):
        return compare(left, right)
    if isinstance(left, Text) and isinstance(right, Text):
        return compare(left.array(), right.array())
    if isinstance(left, Text):
        return np.array([compare(kind, right) for kind in left.kinds], bool)[left.which]
    return np.array([compare(left, kind) for kind in right.kinds], bool)[right.which]
