"""Surfaces: files of meshes as scenes, one a frame."""

from collections.abc import Generator, Iterable, Sequence
from typing import Any

from msgspec.structs import replace

from clrt.figure import compose, sources
from clrt.figure.captions import captioned
from clrt.figure.compose import Look
from clrt.figure.meaning import joint
from clrt.files.meshes.reader import is_mesh
from clrt.files.particles import series
from clrt.motion.animation import checked
from clrt.motion.trajectory import looked_at
from clrt.pipeline import in_order
from clrt.scene.scene import Scene


def are_meshes(names: Sequence[str]) -> bool:
    """Whether these are files of meshes, or patterns of their names as surface.*.ply."""
    paths = [path for name in names for path in series.files_of(name)]
    return len(paths) > 0 and all(map(is_mesh, paths))


class Surfaces:
    """Meshes as frames, a file each, in the order of the numbers in their names. All are seen by
    the camera and in the light of the first. Colours of numbers mean the same in all: their range
    is that of ten frames (`clim`: of the first, or of all).

    Args:
        names: of the files, or patterns of them.
        look: as of clrt.figure.sources.mesh_look().

    Raises:
        RequestError: as mesh_look(), of any frame that is read.
    """

    fps = 30.0

    def __init__(self, names: Sequence[str], **look: Any) -> None:
        self._paths = series.in_order(path for name in names for path in series.files_of(name))
        self.frames = range(len(self._paths))
        """The numbers of the frames."""
        self._given, asked = look, look.get("clim")
        first = self._look(0)
        if first.mesh is not None and first.mesh.clim is not None and not isinstance(asked, tuple):
            ends = [first.mesh.clim]
            for frame in looked_at(self.frames, asked):
                mesh = self._look(frame).mesh
                if mesh is not None and mesh.clim is not None:
                    ends.append(mesh.clim)
            self._given = look | {"clim": joint(ends)}
            first = self._look(0)
        self._first = compose.mesh_scene(first)
        self.said = replace(self._first, meshes=())
        """The scene of the first frame, whose mesh stays in its file."""

    def _look(self, frame: int) -> Look:
        return sources.mesh_look(self._paths[frame], **self._given)

    def scene(self, frame: int) -> Scene:
        """The scene of a frame.

        Raises:
            RequestError: it cannot be read.
        """
        found = self._first
        if frame:
            made = compose.mesh_scene(self._look(frame))
            found = replace(found, meshes=made.meshes, materials=made.materials)
        return captioned(found, {"frame": frame, "time": frame / self.fps})

    def scenes(self, frames: Iterable[int]) -> Generator[Scene, None, None]:
        """The scenes of some frames in turn; while the caller has one the next is read."""
        yield from in_order(self.scene, frames, 1)

    def check(self, frames: Iterable[int]) -> Sequence[int]:
        """Finds out whether there are such frames; returns them.

        Raises:
            RequestError: one is no number of a frame.
        """
        return checked(frames, self.frames)
