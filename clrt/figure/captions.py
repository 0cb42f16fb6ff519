"""Captions: what is written in a figure, of the particles that it shows."""

from collections.abc import Iterator, Mapping
from string import Formatter
from typing import Any

import numpy as np
from msgspec.structs import replace

from clrt.errors import RequestError, SceneError
from clrt.particles.particles import Particles
from clrt.particles.texts import Text
from clrt.scene.film import Label
from clrt.scene.scene import Scene
from clrt.scene.spheres import Spheres
from clrt.values import Array, did_you_mean, some

MOST = 10_000
"""Labels: more could not be read."""
USUAL: Mapping[str, float] = {"frame": 0}
"""Facts of what is no file."""


def filled(
    template: str,
    facts: Mapping[str, float],
    particles: Particles | None = None,
    rows: Array | None = None,
) -> str:
    """A text with the values of its fields, as str.format() writes them. It is a template as well:
    braces that are to be seen are still written twice.

    Args:
        template: checked by clrt.Film.
        facts: values by name.
        particles: whose columns of one value are fields as well.
        rows: (n,) which of them are shown; None: all.

    Raises:
        RequestError: there is no such field, or its value cannot be written so.
    """
    found = ""
    for text, name, spec, conversion in Formatter().parse(template):
        found += _braced(text)
        if name is None:
            continue
        value = _value(name, facts, particles, rows)
        field = f"{{0{'!' + conversion if conversion else ''}:{spec}}}"
        try:
            found += _braced(field.format(value))
        except (ValueError, TypeError, LookupError, AttributeError) as error:
            raise RequestError(f"label: {{{name}:{spec}}} of {value!r}: {error}") from None
    return found


def captioned(scene: Scene, facts: Mapping[str, float]) -> Scene:
    """A scene whose label has its fields filled.

    Raises:
        SceneError: as filled().
    """
    try:
        label = filled(scene.film.label, facts)
    except RequestError as error:
        raise SceneError(f"film.{error}") from None
    return replace(scene, film=replace(scene.film, label=label))


def _braced(text: str) -> str:
    return text.replace("{", "{{").replace("}", "}}")


def _value(
    name: str, facts: Mapping[str, float], particles: Particles | None, rows: Array | None
) -> Any:
    if name in facts:
        return facts[name]
    columns: Mapping[str, Array | Text] = {} if particles is None else particles.columns
    if name not in columns:
        known = [*facts, *columns]
        hint = did_you_mean(name, known)
        raise RequestError(f"label: expected one of {some(known, 20)}, got {name!r}{hint}")
    column = columns[name]
    values = column.which if isinstance(column, Text) else column
    values = values if rows is None else values[rows]
    if len(values) == 0 or (values != values[0]).any():
        raise RequestError(f"label: expected a column of one value, {name!r} has several")
    return column.kinds[int(values[0])] if isinstance(column, Text) else values[0].item()


def labels(column: Array | Text, rows: Array | None, spheres: Spheres) -> Iterator[Label]:
    """A label for each sphere whose text is not empty.

    Args:
        column: of the particles.
        rows: (spheres,) which of them each sphere is; None: the spheres are the particles.

    Raises:
        RequestError: there are too many.
    """
    if isinstance(column, Text):
        texts, which = ["".join(_printable(kind)) for kind in column.kinds], column.which
    else:
        kinds, which = np.unique(column, return_inverse=True)
        texts = [_number(one) for one in kinds.tolist()]
    which = which.reshape(-1) if rows is None else which.reshape(-1)[rows]
    there = np.flatnonzero(np.array([text != "" for text in texts] or [False])[which])
    if len(there) > MOST:
        raise RequestError(
            f"labels: expected at most {MOST:,} particles, got {len(there):,}: --select chooses"
            " some, and an empty text is no label"
        )
    for k in there.tolist():
        yield Label(
            texts[int(which[k])], tuple(spheres.center[k].tolist()), float(spheres.radius[k])
        )


def _printable(text: str) -> Iterator[str]:
    return (c if c.isprintable() else " " for c in text.strip())


def _number(value: float) -> str:
    return "" if value != value else f"{value:g}" if isinstance(value, float) else str(value)
