"""Animation: a scene's camera on its way, and the frames that it sees."""

import threading
from collections.abc import Generator, Iterable
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import nullcontext
from functools import partial
from typing import Any

import numpy as np
from msgspec.structs import replace
from numpy.typing import DTypeLike, NDArray

from clrt.device import check_process
from clrt.errors import SceneError
from clrt.renderer import Renderer
from clrt.scene import MOVING, Animation, Camera, Scene

Array = NDArray[Any]


def animate(
    scene: Scene,
    width: int,
    height: int,
    *,
    frames: Iterable[int] | None = None,
    dtype: DTypeLike = np.float32,
    renderer: Renderer | None = None,
) -> Generator[Array, None, None]:
    """Renders the frames of a scene's animation, one after the other.

    While the caller works on a frame the next one is rendered. Frame k is the same picture whether
    it is rendered alone or in a row.

    Args:
        frames: which ones; default: all.
        dtype: float32 or uint8, as for Renderer.render().
        renderer: default: one for the default device.

    To close what is returned stops at once what is under way.

    Yields:
        (height, width, 3) of dtype, an array of its own each.

    Raises:
        SceneError: the scene has no animation, or its camera cannot be at some frame.
    """
    # All at once, so that an impossible one is found before hours of work.
    cameras = [camera_at(scene, k) for k in (all_frames(scene) if frames is None else frames)]

    def rendered() -> Generator[Array, None, None]:
        own = Renderer() if renderer is None else nullcontext(renderer)
        stopped = threading.Event()

        def stop(rows: int) -> None:
            if stopped.is_set():
                raise CancelledError

        with own as used, ThreadPoolExecutor(1) as ahead:
            render = partial(used.render, width=width, height=height, dtype=dtype, progress=stop)
            under_way = None
            try:
                for camera in cameras:
                    check_process()  # a fork has not the thread
                    submitted = ahead.submit(render, replace(scene, camera=camera))
                    if under_way is not None:
                        yield under_way.result()
                    under_way = submitted
                if under_way is not None:
                    yield under_way.result()
            finally:  # nobody wants those that are still to come
                stopped.set()
                ahead.shutdown(cancel_futures=True)

    return rendered()


def all_frames(scene: Scene) -> range:
    """The numbers of an animation's frames."""
    return range(_animation(scene).frames)


def camera_at(scene: Scene, frame: int) -> Camera:
    """The camera of a frame.

    Between keys "linear" goes straight. "smooth" is a Catmull-Rom spline (Catmull & Rom, 1974) for
    keys at uneven frames: at each key it moves as the line from the key before to the key after,
    and at the ends of a path that is no loop as the line to the only neighbour. Before the first
    and after the last key the camera stands still.

    Raises:
        SceneError: the scene has no animation, or no camera can be there.
    """
    animation = _animation(scene)
    at = np.array([key.frame for key in animation.keys], float)
    now = np.clip(frame, at[0], at[-1])
    i = min(int(np.searchsorted(at, now, "right")) - 1, len(at) - 2)
    span = at[i + 1] - at[i]
    u = (now - at[i]) / span
    moved: dict[str, Any] = {}
    path = {name: _values(scene, name) for name in MOVING}
    loop = all(np.array_equal(values[0], values[-1]) for values in path.values())
    for name, values in path.items():
        start, end = values[i], values[i + 1]
        if animation.interpolation == "linear":
            value = (1 - u) * start + u * end
        else:
            slope = _slopes(at, values, loop)
            # Cubic Hermite: through both keys, with these slopes there.
            value = (
                (1 + 2 * u) * (1 - u) ** 2 * start
                + u**2 * (3 - 2 * u) * end
                + span * u * (1 - u) * ((1 - u) * slope[i] - u * slope[i + 1])
            )
        moved[name] = float(value[0]) if name == "fov" else tuple(map(float, value))
    try:
        return replace(scene.camera, **moved)
    except ValueError as error:
        raise SceneError(f"animation, frame {frame}: camera.{error}") from None


def _animation(scene: Scene) -> Animation:
    if scene.animation is None:
        raise SceneError("animation: expected a table, got none: see README, Video")
    return scene.animation


def _values(scene: Scene, name: str) -> Array:
    """What the keys say of a part of the camera: (keys, 3), or (keys, 1) of fov."""
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
