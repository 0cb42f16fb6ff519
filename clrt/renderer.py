"""Renderer: a device, its programs and a scene's buffers, which together make a film."""

import operator
import threading
import warnings
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import TYPE_CHECKING, Any, Self, TypeAlias

import numpy as np
from msgspec.structs import replace
from numpy.typing import DTypeLike, NDArray

from clrt import data, memory, pack
from clrt.errors import DeviceError, DeviceWarning, RequestError
from clrt.files.scenefile import as_scene
from clrt.opencl import bands, pocl, program
from clrt.opencl.device import check_process, find_device, label
from clrt.opencl.tree import Tree
from clrt.pack import LANES, PRECISIONS, Features, Film, Precision
from clrt.scene import Scene

if TYPE_CHECKING:
    import pyopencl as cl

Region: TypeAlias = tuple[int, int, int, int]
MAX_SIDE = 1 << 24  # pixels of a row or a column that float32 can number


class Renderer:
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
        self._world: pack.World | None = None
        self._tree: Tree | None = None
        self._moved = False  # since the tree was built its spheres have been exchanged for others
        self._films = memory.Films()
        self._lock = threading.RLock()  # a kernel has its arguments until it is enqueued
        self.kernel_seconds = 0.0
        """How long the kernel ran for the last picture, by the device's own clock."""

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def close(self) -> None:
        """Waits for the device and lets go of it."""
        with self._lock:
            self._queue.finish()
            self._programs.clear()
            self._world = self._tree = None
            self._films = memory.Films()

    @contextmanager
    def _errors(self) -> Iterator[None]:
        """OpenCL's, as ours."""
        import pyopencl as cl

        try:
            yield
        except cl.Error as error:
            raise DeviceError(f"{label(self.device)} cannot do this: {error}") from None

    def render(
        self,
        scene: Scene | str | Path,
        width: int,
        height: int,
        *,
        dtype: DTypeLike | None = None,
        region: Region | None = None,
        out: NDArray[Any] | None = None,
        progress: Callable[[int], object] | None = None,
    ) -> NDArray[Any]:
        """Renders a picture.

        Args:
            scene: a scene, or what load_scene() takes.
            width, height: of the whole picture, pixels.
            dtype: float32, the default, gives linear colours, not clipped; uint8 gives
                round(255 c) of them, clipped to [0, 1].
            region: (x0, y0, x1, y1), the part of it that is wanted: columns x0 <= x < x1 and rows
                y0 <= y < y1, y from the top. It is equal, bit for bit, to that part of the whole.
            out: a film to fill, of the shape that is returned, float32 or uint8, of any strides.
            progress: called with the number of rows just finished. It may raise, which ends the
                picture.

        Returns:
            (height, width, 3) of dtype, or (y1 - y0, x1 - x0, 3): `out`, or an array of the
            caller's own, whose memory is taken again when nobody has a reference to it any more.

        Raises:
            RequestError: there is no such scene, size, region or dtype, or `out` is not so.
            OutputError: the film does not fit into memory.
            DeviceError: the device fails.
        """
        check_process()
        scene = as_scene(scene)
        with self._lock, self._errors():
            return self._film(
                scene, (width, height), 3, film_kind(dtype, out), region, out, progress
            )

    def paths(self, scene: Scene, width: int, height: int) -> NDArray[np.uint32]:
        """A hash of each pixel's path, (height, width), to compare with reference.trace()'s."""
        check_process()
        with self._lock, self._errors():
            return self._film(scene, (width, height), 1, "paths")[..., 0]

    def _film(
        self,
        scene: Scene,
        size: tuple[int, int],
        channels: int,
        kind: Film,
        region: Region | None = None,
        out: NDArray[Any] | None = None,
        progress: Callable[[int], object] | None = None,
    ) -> NDArray[Any]:
        width, height = check_size(*size)
        left, top, right, bottom = check_region(region, width, height)
        wanted = bottom - top, right - left, channels
        if out is not None and (out.shape != wanted or not out.flags.writeable):
            raise RequestError(f"out: expected a writeable array of {wanted}, got {out.shape}")
        features, kernels = self._program(scene, kind)
        arguments = self._arguments(scene, width, height, features, kernels)
        # From the packet on that `left` is in: so every packet is one of the whole picture's.
        columns, _ = features.packet
        first = left // columns * columns
        shape = bottom - top, right - first, channels
        if out is not None and out.flags.c_contiguous and shape == wanted:
            film = out
        else:
            film = self._films.film(shape, np.dtype(pack.FILMS[kind]))
        self.kernel_seconds = bands.fill(
            film,
            (first, top),
            features.packet,
            self._queue,
            kernels["render"],
            arguments,
            progress,
        )
        if film is out:
            return out
        if out is not None:
            out[...] = film[:, left - first :]
            return out
        if left == first:
            return film
        # The columns before `left` are dropped where the film is: it may be as large as memory.
        flat, length = film.reshape(-1), channels * (right - left)
        for i, row in enumerate(film):
            flat[i * length : (i + 1) * length] = row[left - first :].reshape(-1)
        return flat[: len(film) * length].reshape(wanted)

    def _arguments(
        self,
        scene: Scene,
        width: int,
        height: int,
        features: Features,
        kernels: "dict[str, cl.Kernel]",
    ) -> dict[str, Any]:
        world = self._packed_world(scene)
        arguments = pack.arguments(world, scene, width, height)
        if not features.tree:
            return arguments
        beads, fitted = arguments["beads"], None
        if self._moved and self._tree is not None:
            # As many spheres elsewhere: their order is kept if the picture is there sooner so.
            fitted = self._tree.fit(beads, kernels)
            loose = self._tree.looseness()
            # The picture before may have been a small one, hence the bound.
            if loose > 2 or self.kernel_seconds * (loose - 1) > self._tree.build_seconds:
                self._tree = fitted = None
            self._moved = False
        if self._tree is None:
            self._tree = Tree(pack.tree_keys(world.spheres), self._queue, kernels)
        return arguments | (fitted or self._tree.fit(beads, kernels))

    def prepare(self, scene: Scene, dtype: DTypeLike | None = None) -> None:
        """Compiles what render() will need for such a scene, if it is not compiled yet."""
        check_process()
        with self._lock, self._errors():
            self._program(scene, film_kind(dtype))

    def _packed_world(self, scene: Scene) -> pack.World:
        """What is packed of a scene while only its camera changes."""
        if self._world is None or not self._world.is_of(scene):
            before, self._world = self._world, pack.pack_world(scene, self.precision)
            if before is None or len(before.spheres) != len(self._world.spheres):
                self._tree = None  # else its order may still do: see _arguments()
            self._moved = self._tree is not None
        return self._world

    def _program(self, scene: Scene, film: Film) -> "tuple[Features, dict[str, cl.Kernel]]":
        """The program for a scene; if none of so many lanes works, one of fewer."""
        needed = pack.features(self._packed_world(scene), scene, self.lanes, film)
        while needed not in self._programs:
            try:
                self._programs[needed] = program.kernels(self._made(needed))
            except DeviceError as error:
                narrower = [n for n in LANES if n < self.lanes]
                if not narrower:
                    raise DeviceError(f"{label(self.device)} cannot be used: {error}") from None
                self._narrow(narrower[-1], str(error))
                needed = replace(needed, lanes=self.lanes)
        return needed, self._programs[needed]

    def _narrow(self, lanes: int, why: str) -> None:
        self.lanes, before = lanes, self.lanes
        message = f"{label(self.device)}: {before} lanes cannot be used, {lanes} are: {why}"
        warnings.warn(message, DeviceWarning, stacklevel=2)

    def _made(self, needed: Features) -> "cl.Program":
        """From the cache; else it is compiled, tried and kept.

        Raises:
            DeviceError: it has not passed its trial.
        """
        import pyopencl as cl

        source = program.kernel_source()
        path = program.cache_path(self.device, source, needed.options)
        if (binary := data.kept(path)) is not None:
            with suppress(cl.Error):  # it is refused, as by another build of the same version
                return program.loaded(self._context, self.device, binary)
        from clrt import trial

        binary = trial.tried(self.device, source, needed)
        data.keep(path, binary)
        return program.loaded(self._context, self.device, binary)


def default_lanes(device: "cl.Device") -> int:
    """16 on a CPU whatever its vectors' width: wider packets than those have more to do at a time,
    which hides latency (benchmarks/NOTES.md)."""
    import pyopencl as cl

    return max(LANES) if device.type & cl.device_type.CPU else 1


def film_kind(dtype: DTypeLike | None, out: NDArray[Any] | None = None) -> Film:
    """The kind of film whose pixels are float32, the default, or uint8.

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
    for film in ("float", "bytes"):
        if wanted == pack.FILMS[film]:
            return film
    got = wanted if dtype is None else repr(dtype)
    raise RequestError(f"dtype: expected float32 or uint8, got {got}")


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
    precision: Precision = "robust",
    lanes: int | None = None,
    device: "str | cl.Device | None" = None,
    threads: int | None = None,
) -> NDArray[Any]:
    """Renders one picture, see Renderer and its render().

    For more than one picture keep a Renderer, which compiles once.
    """
    with Renderer(precision=precision, lanes=lanes, device=device, threads=threads) as renderer:
        return renderer.render(scene, width, height, dtype=dtype, region=region)
