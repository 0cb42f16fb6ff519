"""PoCL: what must be right before, and just after, it starts."""

import ctypes
import os
import stat
import struct
import tempfile
from pathlib import Path

from clrt import data

THREAD_VARIABLES = ("POCL_MAX_PTHREAD_COUNT", "POCL_CPU_MAX_CU_COUNT")  # PoCL 3; later versions


def prepare(threads: int | None) -> None:
    """Sets the environment that PoCL reads when it starts; what the user has set stays,
    unless `threads` says otherwise.

    threads: None means every core that this process may use.
    """
    for variable in THREAD_VARIABLES:
        if threads is not None:
            os.environ[variable] = str(threads)
        else:
            os.environ.setdefault(variable, str(len(os.sched_getaffinity(0))))
    # Where they cannot write a cache PoCL finds no device and PyOpenCL fails.
    if not _writable(data.user_cache()):
        os.environ["XDG_CACHE_HOME"] = str(_temporary_cache())


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)


def _temporary_cache() -> Path:
    """A folder that only this user can write, the same one in every run if possible."""
    folder = Path(tempfile.gettempdir()) / f"clrt-{os.getuid()}"
    folder.mkdir(mode=0o700, exist_ok=True)
    status = folder.lstat()
    if status.st_uid == os.getuid() and stat.S_ISDIR(status.st_mode) and _writable(folder):
        return folder
    return Path(tempfile.mkdtemp(prefix="clrt-"))


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
