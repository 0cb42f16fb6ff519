"""How fast each kind of x86-64 code is: AVX-512, AVX2 and SSE4.2, all on this CPU."""

import json
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
import numpy as np

import clrt
from benchmarks import harness
from benchmarks.speed import many_spheres
from clrt.figure.rendering import Renderer
from clrt.opencl import pocl
from clrt.opencl.device import find_device
from clrt.renderer.pack.structs import Precision

# What to call it, PoCL's library of built-in functions, the CPU to compile for.
TARGETS = (
    ("AVX-512", "avx512", "skylake-avx512"),
    ("AVX2", "avx2", "haswell"),
    ("SSE4.2", "sse41", "nehalem"),
)
LANES = (16, 8)
SCENES = ("four-spheres", "sunflower")
PRECISIONS: tuple[Precision, ...] = ("robust",)
LIBRARY = "kernel-x86_64-unknown-linux-gnu-{}.bc"


@click.command("targets")
@click.pass_obj
def command(quick: bool) -> None:
    """Times AVX-512, AVX2 and SSE4.2 code on three scenes, each with 16 and 8 lanes.

    Needs a CPU with AVX-512, and leave to mount (unshare): PoCL takes its library by CPUID, so
    another one is mounted in its place.
    """
    native = pocl.name_given(find_device("PoCL 3.0"))
    if native != TARGETS[0][2]:
        click.echo(f"not measured: expected a CPU with AVX-512, this one is {native}")
        return
    import pocl_binary_distribution

    folder = Path(pocl_binary_distribution.__file__).parent / ".libs" / "share" / "pocl"
    figures: dict[str, Any] = {}
    rows: list[Sequence[str]] = []
    size = ("480", "270", "2") if quick else ("3840", "2160", "3")
    for what, library, name in TARGETS[2 if quick else 0 :]:
        mount = f'mount --bind "$0/{LIBRARY.format(library)}" "$0/{LIBRARY.format("avx512")}"'
        run = f'{mount} && exec "$@"'
        words = [sys.executable, "-m", "benchmarks.targets", library, name, *size]
        done = subprocess.run(
            ["unshare", "--user", "--map-root-user", "--mount", "sh", "-c", run, folder, *words],
            check=True,
            stdout=subprocess.PIPE,
        )
        figures[what] = json.loads(done.stdout)
        for precision, scenes in figures[what].items():
            for scene, times in scenes.items():
                cells = [f"{1e3 * times[str(lanes)]['median']:.1f}" for lanes in LANES]
                rows.append((f"{what}, {precision}, {scene}", *cells))
    print(harness.table(("ms", *(f"{lanes} lanes" for lanes in LANES)), rows))
    harness.record(harness.results_folder(quick), "targets", {"size": size[:2], **figures})


def one(library: str, name: str, width: int, height: int, turns: int) -> dict[str, Any]:
    """The times of one target, in a process where its library is mounted."""
    device = find_device("PoCL 3.0")
    if name != pocl.name_given(device):
        pocl.rename(device, name)
    scenes = {scene: clrt.load_scene(scene) for scene in SCENES}
    scenes["64 spheres"] = many_spheres(64)
    found: dict[str, Any] = {}
    for precision in PRECISIONS:
        renderers = {n: Renderer(lanes=n, device=device, precision=precision) for n in LANES}
        found[precision] = {}
        for what, scene in scenes.items():
            contenders = {
                str(lanes): harness.kernel_time(renderer, scene, width, height, np.uint8, 1)
                for lanes, renderer in renderers.items()
            }
            seconds = harness.in_turn(contenders, turns)
            found[precision][what] = {n: harness.summary(s) for n, s in seconds.items()}
    return found


if __name__ == "__main__":
    library, name, *numbers = sys.argv[1:]
    print(json.dumps(one(library, name, *map(int, numbers))))
