"""Error beside time of 10^5 atoms with occlusion and a round light: whole commands, to a PNG.

Beside clrt: OVITO's renderers, each against its own converged picture, and Open Image Denoise on
clrt's pictures, where they are installed.
"""

import importlib.util
import random
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import click
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

import clrt
from benchmarks import harness, many, ovito_peer
from benchmarks.samples import TRUTH, Figures, Size, converged, curve, middle
from clrt.figure.rendering import Renderer
from clrt.files.image import load
from clrt.renderer.checks import Region
from clrt.renderer.pack.features import ENOUGH

Array = NDArray[Any]

Way = tuple[str, int]
"""One of these, and how many samples."""

CLRT, FILTERED, OIDN = "clrt", "clrt, --denoise", "clrt and OIDN"
MEASURES = {"of_mean": "rmse / mean", "of_deviation": "rmse / deviation", "flip": "FLIP"}
SAMPLES = (2, 3, 4, 8, 10, 16, 64)
SIZE = 1920, 1080
PLOT = Path(__file__).parents[1] / "docs" / "atoms.webp"

# OVITO's: Tachyon's light, sky and the part of the sky that is not hidden, with occlusion on.
SHINES, SKY_SHINES, ALWAYS = 0.8 * 0.9 * 0.2, 0.8 * 0.8, 0.3
ALBEDO = 0.7
OVITO: dict[str, Figures] = {
    "Tachyon": {"antialiasing_samples": 12, "ambient_occlusion_samples": 12},
    "OSPRay": {"samples_per_pixel": 8, "refinement_iterations": 4, "denoising_enabled": True},
}
CONVERGED: dict[str, Figures] = {
    "Tachyon": {"antialiasing_samples": 64, "ambient_occlusion_samples": 64},
    "OSPRay": {"samples_per_pixel": 16, "refinement_iterations": 16, "denoising_enabled": False},
}
# Its arguments: .npz of a film of guides, and the .npy to write. It prints its seconds.
OIDN_SCRIPT = """
import sys, time
import numpy as np
guides = np.load(sys.argv[1])
color, *others = (guides[name] for name in ("color", "albedo", "normal"))
started = time.perf_counter()
import pyoidn
clear = pyoidn.denoise(color, *others, hdr=True, quality="fast")
print(time.perf_counter() - started)
np.save(sys.argv[2], clear)
"""


@click.command("atoms")
@click.option("--converged", "kept", type=click.Path(exists=True, path_type=Path), metavar="FOLDER",
              help="Where OVITO's converged pictures are kept. Those that are there are not made "
              "again.")  # fmt: skip
@click.pass_obj
def command(quick: bool, kept: Path | None) -> None:
    """Times pictures of 10^5 atoms, and says how far each is from the converged one."""
    size = (240, 135) if quick else SIZE
    with tempfile.TemporaryDirectory() as folder:
        rows = beside(Path(folder), kept or Path(folder), size, quick)
    found: Figures = {"size": size, "atoms": rows}
    print(f"\n{table(found)}")
    results = harness.results_folder(quick)
    harness.record(results, "atoms", found)
    plot(rows, results / PLOT.name if quick else PLOT)


def scene_of(spheres: Array, albedo: float = ALBEDO) -> clrt.Scene:
    """Atoms in OVITO's light, but that it is 10 degrees wide, as OSPRay's is."""
    color = (albedo,) * 3
    lights = (
        clrt.AmbientLight((ALWAYS,) * 3),
        clrt.AmbientLight((SKY_SHINES,) * 3, occlusion=True),
        clrt.DirectionalLight(
            (0.2, -0.2, -1), ambient=(0, 0, 0), diffuse=(SHINES,) * 3, half_angle=5
        ),
    )
    return clrt.Scene(
        clrt.Camera((0, 0, 1), (0, 0, 0)),
        lights,
        {"atom": clrt.Material(color, color, (0, 0, 0))},
        clrt.Spheres(spheres[:, :3], spheres[:, 3], "atom"),
        max_depth=1,
    )


