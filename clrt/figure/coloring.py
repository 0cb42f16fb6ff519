"""Coloring: particles as spheres: which ones, how large they are, of which colour, and what that
means."""

import re
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from msgspec.structs import replace

from clrt.errors import ParticleWarning, RequestError
from clrt.figure import bonding, captions
from clrt.figure.lines import Asked, Lines, Sizes, edges, lines
from clrt.film import color as colors_of
from clrt.film.decor import legend as legends
from clrt.particles import choose, elements, expression, palette
from clrt.particles.neighbours import spacing
from clrt.particles.particlefile import ATOMS, PLAIN, STYLE_NAMES
from clrt.particles.particles import Particles
from clrt.particles.texts import Text
from clrt.scene.capsules import Capsules
from clrt.scene.film import Cell, Film, Label, LegendEntry
from clrt.scene.spheres import Spheres
from clrt.values import Array, did_you_mean, frozen, some

By = Literal["file", "element", "type", "material", "one", "column", "text"]

STEEL_BLUE = (70, 130, 180)
"""sRGB, of particles of which nothing is known that has a colour."""
BALL_OF_ATOM, BALL = 0.25, 0.5
"""The radius of a ball of ball-and-stick: of an element's van der Waals radius, and of another."""
UNITS = {"angstrom": "Å", "bohr": "a₀", "um": "µm"}
"""How some are written."""
LOGARITHM = re.compile(r"(log10|log)\((.*)\)")
Legend: TypeAlias = Callable[[], tuple[LegendEntry, ...]]


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


class Colored(NamedTuple):
    """Particles as spheres, and what their colours mean."""

    spheres: Spheres
    rows: Array | None
    """(n,) which of the particles each sphere is; None: the spheres are the particles."""
    by: By
    """What they have their colours of."""
    title: str
    """What that is called."""
    cmap: str
    meaning: Meaning
    legend: Legend
    """What the colours stand for, if they are of an element, a type or text."""
    box: Cell | None
    """The box that they are in."""
    cell: Cell | None
    """The box that is to be drawn."""
    labels: tuple[Label, ...]
    """Texts at the spheres."""
    label: str
    """That of the film, with its fields filled."""
    unit: str
    """Of lengths, as it is written; "": nobody knows."""
    capsules: Capsules | None
    """Bonds, arrows, and edges of a solid box."""
    parts: list[Spheres]
    """They hold all that is drawn beside the box."""
    is_solid: bool = False
    """The box is drawn by capsules."""


def nothing(material: str) -> Colored:
    """No particles, for a figure of something else."""
    spheres = Spheres(np.zeros((0, 3)), np.zeros(0), material)
    return Colored(
        spheres, None, "one", "", "viridis", Meaning(), tuple, None, None, (), "", "", None, []
    )


