"""Programs: the kernels' source, compiled for a device, and kept for the next process.

PoCL's way to keep compiled programs is not used (clrt/pocl.py). This one is as fast: a program is
there in 3 ms, and in PoCL's would be after 33 ms, for it preprocesses the source to find it.
"""

import hashlib
import os
import secrets
import threading
import warnings
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, cast

from clrt import data, pocl
from clrt.device import label
from clrt.errors import DeviceError

if TYPE_CHECKING:
    import pyopencl as cl

KERNELS = ("lanes", "sphere", "camera", "shading", "film", "render")

_building = threading.Lock()  # catch_warnings() is not for several threads


def kernel_source() -> str:
    """The kernel's source, one text of all files; #line names the file in error messages."""
    folder = data.folder("kernels")
    return "".join(
        f'#line 1 "{name}.cl"\n' + (folder / f"{name}.cl").read_text() for name in KERNELS
    )


class Program:
    """The program for a device, from the cache if it is there.

    Raises:
        DeviceError: the device cannot compile it.
    """

    def __init__(self, context: "cl.Context", device: "cl.Device", options: list[str]) -> None:
        import pyopencl as cl

        source = kernel_source()
        of_device = (device.name, device.version, device.driver_version, cl.VERSION)
        key = hashlib.sha256(repr((source, options, of_device)).encode()).hexdigest()
        self._path = data.cache_folder() / key
        pocl.run_folder().mkdir(parents=True, exist_ok=True)  # somebody may have cleaned up
        with _building, pocl.signals_kept(), warnings.catch_warnings():
            warnings.simplefilter("ignore", cl.CompilerWarning)  # Intel says that it is done
            kept = self._kept(context, device)
            self._is_kept = kept is not None
            try:
                self._built = kept or cl.Program(context, source).build(options=options)
            except cl.Error as error:
                message = f"{label(device)} cannot compile the kernel: {_first_error(str(error))}"
                raise DeviceError(message) from None
        self.render: cl.Kernel = self._built.render

    def _kept(self, context: "cl.Context", device: "cl.Device") -> "cl.Program | None":
        """From the cache; what cannot be read, was cut short or is refused is built again."""
        import pyopencl as cl

        with suppress(OSError, cl.Error):
            content = self._path.read_bytes()
            size = hashlib.sha256().digest_size
            if hashlib.sha256(content[size:]).digest() == content[:size]:
                built: cl.Program = cl.Program(context, [device], [content[size:]]).build()
                return built
        return None

    def keep(self) -> None:
        """Keeps it, if it is not kept yet, as sha256(binary) + binary.

        To be called after the first run: PoCL compiles the last part of a kernel then, for the size
        of its work-groups, and a binary that was asked for before would be without it.
        """
        import pyopencl as cl

        if self._is_kept:
            return
        self._is_kept = True
        with suppress(OSError, cl.Error):  # slower next time
            (binary,) = cast(list[bytes], self._built.get_info(cl.program_info.BINARIES))
            _write(self._path, hashlib.sha256(binary).digest() + binary)


def _write(path: Path, content: bytes) -> None:
    """Whole or not at all. What was there stays as it is for those who have it open."""
    beside = path.with_suffix(f".{secrets.token_hex(4)}")
    try:
        beside.write_bytes(content)
        os.replace(beside, path)
    finally:
        beside.unlink(missing_ok=True)


def _first_error(log: str) -> str:
    """The line of a build log that says what is wrong."""
    lines = [line.strip() for line in log.splitlines()]
    return next((line for line in lines if "error:" in line), lines[0])
