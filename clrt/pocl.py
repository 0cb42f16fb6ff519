"""PoCL: the environment in which it starts, and what must be right just after."""

import atexit
import ctypes
import fcntl
import os
import shutil
import signal
import struct
import tempfile
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

from clrt import data

THREAD_VARIABLES = ("POCL_MAX_PTHREAD_COUNT", "POCL_CPU_MAX_CU_COUNT")  # PoCL 3; later versions
YOUNG = 60  # seconds; a younger folder may not be locked yet

_run_folder: Path | None = None


@contextmanager
def starting(threads: int | None) -> Iterator[None]:
    """The environment in which OpenCL starts; what the user has set stays, unless `threads` says
    otherwise, and it is put back at the end.

    threads: for PoCL; None means every core that this process may use.

    Raises:
        DeviceError: there is no room for what PoCL compiles.
    """
    cores = str(threads or len(os.sched_getaffinity(0)))
    wanted = dict.fromkeys(THREAD_VARIABLES, cores)
    # PyOpenCL's cache, a database that a full disk or a second machine can spoil, saves no time.
    wanted["PYOPENCL_NO_CACHE"] = "1"
    with signals_kept():
        wanted["POCL_CACHE_DIR"] = str(run_folder())
        before = {name: os.environ.get(name) for name in wanted}
        for name, value in wanted.items():
            if before[name] is None or (threads is not None and name in THREAD_VARIABLES):
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
def signals_kept() -> Iterator[None]:
    """Answers Ctrl-C, SIGTERM and SIGHUP only afterwards, by the handlers that were there before.

    LLVM, which compiles for PoCL and for Intel, puts its own in their place. They hand the signal
    on, but work once only: a second one, which `timeout` sends, ends the process with its files
    half written. And an exception from a handler while PyOpenCL is imported aborts ("Critical
    nanobind error").
    """
    if threading.current_thread() is not threading.main_thread():  # others have no handlers
        yield
        return
    came: list[int] = []
    before = {}
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
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
    process ("file too short"), before anything can be said. clrt/program.py keeps programs for the
    next process, and checks them.
    """
    global _run_folder
    if _run_folder is None:
        cache = data.cache_folder()
        for old in cache.glob("run-*"):
            with suppress(OSError):
                if time.time() - old.stat().st_mtime > YOUNG:
                    os.close(_locked(old))  # an error if its process lives
                    shutil.rmtree(old, ignore_errors=True)
        _run_folder = Path(tempfile.mkdtemp(prefix="run-", dir=cache))
        with suppress(OSError):  # some network file systems have no locks
            _locked(_run_folder)
        atexit.register(_remove, _run_folder, os.getpid())
    return _run_folder


def _locked(folder: Path) -> int:
    """Locks it for as long as this process lives, or until the file that is returned is closed."""
    file = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(file)
        raise
    return file


def _remove(folder: Path, owner: int) -> None:
    if os.getpid() == owner:  # and not a fork of it
        shutil.rmtree(folder, ignore_errors=True)


# What each level of x86-64 adds, best first, by the names of /proc/cpuinfo; and the CPU whose name
# PoCL's own kernel library for that level was compiled with.
CPU_LEVELS = (
    ("skylake-avx512", {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl", "avx2", "fma"}),
    ("haswell", {"avx2", "fma", "bmi1", "bmi2", "f16c", "movbe"}),
    ("x86-64", {"sse2"}),
)
UNKNOWN_CPU = b"generic\0"
_named: set[int] = set()  # the addresses of devices that have been given a name


def name_cpu(device_address: int) -> None:
    """Gives PoCL a CPU name that its compiler takes, where it found none by itself.

    PoCL asks its LLVM for the host's name. A CPU that is younger than that LLVM (14 in the wheel of
    PoCL 3.0, which ends at Zen 3) is called "generic", a name that clang then refuses: every build
    fails with "unknown target CPU 'generic'" (pocl issue 1049), and no option or environment
    variable can say otherwise. So the name is replaced in PoCL's device structure, at
    `device_address`, which is searched for its first pointer to the text "generic". Memory is read
    and written through /proc/self/mem, where a wrong address is an error and not a crash.

    Raises:
        OSError, LookupError: it could not be done; builds will fail.
    """
    if device_address in _named:
        return
    flags: set[str] = set()
    with open("/proc/cpuinfo") as cpuinfo:
        for line in cpuinfo:
            if line.startswith("flags"):
                flags = set(line.split(":")[1].split())
                break
    name = next(name for name, needed in CPU_LEVELS if needed <= flags)
    libc = ctypes.CDLL(None)
    libc.strdup.restype = ctypes.c_void_p
    memory = os.open("/proc/self/mem", os.O_RDWR)
    try:
        structure = os.pread(memory, 1024, device_address)
        for offset, (pointer,) in enumerate(struct.iter_unpack("<Q", structure)):
            try:
                found = os.pread(memory, len(UNKNOWN_CPU), pointer) == UNKNOWN_CPU
            except (OSError, OverflowError):  # a word that is no pointer
                continue
            if found:
                # From malloc, as the one that it replaces: PoCL may free it.
                new = struct.pack("<Q", libc.strdup(name.encode()))
                os.pwrite(memory, new, device_address + 8 * offset)
                _named.add(device_address)
                return
        raise LookupError("no pointer to the CPU's name")
    finally:
        os.close(memory)
