"""Resolved: a scene's files of particles as spheres of it."""

import os
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import msgspec
from msgspec.structs import replace

from clrt.errors import RequestError, SceneError
from clrt.figure.styles import STYLES
from clrt.particles.particlefile import ParticleFile
from clrt.scene.film import Film
from clrt.scene.scene import Scene
from clrt.scene.spheres import Spheres

if TYPE_CHECKING:
    from clrt.figure.coloring import Colored


class Resolver:
    """Reads files of particles, and keeps the spheres of the last scene's. A scene that differs in
    other parts only gets the same spheres."""

    def __init__(self) -> None:
        self._key: Any = None
        self._own: Any = None
        self._made: tuple[Spheres, Film] | None = None

    def scene(self, scene: Scene) -> Scene:
        """The scene, with its particles as spheres after its own.

        Raises:
            SceneError: a file cannot be read, or lacks a quantity that is to be drawn. The message
                names the entry of `particles`, the file and the expected value.
            OutputError: it does not fit into memory.
        """
        if not scene.particles:
            return scene
        key = scene.particles, [_state(one) for one in scene.particles], scene.film
        if key != self._key or self._own is not scene.spheres or self._made is None:
            self._made = None  # the old goes before the new comes
            self._key, self._own, self._made = key, scene.spheres, _read(scene)
        spheres, film = self._made
        used = (one.material for one in scene.particles)
        materials = {name: STYLES[name].material for name in used if name in STYLES}
        materials |= scene.materials
        return replace(scene, spheres=spheres, particles=(), materials=materials, film=film)


def resolved(scene: Scene) -> Scene:
    """The scene, with its particles as spheres after its own: see Resolver."""
    return Resolver().scene(scene)


def _read(scene: Scene) -> tuple[Spheres, Film]:
    """All its spheres, and its film with the boxes, range and legend of its particles."""
    from clrt.figure.coloring import (
        decorated,
    )  # imported late: scenes without particles need it not

    parts = [_colored(i, one) for i, one in enumerate(scene.particles)]
    own = [Spheres.of(scene.spheres)] if len(scene.spheres) else []
    try:
        film = decorated(scene.film, parts)
    except RequestError as error:
        raise SceneError(f"film.{error}") from None
    return Spheres.joined([*own, *(part.spheres for part in parts)]), film


def _colored(i: int, one: ParticleFile) -> "Colored":
    from clrt.figure.coloring import colored
    from clrt.files.particles.reader import read

    where = f"particles[{i}]"
    try:
        particles = read(one.file, one.frame)
    except RequestError as error:
        raise SceneError(f"{where}.file: {error}") from None
    drawn = msgspec.structs.asdict(one)
    del drawn["file"], drawn["frame"]
    try:
        return colored(particles, **drawn)
    except RequestError as error:
        raise SceneError(f"{where}.{error}, {one.file}") from None


def _state(one: ParticleFile) -> tuple[int, ...]:
    """Its inode, size and time: they tell a file that has changed."""
    with suppress(OSError):
        status = os.stat(one.file)
        return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns
    return ()
