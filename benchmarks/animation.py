"""Video: the pipeline against its parts, kernel and encoder, measured apart."""

import itertools
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import click
import numpy as np
from numpy.typing import NDArray

import clrt
from benchmarks import harness
from clrt.figure.rendering import Renderer
from clrt.files import video
from clrt.motion import animation

CRF = 18


@click.command("animation")
@click.pass_obj
def command(quick: bool) -> None:
    """Times 300 frames at 1080p to .mp4, and what rendering and encoding take by themselves."""
    width, height, count, turns = (320, 180, 20, 1) if quick else (1920, 1080, 300, 1)
    scene = clrt.load_scene("orbit")
    renderer = Renderer()
    chosen = list(itertools.islice(itertools.cycle(animation.all_frames(scene)), count))
    cores: dict[str, list[float]] = {}

    def frames() -> Iterator[NDArray[np.uint8]]:
        return animation.animate(
            scene, width, height, frames=chosen, dtype=np.uint8, renderer=renderer
        )

    def render_alone() -> None:
        for k in chosen:
            camera = animation.camera_at(scene, k)
            still = clrt.Scene(camera, scene.lights, scene.materials, scene.spheres)
            renderer.render(still, width, height, dtype=np.uint8)

    once = list(animation.animate(scene, width, height, dtype=np.uint8, renderer=renderer))

    def encode(pictures: Iterable[NDArray[np.uint8]]) -> None:
        with tempfile.TemporaryDirectory() as folder:
            video.save(Path(folder) / "a.mp4", pictures, 30, CRF)

    def timed(name: str, run: Callable[[], object]) -> Callable[[], float]:
        def measured() -> float:
            before = resource.getrusage(resource.RUSAGE_SELF)
            started = time.perf_counter()
            run()
            took = time.perf_counter() - started
            after = resource.getrusage(resource.RUSAGE_SELF)
            used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
            cores.setdefault(name, []).append(used)
            return took

        return measured

    runs: dict[str, Callable[[], object]] = {
        "rendering alone": render_alone,
        "encoding alone": lambda: encode(once[k] for k in chosen),
        "the pipeline": lambda: encode(frames()),
    }
    seconds = harness.in_turn({name: timed(name, run) for name, run in runs.items()}, turns)
    medians = {name: harness.summary(s)["median"] for name, s in seconds.items()}
    slower = max(medians["rendering alone"], medians["encoding alone"])
    rows = []
    for name, took in seconds.items():
        time_ = harness.summary(took)
        core_seconds = harness.summary(cores[name][1:])["median"]
        ratio = f"{time_['median'] / slower:.2f}"
        rows.append(
            (name, f"{time_['median']:.2f}", f"{time_['min']:.2f}-{time_['max']:.2f}",
             f"{count / time_['median']:.0f}", f"{core_seconds:.2f}", ratio)
        )  # fmt: skip
    print(f"orbit, {count} frames of {width}x{height}, H.264, crf {CRF}\n")
    head = ("what", "s", "spread", "frames/s", "core-seconds", "x the slower part")
    print(harness.table(head, rows))
    memory = {n: peak_memory(n) for n in ((50, 100) if quick else (50, 500))}
    print(
        "\npeak memory, 160x90: " + ", ".join(f"{n} frames {mb:.0f} MB" for n, mb in memory.items())
    )
    folder = harness.results_folder(quick)
    harness.record(folder, "animation", {"seconds": seconds, "core_seconds": cores,
                                         "peak_mb": memory})  # fmt: skip


def peak_memory(frames: int) -> float:
    """The largest resident size, MB, of a process that makes a small .mp4 of so many frames."""
    code = (
        "import clrt, itertools, numpy, re, sys\n"
        "from pathlib import Path\n"
        "from clrt.files import video\n"
        "scene = clrt.load_scene('orbit')\n"
        f"chosen = itertools.islice(itertools.cycle(range(120)), {frames})\n"
        "frames = clrt.animate(scene, 160, 90, frames=chosen, dtype=numpy.uint8)\n"
        "video.save(Path(sys.argv[1]) / 'a.mp4', frames, 30, 18)\n"
        # Not ru_maxrss, which counts the parent's memory before exec.
        "print(re.search(r'VmHWM:\\s+(\\d+)', Path('/proc/self/status').read_text())[1])\n"
    )
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([sys.executable, "-c", code, folder], check=True, text=True,
                              capture_output=True)  # fmt: skip
    return float(done.stdout) / 1e3
