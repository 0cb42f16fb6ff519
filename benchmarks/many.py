"""Many spheres: what a tree costs and what it saves, from ten spheres to ten millions."""

import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

import clrt
from benchmarks import files, harness, ovito_peer, povray_peer
from clrt.figure.rendering import Renderer
from clrt.opencl.tree import Tree
from clrt.renderer.pack import features as needs
from clrt.renderer.pack.spheres import tree_keys
from clrt.scene.scene import Scene

Array = NDArray[Any]
HEAD = (
    "spheres, depth; ms",
    "build",
    "each picture",
    "trace",
    "spread",
    "list",
    "Embree",
    "x",
    "POV-Ray",
)
MOST = {"random": 10**6, "molecule": 10**7}
LINEAR_TO = 1000  # spheres that are also timed without a tree
POVRAY = (10**5,)  # spheres that POV-Ray is timed with

SCRIPT = """
import sys
import numpy as np, clrt
data = np.load(sys.argv[1])
spheres = clrt.Spheres(data["center"], data["radius"], "atom")
atom = clrt.Material((0.1, 0.1, 0.1), (0.6, 0.6, 0.6), (0.3, 0.3, 0.3), 100)
camera, light = clrt.Camera((0, 0, 1), (0, 0, 0)), clrt.Light((5, 5, 5))
scene = clrt.Scene(camera, (light,), {"atom": atom}, spheres)
clrt.save(sys.argv[2], clrt.render(scene, 1920, 1080, dtype="uint8"))
"""


# What run_script() adds to each script.
PEAK = """
import re
print(re.search(r"VmHWM:\\s+(\\d+)", open("/proc/self/status").read())[1])
"""


def random(n: int) -> Array:
    """(n, 4): spheres of one radius in a box before the camera, which fill 6.5 % of it."""
    low, high = np.array([-2, -1.2, -4.0]), np.array([2, 1.2, -0.5])
    center = np.random.default_rng(1234 + n).random((n, 3)) * (high - low) + low
    radius = 0.25 * (np.prod(high - low) / n) ** (1 / 3)
    return np.column_stack([center, np.full(n, radius)])


def molecule(n: int) -> Array:
    """(n, 4): atoms on a jittered lattice of 1.5 Å that fills a ball, of radii 1.2 to 1.8 Å."""
    generator = np.random.default_rng(99 + n)
    across = int(np.ceil((n * 6 / np.pi) ** (1 / 3))) + 2
    axis = np.arange(across, dtype=np.float32) - (across - 1) / 2 + 0.17
    lattice = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), -1).reshape(-1, 3)
    square = np.einsum("ij,ij->i", lattice, lattice)
    lattice = lattice[np.argpartition(square, n - 1)[:n]]
    unit = 0.95 / np.sqrt(np.einsum("ij,ij->i", lattice, lattice).max())
    center = (lattice + generator.uniform(-0.2, 0.2, lattice.shape)) * unit + (0, 0, -1)
    kinds = np.array([1.2, 1.52, 1.55, 1.7, 1.8]) / 1.5
    radius = generator.choice(kinds, n, p=[0.45, 0.15, 0.1, 0.28, 0.02]) * unit
    return np.column_stack([center, radius])[generator.permutation(n)]


def with_outlier(n: int) -> Array:
    """(n + 1, 4): a molecule on a ball of radius 5, which is no giant."""
    return np.concatenate([molecule(n), [(0, -6.2, -1, 5)]])


# The kind of spheres, and rays: how many segments of a path.
KINDS: tuple[tuple[str, Callable[[int], Array], int], ...] = (
    ("random", random, 3), ("random", random, 1), ("molecule", molecule, 1),
)  # fmt: skip


def scene_of(spheres: Array, depth: int) -> Scene:
    """Three materials, mirrors if depth is more than 1, and one light."""
    colors = (
        ((0.1, 0, 0), (0.7, 0, 0)),
        ((0.1, 0, 0.1), (0.7, 0, 0.7)),
        ((0, 0.1, 0), (0, 0.6, 0)),
    )
    materials = {
        str(i): clrt.Material(ambient, diffuse, (1, 1, 1), 100, 0.5 * (depth > 1))
        for i, (ambient, diffuse) in enumerate(colors)
    }
    arrays = clrt.Spheres(spheres[:, :3], spheres[:, 3], np.arange(len(spheres)) % 3)
    camera, light = clrt.Camera((0, 0, 1), (0, 0, 0)), clrt.Light((5, 5, 5))
    return clrt.Scene(camera, (light,), materials, arrays, max_depth=depth)


@click.command("many")
@click.option("--embree", type=click.Path(exists=True, path_type=Path), metavar="PROGRAM",
              help="A program to time in turn: PROGRAM embree 16 FRAMES WIDTH HEIGHT FILE N DEPTH "
              "reads N spheres as float32 x y z radius and prints 'med N ms' for its build and for "
              "a frame.")  # fmt: skip
