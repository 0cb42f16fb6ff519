"""Many machines: how long a cluster takes, simulated from what start-up, frames, encoding and the
kernels' cache take here."""

import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import click
import numpy as np

from benchmarks import harness
from clrt import storage

Figures = dict[str, Any]
FRAMES = 10_000
WORKERS = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)
OTHERS = 1000  # run folders of other workers that a start finds in a shared cache
NETWORK = 10  # how many times slower than this disk a storage is that machines share: a guess
BEADS = 1_000
CASES = ("carried", "shared", f"shared, {NETWORK} x slower", "cold", "carried, and encoded")


@click.command("scale")
@click.pass_obj
def command(quick: bool) -> None:
    """Times the parts of a cluster's work, and simulates 1 to 1000 workers."""
    size, counts, turns = ((320, 180), (6, 6), 1) if quick else ((1920, 1080), (36, 12), 2)
    scenes = {}
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for (scene, text), count in zip(texts().items(), counts, strict=True):
            (folder / f"{scene}.toml").write_text(text)
            scenes[scene] = measured(folder, scene, size, count, turns)
        stored = cache(folder / "warm" / "clrt", 3 if quick else 30)
    figures = {"size": size, "frames": FRAMES, "beads": BEADS, "scenes": scenes, "cache": stored}
    print(report(figures))
    harness.record(harness.results_folder(quick), "scale", figures)


def texts() -> dict[str, str]:
    """Scene files: `orbit`, and with many small spheres."""
    orbit = (storage.folder("scenes") / "orbit.toml").read_text()
    low, high = np.array([-2, -0.6, -3]), np.array([2, 1, 1])
    centers = np.random.default_rng(1).uniform(low, high, (BEADS, 3)).tolist()
    bead = '[[spheres]]\ncenter = {}\nradius = 0.02\nmaterial = "green"\n'
    return {"orbit": orbit, "beads": orbit + "".join(map(bead.format, centers))}


def measured(folder: Path, scene: str, size: tuple[int, int], frames: int, turns: int) -> Figures:
    """The seconds of each part, by whole commands of all and of a sixth of the frames."""
    few = frames // 6
    pictures = f"{scene}-###.png"

    def run(cache: str, *words: str) -> float:
        environment = {**os.environ, "XDG_CACHE_HOME": str(folder / cache)}
        # The command's own script, as a user has it.
        script = str(Path(sys.executable).with_name("clrt"))
        started = time.perf_counter()
        subprocess.run((script, *words, "-q"), cwd=folder, check=True, env=environment)
        return time.perf_counter() - started

    def animate(cache: str, count: int) -> float:
        width, height = map(str, size)
        return run(cache, "animate", f"{scene}.toml", "-o", pictures, "--frames", f"0-{count - 1}",
                   "--width", width, "--height", height)  # fmt: skip

    def cold() -> float:
        shutil.rmtree(folder / "cold", ignore_errors=True)
        return animate("cold", 1)

    def encode(count: int) -> float:
        video = f"{scene}.mp4"
        return run("warm", "encode", pictures, "-o", video, "--frames", f"0-{count - 1}")

    seconds = harness.in_turn(
        {
            "cold": cold,
            "few": lambda: animate("warm", few),
            "all": lambda: animate("warm", frames),
            "encode few": lambda: encode(few),
            "encode all": lambda: encode(frames),
        },
        turns,
    )
    median = {name: harness.summary(took)["median"] for name, took in seconds.items()}
    frame = (median["all"] - median["few"]) / (frames - few)
    encoded = (median["encode all"] - median["encode few"]) / (frames - few)
    return {
        "start": median["few"] - few * frame,
        "cold start": median["cold"] - frame,
        "frame": frame,
        "start to encode": median["encode few"] - few * encoded,
        "encode": encoded,
        "seconds": seconds,
    }


def cache(shared: Path, turns: int) -> Figures:
    """The seconds that a start spends on files of the kernels' cache, alone and for each other
    worker that shares it. It does again what strace shows of a command."""
    kept = max(shared.iterdir(), key=lambda path: path.stat().st_size)

    def start() -> None:
        for _ in storage.abandoned(shared.glob("run-*")):
            pass
        own = Path(tempfile.mkdtemp(prefix="run-", dir=shared))
        binary = storage.kept(kept) or b""
        for name in ("program.bc", "render/64-1-1/render.so", "render/0-0-0/render.so"):
            (own / name).parent.mkdir(parents=True, exist_ok=True)
            (own / name).write_bytes(binary[: len(binary) // 3])  # PoCL unpacks it
        shutil.rmtree(own)

    def median() -> float:
        return harness.summary([harness.wall(start)() for _ in range(turns)])["median"]

    alone = median()
    for i in range(OTHERS):
        (shared / f"run-{i}").mkdir()
    return {"start": alone, "each other": max(median() - alone, 0) / OTHERS}


def rendered(workers: int, frames: int, frame: float, start: float, storage: Figures) -> float:
    """Seconds until the last picture is there, if all workers start at once.

    Args:
        start: of each worker, while it waits for nobody.
        storage: what serves the workers one after the other as they start, see cache().
    """
    served = last = 0.0
    for i in range(workers):
        served += storage["start"] + i * storage["each other"]
        share = len(range(i, frames, workers))
        last = max(last, served + start + share * frame)
    return last


def simulated(workers: int, scene: Figures, frames: int, cache: Figures) -> dict[str, float]:
    """Seconds of the whole job in each of the CASES."""
    own = {"start": 0.0, "each other": 0.0}
    network = {name: NETWORK * seconds for name, seconds in cache.items()}
    elsewhere = scene["start"] - cache["start"]  # what a start does but for the cache
    starts = ((scene["start"], own), (elsewhere, cache), (elsewhere, network),
              (scene["cold start"], own))  # fmt: skip
    seconds = [rendered(workers, frames, scene["frame"], *start) for start in starts]
    encoded = seconds[0] + scene["start to encode"] + frames * scene["encode"]
    return dict(zip(CASES, (*seconds, encoded), strict=True))


def report(figures: Figures) -> str:
    """What was measured, and a table for each scene, of one row for each number of workers."""
    parts = [times(figures)]
    for name, scene in figures["scenes"].items():
        found = {n: simulated(n, scene, figures["frames"], figures["cache"]) for n in WORKERS}
        rows = [
            (f"{n:,}", *(f"{s:,.1f}" for s in seconds.values()),
             f"{found[1][CASES[-1]] / seconds[CASES[-1]]:.1f}")
            for n, seconds in found.items()
        ]  # fmt: skip
        head = (f"{name}, {figures['frames']:,} frames, s: workers", *CASES, "x one worker")
        parts.append(harness.table(head, rows))
    return "\n\n".join(parts)


def times(figures: Figures) -> str:
    size = "x".join(map(str, figures["size"]))
    head = (f"{size}, ms", "start", "cold start", "frame", "start to encode", "encode")
    rows = [
        (name, *(f"{1e3 * scene[part]:,.1f}" for part in head[1:]))
        for name, scene in figures["scenes"].items()
    ]
    cache = figures["cache"]
    return (
        f"{harness.table(head, rows)}\n\n"
        f"beads: orbit and {figures['beads']:,} small spheres; files of the kernels' cache: "
        f"{1e3 * cache['start']:.2f} ms a start and {1e6 * cache['each other']:.1f} µs for each "
        "other worker"
    )
