"""PoCL: the environment in which it starts, and what must be right just after."""

import atexit
import ctypes
import importlib
import os
import re
import shlex
import shutil
import signal
import struct
import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING

from clrt import cgroups, storage
from clrt.errors import RequestError

if TYPE_CHECKING:
    import pyopencl as cl

# Those that LLVM takes: to end, to report, and of what went beyond a limit.
SIGNALS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT, signal.SIGUSR1,
           signal.SIGUSR2, signal.SIGPIPE, signal.SIGXFSZ, signal.SIGXCPU)  # fmt: skip
THREAD_VARIABLES = ("POCL_MAX_PTHREAD_COUNT", "POCL_CPU_MAX_CU_COUNT")  # PoCL 3; later versions

_run_folder: Path | None = None


@contextmanager
def starting(threads: int | None) -> Iterator[None]:
    """The environment in which OpenCL starts; what the user has set stays, unless `threads` says
    otherwise, and it is put back at the end.

    threads: for PoCL; None means every core that this process may use, see clrt.cgroups.

    Raises:
        DeviceError: there is no room for what PoCL compiles.
        RequestError: a variable is no number of threads, at which PoCL would crash.
    """
    cores = str(threads or cgroups.cores())
    wanted = dict.fromkeys(THREAD_VARIABLES, cores)
    # PyOpenCL's cache, a database that a full disk or a second machine can spoil, saves no time.
    wanted["PYOPENCL_NO_CACHE"] = "1"
    with signals_kept():
        # Whatever the user has set: a folder that cannot be written, or that holds a file which was
        # cut short, ends the process. clrt needs none of theirs.
        wanted["POCL_CACHE_DIR"] = str(run_folder())
        before = {name: os.environ.get(name) for name in wanted}
        for name, value in wanted.items():
            is_set = name in THREAD_VARIABLES and before[name]
            if is_set and not re.fullmatch("[1-9][0-9]{0,3}", before[name] or ""):
                expected = "a number of threads from 1 to 9999"
                raise RequestError(f"{name}: expected {expected}, got {before[name]!r}")
            if threads is not None or not is_set:
                os.environ[name] = value
        try:
            yield
        finally:
            for name, was in before.items():
                if was is None:
                    os.environ.pop(name, None)
                else:
                    os.environ[name] = was


@contextmanager
def linking() -> Iterator[None]:
    """Has PoCL link by clrt/opencl/linker.py what it compiles, whatever PATH is.

    PoCL links as clang does, which looks for `ld` in COMPILER_PATH first. The variable is put back
    at the end: gcc, which others may start from this process, reads it as well.
    """
    if os.uname().machine != "x86_64" or not sys.executable:
        yield
        return
    folder = run_folder() / "bin"
    folder.mkdir(parents=True, exist_ok=True)
    # Imported, because Python keeps it compiled then: that saves 2 of 10 ms.
    start = "import sys; sys.path.insert(0, sys.argv[1]); import linker; linker.main(sys.argv[2:])"
    words = [sys.executable, "-SPc", start, str(Path(__file__).parent)]
    script = folder / "ld"
    script.write_text(f'#!/bin/sh\nexec {shlex.join(words)} "$@"\n')
    script.chmod(0o700)
    before = os.environ.get("COMPILER_PATH")
    os.environ["COMPILER_PATH"] = os.pathsep.join(filter(None, (str(folder), before)))
    try:
        yield
    finally:
        if before is None:
            del os.environ["COMPILER_PATH"]
        else:
            os.environ["COMPILER_PATH"] = before


@contextmanager
def signals_kept() -> Iterator[None]:
    """Answers signals only afterwards, by the handlers that were there before.

    LLVM, which compiles for PoCL and for Intel, puts its own in their place. They hand the signal
    on, but work once only: a second one, which `timeout` sends, ends the process with its files
    half written; and SIGQUIT and SIGUSR1 they swallow. And an exception from a handler while
    PyOpenCL is imported aborts ("Critical nanobind error").
    """
    if threading.current_thread() is not threading.main_thread():  # others have no handlers
        yield
        return
    came: list[int] = []
    before = {}
    for number in SIGNALS:
        before[number] = signal.getsignal(number)
        if callable(before[number]):  # else it is ignored, or ends the process
            signal.signal(number, lambda number, frame: came.append(number))
    try:
        yield
    finally:
        for number, handler in before.items():
            if handler is not None:
                signal.signal(number, handler)
        for first in came[:1]:
            signal.raise_signal(first)