def colored(
    particles: Particles,
    *,
    material: str = PLAIN,
    select: str | None = None,
    hide: str | None = None,
    mask: Array | None = None,
    wrap: bool = False,
    replicate: Sequence[int] = (1, 1, 1),
    radius: float | Mapping[str, float] | None = None,
    balls: bool = False,
    scale: float = 1.0,
    color: str | None = None,
    colors: str | Mapping[str, Any] | None = None,
    opacity: float | str | None = None,
    cmap: str = "viridis",
    clim: tuple[float, float] | str | None = None,
    cell: bool | Literal["solid"] = False,
    bonds: Any = None,
    bond_radius: float | None = None,
    bond_color: str = ATOMS,
    vectors: str | None = None,
    vector_scale: float | None = None,
    vector_color: str = ATOMS,
    labels: str | None = None,
    label: str = "",
    meaning: Meaning | None = None,
) -> Colored:
    """Particles as spheres, as a ParticleFile's fields of the same names say.

    Args:
        mask: (n,) of bool: only these are there.
        label: that of the film, whose fields are filled.
        meaning: of another frame; then nothing is said again, and no particle may be left.

    Raises:
        RequestError: naming the key, if the particles do not have what it needs.
    """
    if wrap:
        particles = choose.wrapped(particles)
    if isinstance(bonds, np.ndarray):
        particles, bonds = particles.replaced(bonds=bonds), bonding.LISTED
    columns = particles.columns
    written = None if labels is None else _column("labels", labels, columns, ())
    kept = choose.selected(columns, len(particles), select, hide, may_be_none=meaning is not None)
    if mask is not None:
        kept = mask if kept is None else kept & mask
    radii, spare = _radii(particles, radius, meaning, balls)
    by, title, column = _by(particles, columns, color, colors, material)
    rows = None if kept is None else np.flatnonzero(kept)
    if rows is not None:
        radii = radii[rows]
    own, found, legend = _srgb(particles, rows, by, column, cmap, clim, meaning)
    if by == "column" and found.reach is None and meaning is None:
        _warn(f"color: no value of {title} is finite: what has none is gray, without a colour bar")
    if isinstance(colors, Mapping):
        own, legend = _overridden(particles, rows, by, column, colors, own, legend, meaning is None)
    elif colors is not None:
        own = np.broadcast_to(colors_of.srgb("colors", colors), (len(radii), 3))
    positions = particles.positions if rows is None else particles.positions[rows]
    linear = None if own is None else colors_of.linear(own)
    opacities = _opacities(particles, columns, rows, opacity)
    radii = radii * scale
    many = int(np.prod(replicate))
    moved = choose.images(particles, replicate) if many > 1 else np.zeros((1, 3))
    asked = Asked(
        balls if bonds is None else bonds,
        bond_radius,
        bond_color,
        vectors,
        vector_scale,
        vector_color,
    )
    beside = Lines(None, [], Sizes())
    if asked != Asked():
        part = particles if kept is None else particles.where(kept)
        known = None if meaning is None else meaning.lines or Sizes()
        beside = lines(part, radii, linear, moved, material, asked, known)
    if many > 1:
        positions = (positions + moved[:, np.newaxis]).reshape(-1, 3)
        radii = np.tile(radii, many)
        linear = None if linear is None else np.tile(linear, (many, 1))
        opacities = None if opacities is None else np.tile(opacities, many)
        rows = np.tile(np.arange(len(particles)) if rows is None else rows, many)
    if positions is not particles.positions:
        frozen(positions)
    spheres = Spheres(
        positions,
        frozen(radii),
        material,
        None if linear is None else frozen(linear),
        None if opacities is None else frozen(opacities),
    )
    box = None if particles.cell is None else box_of(particles, replicate)
    if cell and box is None:
        raise RequestError("cell: expected particles in a box, got none")
    texts = () if written is None else tuple(captions.labels(written, rows, spheres))
    capsules = beside.capsules
    if cell == "solid" and box is not None:
        walls = edges(box, material)
        capsules = walls if capsules is None else Capsules.joined([capsules, walls])
    return Colored(
        spheres,
        rows,
        by,
        title,
        cmap,
        found._replace(spare=spare, lines=beside.sizes),
        legend,
        box,
        box if cell else None,
        texts,
        captions.filled(label, {**captions.USUAL, **particles.facts}, particles, rows),
        UNITS.get(particles.unit or "", particles.unit or ""),
        capsules,
        [spheres, *beside.aside],
        cell == "solid",
    )


def together(meanings: Sequence[Meaning]) -> Meaning:
    """What colours mean in several frames: from the least to the largest, and all texts."""
    clim = _joint(one.clim for one in meanings)
    kinds = tuple(sorted({kind for one in meanings for kind in one.kinds}))
    names: tuple[str, ...] = ()
    numbers = set[int]()
    for one in meanings:
        names = _extended(names, one.names)
        numbers |= {names.index(one.names[k]) if one.names != names[: len(one.names)] else k
                    for k in one.numbers}  # fmt: skip
    first, reach = meanings[0], _joint(one.reach for one in meanings)
    there = tuple(sorted(numbers))
    return Meaning(clim, kinds, there, names, reach, first.spare, first.lines)


