"""Programs: the kernels' source, compiled for a device, and kept for the next process.

PoCL's way to keep compiled programs is not used (clrt/opencl/pocl.py). This one is faster: a
program is there in 3 ms, and in PoCL's after 33 ms, because it preprocesses the source to find it.
"""

import hashlib
import threading
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, cast

from clrt import storage
from clrt.errors import DeviceError
from clrt.opencl import pocl
from clrt.opencl.device import identity

if TYPE_CHECKING:
    import pyopencl as cl

KERNELS = (
    "features",
    "lanes",
    "angles",
    "draw",
    "sphere",
    "glass",
    "camera",
    "shading",
    "round",
    "tree",
    "single",
    "beam",
    "capsule",
    "face",
    "walk",
    "cone",
    "near",
    "beads",
    "build",
    "film",
    "scene",
    "mesh",
    "path",
    "tile",
    "raster",
    "light",
    "through",
    "onward",
    "trace",
    "samples",
    "render",
    "denoise",
)

LAUNCHES = 3  # to be counted up where a kernel gets another size of work-group: binaries hold one
_building = threading.Lock()  # catch_warnings() is not for several threads


def kernel_source() -> str:
    """The kernel's source, one text of all files; #line names the file in error messages."""
    folder = storage.folder("kernels")
    return "".join(
        f'#line 1 "{name}.cl"\n' + (folder / f"{name}.cl").read_text() for name in KERNELS
    )


def compiled(
    context: "cl.Context", device: "cl.Device", source: str, options: Sequence[str]
) -> "cl.Program":
    """A program, compiled here and now.

    Raises:
        DeviceError: the device cannot compile it.
    """
    import pyopencl as cl

    if pocl.takes_declarations(device):
        source = (storage.folder("kernels") / "builtins.cl").read_text() + source
        options = [*options, "-D_OPENCL_H_"]  # the guard of OpenCL's header, which is left out then
    try:
        return _built(cl.Program(context, source), options)
    except cl.Error as error:
        raise DeviceError(f"it cannot compile the kernel: {_first_error(str(error))}") from None


def kernels(program: "cl.Program") -> "dict[str, cl.Kernel]":
    """By their names."""
    return {kernel.function_name: kernel for kernel in program.all_kernels()}


def binary(program: "cl.Program") -> bytes:
    """The binary of a program.

    To be asked for after the first run: PoCL compiles the last part of a kernel then, for the size
    of its work-groups, and a binary that was asked for before would be without it.
    """
    import pyopencl as cl

    pocl.spare_generic()
    (found,) = cast(list[bytes], program.get_info(cl.program_info.BINARIES))
    return found


def loaded(context: "cl.Context", device: "cl.Device", binary: bytes) -> "cl.Program":
    """A program of its binary.

    Raises:
        pyopencl.Error: the device refuses it.
    """
    import pyopencl as cl

    return _built(cl.Program(context, [device], [binary]), ())


def _built(program: "cl.Program", options: Sequence[str]) -> "cl.Program":
    import pyopencl as cl

    pocl.run_folder().mkdir(parents=True, exist_ok=True)  # somebody may have cleaned up
    with _building, pocl.signals_kept(), warnings.catch_warnings():
        warnings.simplefilter("ignore", cl.CompilerWarning)  # Intel says that it is done
        built: cl.Program = program.build(options=list(options))
        return built


def cache_path(device: "cl.Device", source: str, options: Sequence[str]) -> Path:
    """Where a program is kept."""
    of_source = hashlib.sha256(source.encode()).digest()  # its repr() takes ten times as long
    depends_on = of_source, list(options), identity(device), LAUNCHES
    key = hashlib.sha256(repr(depends_on).encode()).hexdigest()
    return storage.cache_folder() / key


def _first_error(log: str) -> str:
    """The line of a build log that has the error."""
    lines = [line.strip() for line in log.splitlines()]
    return next((line for line in lines if "error:" in line), lines[0])
