"""Trajectory: a file of particles as scenes, one a frame."""

from collections.abc import Generator, Iterable, Iterator, Sequence
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from msgspec.structs import replace

from clrt.errors import ClrtError, RequestError, named
from clrt.figure import compose, sources
from clrt.figure.compose import Look
from clrt.figure.decoration import decorated
from clrt.figure.meaning import Meaning, together
from clrt.figure.representation import Representation
from clrt.files.particles.reader import Reader, Source
from clrt.motion.animation import checked
from clrt.particles.particles import Particles
from clrt.pipeline import in_order
from clrt.scene.camera import Camera
from clrt.scene.scene import Scene
from clrt.scene.spheres import Spheres
from clrt.values import Array

LOOKED_AT = 10
"""Frames that say what colours mean."""
NONE = Spheres(np.zeros((0, 3)), 1.0, "")


def looked_at(frames: range, clim: Any) -> Sequence[int]:
    """The frames beside the first that say what colours mean.

    clim: "first": none; "all"; else LOOKED_AT with the first and the last, as far as there are.
    """
    if clim in ("first", "all"):
        return frames[1:] if clim == "all" else ()
    last = len(frames) - 1
    return sorted({round(k * last / (LOOKED_AT - 1)) for k in range(LOOKED_AT)} - {0})


class Flow:
    """The frames of a file of particles, all of them seen as the first one: by its camera, which
    holds its particles and, unless only some are selected, its box. Colours mean the same in all:
    their range and their legend are those of ten frames (`clim`: of the first, or of all).

    Args:
        source: a file's name, or several of a frame each, as clrt.read() takes them.
        look: how the particles are drawn.
        view_all: the camera holds the particles of all frames, which are read for that.
        reading: other arguments of clrt.read().

    Raises:
        RequestError: it cannot be read, or lacks a quantity that is to be drawn; it names the file.
        OutputError: a frame does not fit into memory.
    """

    fps = 30.0

    def __init__(
        self, source: Source, look: Look, *, view_all: bool = False, **reading: Any
    ) -> None:
        self.look = look
        self._opened = partial(Reader, source, **reading)
        with self._opened() as reader:
            self.path = path = Path(reader.name)
            self.frames = range(reader.count())
            """The numbers of its frames."""
            particles = self._particles(reader, 0)
            self.columns = tuple(particles.columns)
            """The names of what can be selected and coloured by, in the first frame."""
            first = self._drawn(particles)
            seen = [first, *self._looked_at(reader, first)]
        self._meaning = together([one.meaning for one in seen])
        # What gives the colours is in all frames what it is in the first.
        self.look = replace(
            look, color=look.color or (None if first.source.by == "one" else first.source.title)
        )  # fmt: skip
        if first.source.by == "column" and not isinstance(look.clim, tuple):
            self.look = replace(self.look, clim=self._meaning.clim or (0.0, 1.0))
        if look.radius is None and self._meaning.spare is not None:
            self.look = replace(self.look, radius=self._meaning.spare)
        """What was given, with what colours mean, and the radius that the first frame gives."""
        if len(seen) > 1:
            with self._opened() as reader:
                first = self._drawn(self._particles(reader, 0), self._meaning)
        parts = self._every() if view_all else first.parts
        # Particles go about in their box. Those of one frame, or some of them, do not.
        still = look.select is not None or look.hide is not None or len(self.frames) == 1
        with named(path):
            box = first.cell if still else first.box
            self._first = compose.scene_of(first, self.look, parts, box)
        self._seen = first, box
        # Each frame has its own.
        self._film = replace(self._first.film, cells=(), labels=(), label=look.label)
        self.said = sources.in_file(self._first, Path(path.name), 0, self.look)
        """The scene of the first frame, whose particles stay in their file."""

    def camera(self, size: tuple[int, int], view: str | None = None) -> Camera:
        """The camera that holds the first frame in a picture of so many columns and rows.

        view: None: where the look says.
        """
        first, box = self._seen
        return compose.seen_in(first, self.look, first.parts, box, self._first.film, size, view)

    def scene(self, frame: int) -> Scene:
        """The scene of a frame.

        Raises:
            as Flow().
        """
        if frame == 0:
            return self._first
        with self._opened() as reader:
            return self._scene(reader, frame)

    def scenes(self, frames: Iterable[int]) -> Generator[Scene, None, None]:
        """The scenes of some frames in turn; while the caller has one the next is read.

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
        made = self._drawn(self._particles(reader, frame), self._meaning)
        return replace(
            self._first,
            spheres=made.spheres,
            capsules=() if made.capsules is None else made.capsules,
            film=decorated(self._film, [made]),
        )

    def _every(self) -> Iterator[Spheres]:
        """The spheres of each frame."""
        with self._opened() as reader:
            for frame in self.frames:
                yield from self._drawn(self._particles(reader, frame), self._meaning).parts

    def _looked_at(self, reader: Reader, first: Representation) -> Iterator[Representation]:
        """The frames beside the first that say what colours mean."""
        clim = self.look.clim
        if first.source.by not in ("column", "element", "type", "text"):
            return
        if first.source.by == "column" and isinstance(clim, tuple):
            return
        for frame in looked_at(self.frames, clim):
            alone = Meaning(spare=first.meaning.spare)
            with suppress(ClrtError):  # it is told when the frame is rendered
                made = self._drawn(self._particles(reader, frame), alone)
                yield made._replace(spheres=NONE, rows=None, capsules=None, parts=[])

    def _particles(self, reader: Reader, frame: int) -> Particles:
        found = reader.frame(frame)
        if found is None:  # the file was cut meanwhile
            raise RequestError(f"{self.path}: expected {len(self.frames)} frames, got {frame}")
        return found

    def rows(self, frame: int) -> Array | None:
        """Which of a frame's particles each sphere is; None: the spheres are the particles.

        Raises:
            as Flow().
        """
        with self._opened() as reader:
            return self._drawn(self._particles(reader, frame), self._meaning).rows

    def _drawn(self, particles: Particles, meaning: Meaning | None = None) -> Representation:
        with named(self.path):
            return compose.drawn(particles, self.look, meaning)