def run_folder() -> Path:
    """The folder where PoCL keeps what this process compiles.

    PoCL's own cache, ~/.cache/pocl, is never read: a file in it that was cut short ends the
    process ("file too short"), before anything can be said. clrt/opencl/program.py keeps programs
    for the next process, and checks them.
    """
    global _run_folder
    if _run_folder is None:
        cache = storage.cache_folder(runs=True)
        for parent in {cache, storage.cache_folder()}:  # 0.3.0 ran from the latter
            for old in storage.abandoned(parent.glob("run-*")):
                shutil.rmtree(old, ignore_errors=True)
        _run_folder = Path(tempfile.mkdtemp(prefix="run-", dir=cache))
        with suppress(OSError):  # some network file systems have no locks
            storage.locked(_run_folder)
        atexit.register(_remove, _run_folder, os.getpid())
    return _run_folder


def takes_declarations(device: "cl.Device") -> bool:
    """Whether kernels/builtins.cl can stand for OpenCL's header: that of PoCL 3.0 was tried."""
    return "PoCL 3.0" in device.platform.version


def spare_generic() -> None:
    """Spares PoCL a second compilation of each kernel, to be called before a binary is asked for.

    PoCL compiles a kernel for each size of work-group, and for a binary once more, for any size: a
    third to a half of the time that a program takes. clrt runs each kernel with one size only
    (clrt/opencl/bands.py, edges.py, tree.py), so the library of that size stands in for the other.
    A size that the binary lacks would be compiled when it is met, as ever.
    """
    for library in run_folder().glob("*/*/*/*-smallgrid/*.so"):
        generic = library.parent.parent / "0-0-0" / library.name
        with suppress(OSError):  # it is there, or a file system has no links
            generic.parent.mkdir(exist_ok=True)
            os.link(library, generic)


def _remove(folder: Path, owner: int) -> None:
    if os.getpid() == owner:  # and not a fork of it
        shutil.rmtree(folder, ignore_errors=True)


# For the width of PoCL's kernel library, in float32, the CPUs that it was compiled for, best first,
# and what each needs of a CPU, by NumPy's names. A CPU that lacks some is given the next name.
CPU_NAMES: dict[int, list[tuple[str, tuple[str, ...]]]] = {
    16: [("skylake-avx512", ("AVX512F", "AVX512CD", "AVX512BW", "AVX512DQ", "AVX512VL"))],
    8: [
        ("haswell", ("AVX2", "FMA3", "F16C", "BMI", "BMI2", "LZCNT", "MOVBE")),
        ("sandybridge", ("AVX",)),
    ],
    4: [("nehalem", ("SSE42", "POPCNT")), ("x86-64", ("SSE2",))],
}
NARROW = 16  # bytes of the vectors that every x86-64 CPU passes in the same way
_names: dict[int, str | None] = {}  # given to devices, by their addresses; None: it could not be


def name_cpu(device: "cl.Device") -> None:
    """Makes PoCL compile for a CPU that agrees with its library of built-in functions.

    PoCL takes the library by what CPUID says, but compiles for the name that LLVM has for the CPU.
    The two need not agree: Zen 4 has AVX-512, but LLVM 14 takes it for Zen 3, which has not; a
    hypervisor masks AVX-512 of a CPU whose name promises it; a younger CPU is called "generic",
    which clang refuses (pocl issue 1049). A vector that is wider than the named CPU's registers is
    then passed in memory and taken from a register. What LLVM makes of that is a loop until memory
    is full, a crash, or a wrong picture. No option or variable can say otherwise, so the name is
    replaced. PoCL 3.1 and later name the device after its library by themselves.

    If it cannot be done the device is narrow, see is_narrow().
    """
    version = re.search(r"PoCL (\d+)\.(\d+)", device.platform.version)
    if device.int_ptr in _names or (version and tuple(map(int, version.groups())) >= (3, 1)):
        return
    _names[device.int_ptr] = None
    with suppress(LookupError, OSError):
        rename(device, cpu_name(device.native_vector_width_float))


