"""What surrounds the start of OpenCL."""

# A fake stands for a device.
# mypy: disable-error-code="arg-type, dict-item"

import ctypes
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, NamedTuple

import pytest

import clrt
from clrt.opencl import pocl


def test_the_environment_is_put_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("POCL_CACHE_DIR", "mine")
    monkeypatch.delenv("PYOPENCL_NO_CACHE", raising=False)
    monkeypatch.setenv(pocl.THREAD_VARIABLES[0], "7")
    before = dict(os.environ)
    with pocl.starting(None):
        assert os.environ["POCL_CACHE_DIR"] == str(pocl.run_folder())
        assert os.environ["PYOPENCL_NO_CACHE"] == "1"
        assert os.environ[pocl.THREAD_VARIABLES[0]] == "7"
    with pocl.starting(3):
        assert [os.environ[name] for name in pocl.THREAD_VARIABLES] == ["3", "3"]
    assert dict(os.environ) == before


@pytest.mark.parametrize("text", ["-5", "0", "two", "99999", "3\n"])
def test_refuses_what_is_no_number_of_threads(monkeypatch: pytest.MonkeyPatch, text: str) -> None:
    monkeypatch.setenv(pocl.THREAD_VARIABLES[0], text)
    expected = "POCL_MAX_PTHREAD_COUNT: expected a number of threads from 1 to 9999"
    with pytest.raises(clrt.RequestError, match=expected), pocl.starting(None):
        pass


ALL = dict.fromkeys(
    {feature for row in pocl.CPU_NAMES.values() for _, has in row for feature in has}
)


@pytest.mark.parametrize(
    ("width", "lacks", "name"),
    [
        (16, "", "skylake-avx512"),
        (8, "AVX512F AVX512BW", "haswell"),
        (8, "AVX512F BMI2", "sandybridge"),
        (8, "AVX2 FMA3", "sandybridge"),
        (4, "AVX AVX2", "nehalem"),
        (4, "AVX SSE42", "x86-64"),
        (16, "AVX512VL", None),
        (8, "AVX AVX2", None),
        (3, "", None),
    ],
)
def test_the_cpus_name_is_what_library_and_cpu_have_in_common(
    monkeypatch: pytest.MonkeyPatch, width: int, lacks: str, name: str | None
) -> None:
    has = {feature: feature not in lacks.split() for feature in ALL}
    monkeypatch.setattr("clrt.opencl.pocl._cpu_features", lambda: has)
    if name is None:
        with pytest.raises(LookupError):
            pocl.cpu_name(width)
    else:
        assert pocl.cpu_name(width) == name


def test_a_numpy_that_knows_fewer_features(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("clrt.opencl.pocl._cpu_features", lambda: {"AVX2": True, "FMA3": True})
    assert pocl.cpu_name(8) == "haswell"


class Fake(NamedTuple):
    """A PoCL device whose structure is an array of pointers."""

    int_ptr: int
    version: str
    native_vector_width_float: int
    platform: SimpleNamespace


def fake(version: str, text: str, width: int = 4) -> tuple[Fake, Any, Any]:
    name = ctypes.create_string_buffer(text.encode())
    structure = (ctypes.c_uint64 * 128)(7, 2**63, 0, ctypes.addressof(name))
    platform = SimpleNamespace(version=f"OpenCL 3.0 PoCL {version}  Linux")
    device = Fake(ctypes.addressof(structure), f"x-linux-gnu-{text}", width, platform)
    return device, structure, name


@pytest.mark.parametrize("version", ["3.0", "3.0-rc2", "1.8", "3.1", "3.1+debian", "6.0"])
def test_pocls_before_3_1_are_told_the_cpu(version: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pocl, "_names", {})
    device, structure, *_kept = fake(version, "k8-sse3")
    pocl.name_cpu(device)
    now = ctypes.string_at(structure[3]).decode()
    assert not pocl.is_narrow(device)
    if version in ("3.0", "3.0-rc2", "1.8"):
        assert now == pocl.name_given(device) == pocl.cpu_name(4)
    else:
        assert now == "k8-sse3"
        assert pocl.name_given(device) is None


def test_a_device_that_cannot_be_told_is_narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(pocl, "_names", {})
    nowhere, *_kept = fake("3.0", "k8-sse3")
    nowhere = nowhere._replace(version="x-linux-gnu-another")
    pocl.name_cpu(nowhere)
    assert pocl.is_narrow(nowhere)
    refused, *_also_kept = fake("3.0", "k8-sse3")

    def refuse() -> tuple[int, int]:
        raise OSError("too many open files")

    monkeypatch.setattr(os, "pipe", refuse)
    pocl.name_cpu(refused)
    assert pocl.is_narrow(refused)


def test_signals_are_answered_afterwards() -> None:
    answered = []
    before = signal.signal(signal.SIGINT, lambda number, frame: answered.append(number))
    try:
        with pocl.signals_kept():
            signal.raise_signal(signal.SIGINT)
            signal.signal(signal.SIGINT, signal.SIG_IGN)  # as LLVM takes it over
            assert not answered
        assert answered == [signal.SIGINT]
        signal.raise_signal(signal.SIGINT)
        assert len(answered) == 2
    finally:
        signal.signal(signal.SIGINT, before)


def test_somebody_cleans_up(tmp_path: Path) -> None:
    program = """
import shutil, clrt
from clrt.storage import cache_folder
renderer, scene = clrt.Renderer(), clrt.load_scene("four-spheres")
shutil.rmtree(cache_folder())
before = renderer.render(scene, 9, 9)
shutil.rmtree(cache_folder())
assert renderer.render(scene, 9, 9, dtype="uint8").any()
"""
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    assert subprocess.run([sys.executable, "-c", program], env=environment).returncode == 0


START = "from clrt.opencl import pocl; print(pocl.run_folder(), flush=True); "


def test_the_folder_goes_with_the_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))

    def start(then: str) -> tuple["subprocess.Popen[str]", Path]:
        process = subprocess.Popen(
            [sys.executable, "-c", START + then],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )
        assert process.stdout is not None
        return process, Path(process.stdout.readline().strip())

    alive, folder = start("input()")
    killed, left = start("import os; os.kill(os.getpid(), 9)")
    killed.wait()
    assert left.is_dir()
    for path in (folder, left):
        os.utime(path, (0, 0))
    ended, gone = start("")
    ended.wait()
    assert folder.is_dir()
    assert not left.exists()  # the third has removed it
    assert not gone.exists()
    alive.communicate("\n")
    assert not list((tmp_path / "clrt").iterdir())
