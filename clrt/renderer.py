"""Renderer: a device, its programs and a scene's buffers, which together make a film."""

import math
import operator
import threading
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType
from typing import TYPE_CHECKING, Any, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

from clrt import memory
from clrt.device import check_process, find_device, label
from clrt.errors import DeviceError, RequestError
from clrt.pack import Real, encloses, pack
from clrt.program import Program
from clrt.scene import Scene

if TYPE_CHECKING:
    import pyopencl as cl

Region: TypeAlias = tuple[int, int, int, int]
Precision: TypeAlias = Literal["robust", "literal", "double"]
PRECISIONS: dict[Precision, Real] = {
    "robust": np.float32,
    "literal": np.float32,
    "double": np.float64,
}
LANES = (1, 2, 4, 8, 16)

# The kernel's option for each kind of film; the last are paths.
FILMS: dict[np.dtype[Any], list[str]] = {
    np.dtype(np.float32): [],
    np.dtype(np.uint8): ["-DFILM_BYTES"],
    np.dtype(np.uint32): ["-DFILM_PATHS"],
}

# The work-items of a work-group, all in one row. PoCL compiles a kernel again for each size, so
# there is one; with 8 work-items PoCL's cost per group shows, from 32 on it does not.
GROUP = 64
# Rows are rendered in bands, up to three under way at a time. A band has at most so many pixels,
# enough to cost nothing (half or twice as many take as long). The first ones have as many as test
# FIRST_BAND spheres, and what a band takes says how many rows a next one can have, GROWTH times as
# many at most: so Ctrl-C is answered in about three times BAND_SECONDS, or after three rows.
BAND, FIRST_BAND = 1 << 20, 1 << 25
PIXEL = 60  # what a pixel costs, in tests of spheres, if there is none
BAND_SECONDS, GROWTH = 0.1, 4
LARGEST = 1 << 24  # pixels of a row or a column that float32 can number