def _joint(ranges: Iterable[tuple[float, float] | None]) -> tuple[float, float] | None:
    there = [one for one in ranges if one is not None]
    return (min(low for low, _ in there), max(high for _, high in there)) if there else None


def _extended(names: tuple[str, ...], more: tuple[str, ...]) -> tuple[str, ...]:
    """Names, and behind them those of others that are none of them."""
    return names + tuple(name for name in more if name not in names) if names else more


def decorated(film: Film, parts: Sequence[Colored]) -> Film:
    """A film with the boxes and labels of particles, and what it asks for and does not say: the
    fields of its label, those of the first; the edges that its axes are along; the range and the
    map of its colour bar, those of the first that are coloured by a column, or a legend, that of
    the first that are coloured by element, type or text.

    Raises:
        RequestError: nothing is coloured so, or there is no box.
    """
    drawn = [part.cell for part in parts if part.cell and not part.is_solid]
    film = replace(
        film,
        cells=(*film.cells, *drawn),
        labels=(*film.labels, *(label for part in parts for label in part.labels)),
        label=next((part.label for part in parts), film.label),
    )
    if film.scalebar == "auto" and not film.scalebar_label:
        film = replace(film, scalebar_label=next((part.unit for part in parts), ""))
    if film.axes == "abc" and film.axes_edges is None:
        boxes = [part.box for part in parts if part.box is not None]
        if not boxes:
            raise RequestError("axes: expected particles in a box, for abc are its edges")
        film = replace(film, axes_edges=boxes[0].edges)
    if not film.colorbar or film.legend:
        return film
    for part in parts:
        if part.by == "column":
            return _with_bar(film, part)
    if film.colorbar_clim is not None:
        return film
    for part in parts:
        if part.by in ("element", "type", "text"):
            return replace(film, legend=part.legend())
    expected = "particles coloured by a column, by element or by type"
    raise RequestError(f"colorbar: expected {expected}")


def _with_bar(film: Film, part: Colored) -> Film:
    reach, clim = part.meaning.reach, film.colorbar_clim or part.meaning.clim
    if reach is None or clim is None:
        return replace(film, colorbar="")
    of = LOGARITHM.fullmatch(part.title)
    log: Any = film.colorbar_log or (of[1] if of and _is_whole(of[2]) else "")
    label = film.colorbar
    if of and " ".join(label.split()) == part.title:
        label = of[2]  # the ticks are its values, not their logarithms
    return replace(
        film,
        colorbar=label,
        colorbar_cmap=film.colorbar_cmap or part.cmap,
        colorbar_clim=clim,
        colorbar_log=log,
        colorbar_ends=(reach[0] < clim[0], reach[1] > clim[1]),
    )


def _is_whole(inside: str) -> bool:
    """Whether brackets that are opened in it are closed in it."""
    depth = 0
    for character in inside:
        depth += {"(": 1, ")": -1}.get(character, 0)
        if depth < 0:
            return False
    return depth == 0


def box_of(particles: Particles, replicate: Sequence[int] = (1, 1, 1)) -> Cell:
    """The box that particles are in, as long as so many of it.

    Raises:
        RequestError: they are in none.
    """
    if particles.cell is None:
        raise RequestError("cell: expected particles in a box, got none")
    edges = particles.cell * np.array(replicate)[:, np.newaxis]
    return Cell(edges, particles.origin)  # type: ignore[arg-type]


