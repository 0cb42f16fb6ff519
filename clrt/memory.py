"""Memory: whether what is asked for fits, before hours are spent on it."""

import resource
from contextlib import suppress
from pathlib import Path

from clrt.errors import OutputError


def require(size: int, what: str, advice: str = "render it in parts (--region) or smaller") -> None:
    """Says so if there is no room for `size` bytes more.

    Linux grants memory that is not there and kills who uses it, so that nobody could say anything.

    Raises:
        OutputError: there is none.
    """
    free = available()
    if size > free:
        raise OutputError(
            f"{what} needs {size / 1e9:.1f} GB of memory and {max(free, 0) / 1e9:.1f} GB are free: "
            f"{advice}"
        )


def available() -> int:
    """Bytes that this process may still take: of the machine, its control group and its limit."""
    room = [_fields(Path("/proc/meminfo"))["MemAvailable:"] * 1024]
    with suppress(OSError, KeyError, ValueError, IndexError):  # cgroup v2, if it has a limit
        group = Path("/proc/self/cgroup").read_text().split("::")[1].split("\n")[0]
        folder = Path(f"/sys/fs/cgroup{group}")
        used = int((folder / "memory.current").read_text())
        cached = _fields(folder / "memory.stat")["inactive_file"]
        room.append(int((folder / "memory.max").read_text()) - used + cached)
    limit, _ = resource.getrlimit(resource.RLIMIT_AS)
    if limit != resource.RLIM_INFINITY:
        room.append(limit - _fields(Path("/proc/self/status"))["VmSize:"] * 1024)
    return min(room)


def _fields(path: Path) -> dict[str, int]:
    """The lines "name number ..." of a file of the kernel's."""
    words = (line.split() for line in path.read_text().splitlines())
    return {name: int(rest[0]) for name, *rest in words if rest and rest[0].isdecimal()}
