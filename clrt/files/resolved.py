"""Resolved: a scene's files of particles as spheres of it."""

import os
from contextlib import suppress
from typing import Any

from msgspec.structs import replace

from clrt.errors import RequestError, SceneError
from clrt.particlefile import MATTE, ParticleFile
from clrt.scene import Scene
from clrt.spheres import Spheres
from clrt.styles import STYLES


class Resolver:
    """Reads files of particles, and keeps what it made of those of the last scene: it is the same
    for a scene of which other parts were changed."""

    def __init__(self) -> None:
        self._key: Any = None
        self._own: Any = None
        self._spheres: Spheres | None = None

    def scene(self, scene: Scene) -> Scene:
        """The scene, with its particles as spheres after its own.

        Raises:
            SceneError: a file cannot be read, or has not what is to be drawn; it names the entry of
                `particles`, the file and what was expected.
            OutputError: it does not fit into memory.
        """
        if not scene.particles:
            return scene
        key = scene.particles, [_state(one) for one in scene.particles]
        if key != self._key or self._own is not scene.spheres or self._spheres is None:
            self._key = self._spheres = None  # the old go before the new come
            parts = [Spheres.of(scene.spheres)] if len(scene.spheres) else []
            parts += [_spheres(i, one) for i, one in enumerate(scene.particles)]
            self._key, self._own, self._spheres = key, scene.spheres, Spheres.joined(parts)
        materials = scene.materials
        if any(one.material == MATTE for one in scene.particles):
            materials = {MATTE: STYLES[MATTE].material} | materials
        return replace(scene, spheres=self._spheres, particles=(), materials=materials)


def resolved(scene: Scene) -> Scene:
    """The scene, with its particles as spheres after its own: see Resolver."""
    return Resolver().scene(scene)


def _spheres(i: int, one: ParticleFile) -> Spheres:
    from clrt.coloring import colored  # what scenes without particles have no need of
    from clrt.files.particles.reader import read

    where = f"particles[{i}]"
    try:
        particles = read(one.file, one.frame)
    except RequestError as error:
        raise SceneError(f"{where}.file: {error}") from None
    try:
        return colored(
            particles,
            material=one.material,
            radius=one.radius,
            scale=one.scale,
            color=one.color,
            cmap=one.cmap,
            clim=one.clim,
        ).spheres
    except RequestError as error:
        raise SceneError(f"{where}.{error}, {one.file}") from None


def _state(one: ParticleFile) -> tuple[int, ...]:
    """Which tells a file that has changed."""
    with suppress(OSError):
        status = os.stat(one.file)
        return status.st_dev, status.st_ino, status.st_size, status.st_mtime_ns
    return ()
