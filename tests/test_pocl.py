"""What surrounds the start of OpenCL."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from clrt import pocl


def test_the_environment_is_put_back(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("POCL_CACHE_DIR", "mine")
    monkeypatch.delenv("PYOPENCL_NO_CACHE", raising=False)
    monkeypatch.setenv(pocl.THREAD_VARIABLES[0], "7")
    before = dict(os.environ)
    with pocl.starting(None):
        assert os.environ["POCL_CACHE_DIR"] == "mine"
        assert os.environ["PYOPENCL_NO_CACHE"] == "1"
        assert os.environ[pocl.THREAD_VARIABLES[0]] == "7"
    with pocl.starting(3):
        assert [os.environ[name] for name in pocl.THREAD_VARIABLES] == ["3", "3"]
    assert dict(os.environ) == before


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
from clrt.data import cache_folder
renderer, scene = clrt.Renderer(), clrt.load_scene("four-spheres")
shutil.rmtree(cache_folder())
before = renderer.render(scene, 9, 9)
shutil.rmtree(cache_folder())
assert renderer.render(scene, 9, 9, dtype="uint8").any()
"""
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}
    assert subprocess.run([sys.executable, "-c", program], env=environment).returncode == 0


START = "from clrt import pocl; print(pocl.run_folder(), flush=True); "


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