def _radii(
    particles: Particles,
    radius: float | Mapping[str, float] | None,
    meaning: Meaning | None,
    balls: bool,
) -> tuple[Array, float | None]:
    """(n,), and the radius of those that have none.

    balls: radii that are not given are smaller.
    """
    n = len(particles)
    if radius is not None and not isinstance(radius, Mapping):
        return np.full(n, radius), None
    found = np.full(n, np.nan)
    kinds = choose.kinds_of(particles) if radius else {}
    for key, one in (radius or {}).items():
        of = next((text for text in kinds.values() if key in text.kinds), None)
        if of is not None:
            found[of.which == of.kinds.index(key)] = one
        elif meaning is None:
            _say_absent("radius", key, kinds)
    left = np.isnan(found)
    if not left.any():
        return found, None
    if particles.elements is not None and (balls or particles.radii is None):
        known: Array = elements.VAN_DER_WAALS[particles.elements] / particles.angstroms
        known = known * BALL_OF_ATOM if balls else known
    elif particles.radii is not None:
        known = particles.radii * BALL if balls else particles.radii
    else:
        known_spare = None if meaning is None else meaning.spare
        spare = known_spare or _spare(particles) * (BALL if balls else 1)
        found[left] = spare
        return found, spare
    return (known if left.all() else np.where(left, known, found)), None


