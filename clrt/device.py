"""OpenCL devices: which there are, and which one to use."""

import os
from contextlib import suppress
from typing import TYPE_CHECKING

from clrt import pocl
from clrt.errors import DeviceError

if TYPE_CHECKING:
    import pyopencl as cl

_started_in: int | None = None  # the process that started OpenCL
INSTALL_HINT = "pip install 'pyopencl[pocl]' brings one for the CPU"


def devices(threads: int | None = None) -> list["cl.Device"]:
    """Every OpenCL device found, CPUs first.

    Args:
        threads: how many PoCL may use; None means every core that this process may use. It is
            read when OpenCL starts, so only the first call of a process can say.

    Raises:
        DeviceError: OpenCL is not there, or has no device.
    """
    refuse_fork()
    found = []
    with pocl.starting(threads):
        try:
            import pyopencl as cl
        except ImportError as error:
            raise DeviceError(f"OpenCL does not load ({error}): {INSTALL_HINT}") from None
        with suppress(cl.Error):  # no platform
            for platform in cl.get_platforms():
                with suppress(cl.Error):  # this one has no device
                    found += platform.get_devices()
    if not found:
        raise DeviceError(f"no OpenCL device found: {INSTALL_HINT}")
    for device in found:
        if is_pocl(device) and device.version.endswith("-generic"):
            with suppress(LookupError, OSError):  # if it fails, the build will tell
                pocl.name_cpu(device.int_ptr)
    return sorted(found, key=lambda device: not device.type & cl.device_type.CPU)


def refuse_fork() -> None:
    """Says so if this process was forked off one that had started OpenCL, whose threads it lacks.

    Raises:
        DeviceError: it was. Any use of OpenCL would hang.
    """
    global _started_in
    if _started_in is None:
        _started_in = os.getpid()
    if _started_in != os.getpid():
        raise DeviceError(
            "this process was forked off one that had started OpenCL: "
            "use multiprocessing.get_context('spawn')"
        )


def is_pocl(device: "cl.Device") -> bool:
    return bool(device.platform.name == "Portable Computing Language")


def find_device(name: str | None = None, threads: int | None = None) -> "cl.Device":
    """The first device, or the first whose name or platform contains `name`, in any case.

    Raises:
        DeviceError: there is none.
    """
    found = devices(threads)
    for device in found:
        if name is None or name.lower() in label(device).lower():
            if threads is not None and is_pocl(device) and device.max_compute_units != threads:
                raise DeviceError(
                    f"OpenCL already runs with {device.max_compute_units} threads, not {threads}: "
                    "choose before its first use in a process"
                )
            return device
    there = "; ".join(map(label, found))
    raise DeviceError(f"no OpenCL device is called {name!r}; there are: {there}")


def label(device: "cl.Device") -> str:
    """The names of the device and its platform, and its driver's version, on one line."""
    platform, driver = device.platform.name.strip(), device.driver_version.strip()
    return f"{device.name.strip()} ({platform}, {driver})"
