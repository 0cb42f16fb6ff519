"""Ticks: round numbers on a scale, and how they are written."""

from decimal import Decimal
from fractions import Fraction
from math import ceil, floor, inf, log
from typing import NamedTuple

STEPS = (1, 2, 5)
"""Between ticks, times a power of ten."""

DIGITS = 6
"""The most digits of a tick: with more the scale has an offset, with more zeros a power."""


class Ticks(NamedTuple):
    """From the lowest to the highest. A number is its text times 10 to the power, plus the offset,
    to the last digit."""

    parts: tuple[float, ...]
    """Where on the scale they are, 0 for its low end, 1 for its high one."""
    texts: tuple[str, ...]
    power: int = 0
    offset: str = ""

    @property
    def note(self) -> str:
        """The note beside the texts: a factor, an offset, or nothing."""
        power = f"×{_ten_to(self.power)}" if self.power else ""  # noqa: RUF001
        sign = "- " if self.offset.startswith("-") else "+ "
        offset = sign + self.offset.lstrip("-") if self.offset else ""
        return f"{power} {offset}".strip()


def ticks(low: float, high: float, most: int) -> Ticks:
    """At most so many round numbers from `low` to `high`, or where they are one number that one, to
    six digits.

    most: at least 2.
    """
    # Of a float the shortest decimal that stands for it: 0.3 is three tenths.
    start, end = Fraction(repr(low)), Fraction(repr(high))
    if start == end:
        return Ticks((0.5,), (f"{low:.{DIGITS}g}",))
    size = (Decimal(repr(high)) - Decimal(repr(low))).adjusted()
    # Powers from one that is too small for any picture to one that has at most one tick.
    steps = ((m, k) for k in range(size - len(str(most)), size + 2) for m in STEPS)
    for m, power in steps:
        step = m * Fraction(10) ** power
        first, last = ceil(start / step), floor(end / step)
        if last - first < most:
            break
    parts = tuple(float((n * step - start) / (end - start)) for n in range(first, last + 1))
    return _written(parts, [n * m for n in range(first, last + 1)], power)


def powers(low: float, high: float, most: int, base: float) -> Ticks:
    """At most so many round numbers whose logarithms lie from `low` to `high`: powers of ten, or
    where there is one at most 1, 2 and 5 times such, or any. Texts that are empty are those of the
    numbers from 2 to 9 times a power.

    Args:
        most: at least 2.
        base: of the logarithm.
    """
    decade = log(10) / log(base)
    start, end = low / decade, high / decade
    near = 1e-9 * (end - start)  # logarithms of powers of ten are not exact
    first, last = ceil(start - near), floor(end + near)

    def parts(numbers: list[float]) -> tuple[float, ...]:
        return tuple(min(max((x - start) / (end - start), 0), 1) for x in numbers)

    if last - first >= 1:
        step = next(k for k in range(1, last - first + 2) if (last - first) // k < most)
        found = [(float(k), _ten_to(k)) for k in range(-(-first // step) * step, last + 1, step)]
        if step == 1 and last - first < most:
            minor = [k + log(m, 10) for k in range(first - 1, last + 1) for m in range(2, 10)]
            found += [(x, "") for x in minor if start <= x <= end]
        return Ticks(parts([x for x, _ in found]), tuple(text for _, text in found))
    decades = range(floor(start) - 1, ceil(end) + 1)
    between = [(k + log(m, 10), _plain(m, k)) for k in decades for m in STEPS]
    inside = [(x, text) for x, text in between if start - near <= x <= end + near]
    if 3 <= len(inside) <= most:
        return Ticks(parts([x for x, _ in inside]), tuple(text for _, text in inside))
    try:
        least, largest = float(10.0**start), float(10.0**end)
    except OverflowError:
        least = largest = inf
    if not 0 < least < largest < inf:
        linear = ticks(low, high, most)
        return linear._replace(texts=tuple(f"10^{text}" for text in linear.texts))
    linear = ticks(least, largest, most)
    numbers = [least + part * (largest - least) for part in linear.parts]
    return linear._replace(parts=parts([log(x, 10) for x in numbers]))


def _plain(number: int, power: int) -> str:
    """A digit times a power of ten."""
    if -4 < power < DIGITS:
        return f"{Decimal(number).scaleb(power):f}"
    return f"{number}×{_ten_to(power)}"  # noqa: RUF001


def _ten_to(power: int) -> str:
    return "10" + str(power).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))


def _written(parts: tuple[float, ...], numbers: list[int], power: int) -> Ticks:
    """Ticks at numbers times 10 to a power."""
    offset = 0
    if max(len(str(abs(n))) for n in numbers) > DIGITS:
        unit = 10 ** len(str(numbers[-1] - numbers[0]))
        offset = numbers[0] // unit * unit
        numbers = [n - offset for n in numbers]
    beside = _short(Decimal(offset).scaleb(power)) if offset else ""
    if not any(numbers):
        return Ticks(parts, ("0",), 0, beside)
    size = max(len(str(abs(n))) for n in numbers) - 1 + power  # the largest is about 10^size
    factor = 0 if -4 < size < DIGITS else size
    texts = tuple(f"{Decimal(n).scaleb(power - factor):f}" for n in numbers)
    return Ticks(parts, texts, factor, beside)


def _short(number: Decimal) -> str:
    """A number to its last digit, with or without a power of ten."""
    number = number.normalize()
    return min(f"{number:f}", f"{number:e}".replace("e+", "e"), key=len)