def _opacities(
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
            found = _column("opacity", opacity, columns, ())
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
    return np.array(np.broadcast_to(found, (n,)))


def _number(given: str, columns: Mapping[str, Array | Text]) -> Any:
    """The number that a text is; None: it is none, or a column's name."""
    try:
        return None if given in columns else np.float64(given)
    except ValueError:
        return None


def _spare(particles: Particles) -> float:
    """Half the median distance of nearest neighbours."""
    apart = spacing(particles.positions)
    radius = 1.0 if apart is None else apart / 2
    why = "half the median distance between nearest neighbours" if apart else "there is one place"
    _warn(f"radius {radius:.4g}: {why}; --radius X, radii=X in Python, says another")
    return radius


def _by(
    particles: Particles,
    columns: Mapping[str, Array | Text],
    color: str | None,
    colors: str | Mapping[str, Any] | None,
    material: str,
) -> tuple[By, str, Array | Text | None]:
    """What gives the colours, what it is called, and the column if it is one."""
    there: list[By] = ["material"]
    if particles.types is not None:
        there.insert(0, "type")
    if particles.elements is not None:
        there.insert(0, "element")
    if particles.colors is not None:
        there.insert(0, "file")
    if color is None and isinstance(colors, str):
        return "one", "", None
    if color is None and isinstance(colors, Mapping):
        of = choose.matching(colors, choose.kinds_of(particles))
        if of == "name":
            return "text", of, columns[of]
        if of is not None:
            return ("element" if of == "element" else "type"), of, None
    if color is None:
        first = there[0]
        if first == "material" and material in STYLE_NAMES:
            first = "one"
        return first, first, None
    for by in there:
        if by == color:
            return by, by, None
    found = _column("color", color, columns, there)
    title = " ".join(color.split())
    if isinstance(found, Text):
        return "text", title, found
    found = np.broadcast_to(found, (len(particles),))
    if found.dtype == bool:
        return "text", title, Text(("False", "True"), found.astype(np.intp))
    return "column", title, found


def _column(
    key: str, given: str, columns: Mapping[str, Array | Text], there: Sequence[str]
) -> Array | Text:
    if given not in columns and given.replace("_", "a").isalnum():
        known = list(dict.fromkeys([*there, *columns]))
        hint = did_you_mean(given, known)
        raise RequestError(f"{key}: expected one of {some(known, 20)}, got {given!r}{hint}")
    try:
        return expression.evaluate(given, columns)
    except RequestError as error:
        raise RequestError(f"{key}: {error}") from None


def _srgb(
    particles: Particles,
    rows: Array | None,
    by: By,
    column: Array | Text | None,
    cmap: str,
    clim: tuple[float, float] | str | None,
    meaning: Meaning | None,
) -> tuple[Array | None, Meaning, Legend]:
    """The colours (n, 3) of the rows, what they mean, and their legend."""
    known = meaning or Meaning()

    def part(array: Array) -> Array:
        return array if rows is None else array[rows]

    if by == "file" and particles.colors is not None:
        return part(particles.colors), Meaning(), tuple
    if by == "element" and particles.elements is not None:
        numbers = part(particles.elements)
        there = _there(numbers, known)
        return elements.COLORS[numbers], there, lambda: legends.of_elements(there.numbers)
    if by == "type" and particles.types is not None:
        types, own_names = part(particles.types), particles.type_names
        if own_names is None:
            there, names = _there(types, known), None
        else:
            names = _extended(known.names, own_names)
            if names[: len(own_names)] != own_names:
                types = np.array([names.index(name) for name in own_names])[types]
            there = _there(types, known)._replace(names=names)
        return palette.of_types(types), there, lambda: legends.of_types(there.numbers, names)
    if by == "one":
        n = len(particles) if rows is None else len(rows)
        return np.broadcast_to(np.array(STEEL_BLUE, np.uint8), (n, 3)), Meaning(), tuple
    if isinstance(column, Text):
        text = Text.of(column.kinds, part(column.which))
        kinds = tuple(sorted({*text.kinds, *known.kinds}))
        shades = palette.of_kinds(len(kinds))
        places = np.array([kinds.index(kind) for kind in text.kinds], np.intp)
        own = shades[places[text.which]] if len(text.which) else np.zeros((0, 3), np.uint8)
        return own, Meaning(kinds=kinds), lambda: legends.of_kinds(kinds, shades)
    if column is not None:
        values = part(column)
        limits = known.clim if clim is None or isinstance(clim, str) else clim
        reach = palette.limits(values) if np.isfinite(values).any() else None
        shades = palette.of_values(values, cmap, limits or reach or (0.0, 1.0))
        return shades, Meaning(clim=limits or reach, reach=_joint([reach, known.reach])), tuple
    return None, Meaning(), tuple


def _there(numbers: Array, known: Meaning) -> Meaning:
    """The numbers that there are beside those that are known to be."""
    low, high = numbers.min(initial=0), numbers.max(initial=0)
    few = low >= 0 and high < 1 << 16  # they are counted faster than sorted
    found = np.flatnonzero(np.bincount(numbers)) if few else np.unique(numbers)
    return Meaning(numbers=tuple(sorted({*found.tolist(), *known.numbers})))


def _overridden(
    particles: Particles,
    rows: Array | None,
    by: By,
    column: Array | Text | None,
    colors: Mapping[str, Any],
    own: Array | None,
    legend: Legend,
    says: bool,
) -> tuple[Array | None, Legend]:
    """Colours and their legend, with those that some kinds are given."""
    kinds = choose.kinds_of(particles)
    of = by if by in ("element", "type") else choose.matching(colors, kinds) or ""
    text = column if isinstance(column, Text) else kinds.get(of)
    given = {str(key): colors_of.srgb("colors", one) for key, one in colors.items()}
    if own is None:
        n = len(particles) if rows is None else len(rows)
        own = np.full((n, 3), 255, np.uint8)
    found = own.astype(np.float64) / (255 if own.dtype.kind == "u" else 1)
    for key, shade in given.items():
        if text is not None and key in text.kinds:
            which = text.which if rows is None else text.which[rows]
            found[which == text.kinds.index(key)] = shade
        elif says:
            _say_absent("colors", key, kinds if text is None else {by: text})

    def changed() -> tuple[LegendEntry, ...]:
        return tuple(
            LegendEntry(entry.name, tuple(colors_of.to_linear(given[entry.name]).tolist()))
            if entry.name in given
            else entry
            for entry in legend()
        )

    return found, changed


def _say_absent(key: str, name: str, kinds: Mapping[str, Text]) -> None:
    there = [kind for text in kinds.values() for kind in text.kinds]
    hint = did_you_mean(name, there)
    _warn(f"{key}: no particle is called {name!r}, there are {some(there, 12)}{hint}")


def _warn(text: str) -> None:
    warnings.warn(text, ParticleWarning, stacklevel=4)
