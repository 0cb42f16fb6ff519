"""Subject: the scene or particles in view, and the words of the command line that name them."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from msgspec.structs import replace

from clrt.errors import RequestError
from clrt.figure import compose, sources, styles
from clrt.figure.compose import Look
from clrt.figure.framing import VIEWS
from clrt.figure.resolver import resolved
from clrt.files.particles.reader import read
from clrt.files.scenefile import as_scene
from clrt.motion.animation import Way, all_frames
from clrt.motion.trajectory import Flow
from clrt.particles.particles import Particles
from clrt.scene.camera import Camera
from clrt.scene.scene import Scene
from clrt.values import Array
from clrt.viewer import orbit
from clrt.viewer.thing import thing


def _moved(scene: Scene, camera: Camera) -> Scene:
    return replace(scene, camera=camera)


FRAME = (16, 9)
"""The shape of what `clrt render` makes of a scene."""


def _held(scene: Scene, size: orbit.Size, view: str | None, frame: orbit.Size = FRAME) -> Camera:
    camera = scene.camera
    if view is not None:
        camera = orbit.from_side(camera, VIEWS[view])
    return orbit.held(camera, frame, size)


def _nothing(frame: int, index: int) -> dict[str, Any]:
    return {}


@dataclass(frozen=True)
class Subject:
    """A scene, or one a frame."""

    words: Sequence[str]
    """Of `clrt render`, which draw it but for its camera, size and samples: its name first. None
    where it is no file."""
    at: Callable[[int], Scene]
    """The scene of a frame."""
    frames: int = 1
    fps: float = 30.0
    is_trajectory: bool = False
    """Its frames are those of a file, and the camera stays where it is from one to the next."""
    is_noted: bool = True
    """Whether a file that `clrt render` makes of it says so."""
    seen_by: Callable[[Scene, Camera], Scene] = _moved
    """A scene with another camera."""
    framed: Callable[[Scene, orbit.Size, str | None], Camera] = _held
    """The camera of one of its scenes that holds all in a picture of so many columns and rows; from
    one of clrt.figure.framing.VIEWS, if it is given."""
    values: Callable[[int, int], dict[str, Any]] = _nothing
    """The values of a frame's sphere in its file."""
    look: Mapping[str, str] = field(default_factory=dict)
    """How its particles are drawn, as the options of these names say it; none: it is no figure
    whose looks can be chosen."""
    columns: Sequence[str] = ()
    """That it can be coloured by."""
    capsules: str = "capsule"
    """What one of its capsules is."""
    drawn: "Callable[[str, str], Subject] | None" = None
    """The same with another value of one of `look`."""

    @property
    def is_figure(self) -> bool:
        """Whether it is drawn of particles or a mesh, as options say, `--center` among them."""
        return self.seen_by is styles.seen_by

    def described(self, scene: Scene, frame: int, index: int) -> dict[str, Any] | None:
        """What is told of the thing of an index: its place, size and material, and a sphere's
        values; None of -1, which is none."""
        found = thing(scene, index)
        if found is None:
            return None
        return found.about | (self.values(frame, index) if found.kind == "sphere" else {})


def of(source: Scene | str | Path, words: Sequence[str] = ()) -> Subject:
    """A scene, and the frames of its animation.

    Args:
        source: a scene, or what load_scene() takes.
        words: of `clrt render`, beside the name.

    Raises:
        SceneError: it cannot be read, or is not a scene.
    """
    given = as_scene(source)
    scene, is_noted = resolved(given) if given.particles else given, not given.particles
    words = () if isinstance(source, Scene) else (str(source), *words)
    if scene.animation is None:
        return Subject(words, lambda frame: scene, is_noted=is_noted)
    way = Way(scene)
    way.check(all_frames(scene))

    def at(frame: int) -> Scene:
        # A camera that is moved by hand may not suit its keys.
        return replace(way.scene(frame), animation=None)

    moves = scene.animation
    return Subject(words, at, moves.frames, moves.fps, is_noted=is_noted)


