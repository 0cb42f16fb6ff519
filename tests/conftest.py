"""Renderers for every OpenCL device found, kernels run alone, pictures that fail kept."""

import functools
import signal
import tempfile
from collections.abc import Callable, Container, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from numpy.typing import ArrayLike, NDArray

from clrt.figure.rendering import Renderer
from clrt.files.image import save
from clrt.film import metrics
from clrt.opencl import program
from clrt.opencl.device import devices, label
from clrt.renderer.pack.features import LANES, Features
from clrt.renderer.pack.structs import Precision
from clrt.scene.scene import Scene

LIT = """[camera]
position = [0, 0, 3]
look_at = [0, 0, 0]
[[lights]]
position = [0, 5, 5]
[materials.m]
diffuse = [1, 1, 1]
"""
"""A scene file that what is to be seen goes on."""

DEVICES = devices()
# As clrt does without PyOpenCL's cache: its programs for Intel have lost the arguments' names.
setattr(cl, "_PYOPENCL_NO_CACHE", True)  # noqa: B010
# Ctrl-C may be ignored where the tests were started; processes would inherit that.
signal.signal(signal.SIGINT, signal.default_int_handler)


@functools.cache
def renderer_for(
    device: cl.Device, lanes: int, precision: Precision = "robust", of: str = ""
) -> Renderer:
    """One for all tests that use it for the same."""
    return Renderer(device=device, lanes=lanes, precision=precision)


def options(lanes: int, precision: Precision = "robust", **used: Any) -> list[str]:
    """The compiler's, for a program with the kernels' functions in it."""
    return Features(lanes, precision, "float", **used).options


@functools.cache
def kernels_of(
    device: cl.Device, code: str, options: tuple[str, ...]
) -> tuple[cl.Context, dict[str, cl.Kernel]]:
    """clrt's kernels and those that a test adds, compiled once."""
    context = cl.Context([device])  # Intel's kernels do not keep theirs
    built = cl.Program(context, program.kernel_source() + code).build(options=list(options))
    return context, program.kernels(built)


def run_kernel(
    device: cl.Device,
    code: str,
    name: str,
    options: Sequence[str],
    size: int,
    inputs: Sequence[NDArray[Any]],
    output: NDArray[Any],
    *more: NDArray[Any],
) -> None:
    """Runs a kernel that a test adds to clrt's: kernel(inputs..., output, more...).

    size: how many work-items.
    """
    context, kernels = kernels_of(device, code, tuple(options))
    kernel, queue = kernels[name], cl.CommandQueue(context)
    flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR

    def buffer(array: NDArray[Any]) -> cl.Buffer:
        return cl.Buffer(context, flags, hostbuf=np.ascontiguousarray(array))

    found = cl.Buffer(context, cl.mem_flags.WRITE_ONLY, output.nbytes)
    kernel(queue, (size,), None, *map(buffer, inputs), found, *map(buffer, more))
    cl.enqueue_copy(queue, output, found)


def same(found: ArrayLike | None, expected: ArrayLike) -> bool:
    """Whether an array is there and equal to one, or all of it to a number."""
    return (
        found is not None
        and np.shape(expected) in ((), np.shape(found))
        and bool(np.all(np.asarray(found) == expected))
    )


def kept(image: NDArray[Any], truth: NDArray[Any]) -> str:
    """Leaves a picture that fails, its truth and a map of their difference; says where."""
    folder = Path(tempfile.mkdtemp(prefix="clrt-failed-"))
    error = metrics.heatmap(metrics.pixel_error(image, truth))
    for name, picture in (("image", image), ("truth", truth), ("error", error)):
        save(folder / f"{name}.npy", picture.astype(np.float32))
        byte = np.rint(255 * np.clip(np.nan_to_num(picture, nan=1.0), 0, 1)).astype(np.uint8)
        save(folder / f"{name}.png", byte)
    return f"see {folder}"


@pytest.fixture(params=DEVICES, ids=label, scope="session")
def device(request: pytest.FixtureRequest) -> cl.Device:
    return request.param


# One lane is scalars, sixteen are what a CPU gets; the others are slow to go through.
EVERY_LANES = [
    pytest.param(n, marks=[pytest.mark.slow] * (n not in (1, 16)), id=f"lanes{n}") for n in LANES
]


@pytest.fixture(params=EVERY_LANES, scope="session")
def lanes(request: pytest.FixtureRequest) -> int:
    return request.param


def in_lanes(cases: Iterable[Any], at_one: Container[Any]) -> list[Any]:
    """Parameters (lanes, case): all cases in 16 lanes and some in one. Slow: all others in 1 and 4,
    and those some in 2 and 8."""
    return [
        pytest.param(n, case, id=f"lanes{n}-{case}",
                     marks=[pytest.mark.slow] * (n != 16 and (n != 1 or case not in at_one)))
        for n in LANES
        for case in cases
        if n in (1, 4, 16) or case in at_one
    ]  # fmt: skip


@pytest.fixture
def renderer(device: cl.Device, lanes: int) -> Renderer:
    return renderer_for(device, lanes)


@pytest.fixture
def render(device: cl.Device, monkeypatch: pytest.MonkeyPatch) -> Callable[..., NDArray[Any]]:
    """Renders a scene with a tree, however few its spheres are, or without."""

    def rendered(
        scene: Scene,
        size: tuple[int, int],
        tree: bool = False,
        lanes: int = 16,
        precision: Precision = "robust",
        **options: Any,
    ) -> NDArray[Any]:
        if precision == "double" and device.native_vector_width_double == 0:
            pytest.skip("no float64")
        monkeypatch.setattr("clrt.renderer.pack.features.TREE_FROM", 1 if tree else np.inf)
        renderer = renderer_for(device, lanes, precision, "a tree" if tree else "a list")
        return renderer.render(scene, *size, **options)

    return rendered


@pytest.fixture
def double_renderer(device: cl.Device, lanes: int) -> Renderer:
    if device.native_vector_width_double == 0:
        pytest.skip("no float64")
    return renderer_for(device, lanes, "double")