@click.pass_obj
def command(quick: bool, embree: Path | None) -> None:
    """Times the tree for 10 to 10^7 spheres, beside the list where that is bearable."""
    size, turns = ((480, 270), 1) if quick else ((1920, 1080), 2)
    counts = [100, 1000] if quick else [10**k for k in range(1, 8)]
    figures: list[dict[str, Any]] = []
    for kind, make, depth in KINDS:
        for n in (n for n in counts if n <= MOST[kind]):
            found = measure(make(n), depth, size, turns, embree)
            figures.append({"kind": kind, "spheres": n, "depth": depth, **found})
            print(f"{kind} {n:,}, depth {depth}: done", file=sys.stderr)
    print(f"{size[0]}x{size[1]}, ms\n")
    print(harness.table(HEAD, [row(figure) for figure in figures]))
    for figure in figures:
        seen, trace = (1e3 * figure[what]["median"] for what in ("seen", "trace"))
        what = f"{figure['kind']} {figure['spheres']:,}, depth {figure['depth']}"
        print(f"{what}: what is seen first takes {seen:.1f} ms of {trace:.1f}")
    crossover = {f"{k}, depth {d}": crossing(figures, k, d) for k, _, d in KINDS}
    for what, n in crossover.items():
        print(f"\n{what}: the tree is quicker than the list from {n:.0f} spheres on")
    n = 1000 if quick else 10**5
    outlier = harness.in_turn(
        {
            name: harness.kernel_time(Renderer(), scene_of(make(n), 1), *size, np.float32, 5)
            for name, make in (("without", molecule), ("with", with_outlier))
        },
        turns,
    )
    of_outlier = {name: harness.summary(seconds) for name, seconds in outlier.items()}
    ratio = of_outlier["with"]["median"] / of_outlier["without"]["median"]
    print(f"\nmolecule {n:,} on a ball of radius 5: {ratio:.2f} x without the ball")
    script = [] if quick else whole_script(1)
    for figure in script:
        print(f"\n{figure['name']}: {figure['spheres']:,} atoms to .png: {figure['median']:.2f} s "
              f"({figure['min']:.2f}-{figure['max']:.2f}), {figure['peak_mb']:.0f} MB")  # fmt: skip
    of_files = files.measure([molecule(n) for n in ([1000] if quick else [10**5, 10**6])], size, 1)
    print("\n`clrt render FILE`, one sample a pixel\n")
    print(files.table(of_files))
    folder = harness.results_folder(quick)
    found = {"size": size, "figures": figures, "crossover": crossover, "outlier": of_outlier}
    harness.record(folder, "many", found)
    harness.record(folder, "files", {"size": size, "script": script, "files": of_files})
    plot(figures, folder / "many.png")


@contextmanager
def trees_from(count: int) -> Iterator[None]:
    """Scenes of that many spheres and more have a tree."""
    saved, needs.TREE_FROM = needs.TREE_FROM, count
    try:
        yield
    finally:
        needs.TREE_FROM = saved


def measure(
    spheres: Array, depth: int, size: tuple[int, int], turns: int, embree: Path | None
) -> dict[str, Any]:
    """Seconds: to build, to pack and fit for each picture, to trace; by the list; by Embree."""
    scene = scene_of(spheres, depth)
    frames = 5 if len(spheres) <= 10**5 else 3
    contenders: dict[str, Callable[[], float]] = {}
    with tempfile.TemporaryDirectory() as folder, trees_from(0):  # however few there are
        renderer = Renderer()
        contenders["trace"] = harness.kernel_time(renderer, scene, *size, np.float32, frames)
        contenders["trace"]()  # packs and builds
        contenders["seen"] = first_hits(renderer, replace(scene, lights=()), size, frames)
        contenders["seen"]()
        features, kernels = used = renderer._programs_of(scene, ["float"])["float"][0]
        world = renderer._dispatcher.world(scene)
        assert features.tree
        if len(spheres) <= LINEAR_TO:
            with trees_from(sys.maxsize):
                listed = Renderer()
                contenders["list"] = harness.kernel_time(listed, scene, *size, np.float32, 1)
                contenders["list"]()
        builds: list[float] = []
        if embree is not None:
            path = Path(folder) / "spheres.f32"
            spheres.astype(np.float32).tofile(path)
            words = ["embree", "16", "3", *map(str, size), str(path), str(len(spheres)), str(depth)]

            def other() -> float:
                done = subprocess.run([embree.resolve(), *words], capture_output=True, text=True)
                build, frame = map(float, re.findall(r"med +([\d.]+) ms", done.stdout))
                builds.append(build / 1e3)
                return frame / 1e3

            contenders["embree"] = other
        seconds = harness.in_turn(contenders, turns)

        def build() -> None:
            Tree(tree_keys(world.spheres), renderer._queue, kernels)

        def fit() -> None:
            renderer._dispatcher.arguments(scene, *size, used, np.inf)
            renderer._queue.finish()

        if shutil.which("povray") and len(spheres) in POVRAY:
            seconds["povray"] = [povray_peer.render(scene, *size)[1]]  # once: it takes seconds
        found: dict[str, Any] = {what: harness.summary(taken) for what, taken in seconds.items()}
        for what, run in (("build", build), ("picture", fit)):
            found[what] = harness.summary([harness.wall(run)() for _ in range(turns + 1)][1:])
    if builds:
        found["embree_build"] = harness.summary(builds)
    return found