def of_file(
    path: Path,
    drawn: dict[str, Any],
    words: Sequence[str] = (),
    reading: Mapping[str, Any] = MappingProxyType({}),
) -> Subject:
    """A file of particles, and its frames. All are seen by the first one's camera, and a column's
    colours stand for the first one's values.

    Args:
        drawn: see clrt.figure.Look.
        words: of `clrt render`, beside the name and those of `drawn` and `reading`.
        reading: arguments of clrt.read().

    Raises:
        RequestError: it cannot be read, or lacks a quantity that is to be drawn.
    """
    look = sources.look(**drawn)
    flow = Flow(path, look, **reading)

    @lru_cache(1)
    def known(frame: int) -> tuple[Particles, Array | None]:
        return read(path, frame, **reading), flow.rows(frame)

    def values(frame: int, index: int) -> dict[str, Any]:
        particles, rows = known(frame)
        return _values(particles, index if rows is None else int(rows[index]))

    return Subject(
        (
            str(path),
            *words,
            *_options({**reading}),
            *_options(drawn | {"clim": flow.look.clim, "radius": flow.look.radius}),
        ),
        lru_cache(2)(flow.scene),
        len(flow.frames),
        is_trajectory=True,
        is_noted=False,
        seen_by=styles.seen_by,
        framed=lambda scene, size, view: flow.camera(size, view),
        values=values,
        look=_said(flow.look),
        columns=flow.columns,
        capsules=_capsules(flow.look),
        drawn=lambda key, value: of_file(path, _with(drawn, key, value), words, reading),
    )


def of_mesh(path: Path, drawn: dict[str, Any], words: Sequence[str] = ()) -> Subject:
    """A file of a mesh alone.

    Args:
        as of of_file().

    Raises:
        RequestError: it cannot be read, or something was given that is of particles.
    """
    look = sources.mesh_look(path, **drawn)
    made = compose.no_particles(look)
    scene = compose.scene_of(made, look, [], None)

    def framed(scene: Scene, size: orbit.Size, view: str | None) -> Camera:
        return compose.seen_in(made, look, [], None, scene.film, size, view)

    return Subject(
        (str(path), *words, *_options(drawn)),
        lambda frame: scene,
        is_noted=False,
        seen_by=styles.seen_by,
        framed=framed,
    )


def of_particles(particles: Particles, drawn: Mapping[str, Any] = MappingProxyType({})) -> Subject:
    """Particles that are no file.

    drawn: see clrt.figure.Look.

    Raises:
        RequestError: they lack a quantity that is to be drawn.
    """
    look = sources.look(**drawn)
    made = compose.drawn(particles, look)
    scene = compose.scene_of(made, look, made.parts, made.cell)

    def framed(scene: Scene, size: orbit.Size, view: str | None) -> Camera:
        return compose.seen_in(made, look, made.parts, made.cell, scene.film, size, view)

    def values(frame: int, index: int) -> dict[str, Any]:
        return _values(particles, index if made.rows is None else int(made.rows[index]))

    return Subject(
        (),
        lambda frame: scene,
        seen_by=styles.seen_by,
        framed=framed,
        values=values,
        look=_said(look),
        columns=tuple(particles.columns),
        capsules=_capsules(look),
        drawn=lambda key, value: of_particles(particles, _with(drawn, key, value)),
    )


def _said(look: Look) -> dict[str, str]:
    """The values of a look that a page can change."""
    clim = look.clim if isinstance(look.clim, tuple) else ()
    return {
        "style": look.style,
        "color": look.color or "",
        "cmap": look.cmap,
        "clim": " ".join(f"{one:g}" for one in clim),
        "select": look.select or "",
        "opacity": "" if look.opacity is None else str(look.opacity),
    }


def _capsules(look: Look) -> str:
    """What a capsule of particles is: with arrows, or edges of a box, it may be one of these."""
    return "bond" if look.vectors is None and look.cell != "solid" else "capsule"


def _with(drawn: Mapping[str, Any], key: str, value: str) -> dict[str, Any]:
    """What is drawn, with another value of a key; "" is none.

    Raises:
        RequestError: it is no value of that key.
    """
    given: Any = value.strip() or None
    if key == "clim" and given is not None:
        try:
            low, high = map(float, given.split())
        except ValueError:
            raise RequestError(f"clim: expected LO HI, got {given!r}") from None
        given = low, high
    fresh = {"clim": None} if key == "color" else {}  # the range was that of another column
    return {**drawn, **fresh, key: given}


def of_figure(scene: Scene, size: orbit.Size) -> Subject:
    """A scene that was made of particles, whose lights are a style's.

    size: of the picture that it was made for.
    """
    framed = partial(_held, frame=size)
    return Subject((), lambda frame: scene, seen_by=styles.seen_by, framed=framed)


def _values(particles: Particles, index: int) -> dict[str, Any]:
    columns = {**particles.values, **particles.texts}
    return {name: column[index].item() for name, column in columns.items()}


def _options(given: dict[str, Any]) -> Iterator[str]:
    """Options of the command line, as words."""
    for name, value in given.items():
        if value is not None and value is not False:
            yield f"--{name.replace('_', '-')}"
            if isinstance(value, dict):
                yield ",".join(f"{key}={one}" for key, one in value.items())
            elif value is not True:
                yield from map(str, value if isinstance(value, tuple) else [value])
