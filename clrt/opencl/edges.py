"""Edges: the pixels of a film that more samples make better."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from clrt.opencl import bands

if TYPE_CHECKING:
    import pyopencl as cl

GROUP = 8  # work-items, each of which traces many packets, or looks at 16 pixels
BLOCK_PIXELS = 1 << 24  # whose edges are listed at a time
FIRST_SAMPLES = 1 << 22  # are traced at a time at first, then as many as take bands.BAND_SECONDS
MARKERS = 256  # work-items that look which spheres are small
SMALL = 2.0
"""Pixels. The first 16 points leave room for 0.054 of a pixel that a disc of this radius covers,
and for more that smaller ones cover (tests/test_samples.py)."""


def refine(
    film: NDArray[Any],
    corner: tuple[int, int],
    box: tuple[int, int, int, int],
    paths: "cl.Buffer",
    queue: "cl.CommandQueue",
    kernels: "dict[str, cl.Kernel]",
    arguments: dict[str, Any],
    missed: float,
    progress: Callable[[int], object] | None = None,
) -> float:
    """Makes those pixels again whose paths are unlike a neighbour's, or in which a ball may show
    that no path has met.

    Args:
        film: (rows, columns, ...), contiguous.
        corner: its first pixel's column and row in the picture.
        box: columns and rows of the film that are wanted: left, top, right, bottom. What is around
            are neighbours.
        paths: (rows, columns) uint32.
        kernels: `mark_balls`, `edges` and `render` of a program that refines.
        arguments: of `render`, see bands.fill().
        missed: the radius in pixels of the largest balls that may be between all paths.
        progress: called with the number of rows just finished.

    Returns:
        How long kernels ran, in seconds, by the device's clock.
    """
    import pyopencl as cl

    rows, columns = film.shape[:2]
    left, top, right, bottom = box
    uploaded = bands.upload(queue.context, arguments)
    block = min(max(BLOCK_PIXELS // columns, 1), bands.SMALL_GRID)
    found = cl.Buffer(queue.context, cl.mem_flags.READ_WRITE, 4 * min(block, rows) * columns)
    # Of at most 16 samples a pixel gets all anyway.
    small = max(missed, SMALL) if int(arguments["samples"]) > 16 else missed
    real = arguments["points"].dtype.type
    balls = [uploaded[name] for name in ("camera", "sphere_count", "spheres", "leaves", "shape")]
    per_row = bands.padded(-(-(right - left) // 16), GROUP)
    marks = cl.Buffer(queue.context, cl.mem_flags.READ_WRITE, 4 * per_row * min(block, rows))
    seconds = 0.0

    def ran(kernel: "cl.Kernel", size: Any, group: Any, *values: Any) -> None:
        nonlocal seconds
        kernel.set_args(*(np.int32(v) if isinstance(v, int) else v for v in values))
        done = cl.enqueue_nd_range_kernel(queue, kernel, size, group)
        done.wait()
        seconds += 1e-9 * (done.profile.end - done.profile.start)

    try:
        for first in range(top, bottom, block):
            last = min(first + block, bottom)
            number = np.zeros(1, np.int32)
            count = bands.upload(queue.context, {"count": number})["count"]
            # A size of the group's is given: PoCL would compile the kernel again for each that it
            # chooses by itself, in every process. Items beyond the row's end find nothing.
            size = per_row, last - first
            none = np.zeros(1, np.uint32)
            cl.enqueue_fill_buffer(queue, marks, none, 0, 4 * per_row * (last - first))
            sides = [
                int(c + s) for c, s in zip(2 * corner, (left, first, right, last), strict=True)
            ]
            ran(
                kernels["mark_balls"], (MARKERS,), (1,),
                marks, *sides, per_row, real(missed), real(small), *balls,
            )  # fmt: skip
            where = columns, rows, left, first, right
            ran(kernels["edges"], size, (GROUP, 1), paths, *where, marks, found, count)
            cl.enqueue_copy(queue, number, count)
            total, start, told = int(number[0]), 0, 0
            flags = cl.mem_flags.READ_WRITE | cl.mem_flags.USE_HOST_PTR
            band = cl.Buffer(queue.context, flags, hostbuf=film[first:last])
            place = corner[1] + first, columns, last - first, corner[0]
            chunk = FIRST_SAMPLES // int(arguments["samples"])
            while start < total:
                chunk = min(max(chunk, GROUP), total - start, bands.SMALL_GRID)
                before, items = seconds, (bands.padded(chunk, GROUP),)
                each = uploaded | {"list": found, "from": start, "count": chunk}
                ran(kernels["render"], items, (GROUP,), band, *place, *each.values())
                start += chunk
                chunk = int(chunk * min(bands.BAND_SECONDS / (seconds - before), bands.GROWTH))
                if progress is not None:
                    progress((last - first) * start // total - told)
                told = (last - first) * start // total
            if progress is not None:
                progress(last - first - told)
            shape, dtype = film[first:last].shape, film.dtype
            array, _ = cl.enqueue_map_buffer(queue, band, cl.map_flags.READ, 0, shape, dtype)
            array.base.release(queue)
        if arguments["lost"] is not None:
            cl.enqueue_copy(queue, arguments["lost"], uploaded["lost"])
    finally:
        queue.finish()  # the device writes to the film: an error must not free it
    return seconds
