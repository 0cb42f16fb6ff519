"""Bands: a kernel run over a film, some rows at a time, or pieces of these where a row takes long.

So a film can be larger than a device's largest buffer, Ctrl-C is answered and progress is told.
"""

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import pyopencl as cl

# The work-items of a work-group, all in one row. PoCL compiles a kernel again for each size, so a
# program has one; with 8 work-items PoCL's cost per group shows, from 32 on it does not.
GROUP = 64
# PoCL compiles a kernel once more for grids that are larger in some direction. Launches stay within
# it, but those of a picture that has more packets in a row.
SMALL_GRID = 65528
# Up to three bands are under way at a time. A band has at most so many pixels, enough to cost
# nothing (half or twice as many take as long). The first ones have as many as test FIRST_BAND_TESTS
# spheres, and what a band takes says how many rows a next one can have, GROWTH times as many at
# most: so Ctrl-C is answered in about three times BAND_SECONDS, or after three rows.
BAND_PIXELS, FIRST_BAND_TESTS = 1 << 20, 1 << 25
SPHERES_PER_PIXEL = 60  # the cost of a pixel without any, in tests of spheres
BAND_SECONDS, GROWTH = 0.1, 4
# A row of packets of thousands of samples takes seconds. Where it has more than ROW_SAMPLES (of 256
# samples a pixel: if it is wider than 4K) launches have some columns of several rows of packets,
# PIECE_SAMPLES or one packet's width, and less as soon as one takes more than PIECE_SECONDS. They
# do not grow again: a pixel in which there is nothing takes a thousandth of the time of one beside
# it. A row of a piece is a work-group at least: UNIT_ROWS for each of the device's units keep these
# busy.
ROW_SAMPLES, PIECE_SAMPLES, PIECE_SECONDS, UNIT_ROWS = 1 << 22, 1 << 21, 0.3, 8


class Part(NamedTuple):
    """A part of a film that one launch fills."""

    top: int
    rows: int
    left: int
    columns: int

    @property
    def inside(self) -> tuple[slice, slice]:
        return np.s_[self.top : self.top + self.rows, self.left : self.left + self.columns]


