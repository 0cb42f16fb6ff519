"""Reference: true pictures in float64 of scenes, names and files; clrt/truth/ traces them."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from clrt.figure.resolver import resolved
from clrt.files.scenefile import as_scene
from clrt.scene.scene import Scene
from clrt.truth import tracer
from clrt.truth.tracer import Trace, Truth

__all__ = ["Trace", "Truth", "mean", "render", "trace"]


def render(
    scene: Scene | str | Path,
    width: int,
    height: int,
    truth: Truth = "exact",
    dtype: DTypeLike = np.float64,
) -> NDArray[Any]:
    """The true picture: (height, width, 3) of dtype, linear, not clipped. See trace()."""
    return trace(scene, width, height, truth, dtype).image


def trace(
    scene: Scene | str | Path,
    width: int,
    height: int,
    truth: Truth = "exact",
    dtype: DTypeLike = np.float64,
    *,
    pixels: Sequence[tuple[int, int]] | None = None,
    offset: tuple[float, float] = (0.0, 0.0),
) -> Trace:
    """The true picture and its paths.

    Args:
        scene: a scene, or what load_scene() takes.
        truth: "exact", or "seed": the paper to the letter.
        dtype: np.longdouble where float64 itself is in doubt.
        pixels: rows and columns of the pixels that are wanted, in whose order the trace's image is
            (n, 3) and its paths (n,); default: all of them.
        offset: where in its pixel each ray goes through: right and up of the middle, half pixels.

    Raises:
        SceneError: there is no such scene, or its particles cannot be read.
        RequestError: there is no such truth or pixel, or the truth does not know something of the
            scene.
    """
    complete = resolved(as_scene(scene))
    return tracer.trace(complete, width, height, truth, dtype, pixels=pixels, offset=offset)


def mean(scene: Scene, width: int, height: int, offsets: NDArray[Any]) -> NDArray[Any]:
    """The mean of true pictures, (height, width, 4): colours and alpha.

    offsets: (n, 2), where in its pixel each ray goes through, see trace().
    """
    return tracer.mean(resolved(scene), width, height, offsets)
