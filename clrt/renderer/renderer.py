"""Renderer: a device, its programs and a scene's buffers, which together make a film."""

import operator
import threading
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias, TypedDict, Unpack, overload

import numpy as np
from msgspec.structs import replace
from numpy.typing import DTypeLike, NDArray

from clrt import storage
from clrt.errors import DeviceError, DeviceWarning, LinkError, RequestError
from clrt.figure.resolver import Resolver
from clrt.files.scenefile import as_scene
from clrt.film import develop
from clrt.film.decor import decorations
from clrt.opencl import pocl, program
from clrt.opencl.device import check_process, find_device, label
from clrt.renderer import pack
from clrt.renderer.dispatch import Exposer, Program, quiet
from clrt.renderer.pack import LANES, PRECISIONS, Features, FilmKind, Precision
from clrt.scene.scene import Scene

if TYPE_CHECKING:
    import pyopencl as cl

Region: TypeAlias = tuple[int, int, int, int]
Array: TypeAlias = NDArray[Any]
Passes: TypeAlias = dict[str, Array]
MAX_SIDE = 1 << 24  # pixels of a row or a column that float32 can number


class Options(TypedDict, total=False):
    """What render() takes beside a scene, a size and passes."""

    dtype: DTypeLike | None
    region: Region | None
    alpha: bool | None
    out: Array | None
    progress: Callable[[int], object] | None


