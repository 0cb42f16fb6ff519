"""Animation: a scene's camera on its way, and the frames that it sees."""

import operator
import threading
from collections.abc import Generator, Iterable, Iterator, Sequence
from concurrent.futures import CancelledError
from contextlib import closing, nullcontext
from typing import Any, Protocol

import numpy as np
from msgspec.structs import replace
from numpy.typing import DTypeLike, NDArray

from clrt.errors import RequestError, SceneError
from clrt.figure.captions import captioned
from clrt.figure.rendering import Renderer
from clrt.opencl.device import check_process
from clrt.pipeline import in_order
from clrt.scene.animation import Animation
from clrt.scene.camera import CAMERA_VECTORS, LENSES, Camera
from clrt.scene.scene import Scene

Array = NDArray[Any]


class Frames(Protocol):
    """Scenes by the numbers of frames."""

    @property
    def frames(self) -> range:
        """The numbers of the frames."""

    @property
    def fps(self) -> float:
        """Frames a second."""

    @property
    def said(self) -> Scene:
        """All that the frames' pictures depend on, but for the content of files."""

    def scene(self, frame: int) -> Scene:
        """The scene of a frame, whose camera does not move."""

    def scenes(self, frames: Iterable[int]) -> Generator[Scene, None, None]:
        """The scenes of some frames, one after the other."""

    def check(self, frames: Iterable[int]) -> Sequence[int]:
        """Finds out whether there are such frames; returns them."""


def animate(
    scene: "Scene | Frames",
    width: int,
    height: int,
    *,
    frames: Iterable[int] | None = None,
    dtype: DTypeLike | None = None,
    renderer: Renderer | None = None,
) -> Generator[Array, None, None]:
    """Renders the frames of a scene's animation, one after the other.

    While the caller works on a frame the next one is rendered. Frame k is the same picture whether
    it is rendered alone or in a row.

    Args:
        scene: one with an animation, or a clrt.motion.trajectory.Flow.
        frames: which ones; default: all.
        dtype: float32, uint8 or uint16, as for Renderer.render().
        renderer: default: one for the default device.

    To close the generator stops the picture that is under way at once.

    Yields:
        (height, width, 3) of dtype, or 4 if the scene's film is transparent, an array of its own
        each.

    Raises:
        SceneError: the scene has no animation, or its camera cannot be at some frame.
        RequestError: it has no such frame.
    """
    way = Way(scene) if isinstance(scene, Scene) else scene
    chosen = way.check(way.frames if frames is None else frames)

    def rendered() -> Generator[Array, None, None]:
        own = Renderer() if renderer is None else nullcontext(renderer)
        stopped = threading.Event()

        def stop(rows: int) -> None:
            if stopped.is_set():
                raise CancelledError

        def film(shown: Scene) -> Array:
            return used.render(shown, width, height, dtype=dtype, progress=stop)

        def due() -> Iterator[int]:
            for k in chosen:
                check_process()  # a fork has not the thread
                yield k

        with own as used, closing(way.scenes(due())) as scenes:
            films = in_order(film, scenes, 1)
            try:
                # Not `yield from`: closed, that would first wait for those that are still to come.
                for picture in films:  # noqa: UP028
                    yield picture
            finally:
                stopped.set()
                films.close()

    return rendered()


def checked(frames: Iterable[int], every: range) -> Sequence[int]:
    """The numbers of some frames.

    Raises:
        RequestError: one is no number of a frame.
    """
    chosen = frames if isinstance(frames, range) else list(frames)
    ends = [chosen[0], chosen[-1]] if isinstance(chosen, range) and chosen else chosen
    for frame in ends:
        try:
            good = operator.index(frame) in every
        except TypeError:
            good = False
        if not good:
            raise RequestError(f"frames: expected whole numbers from 0 to {every[-1]}, got {frame}")
    return chosen


def all_frames(scene: Scene) -> range:
    """The numbers of an animation's frames."""
    return range(_animation(scene).frames)


def camera_at(scene: Scene, frame: int) -> Camera:
    """The camera of a frame, see Way.

    Raises:
        SceneError: the scene has no animation, or no camera can be there.
    """
    return Way(scene).camera(frame)


