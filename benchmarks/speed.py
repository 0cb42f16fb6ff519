"""How fast: the kernel, how its cost grows, and the whole command."""

import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np
from msgspec.structs import replace

import clrt
from benchmarks import harness
from clrt.figure.rendering import Renderer
from clrt.renderer.pack.features import LANES, TREE_FROM
from clrt.scene.scene import Scene
from clrt.scene.spheres import Sphere

Row = tuple[str, list[float], str]


@click.command("speed")
@click.pass_obj
def command(quick: bool) -> None:
    """Times the kernel for each number of lanes, how its cost grows, and the whole command."""
    size, turns = ((480, 270), 1) if quick else ((3840, 2160), 5)
    figures: dict[str, Any] = {"size": size}
    parts: dict[str, Sequence[Row]] = {
        "The kernel": kernel(*size, turns),
        "How its cost grows": growth(quick, figures),
        "The whole command": whole_command(*size, turns, figures),
    }
    for part, rows in parts.items():
        figures[part] = {what: {**harness.summary(s), "note": note} for what, s, note in rows}
        print(f"\n{part}\n")
        cells = [
            (what, f"{1e3 * statistics.median(s):.1f}",
             f"{1e3 * min(s):.1f}-{1e3 * max(s):.1f}", note)
            for what, s, note in rows
        ]  # fmt: skip
        print(harness.table((f"four-spheres, {size[0]}x{size[1]}", "ms", "spread", "note"), cells))
    folder = harness.results_folder(quick)
    harness.record(folder, "speed", figures)
    plot(figures["growth"], folder / "speed.png")


def kernel(width: int, height: int, turns: int) -> list[Row]:
    """The kernel alone, by the device's clock, beside the yardstick, which is always of 4K."""
    scene = clrt.load_scene("four-spheres")
    contenders: dict[str, Callable[[], float]] = {}
    with tempfile.TemporaryDirectory() as folder:
        if built := build_yardstick(folder):
            contenders["yardstick"] = lambda: yardstick_time(built)
        for lanes in reversed(LANES):
            frames = 21 if lanes == 16 else 3
            renderer = Renderer(lanes=lanes)
            timed = harness.kernel_time(renderer, scene, width, height, np.uint8, frames)
            contenders[f"{lanes} lane{'s' * (lanes > 1)}, 8-bit film"] = timed
        renderer = Renderer(lanes=16)
        timed = harness.kernel_time(renderer, scene, width, height, np.float32, 5)
        contenders["16 lanes, float32 film"] = timed
        seconds = harness.in_turn(contenders, turns)
    if "yardstick" not in seconds:
        return [(what, s, "") for what, s in seconds.items()]
    unit = statistics.median(seconds["yardstick"])
    return [
        (w, s, f"{statistics.median(s) / unit:.2f} x the yardstick") for w, s in seconds.items()
    ]


def build_yardstick(folder: str) -> str | None:
    """The program of yardstick.c, where it can be built."""
    source, program = str(Path(__file__).with_name("yardstick.c")), f"{folder}/yardstick"
    flags = ("-O3", "-march=native", "-ffast-math", "-fopenmp")
    build = ("cc", *flags, source, "-o", program, "-lm")
    if shutil.which("cc") is None:
        why = "there is no C compiler, cc"
    elif subprocess.run(build, capture_output=True).returncode != 0:
        why = "cc cannot build it, as for a CPU without AVX-512"
    else:
        return program
    print(f"The yardstick is left out: {why}.")
    return None


def yardstick_time(program: str) -> float:
    """Seconds of one frame, the median of 21, by the program's own clock."""
    done = subprocess.run([program, "21"], capture_output=True, text=True, check=True)
    return float(done.stdout.split()[1]) / 1e3  # "med N ms"


