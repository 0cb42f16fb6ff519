"""Control groups: files in place of the kernel's."""

import os
from pathlib import Path

import pytest

from clrt import cgroups
from clrt.opencl import pocl

V1 = "5:cpu,cpuacct:{0}\n4:memory:{0}\n1:name=systemd:/\n0::/\n"
V2 = "0::{0}\n"
MAX, QUOTA, PERIOD = "cpu.max", "cpu.cfs_quota_us", "cpu.cfs_period_us"
# What /proc/self/cgroup says, the files there are, and how many of eight cores that leaves.
CASES = [
    ("", {}, 8),
    (V2.format("/"), {}, 8),
    (V2.format("/"), {MAX: "max 100000\n"}, 8),
    (V2.format("/"), {MAX: "200000 100000\n"}, 2),
    (V2.format("/"), {MAX: "150000 100000\n"}, 2),
    (V2.format("/"), {MAX: "5000 100000\n"}, 1),
    (V2.format("/"), {MAX: "9000000 100000\n"}, 8),
    (V2.format("/"), {MAX: "nonsense"}, 8),
    (V2.format("/"), {QUOTA: "200000", PERIOD: "100000"}, 8),
    # The tightest of all that it is in counts.
    (V2.format("/job/step"), {f"job/{MAX}": "300000 100000", f"job/step/{MAX}": "max 100000"}, 3),
    (V2.format("/job/step"), {f"job/{MAX}": "300000 100000", f"job/step/{MAX}": "50000 50000"}, 1),
    (V1.format("/"), {f"cpu/{QUOTA}": "-1\n", f"cpu/{PERIOD}": "100000\n"}, 8),
    (V1.format("/"), {f"cpu/{QUOTA}": "250000\n", f"cpu/{PERIOD}": "100000\n"}, 3),
    # A container sees its own group as the root, by the host's name for it.
    (V1.format("/docker/0a1b"), {f"cpu/{QUOTA}": "100000\n", f"cpu/{PERIOD}": "100000\n"}, 1),
]


@pytest.mark.parametrize(("own", "files", "cores"), CASES)
def test_cores(
    own: str, files: dict[str, str], cores: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "own").write_text(own)
    for name, content in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(content)
    monkeypatch.setattr(cgroups, "MOUNT", tmp_path)
    monkeypatch.setattr(cgroups, "OWN", tmp_path / "own")
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set(range(8)))
    for name in pocl.THREAD_VARIABLES:
        monkeypatch.delenv(name, raising=False)
    assert cgroups.cores() == cores
    with pocl.starting(None):
        assert os.environ[pocl.THREAD_VARIABLES[0]] == str(cores)


def test_without_proc(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(cgroups, "OWN", tmp_path / "none")
    assert cgroups.cores() == len(os.sched_getaffinity(0))
