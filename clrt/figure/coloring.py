"""Coloring: what gives particles their colours, what these mean, and how much they let through."""

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np

from clrt.errors import RequestError, warn
from clrt.figure.meaning import Meaning, extended, joint
from clrt.film import color as colors_of
from clrt.film.decor import legend as legends
from clrt.particles import choose, elements, palette
from clrt.particles.particlefile import STYLE_NAMES
from clrt.particles.particles import Particles
from clrt.particles.texts import Text
from clrt.scene.film import LegendEntry
from clrt.values import Array, frozen

By = Literal["file", "element", "type", "material", "one", "column", "text"]
Legend: TypeAlias = Callable[[], tuple[LegendEntry, ...]]
Limits: TypeAlias = tuple[float, float] | str | None

STEEL_BLUE = (70, 130, 180)
"""sRGB, of particles of which nothing is known that has a colour."""


class Source(NamedTuple):
    """What gives the colours."""

    by: By
    title: str
    """What it is called."""
    column: Array | Text | None = None
    """(n,), if it is one."""


class Coloring(NamedTuple):
    """Colours, and what they mean."""

    source: Source
    srgb: Array | None
    """(n, 3), bytes or numbers from 0 to 1; None: the material's."""
    meaning: Meaning
    legend: Legend
    """What they stand for, if they are of an element, a type or text."""


def coloring(
    particles: Particles,
    columns: Mapping[str, Array | Text],
    rows: Array | None,
    color: str | None,
    colors: str | Mapping[str, Any] | None,
    cmap: str,
    clim: Limits,
    material: str,
    meaning: Meaning | None,
) -> Coloring:
    """The colours of the rows of particles, as a ParticleFile's fields of the same names say.

    Args:
        columns: those of the particles.
        rows: (m,) which of them are there; None: all.
        meaning: of another frame; then nothing is said again.

    Raises:
        RequestError: naming the key, if the particles do not have what it needs.
    """
    source = _source(particles, columns, color, colors, material)
    found = _shaded(particles, rows, source, cmap, clim, meaning)
    if source.by == "column" and found.meaning.reach is None and meaning is None:
        gray = "what has none is gray, without a colour bar"
        warn("color", f"no value of {source.title} is finite: {gray}")
    if isinstance(colors, Mapping):
        return _overridden(particles, rows, found, colors, says=meaning is None)
    if colors is not None:
        n = len(particles) if rows is None else len(rows)
        one = np.broadcast_to(colors_of.srgb("colors", colors), (n, 3))
        return found._replace(srgb=one)
    return found


def opacities(
    particles: Particles,
    columns: Mapping[str, Array | Text],
    rows: Array | None,
    opacity: float | str | None,
) -> Array | None:
    """(n,) of the rows, from 0 to 1; None: all are opaque."""
    if opacity is None:
        found: Any = particles.opacities
    elif isinstance(opacity, str):
        found = _number(opacity, columns)
        if found is None:
            found = choose.column("opacity", opacity, columns)
    else:
        found = np.float64(opacity)
    if found is None:
        return None
    expected = "opacity: expected numbers from 0 to 1"
    if isinstance(found, Text):
        raise RequestError(f"{expected}, got text: {opacity}")
    if found.ndim and rows is not None:
        found = found[rows]
    found = found.astype(np.float32 if found.dtype == np.float32 else np.float64)
    wrong = found[~((found >= 0) & (found <= 1))]
    if wrong.size:
        raise RequestError(f"{expected}, got {wrong.flat[0]:.6g} of {opacity!r}")
    if (found == 1).all():
        return None
    n = len(particles) if rows is None else len(rows)
    return frozen(np.array(np.broadcast_to(found, (n,))))


def _number(given: str, columns: Mapping[str, Array | Text]) -> Any:
    """The number that a text is; None: it is none, or a column's name."""
    try:
        return None if given in columns else np.float64(given)
    except ValueError:
        return None


def _source(
    particles: Particles,
    columns: Mapping[str, Array | Text],
    color: str | None,
    colors: str | Mapping[str, Any] | None,
    material: str,
) -> Source:
    there: list[By] = ["material"]
    if particles.types is not None:
        there.insert(0, "type")
    if particles.elements is not None:
        there.insert(0, "element")
    if particles.colors is not None:
        there.insert(0, "file")
    if color is None and isinstance(colors, str):
        return Source("one", "")
    if color is None and isinstance(colors, Mapping):
        of = choose.matching(colors, choose.kinds_of(particles))
        if of == "name":
            return Source("text", of, columns[of])
        if of is not None:
            return Source("element" if of == "element" else "type", of)
    if color is None:
        first = there[0]
        if first == "material" and material in STYLE_NAMES:
            first = "one"
        return Source(first, first)
    for by in there:
        if by == color:
            return Source(by, by)
    found = choose.column("color", color, columns, there)
    title = " ".join(color.split())
    if isinstance(found, Text):
        return Source("text", title, found)
    found = np.broadcast_to(found, (len(particles),))
    if found.dtype == bool:
        return Source("text", title, Text(("False", "True"), found.astype(np.intp)))
    return Source("column", title, found)


