"""clrt check: whether a scene file is right, or what a file of particles holds."""

import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from clrt.commands.loading import kind_of
from clrt.errors import SceneError, named

if TYPE_CHECKING:
    from clrt.particles.particles import Particles

MANY = 12
"""Texts and kinds that are named, at most."""


@click.command()
@click.argument("scene")
def check(scene: str) -> None:
    """Checks SCENE, a built-in scene's name or a TOML file, and says what is in it; or says what a
    file of particles holds: its columns, which expressions can name, and what is not used; or of
    a mesh whether it is closed."""
    said = {"mesh": _mesh, "particles": _particles, "scene": _scene}[kind_of(scene, {})]
    for line in said(scene):
        click.echo(line)


def _scene(path: str) -> Iterator[str]:
    from clrt.figure.resolver import resolved
    from clrt.files.scenefile import load_scene
    from clrt.motion import animation

    loaded = load_scene(path)
    with named(path, SceneError):
        loaded = resolved(loaded)
    if loaded.animation is not None:
        with named(path, SceneError):
            animation.Way(loaded).check(animation.all_frames(loaded))
    capsules, faces = len(loaded.capsules), sum(map(len, loaded.meshes))
    parts = [
        _count(len(loaded.spheres), "sphere"),
        *([_count(capsules, "capsule")] if capsules else []),
        *([_count(faces, "face")] if faces else []),
        _count(len(loaded.materials), "material"),
        _count(len(loaded.lights), "light"),
    ]
    yield (
        f"{path}: {', '.join(parts)}, max_depth {loaded.max_depth}, "
        f"shadow_bias {loaded.shadow_bias:g}"
    )


def _count(number: int, name: str) -> str:
    return f"{number} {name}" if number == 1 else f"{number} {name}s"


def _mesh(path: str) -> Iterator[str]:
    from clrt.files.meshes.reader import read_mesh

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        mesh = read_mesh(path)
    closed = "closed" if mesh.closed else "open"
    yield f"{path}: {len(mesh)} faces, {len(mesh.vertices)} vertices, {closed}"
    has = [name for name in ("normals", "colors") if getattr(mesh, name) is not None]
    yield f"  has       {', '.join(has) or 'no normals or colours'}"
    for text in dict.fromkeys(str(warning.message) for warning in said):
        yield f"  note      {_plain(text)}"


def _particles(path: str) -> Iterator[str]:
    from clrt.files.particles.reader import Reader, read

    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        particles = read(path)
        with Reader(Path(path)) as reader:
            frames = reader.count()
    yield f"{path}: {len(particles)} particles, {frames} frame{'s' * (frames != 1)}"
    yield f"  unit      {particles.unit or 'unknown'}"
    yield f"  box       {_box(particles)}"
    has = [name for name in ("radii", "colors", "bonds") if getattr(particles, name) is not None]
    yield f"  has       {', '.join(has) or 'no radii, colours or bonds'}"
    columns = particles.columns
    yield "  columns"
    for name in columns:
        yield f"    {_plain(name):16}{_column(columns[name])}"
    for text in dict.fromkeys(str(warning.message) for warning in said):
        yield f"  note      {_plain(text)}"


def _box(particles: "Particles") -> str:
    if particles.cell is None:
        return "none"
    edges = " ".join(f"({x:.6g}, {y:.6g}, {z:.6g})" for x, y, z in particles.cell)
    x, y, z = particles.origin
    return f"{edges} from ({x:.6g}, {y:.6g}, {z:.6g})"


def _column(column: Any) -> str:
    import numpy as np

    from clrt.particles.texts import Text

    if isinstance(column, Text):
        counts = np.bincount(column.which, minlength=len(column.kinds)).tolist()
        kinds = [f"{kind!r} {n}" for kind, n in zip(column.kinds, counts, strict=True)]
        more = [f"{len(kinds) - MANY} more"] if len(kinds) > MANY else []
        return ", ".join(map(_plain, kinds[:MANY] + more))
    if column.dtype == bool:
        return f"{np.count_nonzero(column)} of {len(column)}"
    finite = column[np.isfinite(column)]
    if not finite.size:
        return "nothing finite"
    missing = len(column) - finite.size
    rest = f", {missing} not finite" if missing else ""
    return f"{finite.min():.6g} to {finite.max():.6g}{rest}"


def _plain(text: str) -> str:
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)
