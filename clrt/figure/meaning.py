"""Meaning: what colours and radii of particles mean, in all frames of a trajectory the same."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from clrt.figure.lines import Sizes


class Meaning(NamedTuple):
    """What colours and radii mean: in all frames of a trajectory the same."""

    clim: tuple[float, float] | None = None
    """What the ends of the map stand for, if a column of numbers gives the colours."""
    kinds: tuple[str, ...] = ()
    """Of a column of text: the texts that there are, in order."""
    numbers: tuple[int, ...] = ()
    """Of elements and types: those that there are, in order."""
    names: tuple[str, ...] = ()
    """Of types that have names: that of type t is names[t]. Files number them frame by frame."""
    reach: tuple[float, float] | None = None
    """The least and the largest finite value of that column, if there is one."""
    spare: float | None = None
    """The radius of particles that have none."""
    lines: Sizes | None = None
    """Of bonds and arrows."""


def together(meanings: Sequence[Meaning]) -> Meaning:
    """What colours mean in several frames: from the least to the largest, and all texts."""
    clim = joint(one.clim for one in meanings)
    kinds = tuple(sorted({kind for one in meanings for kind in one.kinds}))
    names: tuple[str, ...] = ()
    numbers = set[int]()
    for one in meanings:
        names = extended(names, one.names)
        numbers |= {names.index(one.names[k]) if one.names != names[: len(one.names)] else k
                    for k in one.numbers}  # fmt: skip
    first, reach = meanings[0], joint(one.reach for one in meanings)
    there = tuple(sorted(numbers))
    return Meaning(clim, kinds, there, names, reach, first.spare, first.lines)


def joint(ranges: Iterable[tuple[float, float] | None]) -> tuple[float, float] | None:
    there = [one for one in ranges if one is not None]
    return (min(low for low, _ in there), max(high for _, high in there)) if there else None


def extended(names: tuple[str, ...], more: tuple[str, ...]) -> tuple[str, ...]:
    """Names, and behind them those of others that are none of them."""
    return names + tuple(name for name in more if name not in names) if names else more
