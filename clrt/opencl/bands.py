"""Bands: a kernel run over a film, some rows at a time.

So a film can be larger than a device's largest buffer, Ctrl-C is answered and progress is told.
"""

from collections import deque
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

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
        progress: called with the number of rows just finished.

    Returns:
        How long the kernel ran, in seconds, by the device's clock.
    """
    import pyopencl as cl

    columns = film.shape[1]
    same_for_all = (
        np.int32(corner[0]),
        *(uploaded := upload(queue.context, arguments)).values(),
    )
    items = padded(-(-columns // item[0]), group)
    tests = columns * (SPHERES_PER_PIXEL + int(arguments["sphere_count"]))
    tests *= max(int(arguments["samples"]), 1)
    rows = _whole(min(FIRST_BAND_TESTS // tests, SMALL_GRID * item[1]), item[1])
    kernel_seconds = 0.0
    # Each band's kernel, and the mapping of its buffer right behind it: so the queue never runs
    # empty while the host waits for the band before.
    under_way: deque[tuple[cl.Event, cl.Event, cl.MemoryMap, int]] = deque()

    def finish_oldest() -> int:
        """Returns how many rows the next band should have."""
        nonlocal kernel_seconds
        done, mapped, mapping, band_rows = under_way.popleft()
        mapped.wait()
        mapping.release(queue)
        seconds = 1e-9 * (done.profile.end - done.profile.start)
        kernel_seconds += seconds
        if progress is not None:
            progress(band_rows)
        fitting = band_rows * min(BAND_SECONDS / max(seconds, 1e-9), GROWTH)
        most = min(BAND_PIXELS // columns, SMALL_GRID * item[1])
        return _whole(int(min(fitting, most)), item[1])

    try:
        begun = 0
        while begun < len(film):
            band = film[begun : begun + rows]
            flags = cl.mem_flags.WRITE_ONLY | cl.mem_flags.USE_HOST_PTR
            buffer = cl.Buffer(queue.context, flags, hostbuf=band)
            place = map(np.int32, (corner[1] + begun, columns, len(band)))
            kernel.set_args(buffer, *place, *same_for_all)
            size = items, -(-len(band) // item[1])
            done = cl.enqueue_nd_range_kernel(queue, kernel, size, (group, 1))
            # On a CPU the kernel writes to the film itself; on other devices this copies.
            array, mapped = cl.enqueue_map_buffer(
                queue, buffer, cl.map_flags.READ, 0, band.shape, band.dtype, is_blocking=False
            )
            under_way.append((done, mapped, array.base, len(band)))
            begun += len(band)
            if len(under_way) > 2:
                rows = finish_oldest()
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


def _whole(rows: int, packet_rows: int) -> int:
    """So many rows as whole packets have, at least one of these."""
    return max(rows // packet_rows, 1) * packet_rows


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