def beside(folder: Path, kept: Path, size: Size, quick: bool) -> list[Figures]:
    """Seconds of whole commands in turn, and the errors of their pictures' middles."""
    number, counts, turns, count = (1000, (4,), 1, 16) if quick else (10**5, SAMPLES, 5, TRUTH)
    spheres, region = many.molecule(number).astype(np.float32), middle(size)
    scene, path, data = scene_of(spheres), folder / "atoms.toml", folder / "data.npz"
    clrt.save_scene(path, scene)
    np.savez(data, center=spheres[:, :3], radius=spheres[:, 3])

    def theirs(picture: Path, name: str, options: Figures, part: Size) -> Callable[[], float]:
        words = ovito_peer.words(data, picture, name, options, part, size[1])
        return partial(many.run_script, words, [])

    ours = [(CLRT, n) for n in counts] + [(FILTERED, n) for n in counts if n < ENOUGH]
    pictures = {key: folder / f"{i}.png" for i, key in enumerate(ours)}
    of_peers = {name: folder / f"{name}.png" for name in ovito_peer.renderers()}
    seconds, long = in_turn(
        {key: partial(render, path, pictures[key], size, *key) for key in ours},
        {name: theirs(of_peers[name], name, OVITO[name], size) for name in of_peers},
        turns,
    )
    found = []
    with Renderer() as renderer:
        truth = converged(renderer, scene, size, count, region)
        for way, n in ours:
            wall = harness.summary(seconds[way, n])
            picture = cut(load(pictures[way, n]), region)
            found.append({"way": way, "samples": n, "wall": wall, **errors(picture, truth)})
        for n in counts[: 4 if importlib.util.find_spec("pyoidn") else 0]:
            film = guides(renderer, replace(scene, samples=n), size)
            clear, more = denoised(film, folder, turns)
            wall = harness.summary(np.add(seconds[CLRT, n], more).tolist())
            found.append({
                "way": OIDN, "samples": n, "wall": wall, "filter": harness.summary(more),
                **errors(cut(clear, region), truth),
            })  # fmt: skip
    for name, path in of_peers.items():
        best = kept / f"{name}-converged.png"
        if not best.exists():
            part = region[2] - region[0], region[3] - region[1]
            theirs(best, name, CONVERGED[name], part)()
        found.append({
            "way": f"OVITO, {name}", "options": OVITO[name], "converged": CONVERGED[name],
            "wall": harness.summary(long[name]),
            **errors(cut(load(path), region), load(best)),
        })  # fmt: skip
    return found


def in_turn(
    ours: dict[Way, Callable[[], float]], theirs: dict[str, Callable[[], float]], turns: int
) -> tuple[dict[Way, list[float]], dict[str, list[float]]]:
    """As harness.in_turn(), but that `theirs`, which take long, run once, amid the others. They
    are warm: ovito_peer.renderers() has run each. Ours run in another order each turn: what comes
    after a long command takes up to a fifth longer."""
    long: dict[str, list[float]] = {}
    seconds: dict[Way, list[float]] = {way: [] for way in ours}
    for turn in range(turns + 1):
        for way in random.Random(turn).sample(list(ours), len(ours)):
            took = ours[way]()
            if turn > 0:
                seconds[way].append(took)
        if turn == turns // 2:
            long = {name: [run()] for name, run in theirs.items()}
    return seconds, long


def render(scene: Path, picture: Path, size: Size, way: str, samples: int) -> float:
    """How long `clrt render` takes."""
    words = [sys.executable, "-m", "clrt", "render", str(scene), "-o", str(picture)]
    numbers = {"--width": size[0], "--height": size[1], "--samples": samples}
    words += [str(word) for pair in numbers.items() for word in pair]
    words += ["--denoise"] * (way == FILTERED)
    return harness.wall(partial(subprocess.run, words, check=True, capture_output=True))()


def guides(renderer: Renderer, scene: clrt.Scene, size: Size) -> Array:
    """What a filter looks at: colours, albedos and normals, of so many samples."""
    used = renderer._programs_of(scene, ["guides"])["guides"]
    arguments = renderer._dispatcher.arguments(scene, *size, used[0], 0.0)
    film, _ = renderer._dispatcher.exposed(used, scene, arguments, size, (0, 0, *size))
    made: Array = film[..., 0]
    return made