def rename(device: "cl.Device", name: str) -> None:
    """Makes PoCL compile for that CPU, before it compiles at all.

    Raises:
        OSError, LookupError: it could not be done.
    """
    # "OpenCL 3.0 PoCL HSTR: pthread-x86_64-unknown-linux-gnu-znver3"
    found = _names.get(device.int_ptr) or device.version.split("-linux-gnu-")[1]
    _replace(device.int_ptr, found, name)
    _names[device.int_ptr] = name


def name_given(device: "cl.Device") -> str | None:
    """The CPU that it was told to compile for."""
    return _names.get(device.int_ptr)


def is_narrow(device: "cl.Device") -> bool:
    """Whether vectors of more than NARROW bytes cannot be trusted."""
    return _names.get(device.int_ptr, "") is None


def cpu_name(width: int) -> str:
    """The CPU to compile for on this one, for a kernel library with `width` float32 a vector.

    Asked of the CPU itself (CPUID): /proc/cpuinfo is the host's under emulation.

    Raises:
        LookupError: there is no such library, or none that this CPU can use.
    """
    has = _cpu_features()
    for name, needed in CPU_NAMES[width]:
        if all(has.get(feature, True) for feature in needed):  # older NumPys know fewer
            return name
    raise LookupError(f"no CPU's name for vectors of {width}")


def _cpu_features() -> dict[str, bool]:
    """What CPUID says, by NumPy's names. NumPy's own dispatch rests on this table."""
    try:
        umath = importlib.import_module("numpy._core._multiarray_umath")
    except ImportError:  # NumPy 1
        umath = importlib.import_module("numpy.core._multiarray_umath")
    found: dict[str, bool] = umath.__cpu_features__
    return found


class _Symbol(ctypes.Structure):
    """Dl_info of dladdr()."""

    _fields_ = (
        ("file", ctypes.c_char_p),
        ("base", ctypes.c_void_p),
        ("name", ctypes.c_char_p),
        ("address", ctypes.c_void_p),
    )


def library(device: "cl.Device") -> Path:
    """The file of the PoCL whose device it is. No name or version tells several apart for sure."""
    # The first word of each of OpenCL's objects points to the functions of its library
    # (cl_khr_icd).
    functions, found = ctypes.c_void_p.from_address(device.int_ptr), _Symbol()
    ctypes.CDLL(None).dladdr(functions, ctypes.byref(found))
    return Path(os.fsdecode(found.file or b""))


def _replace(device_address: int, old: str, new: str) -> None:
    """Replaces the name in PoCL's device structure: its first pointer to such a text.

    Memory is read and written through a pipe, for which the kernel copies: a wrong address is an
    error and not a crash. /proc/self/mem would do, but there may be no /proc.

    Raises:
        OSError, LookupError: it could not be done.
    """
    libc = ctypes.CDLL(None)
    libc.strdup.restype = ctypes.c_void_p
    libc.read.argtypes = libc.write.argtypes = [ctypes.c_int, ctypes.c_void_p, ctypes.c_size_t]
    text = old.encode() + b"\0"
    reader, writer = os.pipe()

    def memory(address: int, size: int) -> bytes:
        copied = libc.write(writer, address, size)
        return os.read(reader, copied) if copied > 0 else b""

    try:
        structure = memory(device_address, 1024)
        for offset, (pointer,) in enumerate(struct.iter_unpack("<Q", structure)):
            if memory(pointer, len(text)) == text:  # else a word that may be no pointer
                # From malloc, as the one that it replaces: PoCL may free it.
                address = struct.pack("<Q", libc.strdup(new.encode()))
                os.write(writer, address)
                if libc.read(reader, device_address + 8 * offset, len(address)) != len(address):
                    raise OSError("PoCL's device structure cannot be written")
                return
        raise LookupError("no pointer to the CPU's name")
    finally:
        os.close(reader)
        os.close(writer)
