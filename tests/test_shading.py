"""The highlight's power, alone, against long double."""

from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from conftest import options, run_kernel

from clrt.renderer.pack.structs import PRECISIONS

KERNEL = """
__kernel void powers(__global const LANES_OF(FLOATING) *cosine2,
                     __global const LANES_OF(FLOATING) *sine2,
                     __global const LANES_OF(FLOATING) *exponent,
                     __global LANES_OF(FLOATING) *found) {
    int i = get_global_id(0);
    found[i] = power(cosine2[i], sine2[i], exponent[i]);
}
"""


@pytest.mark.parametrize(("precision", "bound"), [("robust", 2.5e-7), ("double", 5e-16)])
def test_power(device: cl.Device, lanes: int, precision, bound: float) -> None:
    """A million pairs of angle and exponent: angles from 1e-6 to a right one, exponents to 1e6."""
    if precision == "double" and device.native_vector_width_double == 0:
        pytest.skip("no float64")
    real: Any = PRECISIONS[precision]
    random = np.random.default_rng(7)
    angle = 10 ** random.uniform(-6, np.log10(np.pi / 2), 1 << 20)
    sine2 = (np.sin(angle) ** 2).astype(real)
    cosine2 = (np.cos(angle) ** 2).astype(real)
    exponent = (10 ** random.uniform(-2, 6, 1 << 20)).astype(real)
    exponent[::100] = 0
    found = np.empty_like(sine2)
    inputs = (cosine2, sine2, exponent)
    run_kernel(
        device, KERNEL, "powers", options(lanes, precision), found.size // lanes, inputs, found
    )

    wide = np.longdouble
    near: Any = sine2 < 0.3
    log = np.where(
        near, np.log1p(-np.where(near, sine2, 0).astype(wide)), np.log(cosine2.astype(wide))
    )
    truth = np.exp(exponent * log)
    off = abs(found - truth)
    assert off.max() <= bound
    assert (found[exponent == 0] == 1).all()
    assert (truth > 0.5).mean() > 0.1
