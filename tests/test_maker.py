"""Makers: a compiler that crashes or hangs is a line; a child makes one program after another."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pyopencl as cl
import pytest

from clrt.errors import DeviceError
from clrt.opencl import program
from clrt.opencl.device import devices
from clrt.renderer import maker
from clrt.renderer.pack.features import LANES, Features

PLAIN = Features(4, "robust", "float")


# What a child does in place of its work, and what is said of it.
CRASHES = {
    "ctypes.string_at(0)": "its compiler crashed (Segmentation fault)",
    "os.abort()": "its compiler crashed (Aborted)",
    "bytearray(3 << 30)": "its compiler crashed (exit status 1: MemoryError)",
    "print('LLVM ERROR: out of memory', file=sys.stderr); os.abort()": (
        "its compiler crashed (more than 2 GB of memory)"
    ),
    "time.sleep(99)": "its compiler took more than 2 s",
    "sys.exit(7)": "its compiler crashed (exit status 7: )",
}


@pytest.mark.parametrize("code", CRASHES)
def test_what_crashes_is_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, code: str) -> None:
    child = tmp_path / "python"
    child.write_text(
        f"#!{sys.executable} -P\nimport ctypes, os, sys, time\n"
        "from clrt.renderer import maker, trial\n"
        f"def crash(*words):\n    {code}\ntrial.try_here = crash\nmaker.main()\n"
    )
    child.chmod(0o755)
    monkeypatch.setattr(maker, "SECONDS", 2 if "sleep" in code else 60)
    monkeypatch.setattr(sys, "executable", str(child))
    with pytest.raises(DeviceError) as error:
        maker.made(devices()[0], program.kernel_source(), [PLAIN])
    assert str(error.value) == CRASHES[code]


def test_a_child_that_cannot_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """No more processes, no Python to start, or a machine in which a child is elsewhere."""
    source = program.kernel_source()
    device = devices()[0]
    for executable in ("", str(tmp_path / "none")):
        monkeypatch.setattr(sys, "executable", executable)
        assert maker.made(device, source, [PLAIN])
    monkeypatch.undo()
    monkeypatch.setattr(maker, "identity", lambda device: ("another",))
    assert maker.made(device, source, [PLAIN])


@pytest.mark.parametrize("lanes", LANES)
def test_the_child_makes_what_is_made_here(lanes: int) -> None:
    features = Features(lanes, "robust", "bytes")
    device = devices()[0]
    (binary,) = maker.made(device, program.kernel_source(), [features])
    built = program.loaded(cl.Context([device]), device, binary)
    assert built.get_info(cl.program_info.KERNEL_NAMES) == "render"


def test_ctrl_c_ends_the_child(tmp_path: Path) -> None:
    """A terminal sends it to both; here the parent alone gets it."""
    code = (
        "from clrt.renderer import maker\nfrom clrt.opencl import program\n"
        "from clrt.renderer.pack.features import Features\n"
        "from clrt.opencl.device import devices\n"
        "device = devices()[0]; print('ready', flush=True)\n"
        "maker.made(device, program.kernel_source() + '\\n' * 99, [Features(16, 'double', "
        "'float', reflection=True)])"
    )
    parent = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    assert parent.stdout is not None
    assert parent.stdout.readline() == "ready\n"
    children = Path(f"/proc/{parent.pid}/task/{parent.pid}/children")
    while not (found := children.read_text().split()):
        pass
    parent.send_signal(signal.SIGINT)
    _, said = parent.communicate(timeout=20)
    assert "KeyboardInterrupt" in said
    for _ in range(100):
        if not Path(f"/proc/{found[0]}").exists():
            return
        time.sleep(0.1)
    pytest.fail("it lives")


def test_one_child_makes_many_and_several_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    """As many as there are cores; one that has waited for too long is replaced."""
    device, source, started = devices()[0], program.kernel_source(), []

    class Counted(maker.Maker):
        def __init__(self, *words) -> None:
            super().__init__(*words)
            started.append(self)

    monkeypatch.setattr(maker, "Maker", Counted)
    monkeypatch.setattr(maker, "_idle", [])
    monkeypatch.setattr(os, "sched_getaffinity", lambda process: {0, 1})
    wanted = [Features(lanes, "robust", "bytes") for lanes in (1, 2, 4)]
    binaries = maker.made(device, source, wanted)
    assert len(started) == 2
    context = cl.Context([device])
    for features, binary in zip(wanted, binaries, strict=True):
        built = program.loaded(context, device, binary)
        assert built.get_info(cl.program_info.KERNEL_NAMES) == "render"
        assert maker.made(device, source, [features])
    assert len(started) == 2
    for child in started:
        child.end()  # as after IDLE seconds
        child._child.wait()
    assert maker.made(device, source, wanted[:1])
    assert len(started) == 3


def test_a_wrong_program_leaves_the_child_and_says_so() -> None:
    wrong = program.kernel_source().replace("exposure_of(sample);", "exposure_of(sample) nonsense;")
    for _ in range(2):
        with pytest.raises(DeviceError, match="it cannot compile the kernel: "):
            maker.made(devices()[0], wrong, [PLAIN])


def test_children_end_with_their_parent() -> None:
    code = (
        "import os, signal\nfrom clrt.renderer import maker\n"
        "from clrt.renderer.pack.features import Features\n"
        "from clrt.opencl import program\nfrom clrt.opencl.device import devices\n"
        "wanted = [Features(4, 'robust', 'float')]\n"
        "maker.made(devices()[0], program.kernel_source(), wanted)\n"
        "print(maker._idle[0]._child.pid, flush=True)\n"
        "os.kill(os.getpid(), signal.SIGKILL)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    child = Path(f"/proc/{int(done.stdout)}")
    for _ in range(100):
        if not child.exists():
            return
        time.sleep(0.1)
    pytest.fail("it lives")
