"""Renderers for every OpenCL device found, each compiled once for the whole run."""

import functools
import signal

import pyopencl as cl
import pytest

from clrt.opencl.device import devices, label
from clrt.pack import LANES, Features, Precision
from clrt.renderer import Renderer

DEVICES = devices()
# Ctrl-C may be ignored where the tests were started; processes would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


@functools.cache
def renderer_for(device: cl.Device, lanes: int, precision: Precision = "robust") -> Renderer:
    return Renderer(device=device, lanes=lanes, precision=precision)


def options(lanes: int, precision: Precision = "robust", light_inside: bool = False) -> list[str]:
    """The compiler's, for a program with the kernels' functions in it."""
    return Features(lanes, precision, "float", False, False, light_inside).options


@pytest.fixture(params=DEVICES, ids=label, scope="session")
def device(request: pytest.FixtureRequest) -> cl.Device:
    return request.param


@pytest.fixture(params=LANES, ids=lambda n: f"lanes{n}", scope="session")
def lanes(request: pytest.FixtureRequest) -> int:
    return request.param


@pytest.fixture
def renderer(device: cl.Device, lanes: int) -> Renderer:
    return renderer_for(device, lanes)


@pytest.fixture
def double_renderer(device: cl.Device, lanes: int) -> Renderer:
    if device.native_vector_width_double == 0:
        pytest.skip("no float64")
    return renderer_for(device, lanes, "double")
