"""What goes wrong, for real and in a process of its own, and what clrt does then: faults.toml."""

import os
import random
import re
import signal
import subprocess
import sys
import time
import tomllib
from pathlib import Path

import msgspec
import numpy as np
import pytest
from PIL import Image

import clrt
from clrt.storage import folder


class Fault(msgspec.Struct):
    """A row of faults.toml."""

    name: str
    shell: str
    status: int
    said: str


TABLE = tomllib.loads((Path(__file__).parent / "faults.toml").read_text())
FAULTS = msgspec.convert(TABLE["faults"], list[Fault])
SMALL = (40, 23)


@pytest.fixture(scope="session")
def small() -> np.ndarray:
    return clrt.Renderer().render(clrt.load_scene("four-spheres"), *SMALL, dtype=np.uint8)


# A process that has computed for a second itself is past its start and what it compiles. The signal
# goes to it and to what it has started, as `timeout` does, so that it comes twice.
WHEN_BUSY = f"""#!{sys.executable}
import os, pathlib, signal, subprocess, sys, time
number = signal.Signals["SIG" + sys.argv[1]]
process = subprocess.Popen(sys.argv[2:], process_group=0)
while process.poll() is None:
    words = pathlib.Path(f"/proc/{{process.pid}}/stat").read_text().rpartition(")")[2].split()
    if sum(map(int, words[11:13])) > os.sysconf("SC_CLK_TCK"):  # user's and system's ticks
        process.send_signal(number)
        os.killpg(process.pid, number)
        break
    time.sleep(0.01)
status = process.wait()
sys.exit(status if status >= 0 else 128 - status)
"""


def shell(fault: Fault, here: Path) -> subprocess.CompletedProcess[bytes]:
    """Runs it in an empty folder, with one for a disk beside it."""
    here.mkdir()
    (here.parent / "disk").mkdir()
    clrt_itself = f'#!/bin/sh\nexec "{sys.executable}" -m clrt "$@"\n'
    for name, text in {"clrt": clrt_itself, "when_busy": WHEN_BUSY}.items():
        (here.parent / name).write_text(text)
        (here.parent / name).chmod(0o755)
    words = ["sh", "-c", f"PATH={here.parent}:$PATH; {fault.shell}"]
    if "mount" in fault.shell:
        # To be allowed to mount, in a file system that goes with the process.
        words = ["unshare", "--user", "--map-root-user", "--mount", *words]
    return subprocess.run(
        words,
        cwd=here,
        env={**os.environ, "small": "--width 40 --height 23 -q", "scenes": str(folder("scenes"))},
        capture_output=True,
        timeout=120,
    )


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault.name)
def test_a_picture_or_one_line(fault: Fault, tmp_path: Path, small: np.ndarray) -> None:
    here = tmp_path / "here"
    done = shell(fault, here)
    said = done.stderr.decode()
    if "unshare: " in said:
        pytest.skip(said)
    # What tqdm has drawn it has wiped out again.
    lines = [line.split("\r")[-1] for line in said.strip().split("\n")]
    assert done.returncode == fault.status, said
    assert done.stdout == b""
    assert lines[-1].removeprefix("clrt: ").startswith(fault.said)
    assert fault.said or lines == [""]
    assert len(lines) == 1 or lines[0].startswith("Usage:")
    if fault.status > 0:
        assert not list(here.iterdir())
    else:
        assert (np.asarray(Image.open(here / "four-spheres.png")) == small).all()
        assert len(list(here.iterdir())) == 1


def answers_sigint(pid: int) -> bool:
    caught = re.search(r"SigCgt:\s*(\w+)", Path(f"/proc/{pid}/status").read_text())
    return caught is not None and bool(int(caught[1], 16) >> (signal.SIGINT - 1) & 1)


@pytest.mark.slow
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM], ids=["SIGINT", "SIGTERM"])
@pytest.mark.parametrize("words", ["render sunflower --width 1920 --height 1080",
                                   "animate --width 320 --height 180 --frames 0-30"])  # fmt: skip
def test_ended_at_any_moment(tmp_path: Path, words: str, number: signal.Signals) -> None:
    """Nothing but the whole file is left, whenever it was; 4 * 12 moments."""
    cache, here = tmp_path / "cache", tmp_path / "here"
    here.mkdir()
    command = [sys.executable, "-m", "clrt", *words.split()]

    def start() -> "subprocess.Popen[str]":
        return subprocess.Popen(
            command,
            cwd=here,
            env={**os.environ, "XDG_CACHE_HOME": str(cache)},
            stderr=subprocess.PIPE,
            text=True,
        )

    start().communicate()
    begun = time.monotonic()
    start().communicate()
    whole = time.monotonic() - begun
    (result,) = here.iterdir()
    kept = set((cache / "clrt").iterdir())
    moments = random.Random(words)
    ended = 0
    for _ in range(12):
        result.unlink(missing_ok=True)
        process = start()
        # Python's own start is not ours: it has taken Ctrl-C over and clrt has taken it from there.
        while not answers_sigint(process.pid):
            time.sleep(0.001)
        while answers_sigint(process.pid):
            time.sleep(0.001)
        time.sleep(moments.uniform(0, whole))
        process.send_signal(number)
        process.send_signal(number)  # as `timeout` does, and the impatient
        _, said = process.communicate(timeout=20)
        assert "Traceback" not in said
        assert process.returncode in (0, 128 + number, -number), said
        assert set(here.iterdir()) <= {result}
        assert process.returncode != 0 or result.exists()
        ended += process.returncode != 0
    assert ended > 3
    # What a process left that was killed as OpenCL started, the next one removes after a while.
    for left in set((cache / "clrt").iterdir()) - kept:
        os.utime(left, (0, 0))
    start().communicate()
    assert set((cache / "clrt").iterdir()) == kept


@pytest.mark.slow
def test_a_hundred_thousand_spheres(tmp_path: Path) -> None:
    path = tmp_path / "many.toml"
    centers = np.random.default_rng(1).uniform(-3, 3, (100_000, 3)).tolist()
    path.write_text(
        (folder("scenes") / "first-result.toml").read_text()
        + "".join(f"[[spheres]]\ncenter = {c}\nradius = 0.01\nmaterial = 'red'\n" for c in centers)
    )
    scene = clrt.load_scene(path)
    assert len(scene.spheres) > 100_000
    trace = clrt.reference.trace(scene, 16, 9)
    with clrt.Renderer() as renderer:
        flips = renderer.paths(scene, 16, 9) != trace.paths
    assert len(np.unique(trace.paths)) > 50
    assert flips.sum() <= 1
