"""Derived: columns that follow from others, by their names."""

import functools
from collections.abc import Callable, Iterable, Iterator, Mapping

import numpy as np

from clrt import storage
from clrt.particles.texts import Text, distinct
from clrt.values import Array


class Columns(Mapping[str, Array | Text]):
    """Columns by name, (n,) each, some of which are made when they are first asked for."""

    def __init__(self, made: Mapping[str, Array | Text | Callable[[], Array | Text]]) -> None:
        self._made = dict(made)

    def __getitem__(self, name: str) -> Array | Text:
        found = self._made[name]
        if callable(found):
            found = self._made[name] = found()
        return found

    def __contains__(self, name: object) -> bool:
        return name in self._made

    def __iter__(self) -> Iterator[str]:
        return iter(self._made)

    def __len__(self) -> int:
        return len(self._made)


AXES = (("x", "y", "z"), ("_x", "_y", "_z"), ("X", "Y", "Z"), ("_X", "_Y", "_Z"))
"""What the names of three columns end in that are a vector's."""
ALSO = {
    "speed": ("v", "velocity", "velocities", "vel"),
    "force": ("f", "forces"),
}
"""What the length of a vector is called beside its own name, in small letters."""


def vectors(names: Iterable[str]) -> dict[str, tuple[str, str, str]]:
    """The lengths that there can be, by name, and the three columns of each: "v" and "speed" of
    vx, vy and vz. A name that is there already is none."""
    there = dict.fromkeys(names)
    found: dict[str, tuple[str, str, str]] = {}
    for name in there:
        for x, y, z in AXES:
            base = name.removesuffix(x)
            three = name, base + y, base + z
            if (
                base not in ("", name)
                and base[-1] != "_"
                and three[1] in there
                and three[2] in there
            ):
                for called in (base, *(k for k, of in ALSO.items() if base.lower() in of)):
                    if called not in there:
                        found.setdefault(called, three)
    return found


def with_derived(
    columns: Mapping[str, Array | Text | Callable[[], Array | Text]],
    texts: Mapping[str, Array],
    elements: Array | None,
) -> Columns:
    """Columns with those of text, and with what follows from all of them.

    Lengths of vectors; and which particles are water, protein, nucleic, ions and hydrogen, (n,)
    bool, as far as that can be told: by the names of their residues ("residue"), where there are
    none water and ions by their own ("name", or the types'), and hydrogen by the elements.

    Args:
        texts: (n,) str each.
        elements: (n,) atomic numbers.
    """

    def lazily(names: Array) -> Callable[[], Text]:
        return lambda: distinct(names)

    found = {**{name: lazily(names) for name, names in texts.items()}, **columns}
    every = Columns(found)
    more: dict[str, Callable[[], Array | Text]] = {}
    for name, three in vectors(found).items():
        more[name] = lambda three=three: _length(*(every[one] for one in three))  # type: ignore[misc]
    of = "residue" if "residue" in found else "name"
    by = "type" if of == "name" and "name" not in found else of
    if by in found and (by != "type" or not isinstance(columns[by], np.ndarray)):
        for name, names in _told()[of].items():
            more[name] = lambda names=names: _are(every[by], names)  # type: ignore[misc]
    if elements is not None:
        more["hydrogen"] = lambda: elements == 1
    return Columns({**found, **{name: make for name, make in more.items() if name not in found}})


def _length(*columns: Array | Text) -> Array:
    """(n,) float64, of vectors whose x, y and z are columns; NaN where one is."""
    x, y, z = (np.asarray(column, np.float64) for column in columns)
    found: Array = np.sqrt(x * x + y * y + z * z)
    return found


def _are(text: Array | Text, names: frozenset[str]) -> Array:
    assert isinstance(text, Text)
    by_kind = np.array([kind.strip().upper() in names for kind in text.kinds], bool)
    found: Array = by_kind[text.which]
    return found


@functools.cache
def _told() -> dict[str, dict[str, frozenset[str]]]:
    """The names that tell what a particle is: of "residue" or "name", then by what it is."""
    found: dict[str, dict[str, frozenset[str]]] = {}
    for line in (storage.folder("tables") / "residues.csv").read_text().splitlines():
        if not line.startswith(("#", "of,")):
            of, what, names = line.split(",")
            found.setdefault(of, {})[what] = frozenset(names.split())
    # Amber's first and last residues have an N or a C before their name.
    ends = {end + name for name in found["residue"]["protein"] if len(name) == 3 for end in "NC"}
    found["residue"]["protein"] |= ends
    return found
