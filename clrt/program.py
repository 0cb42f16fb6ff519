"""Programs: the kernels' source, compiled for a device, and kept as a binary for the next process.

PoCL keeps compiled programs as well, but to find one it preprocesses the source with all of
OpenCL's headers, which takes 33 ms; from a binary a program is there in 3 ms.
"""

import hashlib
import os
import secrets
from contextlib import suppress
from typing import TYPE_CHECKING, cast

from clrt import data
from clrt.device import label
from clrt.errors import DeviceError

if TYPE_CHECKING:
    import pyopencl as cl

KERNELS = ("lanes", "sphere", "camera", "shading", "film", "render")


def kernel_source() -> str:
    """The kernel's source, one text of all files; #line names the file in error messages."""
    folder = data.folder("kernels")
    return "".join(
        f'#line 1 "{name}.cl"\n' + (folder / f"{name}.cl").read_text() for name in KERNELS
    )


def build(context: "cl.Context", device: "cl.Device", options: list[str]) -> "cl.Program":
    """The program for a device, from the cache if it is there.

    Raises:
        DeviceError: the device cannot compile it.
    """
    import pyopencl as cl

    source = kernel_source()
    of_device = (device.name, device.version, device.driver_version, cl.VERSION)
    key = hashlib.sha256(repr((source, options, of_device)).encode()).hexdigest()
    path = data.cache_folder() / key
    # What cannot be read, is cut short or is refused is built again.
    with suppress(OSError, cl.Error):
        digest, binary = _split(path.read_bytes())
        if hashlib.sha256(binary).digest() == digest:
            kept: cl.Program = cl.Program(context, [device], [binary]).build()
            return kept
    try:
        program: cl.Program = cl.Program(context, source).build(options=options)
    except cl.Error as error:
        message = f"{label(device)} cannot compile the kernel: {_first_error(str(error))}"
        raise DeviceError(message) from None
    with suppress(OSError, cl.Error):  # no cache: slower next time
        (binary,) = cast(list[bytes], program.get_info(cl.program_info.BINARIES))
        path.parent.mkdir(parents=True, exist_ok=True)
        beside = path.with_suffix(f".{secrets.token_hex(4)}")
        beside.write_bytes(hashlib.sha256(binary).digest() + binary)
        os.replace(beside, path)
    return program


def _split(kept: bytes) -> tuple[bytes, bytes]:
    size = hashlib.sha256().digest_size
    return kept[:size], kept[size:]


def _first_error(log: str) -> str:
    """The line of a build log that says what is wrong."""
    lines = [line.strip() for line in log.splitlines()]
    return next((line for line in lines if "error:" in line), lines[0])