def denoised(film: Array, folder: Path, turns: int) -> tuple[Array, list[float]]:
    """By Open Image Denoise: a picture, and its seconds, each of a process of its own."""
    given, made = folder / "guides.npz", folder / "clear.npy"
    np.savez(given, color=film["color"][..., :3], albedo=film["albedo"], normal=film["normal"])
    seconds = []
    for _ in range(turns):
        words = [sys.executable, "-c", OIDN_SCRIPT, str(given), str(made)]
        done = subprocess.run(words, check=True, capture_output=True, text=True)
        seconds.append(float(done.stdout.split()[-1]))
    return np.load(made), seconds


def cut(picture: Array, region: Region) -> Array:
    left, top, right, bottom = region
    return picture[top:bottom, left:right]


def errors(picture: Array, truth: Array) -> Figures:
    """Of the mean of red, green and blue, as parts of what the converged picture has; and FLIP.

    Source: P. Andersson, J. Nilsson, T. Akenine-Moeller, M. Oskarsson, K. Astroem, M. D. Fairchild,
    FLIP: a difference evaluator for alternating images, HPG 2020; the pictures as they are shown,
    67 pixels a degree.
    """
    import flip_evaluator  # of the extra bench: the tests of the tables go without

    picture, truth = (np.clip(a[..., :3], 0, 1).astype(np.float32) for a in (picture, truth))
    off, level = (a.mean(axis=2, dtype=np.float64) for a in (picture - truth, truth))
    rmse = float(np.sqrt((off**2).mean()))
    _, flip, _ = flip_evaluator.evaluate(truth, picture, "LDR", applyMagma=False)
    return {
        "of_mean": rmse / float(level.mean()), "of_deviation": rmse / float(level.std()),
        "flip": float(flip),
    }  # fmt: skip


def table(figures: Figures) -> str:
    """What docs/samples.md shows."""
    found, size = figures["atoms"], "x".join(map(str, figures["size"]))
    rows = [
        (label(f), f"{f['wall']['median']:.2f}",
         f"{f['wall']['min']:.2f}-{f['wall']['max']:.2f}",
         f"{100 * f['of_mean']:.1f} %", f"{100 * f['of_deviation']:.0f} %", f"{f['flip']:.3f}")
        for f in found
    ]  # fmt: skip
    head = (f"atoms to .png, {size}", "command, s", "spread", *MEASURES.values())
    lines = [said(found, f) for f in found if "options" in f]
    filters = [f"{f['filter']['median']:.2f}" for f in found if "filter" in f]
    if filters:
        lines.append(f"Open Image Denoise alone takes {', '.join(filters)} s of its rows.")
    return "\n\n".join([harness.table(head, rows), *lines])


def label(figure: Figures) -> str:
    way: str = figure["way"]
    return f"{way}, samples = {figure['samples']}" if "samples" in figure else way


def said(found: list[Figures], peer: Figures) -> str:
    """How much longer a peer takes than clrt's quickest pictures that are off by no more."""
    phrases = []
    for measure, name in MEASURES.items():
        for way in (CLRT, FILTERED):
            good = [f for f in found if f["way"] == way and f[measure] <= peer[measure]]
            if good:
                best = min(good, key=lambda f: f["wall"]["median"])
                times = peer["wall"]["median"] / best["wall"]["median"]
                phrases.append(f"- {times:.1f} times as long by {name} ({label(best)})")
    what = "\n".join(phrases) or "- less time"
    return f"{peer['way']}, beside clrt's quickest picture of no more error, takes\n\n{what}"


def plot(found: list[Figures], path: Path) -> None:
    """Error against time, both logarithmic."""
    drawn, both = harness.figure(2)
    for axes, measure in zip(both, ("of_mean", "flip"), strict=True):
        for way in dict.fromkeys(f["way"] for f in found):
            rows = [f for f in found if f["way"] == way]
            curve(axes, rows, [f["wall"]["median"] for f in rows], measure, "o-", way)
        axes.set(xlabel="whole command, s", ylabel=MEASURES[measure])
        axes.xaxis.set_minor_formatter("")  # they would overlap
    both[0].legend(fontsize=11)
    drawn.savefig(path, dpi=80)
    print(f"{path}: written")
