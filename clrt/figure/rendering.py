"""Rendering: pictures of scenes. The names, files and particles of a scene are read here."""

from collections.abc import Callable, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypedDict, Unpack, overload

import numpy as np
from numpy.typing import DTypeLike, NDArray

from clrt.figure.resolver import Resolver
from clrt.files.scenefile import as_scene
from clrt.opencl.device import check_process
from clrt.renderer.checks import Passes, Region, check_passes, film_dtype
from clrt.renderer.engine import Engine
from clrt.renderer.pack.structs import Precision
from clrt.scene.scene import Scene

if TYPE_CHECKING:
    import pyopencl as cl

Array: TypeAlias = NDArray[Any]


class Options(TypedDict, total=False):
    """The options of render(), beside passes."""

    dtype: DTypeLike | None
    region: Region | None
    alpha: bool | None
    out: Array | None
    progress: Callable[[int], object] | None


class Renderer(Engine):
    """Renders scenes on one device, keeping compiled programs.

    Threads can share one, which renders one picture at a time, or have one each.

    Args:
        precision: "robust" (float32, the split formula), "literal" (float32, the paper's
            formulas as they stand) or "double" (float64).
        lanes: pixels that a work-item traces in lock step, one of LANES; default: 16 on a CPU,
            else 1. If a device cannot compile so many, fewer are taken, with a DeviceWarning.
        device: part of a device's or platform's name; default: the first CPU.
        threads: for PoCL, before OpenCL's first use in this process; default: every core.

    Raises:
        DeviceError: there is no such device, or it has no float64, which "double" needs.
    """

    @cached_property
    def _resolver(self) -> Resolver:
        return Resolver()

    @overload
    def render(
        self,
        scene: Scene | str | Path,
        width: int,
        height: int,
        *,
        passes: None = None,
        **options: Unpack[Options],
    ) -> Array: ...

    @overload
    def render(
        self,
        scene: Scene | str | Path,
        width: int,
        height: int,
        *,
        passes: Sequence[str],
        **options: Unpack[Options],
    ) -> tuple[Array, Passes]: ...

    def render(
        self,
        scene: Scene | str | Path,
        width: int,
        height: int,
        *,
        dtype: DTypeLike | None = None,
        region: Region | None = None,
        alpha: bool | None = None,
        passes: Sequence[str] | None = None,
        out: Array | None = None,
        progress: Callable[[int], object] | None = None,
    ) -> Array | tuple[Array, Passes]:
        """Renders a picture.

        Args:
            scene: a scene, or what load_scene() takes.
            width, height: of the whole picture, pixels.
            dtype: float32, the default, gives linear colours, not clipped; uint8 and uint16 give
                colours clipped to [0, 1] on the curve of the scene's film, times 255 or 65535,
                rounded.
            region: (x0, y0, x1, y1), the part of it that is wanted: columns x0 <= x < x1 and rows
                y0 <= y < y1, y from the top. It is equal, bit for bit, to that part of the whole.
            alpha: whether the picture has a fourth channel in place of the background: how much of
                a pixel shows something. Floats are then premultiplied, integers straight. Default:
                if `out` has four channels, or the scene's film is transparent.
            passes: which of "depth", "normal" and "id" are wanted beside it, at the pixels' middle.
            out: a film to fill, of the shape that is returned, float32, uint8 or uint16, of any
                strides.
            progress: called with the number of rows just finished. It may raise, which ends the
                picture.

        Returns:
            (height, width, 3 or 4) of dtype, or (y1 - y0, x1 - x0, 3 or 4): `out`, or an array of
            the caller's own, whose memory is taken again when nobody has a reference to it any
            more. With passes, that and a dict of them: "depth" (height, width) float32, world units
            along the ray, infinity where there is nothing; "normal" (height, width, 3) float32,
            outwards in the world, 0 where there is none; "id" (height, width) int32, the index of
            the sphere, after all of these the capsule or face, -1 where there is none.

        Raises:
            RequestError: there is no such scene, size, region, dtype or pass, or `out` is not so.
            OutputError: the film does not fit into memory.
            DeviceError: the device fails.
        """
        pixel, names = film_dtype(dtype, out), check_passes(passes)
        complete = self._complete(scene)
        if alpha is None:
            alpha = complete.film.transparent or (out is not None and out.shape[2:] == (4,))
        size = width, height
        image, found = self.picture(
            complete, size, pixel, bool(alpha), names, region, out, progress
        )
        return image if names is None else (image, found)

    def prepare(
        self,
        scene: Scene | str | Path,
        dtype: DTypeLike | None = None,
        *,
        alpha: bool | None = None,
        passes: Sequence[str] | None = None,
    ) -> None:
        """Compiles the programs that render() needs for such a scene."""
        super().prepare(self._complete(scene), dtype, alpha=alpha, passes=passes)

    def paths(self, scene: Scene | str | Path, width: int, height: int) -> NDArray[np.uint32]:
        """A hash of each pixel's path, (height, width), to compare with reference.trace()'s."""
        return super().paths(self._complete(scene), width, height)

    def _complete(self, scene: Scene | str | Path) -> Scene:
        """The scene, read if it is a name or a path, with its files of particles read."""
        check_process()  # before the lock, which a fork may have for ever
        with self._lock:
            return self._resolver.scene(as_scene(scene))


def render(
    scene: Scene | str | Path,
    width: int,
    height: int,
    *,
    dtype: DTypeLike | None = None,
    region: Region | None = None,
    alpha: bool | None = None,
    precision: Precision = "robust",
    lanes: int | None = None,
    device: "str | cl.Device | None" = None,
    threads: int | None = None,
) -> Array:
    """Renders one picture, see Renderer and its render().

    For more than one picture, or for passes, keep a Renderer, which compiles once.
    """
    with Renderer(precision=precision, lanes=lanes, device=device, threads=threads) as renderer:
        return renderer.render(scene, width, height, dtype=dtype, region=region, alpha=alpha)
