"""Resolved: a scene's files of particles as spheres of it."""

import operator
import os
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import msgspec
from msgspec.structs import replace

from clrt.errors import RequestError, SceneError
from clrt.figure import captions
from clrt.figure.styles import STYLES
from clrt.particles.particlefile import ParticleFile
from clrt.scene.capsules import Capsules
from clrt.scene.film import Film
from clrt.scene.scene import Scene
from clrt.scene.spheres import Spheres

if TYPE_CHECKING:
    from clrt.figure.representation import Representation


class Resolver:
    """Reads files of particles, and keeps the spheres of the last scene's. A scene that differs in
    other parts only gets the same spheres."""

    def __init__(self) -> None:
        self._key: Any = None
        self._own: Any = None
        self._made: tuple[Spheres, Capsules, Film] | None = None

    def scene(self, scene: Scene) -> Scene:
        """The scene, with its particles as spheres after its own.

        Raises:
            SceneError: a file cannot be read, or lacks a quantity that is to be drawn. The message
                names the entry of `particles`, the file and the expected value.
            OutputError: it does not fit into memory.
        """
        if not scene.particles:
            if "{" not in scene.film.label:
                return scene
            return captions.captioned(scene, {"frame": 0, "time": 0.0})
        key = scene.particles, [_state(one) for one in scene.particles], scene.film
        own = scene.spheres, scene.capsules
        same = self._own is not None and all(map(operator.is_, self._own, own))
        if key != self._key or not same or self._made is None:
            self._made = None  # the old goes before the new comes
            self._key, self._own, self._made = key, own, _read(scene)
        spheres, capsules, film = self._made
        used = (one.material for one in scene.particles)
        materials = {name: STYLES[name].material for name in used if name in STYLES}
        materials |= scene.materials
        return replace(
            scene,
            spheres=spheres,
            capsules=capsules,
            particles=(),
            materials=materials,
            film=film,
        )


def resolved(scene: Scene) -> Scene:
    """The scene, with its particles as spheres after its own: see Resolver."""
    return Resolver().scene(scene)


def _read(scene: Scene) -> tuple[Spheres, Capsules, Film]:
    """All its spheres and capsules, and its film with what its particles add to it."""
    # Imported late: scenes without particles do not need it.
    from clrt.figure.decoration import decorated

    label = scene.film.label
    parts = [_represented(i, one, label) for i, one in enumerate(scene.particles)]
    own = [Spheres.of(scene.spheres)] if len(scene.spheres) else []
    capsules = [Capsules.of(scene.capsules), *(part.capsules for part in parts if part.capsules)]
    capsules = [many for many in capsules if len(many)] or capsules[:1]
    try:
        film = decorated(scene.film, parts)
    except RequestError as error:
        raise SceneError(f"film.{error}") from None
    spheres = Spheres.joined([*own, *(part.spheres for part in parts)])
    return spheres, Capsules.joined(capsules), film


def _represented(i: int, one: ParticleFile, label: str) -> "Representation":
    from clrt.figure.representation import represented
    from clrt.files.particles.reader import read

    where = f"particles[{i}]"
    try:
        particles = read(one.file, one.frame)
    except RequestError as error:
        raise SceneError(f"{where}.file: {error}") from None
    drawn = msgspec.structs.asdict(one)
    del drawn["file"], drawn["frame"]
    try:
        return represented(particles, **drawn, label=label)
    except RequestError as error:
        raise SceneError(f"{where}.{error}, {one.file}") from None


def _state(one: ParticleFile) -> tuple[int, ...]:
    """Its inode, size and time: they tell a file that has changed."""
    with suppress(OSError):
        status = os.stat(one.file)
        return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns
    return ()
