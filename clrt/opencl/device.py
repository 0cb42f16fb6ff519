"""OpenCL devices: which there are, and which one to use."""

import os
import threading
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING

from clrt.errors import DeviceError
from clrt.opencl import pocl

if TYPE_CHECKING:
    import pyopencl as cl

_used_in: int | None = None  # the process that uses OpenCL
_starting = threading.Lock()  # the environment is all threads'
# PyPI has PoCL for x86-64 only.
INSTALL = (
    "pip install pocl-binary-distribution"
    if os.uname().machine == "x86_64"
    else "apt-get install pocl-opencl-icd"
)
INSTALL_HINT = f"{INSTALL} brings one for the CPU"


def devices(threads: int | None = None) -> list["cl.Device"]:
    """Every OpenCL device found, CPUs first, and of these PoCL as pip brought it.

    It is what clrt is tested with most, and traces trees faster than later ones (docs/opencl.md).

    Args:
        threads: how many PoCL may use; None means every core that this process may use. It is
            read when OpenCL starts, so only the first call of a process can say.

    Raises:
        DeviceError: OpenCL is not there, or has no device.
    """
    check_process()
    found = []
    with _starting, pocl.starting(threads):
        try:
            import pyopencl as cl
        except ImportError as error:
            raise DeviceError(f"OpenCL does not load ({error}): {INSTALL_HINT}") from None
        with suppress(cl.Error):  # no platform
            for platform in cl.get_platforms():
                with suppress(cl.Error):  # this one has no device
                    found += platform.get_devices()
        for device in filter(is_pocl, found):
            pocl.name_cpu(device)
    if not found:
        raise DeviceError(f"no OpenCL device found: {INSTALL_HINT}")
    folder = Path(cl.__file__).parents[1]
    return sorted(
        found,
        key=lambda device: (
            not device.type & cl.device_type.CPU,
            not (is_pocl(device) and folder in pocl.library(device).parents),
        ),
    )


def check_process() -> None:
    """Says so if this process was forked off one that had used OpenCL, whose threads it lacks.

    To be called before any use of OpenCL, and before any lock, which a fork could find taken.

    Raises:
        DeviceError: it was. OpenCL would hang.
    """
    global _used_in
    if _used_in is None:
        _used_in = os.getpid()
    if _used_in != os.getpid():
        raise DeviceError(
            "this process was forked off one that had started OpenCL: "
            "use multiprocessing.get_context('spawn')"
        )


def is_pocl(device: "cl.Device") -> bool:
    return bool(device.platform.name == "Portable Computing Language")


def find_device(name: str | None = None, threads: int | None = None) -> "cl.Device":
    """The first device, or the first whose label or platform's version has `name` in it, in any
    case.

    Raises:
        DeviceError: there is none.
    """
    found = devices(threads)
    for device in found:
        names = f"{label(device)} {device.platform.version}"
        if name is None or name.lower() in names.lower():
            if threads is not None and is_pocl(device) and device.max_compute_units != threads:
                raise DeviceError(
                    f"OpenCL already runs with {device.max_compute_units} threads, not {threads}: "
                    "choose before its first use in a process"
                )
            return device
    there = "; ".join(map(label, found))
    raise DeviceError(f"no OpenCL device is called {name!r}; there are: {there}")


def identity(device: "cl.Device") -> tuple[str, ...]:
    """The part of a device that a compiled program depends on."""
    import pyopencl as cl

    return (
        device.name,
        device.version,
        device.driver_version,
        cl.VERSION_TEXT,
        f"{device.native_vector_width_float} floats a vector",
        f"for {pocl.name_given(device)}",
    )


def label(device: "cl.Device") -> str:
    """The names of the device and its platform, and its driver's version, on one line."""
    return _with_platform(device.name, device)


def target(device: "cl.Device") -> str:
    """The CPU that kernels are compiled for, and the compiler. Pictures are equal to the bit where
    this is the same. CPUs of several names can have one target."""
    return _with_platform(pocl.name_given(device) or device.name, device)


def _with_platform(name: str, device: "cl.Device") -> str:
    platform, driver = device.platform.name.strip(), device.driver_version.strip()
    return f"{name.strip()} ({platform}, {driver})"