class Renderer(AbstractContextManager["Renderer"]):
    """Renders scenes on one device, keeping what was compiled.

    Threads can share one, which renders one picture at a time, or have one each.

    Args:
        precision: "robust" (float32, the split formula), "literal" (float32, the paper's
            formulas as they stand) or "double" (float64).
        lanes: pixels that a work-item traces in lock step, one of LANES; default: 16 on a CPU,
            else 1. If a device cannot compile so many, fewer are taken, with a DeviceWarning.
        device: part of a device's or platform's name; default: the first CPU.
        threads: for PoCL, before OpenCL's first use in this process; default: every core.

    Raises:
        DeviceError: there is no such device, or it lacks what `precision` needs.
    """

    def __init__(
        self,
        *,
        precision: Precision = "robust",
        lanes: int | None = None,
        device: "str | cl.Device | None" = None,
        threads: int | None = None,
    ) -> None:
        if precision not in PRECISIONS:
            raise RequestError(f"precision: expected one of {list(PRECISIONS)}, got {precision!r}")
        if lanes is not None and lanes not in LANES:
            raise RequestError(f"lanes: expected one of {list(LANES)}, got {lanes!r}")
        check_process()
        if device is None or isinstance(device, str):
            device = find_device(device, threads)
        import pyopencl as cl  # after find_device, which prepares its environment

        self.device = device
        self.precision = precision
        self.real = PRECISIONS[precision]
        if self.real is np.float64 and device.native_vector_width_double == 0:
            raise DeviceError(f"{label(device)} has no float64, which precision double needs")
        self.lanes = lanes or default_lanes(device)
        widest = pocl.NARROW // np.dtype(self.real).itemsize
        if pocl.is_narrow(device) and self.lanes > widest:
            self._narrow(widest, "PoCL could not be told which CPU to compile for")
        with self._errors():
            self._context = cl.Context([device])
            self._queue = cl.CommandQueue(
                self._context, properties=cl.command_queue_properties.PROFILING_ENABLE
            )
        self._programs: dict[Features, dict[str, cl.Kernel]] = {}
        self._exposer = Exposer(self._queue, precision)
        self._resolver = Resolver()
        self._lock = threading.RLock()  # a kernel has its arguments until it is enqueued
        self.kernel_seconds = 0.0
        """How long kernels ran for the last picture, by the device's own clock."""

    def __exit__(self, *error: object) -> None:
        self.close()

    def close(self) -> None:
        """Waits for the device and lets go of it."""
        with self._lock:
            self._exposer.close()
            self._programs.clear()

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """OpenCL's, as ours."""
        import pyopencl as cl

        try:
            yield
        except cl.Error as error:
            raise DeviceError(f"{label(self.device)} cannot do this: {error}") from None

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
                a pixel shows a sphere. Floats are then premultiplied, integers straight. Default:
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
            the sphere, -1 where there is none.

        Raises:
            RequestError: there is no such scene, size, region, dtype or pass, or `out` is not so.
            OutputError: the film does not fit into memory.
            DeviceError: the device fails.
        """
        check_process()
        scene = as_scene(scene)
        pixel, names = film_dtype(dtype, out), check_passes(passes)
        if alpha is None:
            alpha = scene.film.transparent or (out is not None and out.shape[2:] == (4,))
        with self._lock, self._errors():
            scene = self._resolver.scene(scene)
            image, found = self._picture(
                scene, (width, height), pixel, bool(alpha), names, region, out, progress
            )
        return image if names is None else (image, found)

    def paths(self, scene: Scene, width: int, height: int) -> NDArray[np.uint32]:
        """A hash of each pixel's path, (height, width), to compare with reference.trace()'s."""
        check_process()
        with self._lock, self._errors():
            box = 0, 0, *check_size(width, height)
            scene = self._resolver.scene(scene)
            used = self._programs_of(scene, "paths")
            arguments = self._exposer.arguments(scene, width, height, used[0], self.kernel_seconds)
            exposed, self.kernel_seconds = self._exposer.exposed(
                used, scene, arguments, (width, height), box
            )
            return exposed[..., 0]

    def _picture(
        self,
        scene: Scene,
        size: tuple[int, int],
        dtype: np.dtype[Any],
        alpha: bool,
        names: Sequence[str] | None,
        region: Region | None,
        out: Array | None,
        progress: Callable[[int], object] | None,
    ) -> tuple[Array, Passes]:
        width, height = check_size(*size)
        box = left, top, right, bottom = check_region(region, width, height)
        shape = bottom - top, right - left, 3 + alpha
        if out is not None and (out.shape != shape or not out.flags.writeable):
            raise RequestError(f"out: expected a writeable array of {shape}, got {out.shape}")
        kinds = exposures(scene, dtype, alpha, names)
        programs = {kind: self._programs_of(scene, kind) for kind in kinds}
        own = programs[kinds[0]]
        arguments = self._exposer.arguments(scene, width, height, own[0], self.kernel_seconds)
        seconds, found, seen = 0.0, {}, None

        def expose(used: Sequence[Program], box: Region, **options: Any) -> tuple[Array, float]:
            return self._exposer.exposed(used, scene, arguments, size, box, **options)

        def grown(pixels: int) -> tuple[Region, tuple[slice, slice]]:
            """The box with so many more around it, and where in that it lies."""
            x0, y0 = max(left - pixels, 0), max(top - pixels, 0)
            inside = np.s_[top - y0 : bottom - y0, left - x0 : right - x0]
            return (x0, y0, min(right + pixels, width), min(bottom + pixels, height)), inside

        reach = noise(scene)
        if "passes" in programs:
            around, inside = grown(max(develop.halo(scene.film, scene.samples), reach))
            looks, seconds = expose(
                programs["passes"], around, use="passes", progress=quiet(progress)
            )
            looks = looks[..., 0]
            found = {name: looks[inside][name].copy() for name in names or ()}
            radius = self._exposer.world(scene).spheres.radius
            seen = develop.Seen(looks["id"], looks["depth"], radius, inside, scene.samples)
        if "alpha" in programs and (reach or develop.has_steps(scene.film, dtype, alpha)):
            around, inside = grown(reach)
            exposed, more = expose(own, around, use="exposed", progress=progress)
            if seen is not None and reach:
                x, y = (
                    seen.picture[1].start - inside[1].start,
                    seen.picture[0].start - inside[0].start,
                )
                near = seen.sphere[y : y + len(exposed), x : x + exposed.shape[1]]
                exposed = develop.denoised(exposed, near, reach)[inside]
            image = self._exposer.blank(shape, dtype) if out is None else out
            depth = None if seen is None else seen.depth[seen.picture]
            marks = decorations.marks(scene, size, box, alpha, depth)
            develop.develop(exposed, scene.film, image, seen, marks)
        else:
            image, more = expose(own, box, out=out, progress=progress)
        self.kernel_seconds = seconds + more
        return image, found

    def prepare(
        self,
        scene: Scene,
        dtype: DTypeLike | None = None,
        *,
        alpha: bool | None = None,
        passes: Sequence[str] | None = None,
    ) -> None:
        """Compiles what render() will need for such a scene, if it is not compiled yet."""
        check_process()
        alpha = scene.film.transparent if alpha is None else alpha
        with self._lock, self._errors():
            scene = self._resolver.scene(scene)
            for kind in exposures(scene, film_dtype(dtype), alpha, check_passes(passes)):
                self._programs_of(scene, kind)

    def _programs_of(self, scene: Scene, kind: FilmKind) -> list[Program]:
        """A film's programs, one after the other."""
        return [self._program(scene, kind, stage) for stage in pack.stages(scene, kind)]

    def _program(self, scene: Scene, kind: FilmKind, stage: pack.Stage) -> Program:
        """The program for a scene; if none of so many lanes works, one of fewer."""
        needed = pack.features(self._exposer.world(scene), scene, self.lanes, kind, stage)
        while needed not in self._programs:
            try:
                made = _made(self._context, self.device, needed)
                self._programs[needed] = program.kernels(made)
            except DeviceError as error:
                narrower = [n for n in LANES if n < self.lanes]
                if not narrower or isinstance(error, LinkError):
                    raise DeviceError(f"{label(self.device)} cannot be used: {error}") from None
                self._narrow(narrower[-1], str(error))
                needed = replace(needed, lanes=self.lanes)
        return needed, self._programs[needed]

    def _narrow(self, lanes: int, why: str) -> None:
        self.lanes, before = lanes, self.lanes
        message = f"{label(self.device)}: {before} lanes cannot be used, {lanes} are: {why}"
        warnings.warn(message, DeviceWarning, stacklevel=2)