def many_spheres(count: int) -> Scene:
    """The first `count` spheres of a grid of small ones behind each other, without reflection."""
    base = clrt.load_scene("first-result")
    spheres = tuple(
        Sphere((0.25 * (k % 8) - 0.9, 0.2 * (k // 8 % 8) - 0.7, -0.5 - k // 64), 0.09, "green")
        for k in range(count)
    )
    return replace(base, spheres=spheres)


def growth(quick: bool, figures: dict[str, Any]) -> list[Row]:
    """Pixels, depth, spheres and threads, each varied alone."""
    scene = clrt.load_scene("four-spheres")
    width, height = (480, 270) if quick else (3840, 2160)
    renderer = Renderer()
    frames = 3 if quick else 5

    def median(of: Scene, w: int, h: int) -> float:
        timed = harness.kernel_time(renderer, of, w, h, np.uint8, frames)
        timed()
        return timed()

    sizes = [(480, 270), (960, 540)] if quick else [(480 * 2**k, 270 * 2**k) for k in range(5)]
    pixels = {f"{w}x{h}": median(scene, w, h) for w, h in sizes}
    depths = {d: median(replace(scene, max_depth=d), width, height) for d in (1, 2, 3, 4, 8, 16)}
    counts = [1, 4] if quick else [1, 2, 4, 8, 16, 32, 64, 128, 256]
    spheres = {n: median(many_spheres(n), width, height) for n in counts}
    threads = {n: thread_time(n, width, height) for n in (1, len(os.sched_getaffinity(0)))}
    # Of each sphere more: a camera ray, and a shadow ray for the part of them that hits.
    last = max(n for n in counts if n < TREE_FROM)
    slope = (spheres[last] - spheres[counts[0]]) / (last - counts[0])
    figures["growth"] = {
        "pixels": pixels, "depth": depths, "spheres": spheres, "threads": threads,
        "ns_per_pixel_and_sphere": 1e9 * slope / (width * height),
    }  # fmt: skip
    return [
        *((f"{size} pixels", [s], "") for size, s in pixels.items()),
        *((f"max_depth {depth}", [s], "") for depth, s in depths.items()),
        *((f"{n} spheres of a grid", [s], "") for n, s in spheres.items()),
        ("one sphere more", [slope], f"{1e9 * slope / (width * height):.3f} ns a pixel"),
        *((f"{n} thread{'s' * (n > 1)}", [s], f"{threads[1] / s:.2f} x as fast as one")
          for n, s in threads.items()),
    ]  # fmt: skip


def thread_time(threads: int, width: int, height: int) -> float:
    """The kernel's time with so many threads, which a process can choose only once."""
    code = (
        "import clrt, statistics, numpy as np\n"
        f"r = clrt.Renderer(threads={threads}); s = clrt.load_scene('four-spheres'); t = []\n"
        f"for _ in range(15): r.render(s, {width}, {height}, dtype=np.uint8); "
        "t.append(r.kernel_seconds)\n"
        "print(statistics.median(t[2:]))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return float(done.stdout)


def whole_command(width: int, height: int, turns: int, figures: dict[str, Any]) -> list[Row]:
    """`clrt render` as a process, warm and cold, beside a floor: imports and the same PNG."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "XDG_CACHE_HOME": f"{folder}/warm"}

        def run(*words: str) -> Callable[[], float]:
            def timed() -> float:
                started = time.perf_counter()
                subprocess.run(words, cwd=folder, check=True, env=environment)
                return time.perf_counter() - started

            return timed

        def cold() -> float:
            shutil.rmtree(f"{folder}/cold", ignore_errors=True)
            environment["XDG_CACHE_HOME"] = f"{folder}/cold"
            seconds = render()
            environment["XDG_CACHE_HOME"] = f"{folder}/warm"
            return seconds

        # The command's own script, as a user has it: `python -m clrt` would do as well.
        script = str(Path(sys.executable).with_name("clrt"))
        size = ("--width", str(width), "--height", str(height))
        render = run(script, "render", "-q", *size)
        film = Renderer().render(clrt.load_scene("four-spheres"), width, height, dtype=np.uint8)
        np.save(f"{folder}/film.npy", film)
        imports = "import numpy, pyopencl, click; film = numpy.load('film.npy', 'r')\n"
        save = "from clrt.files import png; png.write(open('floor.png', 'wb'), film)"
        floor = run(sys.executable, "-c", imports + save)
        seconds = harness.in_turn({"floor": floor, "warm": render, "cold": cold}, turns)

        def peak(*words: str) -> float:
            """The process's largest resident size, MB."""
            code = (
                "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True); "
                "print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1e3)"
            )
            done = subprocess.run([sys.executable, "-c", code, *words], cwd=folder, text=True,
                                  check=True, capture_output=True, env=environment)  # fmt: skip
            return float(done.stdout)

        imported = peak(sys.executable, "-c", "import numpy, pyopencl")
        memory = peak(script, "render", "-q", *size) - imported
    figures["memory_mb_over_imports"] = memory
    base = statistics.median(seconds["floor"])
    warm = statistics.median(seconds["warm"])
    cold_seconds = statistics.median(seconds["cold"])
    return [
        ("the floor", seconds["floor"], "imports and the same PNG"),
        ("clrt render, warm", seconds["warm"],
         f"{warm / base:.2f} x the floor; {memory:.0f} MB more than the imports"),
        ("clrt render, cold", seconds["cold"], f"empty caches: {cold_seconds - warm:.2f} s more"),
    ]  # fmt: skip


def plot(figures: dict[str, Any], path: Path) -> None:
    """Time against pixels, depth and spheres."""
    drawn, axes = harness.figure(columns=3)
    for axis, key in zip(axes, ("pixels", "depth", "spheres"), strict=True):
        x = list(figures[key])
        axis.plot(range(len(x)), [1e3 * s for s in figures[key].values()], "o-")
        axis.set_xticks(range(len(x)), map(str, x), rotation=40, fontsize=11)
        axis.set(title=key, yscale="linear" if key == "depth" else "log")
        if key == "depth":
            axis.set_ylim(bottom=0)
    axes[0].set_ylabel("kernel, ms")
    drawn.savefig(path, dpi=110)
    print(f"{path}: written")
