"""What does not fit is said."""

import resource
from pathlib import Path

import pytest

from clrt import memory
from clrt.errors import OutputError


def test_available_is_between_what_numpy_takes_and_the_machines_memory() -> None:
    total = memory._fields(Path("/proc/meminfo"))["MemTotal:"] * 1024
    assert 1e8 < memory.available() < total


def test_what_the_system_does_not_tell_is_no_limit(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "_fields", lambda path: {})
    assert memory.available() > 10**15
    monkeypatch.setattr(Path, "read_text", lambda path: Path("none").read_bytes())
    memory.require(10**15, "a film")


def test_require() -> None:
    memory.require(memory.UNASKED_BYTES, "a film")
    with pytest.raises(OutputError, match=r"a film needs 1000000\.0 GB of memory and \d+\.\d GB"):
        memory.require(10**15, "a film")


def test_a_limit_counts() -> None:
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    used = memory._fields(Path("/proc/self/status"))["VmSize:"] * 1024
    resource.setrlimit(resource.RLIMIT_AS, (used + 10**8, hard))
    try:
        assert 5e7 < memory.available() <= 10**8
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))
