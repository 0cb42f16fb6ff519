"""Denoise: a film with less noise, by the kernel `denoise` (kernels/denoise.cl)."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from clrt.opencl import bands

if TYPE_CHECKING:
    import pyopencl as cl

FAR = 2
"""How many columns and rows away a pixel's neighbours are."""
STRIP = 16
"""Rows of a work-item."""


def denoise(
    guides: NDArray[Any],
    out: NDArray[np.float32],
    lanes: int,
    queue: "cl.CommandQueue",
    kernel: "cl.Kernel",
    samples: int,
    camera: NDArray[Any],
    progress: Callable[[int], object] | None = None,
) -> float:
    """Fills a film of colours with alpha.

    Args:
        guides: (rows, columns) of structs.GUIDES, contiguous.
        out: (rows, columns, 4), contiguous.
        lanes: columns of a work-item.
        samples: of a pixel of `guides`.
        camera: as the kernel has it.
        progress: called with 0 now and then. It may raise.

    Returns:
        How long the kernel ran, in seconds, by the device's clock.
    """
    import pyopencl as cl

    rows, columns = guides.shape
    flags, context, seconds = cl.mem_flags, queue.context, 0.0
    of_camera = bands.upload(context, {"camera": camera})["camera"]
    step = bands.padded(max(bands.BAND_PIXELS // columns, 1), STRIP)
    try:
        for first in range(0, rows, step):
            last = min(first + step, rows)
            top, bottom = max(first - FAR, 0), min(last + FAR, rows)
            band, made = guides[top:bottom], out[first:last]
            taken = cl.Buffer(context, flags.READ_ONLY | flags.USE_HOST_PTR, hostbuf=band)
            given = cl.Buffer(context, flags.WRITE_ONLY | flags.USE_HOST_PTR, hostbuf=made)
            place = columns, bottom - top, first - top, last - top, samples
            kernel.set_args(taken, *map(np.int32, place), of_camera, given)
            size = -(-columns // lanes), -(-(last - first) // STRIP)
            done = cl.enqueue_nd_range_kernel(queue, kernel, size, (1, 1))
            array, mapped = cl.enqueue_map_buffer(
                queue, given, cl.map_flags.READ, 0, made.shape, made.dtype, is_blocking=False
            )
            mapped.wait()
            array.base.release(queue)
            seconds += 1e-9 * (done.profile.end - done.profile.start)
            if progress is not None:
                progress(0)
    finally:
        queue.finish()  # the device uses the films: an error must not free them
    return seconds