def _made(context: "cl.Context", device: "cl.Device", needed: Features) -> "cl.Program":
    """From the cache; else it is compiled, tried and kept.

    Raises:
        DeviceError: it has not passed its trial.
    """
    import pyopencl as cl

    source = program.kernel_source()
    path = program.cache_path(device, source, needed.options)
    if (binary := storage.kept(path)) is not None:
        with suppress(cl.Error):  # it is refused, as by another build of the same version
            return program.loaded(context, device, binary)
    from clrt.renderer import trial

    binary = trial.tried(device, source, needed)
    storage.keep(path, binary)
    return program.loaded(context, device, binary)


def default_lanes(device: "cl.Device") -> int:
    """16 on a CPU whatever its vectors' width: wider packets than those have more to do at a time,
    which hides latency (benchmarks/NOTES.md)."""
    import pyopencl as cl

    return max(LANES) if device.type & cl.device_type.CPU else 1


def exposures(
    scene: Scene, dtype: np.dtype[Any], alpha: bool, passes: Sequence[str] | None
) -> list[FilmKind]:
    """The films that kernels must make for a picture, its own first."""
    look, reach = scene.film, noise(scene)
    plain: FilmKind = "float" if dtype == np.float32 else "bytes"
    own: FilmKind = "alpha" if alpha or reach or develop.has_steps(look, dtype, alpha) else plain
    return [own, "passes"] if passes or reach or develop.needs_passes(look) else [own]


def noise(scene: Scene) -> int:
    """How far pixels share their noise, see film.blur(): there is none where nothing is drawn at
    random."""
    return develop.blur(scene.film, scene.samples) if scene.is_random else 0


def film_dtype(dtype: DTypeLike | None, out: Array | None = None) -> np.dtype[Any]:
    """What a picture's pixels are: float32, the default, uint8 or uint16.

    Raises:
        RequestError: they are neither, or are not those of `out`.
    """
    try:
        wanted = np.dtype(np.float32 if dtype is None else dtype)
    except TypeError:
        wanted = np.dtype(object)
    if out is not None:
        if not isinstance(out, np.ndarray):
            raise RequestError(f"out: expected an array, got {type(out).__name__}")
        if dtype is not None and wanted != out.dtype:
            raise RequestError(f"dtype: expected that of out, {out.dtype}, got {dtype!r}")
        wanted = out.dtype
    if wanted not in (np.float32, np.uint8, np.uint16):
        got = wanted if dtype is None else repr(dtype)
        raise RequestError(f"dtype: expected float32, uint8 or uint16, got {got}")
    return wanted


def check_passes(passes: Sequence[str] | None) -> Sequence[str] | None:
    """Names of passes, each once; None stays so.

    Raises:
        RequestError: there is no such pass.
    """
    if passes is None:
        return None
    known = pack.PASSES.names or ()
    wanted = [passes] if isinstance(passes, str) else list(passes)
    for name in wanted:
        if name not in known:
            raise RequestError(f"passes: expected some of {', '.join(known)}, got {name!r}")
    return list(dict.fromkeys(wanted))


def check_size(width: int, height: int) -> tuple[int, int]:
    """Whole numbers of pixels that float32 can count.

    Raises:
        RequestError: they are not.
    """
    try:
        size = operator.index(width), operator.index(height)
    except TypeError:
        size = 0, 0
    if not all(1 <= pixels <= MAX_SIDE for pixels in size):
        expected = f"1 to {MAX_SIDE} pixels each way"
        raise RequestError(f"size: expected {expected}, got {width}x{height}")
    return size


def check_region(region: Region | None, width: int, height: int) -> Region:
    """The region, or all of the picture.

    Raises:
        RequestError: it is empty or not inside the picture.
    """
    if region is None:
        return 0, 0, width, height
    try:
        left, top, right, bottom = map(operator.index, region)
        good = 0 <= left < right <= width and 0 <= top < bottom <= height
    except (TypeError, ValueError):
        good = False
    if not good:
        expected = f"X0 Y0 X1 Y1 with 0 <= X0 < X1 <= {width} and 0 <= Y0 < Y1 <= {height}"
        raise RequestError(f"region: expected {expected}, got {region}")
    return left, top, right, bottom


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