class Way:
    """The way of a scene's camera: the scene of each frame.

    Between keys "linear" goes straight. "smooth" is a Catmull-Rom spline (Catmull & Rom, 1974) for
    keys at uneven frames: at each key it moves as the line from the key before to the key after,
    and at the ends of a path that is no loop as the line to the only neighbour. Before the first
    and after the last key the camera stands still.

    Raises:
        SceneError: the scene has no animation.
    """

    CHUNK = 1 << 16  # frames that are checked at a time: 10 MB

    def __init__(self, scene: Scene) -> None:
        animation = _animation(scene)
        self.said = scene
        self.frames = range(animation.frames)
        """The numbers of its frames."""
        self.fps = animation.fps
        self._smooth = animation.interpolation == "smooth"
        self._at = np.array([key.frame for key in animation.keys], float)
        self._lens = LENSES[scene.camera.projection]
        for lens in set(LENSES.values()) - {self._lens}:
            for i, key in enumerate(animation.keys):
                if getattr(key, lens) is not None:
                    expected = f"none: the camera is {scene.camera.projection}"
                    raise SceneError(f"animation.keys[{i}].{lens}: expected {expected}")
        self._values = {name: _values(scene, name) for name in (*CAMERA_VECTORS, self._lens)}
        loop = all(np.array_equal(values[0], values[-1]) for values in self._values.values())
        self._slopes = {
            name: _slopes(self._at, values, loop) for name, values in self._values.items()
        }

    def scene(self, frame: int) -> Scene:
        """The scene of a frame, whose camera does not move.

        Raises:
            SceneError: no camera can be there.
        """
        found = replace(self.said, camera=self.camera(frame))
        if "{" not in found.film.label or found.particles:
            return found
        return captioned(found, {"frame": frame, "time": frame / self.fps})

    def scenes(self, frames: Iterable[int]) -> Generator[Scene, None, None]:
        """The scenes of some frames, one after the other."""
        return (self.scene(frame) for frame in frames)

    def camera(self, frame: int) -> Camera:
        """The camera of a frame.

        Raises:
            SceneError: no camera can be there.
        """
        moved = {
            name: float(value[0, 0]) if name == self._lens else tuple(map(float, value[0]))
            for name, value in self._moved(np.array([frame], float)).items()
        }
        try:
            return replace(self.said.camera, **moved)
        except ValueError as error:
            raise SceneError(f"animation, frame {frame}: camera.{error}") from None

    def check(self, frames: Iterable[int]) -> Sequence[int]:
        """Finds out, before hours of work, whether there are such frames; returns them.

        Raises:
            RequestError: one is no number of a frame.
            SceneError: no camera can be at one of them.
        """
        chosen = checked(frames, self.frames)
        for start in range(0, len(chosen), self.CHUNK):
            chunk = np.asarray(chosen[start : start + self.CHUNK])
            with np.errstate(all="ignore"):
                moved = self._moved(chunk.astype(float))
                lens, widest = moved[self._lens][:, 0], 180 if self._lens == "fov" else np.inf
                doubtful = ~(_surely_good(moved) & (lens > 0) & (lens < widest))
            for frame in chunk[doubtful]:
                self.camera(int(frame))
        return chosen

    def _moved(self, frames: Array) -> dict[str, Array]:
        """The camera's moving values at each frame: (frames, 3), or (frames, 1) of its lens."""
        now = np.clip(frames, self._at[0], self._at[-1])
        i = np.minimum(np.searchsorted(self._at, now, "right") - 1, len(self._at) - 2)
        span = (self._at[i + 1] - self._at[i])[:, np.newaxis]
        u = (now - self._at[i])[:, np.newaxis] / span
        moved = {}
        for name, values in self._values.items():
            start, end = values[i], values[i + 1]
            if self._smooth:
                # Cubic Hermite: through both keys, with these slopes there.
                leaves, arrives = self._slopes[name][i], self._slopes[name][i + 1]
                moved[name] = (
                    (1 + 2 * u) * (1 - u) ** 2 * start
                    + u**2 * (3 - 2 * u) * end
                    + span * u * (1 - u) * ((1 - u) * leaves - u * arrives)
                )
            else:
                moved[name] = (1 - u) * start + u * end
        return moved


def _surely_good(moved: dict[str, Array]) -> Array:
    """Where a camera can stand and look by far, (frames,). The few others are tried in turn."""
    ahead = moved["look_at"] - moved["position"]
    up = moved["up"]
    lengths = np.linalg.norm(ahead, axis=1) * np.linalg.norm(up, axis=1)
    sine = np.linalg.norm(np.cross(ahead, up), axis=1) / lengths  # NaN is no more than anything
    good: Array = np.isfinite(lengths) & (lengths > 0) & (sine > 1e-6)
    return good


def _animation(scene: Scene) -> Animation:
    if scene.animation is None:
        raise SceneError("animation: expected a table, got none: see docs/video.md")
    return scene.animation


def _values(scene: Scene, name: str) -> Array:
    """The keys' values of a part of the camera: (keys, 3), or (keys, 1) of its lens."""
    default = getattr(scene.camera, name)
    given = [getattr(key, name) for key in _animation(scene).keys]
    return np.array([default if v is None else v for v in given], float).reshape(len(given), -1)


def _slopes(at: Array, values: Array, loop: bool) -> Array:
    """The change per frame at each key, like values."""
    if loop:  # the keys beside the first, which is the last as well
        at = np.concatenate([[at[0] - (at[-1] - at[-2])], at, [at[-1] + at[1] - at[0]]])
        values = np.concatenate([values[-2:-1], values, values[1:2]])
    else:
        at, values = np.pad(at, 1, "edge"), np.pad(values, ((1, 1), (0, 0)), "edge")
    slopes: Array = (values[2:] - values[:-2]) / (at[2:] - at[:-2])[:, np.newaxis]
    return slopes
