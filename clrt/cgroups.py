"""Control groups: what Linux lets a container, or a job of a cluster, have of the machine."""

import math
import os
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

MOUNT, OWN = Path("/sys/fs/cgroup"), Path("/proc/self/cgroup")


def folders(controller: str) -> Iterator[tuple[int, Path]]:
    """Where this process's groups, and all that these are in, tell of "memory" or "cpu": the
    version of control groups, 1 or 2, and a folder, which need not be there."""
    lines = []
    with suppress(OSError):
        lines = OWN.read_text().splitlines()
    for line in lines:
        _, controllers, group = line.split(":", 2)
        version, mount = (1, MOUNT / controller) if controllers else (2, MOUNT)
        if version == 2 or controller in controllers.split(","):
            for folder in (Path(group), *Path(group).parents):
                yield version, mount / folder.relative_to("/")


def cores() -> int:
    """How many threads of this process can run at a time: those of its affinity, or as many as its
    groups' shares of time come to, rounded up."""
    share = min((_share(*found) for found in folders("cpu")), default=math.inf)
    return math.ceil(min(share, len(os.sched_getaffinity(0))))


def _share(version: int, folder: Path) -> float:
    """The cores' worth of time that a group may take; infinite if it has no limit."""
    with suppress(OSError, ValueError):  # it is not there; "max"
        if version == 2:
            quota, period = (folder / "cpu.max").read_text().split()
        else:
            quota = (folder / "cpu.cfs_quota_us").read_text()
            period = (folder / "cpu.cfs_period_us").read_text()
        if int(quota) > 0:  # -1 in version 1
            return int(quota) / int(period)
    return math.inf