class Renderer:
    """Renders scenes on one device, keeping what was compiled.

    Threads can share one, which renders one picture at a time, or have one each.

    Args:
        precision: "robust" (float32, the split formula), "literal" (float32, the paper's
            formulas as they stand) or "double" (float64).
        lanes: pixels that a work-item traces in lock step, one of LANES; default: the device's
            native vector width.
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
        native = device.native_vector_width_float
        if self.real is np.float64:
            native = device.native_vector_width_double
            if native == 0:
                raise DeviceError(f"{label(device)} has no float64: use --precision robust")
        self.lanes = lanes or max(n for n in LANES if n <= max(native, 1))
        with self._errors():
            self._context = cl.Context([device])
            self._queue = cl.CommandQueue(
                self._context, properties=cl.command_queue_properties.PROFILING_ENABLE
            )
        self._programs: dict[tuple[str, ...], Program] = {}
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
        scene: Scene,
        width: int,
        height: int,
        *,
        dtype: DTypeLike = np.float32,
        region: Region | None = None,
        progress: Callable[[int], object] | None = None,
    ) -> NDArray[Any]:
        """Renders a picture.

        Args:
            width, height: of the whole picture, pixels.
            dtype: float32 gives linear colours, not clipped; uint8 gives round(255 c) of them,
                clipped to [0, 1].
            region: (x0, y0, x1, y1), the part of it that is wanted: columns x0 <= x < x1 and rows
                y0 <= y < y1, y from the top. It is equal, bit for bit, to that part of the whole.
            progress: called with the number of rows just finished. It may raise, which ends the
                picture.

        Returns:
            (height, width, 3) of dtype, or (y1 - y0, x1 - x0, 3).

        Raises:
            RequestError: there is no such size, region or dtype.
            OutputError: the film does not fit into memory.
            DeviceError: the device fails.
        """
        check_process()
        with self._lock, self._errors():
            return self._film(scene, (width, height), (3,), color_dtype(dtype), region, progress)

    def paths(self, scene: Scene, width: int, height: int) -> NDArray[np.uint32]:
        """A hash of each pixel's path, (height, width), to compare with reference.trace()'s."""
        check_process()
        with self._lock, self._errors():
            return self._film(scene, (width, height), (), np.dtype(np.uint32))

    def _film(
        self,
        scene: Scene,
        size: tuple[int, int],
        channels: tuple[int, ...],
        dtype: np.dtype[Any],
        region: Region | None = None,
        progress: Callable[[int], object] | None = None,
    ) -> NDArray[Any]:
        import pyopencl as cl

        width, height = check_size(*size)
        left, top, right, bottom = check_region(region, width, height)
        packed = pack(scene, width, height, self.real, self.precision == "literal")
        program = self._program(scene, dtype, light_inside=bool(packed.encloses.any()))
        # From the packet on that `left` is in: so every packet is one of the whole picture's.
        first = left // self.lanes * self.lanes
        columns = right - first
        shape = (bottom - top, columns, *channels)
        memory.require(math.prod(shape) * dtype.itemsize, f"a film of {columns}x{bottom - top}")
        film = np.empty(shape, dtype)
        buffers = map(
            self._upload,
            (packed.camera, packed.spheres, packed.materials, packed.lights, packed.shades,
             packed.encloses),
        )  # fmt: skip
        camera, spheres, materials, lights, shades, enclosing = buffers
        same_for_all_bands = (
            np.int32(columns),
            np.int32(first),
            np.int32(scene.max_depth),
            self.real(packed.shadow_bias),
            camera,
            np.int32(len(packed.spheres)),
            spheres,
            np.int32(len(packed.materials)),
            materials,
            np.int32(len(packed.lights)),
            lights,
            shades,
            enclosing,
        )
        items = -(-columns // (GROUP * self.lanes)) * GROUP
        rows = max(FIRST_BAND // (columns * (PIXEL + len(packed.spheres))), 1)
        self.kernel_seconds = 0.0
        # Each band's kernel, and the mapping of its buffer right behind it: so the queue never runs
        # empty while the host waits for the band before.
        under_way: deque[tuple[cl.Event, cl.Event, cl.MemoryMap, int]] = deque()

        def finish_oldest() -> int:
            """Returns how many rows the next band should have."""
            done, mapped, mapping, band_rows = under_way.popleft()
            mapped.wait()
            mapping.release(self._queue)
            seconds = 1e-9 * (done.profile.end - done.profile.start)
            self.kernel_seconds += seconds
            if progress is not None:
                progress(band_rows)
            fitting = band_rows * min(BAND_SECONDS / max(seconds, 1e-9), GROWTH)
            return max(int(min(fitting, BAND / columns)), 1)

        try:
            begun = 0
            while begun < len(film):
                band = film[begun : begun + rows]
                flags = cl.mem_flags.WRITE_ONLY | cl.mem_flags.USE_HOST_PTR
                buffer = cl.Buffer(self._context, flags, hostbuf=band)
                program.render.set_args(buffer, np.int32(top + begun), *same_for_all_bands)
                done = cl.enqueue_nd_range_kernel(
                    self._queue, program.render, (items, len(band)), (GROUP, 1)
                )
                # On a CPU the kernel writes to the film itself; on other devices this copies.
                array, mapped = cl.enqueue_map_buffer(
                    self._queue,
                    buffer,
                    cl.map_flags.READ,
                    0,
                    band.shape,
                    band.dtype,
                    is_blocking=False,
                )
                under_way.append((done, mapped, array.base, len(band)))
                begun += len(band)
                if len(under_way) > 2:
                    rows = finish_oldest()
            while under_way:
                finish_oldest()
        finally:
            self._queue.finish()  # the device writes to the film: an error must not free it
        program.keep()
        if left == first:
            return film
        # The columns before `left` are dropped where the film is: it may be as large as memory.
        flat, length = film.reshape(-1), math.prod(channels) * (right - left)
        for i, row in enumerate(film):
            flat[i * length : (i + 1) * length] = row[left - first :].reshape(-1)
        return flat[: len(film) * length].reshape(len(film), right - left, *channels)

    def _upload(self, packed: NDArray[Any]) -> "cl.Buffer":
        import pyopencl as cl

        if packed.size == 0:  # OpenCL has no empty buffers
            packed = np.zeros(1, packed.dtype)
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self._context, flags, hostbuf=packed)

    def prepare(self, scene: Scene, dtype: DTypeLike = np.float32) -> None:
        """Compiles what render() will need for such a scene, if it is not compiled yet."""
        check_process()
        with self._lock:
            self._program(scene, color_dtype(dtype), light_inside=bool(encloses(scene).any()))

    def _program(self, scene: Scene, dtype: np.dtype[Any], light_inside: bool) -> Program:
        long_lens = scene.camera.long_lens and self.precision != "literal"
        options = (
            *FILMS[dtype],
            *["-DREFLECTION"] * scene.reflects,
            *["-DLONG_LENS"] * long_lens,
            *["-DLIGHT_INSIDE"] * light_inside,
        )
        if options not in self._programs:
            self._programs[options] = Program(
                self._context, self.device, self.build_options(*options)
            )
        return self._programs[options]

    def build_options(self, *options: str) -> list[str]:
        """The compiler options of this renderer's programs."""
        double = ["-DDOUBLE"] * (self.real is np.float64)
        literal = ["-DLITERAL"] * (self.precision == "literal")
        return [f"-DLANES={self.lanes}", *double, *literal, *options]


def color_dtype(dtype: DTypeLike) -> np.dtype[Any]:
    """float32 or uint8.

    Raises:
        RequestError: it is neither.
    """
    try:
        found = np.dtype(dtype)
    except TypeError:
        found = np.dtype(object)
    if found not in (np.float32, np.uint8):
        raise RequestError(f"dtype: expected float32 or uint8, got {dtype!r}")
    return found


def check_size(width: int, height: int) -> tuple[int, int]:
    """Whole numbers of pixels that float32 can count.

    Raises:
        RequestError: they are not.
    """
    try:
        size = operator.index(width), operator.index(height)
    except TypeError:
        size = 0, 0
    if not all(1 <= pixels <= LARGEST for pixels in size):
        expected = f"1 to {LARGEST} pixels each way"
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


def render(scene: Scene, width: int, height: int, **options: Any) -> NDArray[np.float32]:
    """Renders one picture: float32 (height, width, 3), linear, not clipped.

    options: as for Renderer. For more than one picture keep a Renderer, which compiles once.
    """
    with Renderer(**options) as renderer:
        return renderer.render(scene, width, height)
