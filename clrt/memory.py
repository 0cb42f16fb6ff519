"""Memory: whether a request fits, before hours are spent on it, and the memory of films."""

import math
import resource
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from clrt import cgroups
from clrt.errors import OutputError

# Of each version of control groups, what files and field say limit and use. Cached files are given
# up for what is needed.
CGROUPS = {
    1: ("memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file"),
    2: ("memory.max", "memory.current", "inactive_file"),
}

# For less the system is not asked for its free memory: that takes up to 1 ms, a 4K picture 13.
UNASKED_BYTES = 1 << 27


def require(size: int, what: str, advice: str = "render it in parts or smaller") -> None:
    """Says so if there is no room for `size` bytes more.

    Linux grants memory that is not there and kills who uses it, so that nobody could say anything.

    Raises:
        OutputError: there is none.
    """
    if size < UNASKED_BYTES:
        return
    free = available()
    if size > free:
        raise OutputError(
            f"{what} needs {size / 1e9:.1f} GB of memory and {max(free, 0) / 1e9:.1f} GB are free: "
            f"{advice}"
        )


def available() -> int:
    """Bytes that this process may still take: of the machine, its control group and its limit.

    Where the system tells no limit there is none here: to try finds out.
    """
    room = [sys.maxsize]
    with suppress(OSError, KeyError):
        room.append(_fields(Path("/proc/meminfo"))["MemAvailable:"] * 1024)
    for version, folder in cgroups.folders("memory"):
        limit, used, cached = CGROUPS[version]
        with suppress(OSError, KeyError, ValueError):  # it has no limit, or is not shown
            most = int((folder / limit).read_text()) - int((folder / used).read_text())
            room.append(most + _fields(folder / "memory.stat")[cached])
    most, _ = resource.getrlimit(resource.RLIMIT_AS)
    if most != resource.RLIM_INFINITY:
        with suppress(OSError, KeyError):
            room.append(most - _fields(Path("/proc/self/status"))["VmSize:"] * 1024)
    return min(room)


def _fields(path: Path) -> dict[str, int]:
    """The lines "name number ..." of a file of the kernel's."""
    words = (line.split() for line in path.read_text().splitlines())
    return {name: int(rest[0]) for name, *rest in words if rest and rest[0].isdecimal()}


class Films:
    """Films, each in the memory of the last one if nobody has that any more: to get new memory from
    the system, page by page, takes longer than to render a simple scene."""

    def __init__(self) -> None:
        self._last = np.empty(0, np.uint8)  # the memory of the last film
        self._unused = 0  # how many references there are to it if nobody has the film

    def film(self, shape: tuple[int, ...], dtype: np.dtype[Any]) -> NDArray[Any]:
        """An array of its own, as far as anybody can see.

        Raises:
            OutputError: it does not fit into memory.
        """
        size = math.prod(shape) * dtype.itemsize
        if not (size <= self._last.size <= 2 * size and self._references() == self._unused):
            self._last = np.empty(0, np.uint8)  # the old goes before the new comes
            require(size, f"a film of {shape[1]}x{shape[0]}")
            self._last = np.empty(size, np.uint8)
            self._unused = self._references()
        return self._last[:size].view(dtype).reshape(shape)

    def _references(self) -> int:
        """How many there are to the memory of the last film; every view of it has one."""
        return sys.getrefcount(self._last)
