"""What all parts of the benchmark share: timing in turn, the record of the machine, tables."""

import importlib.metadata
import json
import os
import platform
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from clrt.figure.rendering import Renderer
from clrt.opencl.device import find_device
from clrt.scene.light import PointLight
from clrt.scene.scene import Scene

RESULTS = Path(__file__).parent / "results"


def in_turn(contenders: dict[str, Callable[[], float]], turns: int) -> dict[str, list[float]]:
    """Runs each contender once, then each again, and so on; returns their seconds.

    A contender returns the seconds that it took. A first round, to warm up, does not count.
    """
    seconds: dict[str, list[float]] = {name: [] for name in contenders}
    for turn in range(turns + 1):
        for name, run in contenders.items():
            took = run()
            if turn > 0:
                seconds[name].append(took)
    return seconds


def wall(run: Callable[[], object]) -> Callable[[], float]:
    """A contender that takes its own wall time."""

    def timed() -> float:
        started = time.perf_counter()
        run()
        return time.perf_counter() - started

    return timed


def kernel_time(
    renderer: Renderer, scene: Scene, width: int, height: int, dtype: Any, frames: int
) -> Callable[[], float]:
    """A contender: the median kernel time of some frames, by the device's clock."""

    def run() -> float:
        times = []
        for _ in range(frames):
            renderer.render(scene, width, height, dtype=dtype)
            times.append(renderer.kernel_seconds)
        return statistics.median(times)

    return run


def point_lights(scene: Scene) -> list[PointLight]:
    """A scene's lights, for those that know but one kind."""
    found = [light for light in scene.lights if isinstance(light, PointLight)]
    assert len(found) == len(scene.lights)
    return found


def summary(seconds: Sequence[float]) -> dict[str, float]:
    """Median and spread, in seconds."""
    return {"median": statistics.median(seconds), "min": min(seconds), "max": max(seconds)}


def machine() -> dict[str, Any]:
    """What a figure means nothing without."""
    model = platform.processor()
    with open("/proc/cpuinfo") as cpuinfo:
        for line in cpuinfo:
            if line.startswith("model name"):
                model = line.split(":")[1].strip()
                break
    device = find_device()
    packages = ("clrt", "numpy", "pyopencl", "pillow")
    return {
        "cpu": model,
        "cores": len(os.sched_getaffinity(0)),
        "load": os.getloadavg()[0],
        "device": f"{device.name.strip()}, {device.version.strip()}, {device.driver_version}",
        "threads": device.max_compute_units,
        "python": platform.python_version(),
        **{name: importlib.metadata.version(name) for name in packages},
        "code": code(),
        "date": time.strftime("%Y-%m-%d"),
    }


def code() -> str:
    """Which clrt/ and kernels/ were measured: the trees' hashes, as they were committed."""
    words = ("git", "rev-parse", "--short", "HEAD:clrt", "HEAD:kernels")
    done = subprocess.run(words, cwd=Path(__file__).parent, capture_output=True, text=True)
    return " ".join(done.stdout.split())


def table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A Markdown table, aligned: the first column left, the others right."""
    columns = list(zip(head, *rows, strict=True))
    widths = [max(map(len, column)) for column in columns]

    def line(cells: Sequence[str]) -> str:
        rest = [cell.rjust(width) for cell, width in zip(cells[1:], widths[1:], strict=True)]
        return "| " + " | ".join([cells[0].ljust(widths[0]), *rest]) + " |"

    rule = "|" + "|".join("-" * (w + 1) + (":" if i else "-") for i, w in enumerate(widths)) + "|"
    return "\n".join([line(head), rule, *map(line, rows)])


def figure(columns: int = 1) -> tuple[Any, Any]:
    """A matplotlib figure and its axes; matplotlib comes with the extra "bench"."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    pyplot.rcParams["font.size"] = 13
    drawn, axes = pyplot.subplots(1, columns, figsize=(8 + columns, 5), layout="constrained")
    for axis in drawn.axes:
        axis.grid(alpha=0.3)
    return drawn, axes


def results_folder(quick: bool) -> Path:
    return Path(tempfile.mkdtemp(prefix="clrt-benchmarks-")) if quick else RESULTS


def record(folder: Path, part: str, figures: dict[str, Any]) -> None:
    """Writes a part's figures and the machine as JSON."""
    folder.mkdir(exist_ok=True)
    path = folder / f"{part}.json"
    path.write_text(json.dumps({"machine": machine(), **figures}, indent=1) + "\n")
    print(f"\n{path}: written", file=sys.stderr)