def first_hits(
    renderer: Renderer, scene: Scene, size: tuple[int, int], frames: int
) -> Callable[[], float]:
    """A contender: the median kernel time of what the camera sees first, by the film of paths of a
    scene without lights: camera rays and surfaces, nothing else."""

    def run() -> float:
        times = []
        for _ in range(frames):
            renderer.paths(scene, *size)
            times.append(renderer.kernel_seconds)
        return statistics.median(times)

    return run


def row(figure: dict[str, Any]) -> Sequence[str]:
    def ms(what: str) -> str:
        return f"{1e3 * figure[what]['median']:,.1f}" if what in figure else ""

    trace = figure["trace"]
    ratio = f"{figure['embree']['median'] / trace['median']:.2f}" if "embree" in figure else ""
    return (
        f"{figure['kind']} {figure['spheres']:,}, {figure['depth']}",
        ms("build"),
        ms("picture"),
        ms("trace"),
        f"{1e3 * trace['min']:.1f}-{1e3 * trace['max']:.1f}",
        ms("list"),
        ms("embree"),
        ratio,
        ms("povray"),
    )


def crossing(figures: list[dict[str, Any]], kind: str, depth: int) -> float:
    """Where the times of tree and list are equal, by straight lines in logarithms."""
    rows = [f for f in figures if (f["kind"], f["depth"]) == (kind, depth) and "list" in f]
    counts = np.log([f["spheres"] for f in rows])
    gain = np.log([f["list"]["median"] / f["trace"]["median"] for f in rows])
    if (gain > 0).all() or (gain < 0).all():
        return float(np.exp(counts[0] if gain[0] > 0 else np.inf))
    i = int(np.argmax(gain > 0))
    slope = (gain[i] - gain[i - 1]) / (counts[i] - counts[i - 1])
    return float(np.exp(counts[i] - gain[i] / slope))


def whole_script(turns: int) -> list[dict[str, Any]]:
    """From a file of atoms to a PNG, 1920x1080, as a script that is run again, one after the other
    with OVITO's if it is installed."""
    others = ovito_peer.renderers()
    found = []
    for n in (10**5, 10**6, 10**7):
        with tempfile.TemporaryDirectory() as folder:
            spheres = molecule(n).astype(np.float32)
            path = Path(folder) / "atoms.npz"
            np.savez(path, center=spheres[:, :3], radius=spheres[:, 3])
            picture = Path(folder) / "a.png"
            scripts: dict[str, tuple[str, ...]] = {"clrt": (SCRIPT, str(path), str(picture))}
            theirs = {
                other: ovito_peer.words(path, picture, other, ovito_peer.ONE_SAMPLE[other])
                for other in others
            }
            if n == 10**6:
                scripts |= {f"OVITO, {other}": words for other, words in theirs.items()}
            peaks: dict[str, list[float]] = {name: [] for name in scripts}
            contenders: dict[str, Callable[[], float]] = {
                name: partial(run_script, words, peaks[name]) for name, words in scripts.items()
            }
            for name, seconds in harness.in_turn(contenders, turns).items():
                what = {"name": name, "spheres": n, "peak_mb": statistics.median(peaks[name])}
                found.append({**what, **harness.summary(seconds)})
    return found


def run_script(words: Sequence[str], peaks: list[float]) -> float:
    """The seconds that a script takes, with its arguments. peaks gets its peak of memory, MB."""
    script, *arguments = words
    started = time.perf_counter()
    done = subprocess.run(
        [sys.executable, "-c", script + PEAK, *arguments],
        capture_output=True,
        text=True,
        check=True,
    )
    taken = time.perf_counter() - started
    peaks.append(float(done.stdout.split()[-1]) / 1e3)
    return taken


def plot(figures: list[dict[str, Any]], path: Path) -> None:
    """Time against the number of spheres, both logarithmic."""
    drawn, axes = harness.figure()
    for kind, _, depth in KINDS:
        rows = [f for f in figures if (f["kind"], f["depth"]) == (kind, depth)]
        for what, style in (("trace", "o-"), ("list", "s:"), ("embree", "x--")):
            some = [f for f in rows if what in f]
            if some:
                x, y = zip(*((f["spheres"], 1e3 * f[what]["median"]) for f in some), strict=True)
                label = {"trace": "clrt", "list": "clrt's list", "embree": "Embree"}[what]
                axes.loglog(x, y, style, label=f"{label}, {kind}, depth {depth}")
    axes.set(xlabel="spheres", ylabel="ms for a picture of 1920x1080; lower is better")
    axes.legend(fontsize=10)
    drawn.savefig(path, dpi=110)
    print(f"{path}: written")