def _shaded(
    particles: Particles,
    rows: Array | None,
    source: Source,
    cmap: str,
    clim: Limits,
    meaning: Meaning | None,
) -> Coloring:
    known, (by, _, column) = meaning or Meaning(), source

    def part(array: Array) -> Array:
        return array if rows is None else array[rows]

    if by == "file" and particles.colors is not None:
        return Coloring(source, part(particles.colors), Meaning(), tuple)
    if by == "element" and particles.elements is not None:
        numbers = part(particles.elements)
        there = _there(numbers, known)
        shades = elements.COLORS[numbers]
        return Coloring(source, shades, there, lambda: legends.of_elements(there.numbers))
    if by == "type" and particles.types is not None:
        types, own_names = part(particles.types), particles.type_names
        if own_names is None:
            there, names = _there(types, known), None
        else:
            names = extended(known.names, own_names)
            if names[: len(own_names)] != own_names:
                types = np.array([names.index(name) for name in own_names])[types]
            there = _there(types, known)._replace(names=names)
        shades = palette.of_types(types)
        return Coloring(source, shades, there, lambda: legends.of_types(there.numbers, names))
    if by == "one":
        n = len(particles) if rows is None else len(rows)
        shades = np.broadcast_to(np.array(STEEL_BLUE, np.uint8), (n, 3))
        return Coloring(source, shades, Meaning(), tuple)
    if isinstance(column, Text):
        text = Text.of(column.kinds, part(column.which))
        kinds = tuple(sorted({*text.kinds, *known.kinds}))
        shades = palette.of_kinds(len(kinds))
        places = np.array([kinds.index(kind) for kind in text.kinds], np.intp)
        own = shades[places[text.which]] if len(text.which) else np.zeros((0, 3), np.uint8)
        return Coloring(source, own, Meaning(kinds=kinds), lambda: legends.of_kinds(kinds, shades))
    if column is not None:
        values = part(column)
        limits = known.clim if clim is None or isinstance(clim, str) else clim
        reach = palette.limits(values) if np.isfinite(values).any() else None
        shades = palette.of_values(values, cmap, limits or reach or (0.0, 1.0))
        there = Meaning(clim=limits or reach, reach=joint([reach, known.reach]))
        return Coloring(source, shades, there, tuple)
    return Coloring(source, None, Meaning(), tuple)


def _there(numbers: Array, known: Meaning) -> Meaning:
    """The numbers that there are beside those that are known to be."""
    low, high = numbers.min(initial=0), numbers.max(initial=0)
    few = low >= 0 and high < 1 << 16  # they are counted faster than sorted
    found = np.flatnonzero(np.bincount(numbers)) if few else np.unique(numbers)
    return Meaning(numbers=tuple(sorted({*found.tolist(), *known.numbers})))


def _overridden(
    particles: Particles,
    rows: Array | None,
    found: Coloring,
    colors: Mapping[str, Any],
    says: bool,
) -> Coloring:
    """Colours, with those that some kinds are given."""
    (by, _, column), own = found.source, found.srgb
    kinds = choose.kinds_of(particles)
    of = by if by in ("element", "type") else choose.matching(colors, kinds) or ""
    text = column if isinstance(column, Text) else kinds.get(of)
    given = {str(key): colors_of.srgb("colors", one) for key, one in colors.items()}
    if own is None:
        n = len(particles) if rows is None else len(rows)
        own = np.full((n, 3), 255, np.uint8)
    shades = own.astype(np.float64) / (255 if own.dtype.kind == "u" else 1)
    for key, shade in given.items():
        if text is not None and key in text.kinds:
            which = text.which if rows is None else text.which[rows]
            shades[which == text.kinds.index(key)] = shade
        elif says:
            choose.say_absent("colors", key, kinds if text is None else {by: text})

    def changed() -> tuple[LegendEntry, ...]:
        return tuple(
            LegendEntry(entry.name, tuple(colors_of.to_linear(given[entry.name]).tolist()))
            if entry.name in given
            else entry
            for entry in found.legend()
        )

    return found._replace(srgb=shades, legend=changed)