class Pace:
    """How large the next part is, by how long others took.

    Args:
        shape: rows and columns of the film.
        item: see fill().
        units: how many work-groups the device runs at a time.
        arguments: see fill().
    """

    def __init__(
        self,
        shape: tuple[int, int],
        item: tuple[int, int],
        units: int,
        arguments: dict[str, Any],
    ) -> None:
        self._height, self._columns = shape
        self._item, self._units = item, units
        samples = max(int(arguments["samples"]), 1)
        tests = samples * (SPHERES_PER_PIXEL + int(arguments["sphere_count"]))
        self._band: float = FIRST_BAND_TESTS // tests  # pixels
        # `paths` has rows of the film's width, so all launches need these.
        is_slow = samples * self._columns * item[1] > ROW_SAMPLES
        self._has_pieces = is_slow and arguments["paths"] is None
        self._piece: float = PIECE_SAMPLES // samples  # pixels

    def took(self, part: Part, seconds: float) -> None:
        """Takes note of how long a part took."""
        pixels, seconds = part.rows * part.columns, max(seconds, 1e-9)
        self._band = pixels * min(BAND_SECONDS / seconds, GROWTH)
        self._piece = min(self._piece, pixels * PIECE_SECONDS / seconds)

    def after(self, last: Part) -> Part:
        """The part that comes after another, of no rows if that was the last."""
        left = last.left + last.columns
        if left < self._columns:
            return Part(last.top, last.rows, left, self._piece_columns(left, last.rows))
        top = last.top + last.rows
        remaining, packet_rows = self._height - top, self._item[1]
        if self._has_pieces and remaining >= self._units * packet_rows:
            rows = min(UNIT_ROWS * self._units * packet_rows, remaining)
            return Part(top, rows, 0, self._piece_columns(0, rows))
        most = min(BAND_PIXELS // self._columns, SMALL_GRID * packet_rows)
        rows = _whole(int(min(self._band / self._columns, most)), packet_rows)
        return Part(top, min(rows, remaining), 0, self._columns)

    def _piece_columns(self, left: int, rows: int) -> int:
        """How many columns of so many rows the next piece has: all that remain are as wide."""
        remaining, packet = self._columns - left, self._item[0]
        fitting = _whole(int(min(self._piece / rows, remaining)), packet)
        pieces = -(-remaining // fitting)
        return min(padded(-(-remaining // pieces), packet), remaining)


def fill(
    film: NDArray[Any],
    corner: tuple[int, int],
    item: tuple[int, int],
    group: int,
    queue: "cl.CommandQueue",
    kernel: "cl.Kernel",
    arguments: dict[str, Any],
    progress: Callable[[int], object] | None = None,
) -> float:
    """Fills a film by the kernel `render`.

    Args:
        film: (rows, columns, ...), contiguous.
        corner: its first pixel's column and row in the picture.
        item: columns and rows of the pixels that a work-item renders.
        group: how many of them are a work-group: one size for each program.
        arguments: the kernel's from `paths` on, in its order, see clrt.renderer.pack. `lost`, if
            it is there, is filled.
        progress: called with the number of rows just finished: 0 where others are still to come.

    Returns:
        How long the kernel ran, in seconds, by the device's clock.
    """
    import pyopencl as cl

    same_for_all = (uploaded := upload(queue.context, arguments)).values()
    pace = Pace(film.shape[:2], item, queue.device.max_compute_units, arguments)
    kernel_seconds = 0.0
    # Each launch's kernel, and the mapping of its buffer right behind it: so the queue never runs
    # empty while the host waits for the launch before.
    under_way: deque[tuple[cl.Event, cl.Event, cl.MemoryMap, Part, NDArray[Any]]] = deque()

    def finish_oldest() -> None:
        nonlocal kernel_seconds
        done, mapped, mapping, part, made = under_way.popleft()
        mapped.wait()
        mapping.release(queue)
        if part.columns < film.shape[1]:
            film[part.inside] = made
        seconds = 1e-9 * (done.profile.end - done.profile.start)
        kernel_seconds += seconds
        if progress is not None:
            progress(part.rows if part.left + part.columns == film.shape[1] else 0)
        pace.took(part, seconds)

    try:
        part = pace.after(Part(0, 0, 0, film.shape[1]))
        while part.rows:
            # What is not whole rows gets memory of its own: a kernel's rows follow each other.
            made = film[part.inside]
            if part.columns < film.shape[1]:
                made = np.empty_like(made)
            flags = cl.mem_flags.WRITE_ONLY | cl.mem_flags.USE_HOST_PTR
            buffer = cl.Buffer(queue.context, flags, hostbuf=made)
            place = corner[1] + part.top, part.columns, part.rows, corner[0] + part.left
            kernel.set_args(buffer, *map(np.int32, place), *same_for_all)
            size = padded(-(-part.columns // item[0]), group), -(-part.rows // item[1])
            done = cl.enqueue_nd_range_kernel(queue, kernel, size, (group, 1))
            # On a CPU the kernel writes to the film itself; on other devices this copies.
            array, mapped = cl.enqueue_map_buffer(
                queue, buffer, cl.map_flags.READ, 0, made.shape, made.dtype, is_blocking=False
            )
            under_way.append((done, mapped, array.base, part, made))
            if len(under_way) > 2:
                finish_oldest()
            part = pace.after(part)
        while under_way:
            finish_oldest()
        if arguments["lost"] is not None:
            cl.enqueue_copy(queue, arguments["lost"], uploaded["lost"])
    finally:
        queue.finish()  # the device writes to the film: an error must not free it
    return kernel_seconds


def padded(items: int, group: int) -> int:
    """So many work-items that they are whole groups."""
    return -(-items // group) * group


def _whole(pixels: int, packet: int) -> int:
    """So many rows, or columns, as whole packets have, at least one of these."""
    return max(pixels // packet, 1) * packet


def upload(context: "cl.Context", arguments: dict[str, Any]) -> dict[str, Any]:
    """A kernel's arguments on a device."""
    return {name: _uploaded(context, value) for name, value in arguments.items()}


def _uploaded(context: "cl.Context", value: Any) -> Any:
    """An array as a buffer; a number stays one."""
    import pyopencl as cl

    if not isinstance(value, np.ndarray):  # a number, a buffer that is there, or None
        return value
    if value.size == 0:  # OpenCL has no empty buffers
        value = np.zeros(1, value.dtype)
    flags = cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR
    return cl.Buffer(context, flags, hostbuf=value)
