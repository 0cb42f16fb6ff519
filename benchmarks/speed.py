"""How fast: the kernel alone, the reference, and the whole command."""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import click
import numpy as np

import clrt
from benchmarks import harness
from clrt.renderer import Renderer


@click.command("speed")
@click.pass_obj
def command(quick: bool) -> None:
    """Times the kernel for each number of lanes, the NumPy reference and the whole command."""
    width, height, turns = (480, 270, 1) if quick else (3840, 2160, 7)
    scene = clrt.load_scene("four-spheres")
    rows = []
    figures = {}

    def add(what: str, seconds: list[float], note: str = "") -> None:
        figures[what] = {**harness.summary(seconds), "note": note}
        middle, low, high = harness.summary(seconds).values()
        rows.append((what, f"{1e3 * middle:.1f}", f"{1e3 * low:.1f}-{1e3 * high:.1f}", note))

    contenders = {}
    for dtype, film in ((np.float32, "float32 film"), (np.uint8, "8-bit film")):
        for lanes in (1, 16) if dtype is np.float32 else (16,):
            renderer = Renderer(lanes=lanes)
            contenders[f"kernel, {lanes} lanes, {film}"] = harness.kernel_time(
                renderer, scene, width, height, dtype, frames=5
            )
    for what, seconds in harness.in_turn(contenders, turns).items():
        add(what, seconds)

    small = (width // 4, height // 4)
    reference = harness.wall(lambda: clrt.reference.render(scene, *small))
    seconds = harness.in_turn({"": reference}, 3)[""]
    add(
        "NumPy float64 reference",
        [16 * s for s in seconds],
        f"16 x its time at {small[0]}x{small[1]}",
    )

    warm, cold = command_times(width, height, turns)
    add("whole command, warm", warm)
    add("whole command, cold", cold, "empty caches of PoCL and PyOpenCL")

    print(f"four-spheres, {width}x{height}, max_depth {scene.max_depth}\n")
    print(harness.table(("what", "median ms", "spread", "note"), rows))
    harness.record(harness.results_folder(quick), "speed", {"size": [width, height], **figures})


def command_times(width: int, height: int, turns: int) -> tuple[list[float], list[float]]:
    """Seconds of `clrt render` as a process, with warm and with empty caches."""
    with tempfile.TemporaryDirectory() as folder:
        words = [sys.executable, "-m", "clrt.cli", "render", "-q"]
        words += ["--width", str(width), "--height", str(height)]

        def run(cache: Path) -> float:
            started = time.perf_counter()
            environment = {**os.environ, "XDG_CACHE_HOME": str(cache)}
            subprocess.run(words, cwd=folder, check=True, env=environment)
            return time.perf_counter() - started

        def cold() -> float:
            empty = Path(folder) / "cold"
            shutil.rmtree(empty, ignore_errors=True)
            return run(empty)

        warm = lambda: run(Path(folder) / "warm")  # noqa: E731
        seconds = harness.in_turn({"warm": warm, "cold": cold}, turns)
    return seconds["warm"], seconds["cold"]
