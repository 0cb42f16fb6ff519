"""Trajectory: a file of particles as scenes, one a frame."""

from collections.abc import Generator, Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

from msgspec.structs import replace

from clrt.errors import RequestError, named
from clrt.figure import compose, sources
from clrt.figure.coloring import Colored, box_of, decorated
from clrt.figure.compose import Look
from clrt.files.particles.reader import Reader, Source
from clrt.motion.animation import checked
from clrt.particles.particles import Particles
from clrt.pipeline import in_order
from clrt.scene.scene import Scene
from clrt.scene.spheres import Spheres


class Flow:
    """The frames of a file of particles, all of them seen as the first one: by its camera, which
    holds its box and its particles, with the range of its colours and its legend.

    Args:
        source: a file's name, or several of a frame each, as clrt.read() takes them.
        look: how the particles are drawn.
        view_all: the camera holds the particles of all frames, which are read for that.
        format: as of clrt.read().

    Raises:
        RequestError: it cannot be read, or has not what is to be drawn; it names the file.
        OutputError: a frame does not fit into memory.
    """

    fps = 30.0

    def __init__(
        self, source: Source, look: Look, *, view_all: bool = False, format: str | None = None
    ) -> None:
        self.look = look
        self._opened = partial(Reader, source, format)
        with self._opened() as reader:
            self.path = path = Path(reader.name)
            self.frames = range(reader.count())
            """The numbers of its frames."""
            first = self._particles(reader, 0)
        made = self._drawn(first)
        # Colours mean in all frames what they mean in the first.
        column = look.color if made.by == "column" else made.by
        self.look = replace(look, color=column, clim=look.clim or made.clim)
        """What was given, with the colours of the first frame."""
        parts = self._every() if view_all else [made.spheres]
        box = None if first.cell is None else box_of(first)
        with named(path):
            self._first = compose.scene_of(made, look, parts, box)
        self._film = replace(self._first.film, cells=())
        self.said = sources.in_file(self._first, Path(path.name), 0, self.look)
        """The scene of the first frame, whose particles stay in their file."""

    def scene(self, frame: int) -> Scene:
        """What a frame shows.

        Raises:
            as Flow().
        """
        if frame == 0:
            return self._first
        with self._opened() as reader:
            return self._scene(reader, frame)

    def scenes(self, frames: Iterable[int]) -> Generator[Scene, None, None]:
        """What some frames show, one after the other; while the caller has one the next is read.

        Raises:
            as Flow().
        """
        with self._opened() as reader:
            yield from in_order(partial(self._scene, reader), frames, 1)

    def check(self, frames: Iterable[int]) -> Sequence[int]:
        """Finds out whether there are such frames; returns them.

        Raises:
            RequestError: one is no number of a frame.
        """
        return checked(frames, self.frames)

    def _scene(self, reader: Reader, frame: int) -> Scene:
        made = self._drawn(self._particles(reader, frame))
        return replace(self._first, spheres=made.spheres, film=decorated(self._film, [made]))

    def _every(self) -> Iterator[Spheres]:
        """The spheres of each frame."""
        with self._opened() as reader:
            for frame in self.frames:
                yield self._drawn(self._particles(reader, frame)).spheres

    def _particles(self, reader: Reader, frame: int) -> Particles:
        found = reader.frame(frame)
        if found is None:  # the file was cut meanwhile
            raise RequestError(f"{self.path}: expected {len(self.frames)} frames, got {frame}")
        return found

    def _drawn(self, particles: Particles) -> Colored:
        with named(self.path):
            return compose.drawn(particles, self.look)
