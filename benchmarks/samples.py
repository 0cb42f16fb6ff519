"""Error beside time: of antialiasing, and of each thing that takes many rays.

Every picture is compared with a converged one of the same scene: TRUTH samples at other points, in
all pixels, however like they are.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import Any
from unittest import mock

import click
import numpy as np
from msgspec.structs import replace
from numpy.typing import NDArray

import clrt
from benchmarks import features, harness
from clrt.figure.rendering import Renderer
from clrt.film import metrics
from clrt.opencl import bands, edges, program
from clrt.renderer import samples
from clrt.renderer.checks import Region
from clrt.renderer.pack.arguments import sampling
from clrt.scene.scene import Scene

Array = NDArray[Any]
Size = tuple[int, int]
Figures = dict[str, Any]

TRUTH = 4096
ADAPTIVE = (1, 4, 8, 16, 32, 64, 128, 192, 256)
UNIFORM = (16, 64, 256)
EFFECTS = (1, 4, 16, 64, 256)
PLOT = Path(__file__).parents[1] / "docs" / "samples.webp"

SUN = features.SUN
BASE = replace(features.BASE, shadow_bias=0.0)
ROUND = replace(SUN, radius=0.8)
SKY = clrt.AmbientLight((3, 3, 3), occlusion=True)  # the materials' ambient is 0.1
LENS = replace(BASE.camera, aperture_radius=0.05, focus_distance=1.2)
ROUGH = {name: replace(m, roughness=0.2) for name, m in BASE.materials.items()}
# A lens that blurs nothing, beside which round lights are sampled.
NO_LENS = replace(LENS, aperture_radius=1e-9)
SOFT, SAMPLED = "soft shadow, closed form", "soft shadow, sampled"
SCENES = {
    "hard shadow": BASE,
    SOFT: replace(BASE, lights=(ROUND,)),
    SAMPLED: replace(BASE, lights=(ROUND,), camera=NO_LENS),
    "occlusion": replace(BASE, lights=(SUN, SKY)),
    "lens": replace(BASE, camera=LENS),
    "rough mirrors": replace(BASE, materials=ROUGH),
    "indirect light": replace(BASE, indirect=True),
    "all together": replace(
        BASE, lights=(ROUND, SKY), camera=LENS, materials=ROUGH, indirect=True
    ),
}  # fmt: skip


@click.command("samples")
@click.pass_obj
def command(quick: bool) -> None:
    """Times samples from 1 to 256, and says how far each picture is from the converged one."""
    size = (240, 135) if quick else (1280, 720)
    with Renderer() as renderer:
        found = {
            "size": size,
            "antialiasing": antialiasing(renderer, size, quick),
            "effects": effects(renderer, size, quick),
            "closed_form": closed_form(renderer, size, quick),
        }
    for of_what in TABLES.values():
        print(f"\n{of_what(found)}")
    folder = harness.results_folder(quick)
    harness.record(folder, "samples", found)
    plot(found, folder / PLOT.name if quick else PLOT)


@contextmanager
def other_points() -> Iterator[None]:
    """Within it samples lie elsewhere, so that a picture shares none with its converged one."""
    table = samples.table

    def other(count: int, pairs: int = 1, first: int = 0) -> NDArray[np.uint32]:
        return table(count, pairs, first + 1000)

    with mock.patch.object(samples, "table", other):
        yield


class Uniform:
    """Renders all pixels with as many samples as the scene says, at an edge or not."""

    def __init__(self) -> None:
        self.renderer = Renderer()
        source, count = re.subn(r"(#define ENOUGH) .*", r"\1 REAL(-1.0)", program.kernel_source())
        assert count == 1
        self._never_enough = mock.patch.object(program, "kernel_source", return_value=source)

    def render(self, scene: Scene, size: Size, region: Region | None = None) -> Array:
        """A float32 picture or a region of it."""
        with self._never_enough:
            used = self.renderer._programs_of(scene, ["float"])["float"][-1]
        arguments = self.renderer._dispatcher.arguments(scene, *size, used, 0.0)
        film = np.empty((size[1], size[0], 3), np.float32)
        unlike = np.arange(size[0] * size[1], dtype=np.uint32)  # each path but its own
        paths = bands.upload(self.renderer._context, {"paths": unlike})["paths"]
        left, top, right, bottom = box = region or (0, 0, *size)
        self.renderer.kernel_seconds = edges.refine(
            film, (0, 0), box, paths, self.renderer._queue, used[1],
            arguments | sampling(used[0], scene), 0,
        )  # fmt: skip
        return film[top:bottom, left:right]

    def seconds(self, scene: Scene, size: Size) -> float:
        """A contender's."""
        self.render(scene, size)
        return self.renderer.kernel_seconds


def converged(renderer: Renderer, scene: Scene, size: Size, count: int, region: Region) -> Array:
    scene = replace(scene, samples=count)
    with other_points():
        if scene.is_random:
            return renderer.render(scene, *size, region=region)
        return Uniform().render(scene, size, region)


def middle(size: Size, part: int = 4) -> Region:
    """The part of a picture that is so many times as narrow and as low."""
    width, height = size[0] // part, size[1] // part
    left, top = (size[0] - width) // 2, (size[1] - height) // 2
    return left, top, left + width, top + height


def errors(picture: Array, truth: Array) -> Figures:
    off = metrics.difference(picture, truth)
    return {"within": 1 - off.over_255 / off.pixels, "rmse": off.rmse}


def timed(renderer: Renderer, scene: Scene, size: Size, kernel: list[float]) -> Callable[[], float]:
    """A contender: the wall time of an 8-bit picture. kernel gets the kernel's times."""
    film = np.empty((size[1], size[0], 3), np.uint8)

    def run() -> None:
        renderer.render(scene, *size, out=film)
        kernel.append(renderer.kernel_seconds)

    return harness.wall(run)


def antialiasing(renderer: Renderer, size: Size, quick: bool) -> list[Figures]:
    """Of four-spheres, by edges only and in all pixels."""
    turns, count, adaptive, everywhere = (
        (1, 64, ADAPTIVE[:2], UNIFORM[:1]) if quick else (5, TRUTH, ADAPTIVE, UNIFORM)
    )
    truth = converged(renderer, BASE, size, count, (0, 0, *size))
    kernels: dict[int, list[float]] = {n: [] for n in adaptive}
    scenes = {n: replace(BASE, samples=n) for n in {*adaptive, *everywhere}}
    uniform = Uniform()
    contenders = {f"adaptive {n}": timed(renderer, scenes[n], size, kernels[n]) for n in adaptive}
    for n in everywhere:
        contenders[f"uniform {n}"] = partial(uniform.seconds, scenes[n], size)
    seconds = harness.in_turn(contenders, turns)
    found = []
    for n in adaptive:
        wall, kernel = seconds[f"adaptive {n}"], kernels[n][1:]
        found.append({
            "way": "adaptive", "samples": n,
            **errors(renderer.render(scenes[n], *size), truth),
            "kernel": harness.summary(kernel), "wall": harness.summary(wall),
            "kernel_ratio": ratio(kernel, kernels[1][1:]),
            "wall_ratio": ratio(wall, seconds["adaptive 1"]),
        })  # fmt: skip
    for n in everywhere:
        kernel = seconds[f"uniform {n}"]
        found.append({
            "way": "uniform", "samples": n, **errors(uniform.render(scenes[n], size), truth),
            "kernel": harness.summary(kernel), "kernel_ratio": ratio(kernel, kernels[1][1:]),
        })  # fmt: skip
    return found


def ratio(mine: Sequence[float], its: Sequence[float]) -> float:
    """The median of those of each turn."""
    return float(np.median(np.divide(mine, its)))


def effects(renderer: Renderer, size: Size, quick: bool) -> list[Figures]:
    """Of four-spheres with each of SCENES: times of the picture, errors of a part of it."""
    turns, count, counts = (1, 64, EFFECTS[:2]) if quick else (1, TRUTH, EFFECTS)
    names = ("hard shadow", SAMPLED) if quick else tuple(SCENES)
    scenes = {(name, n): replace(SCENES[name], samples=n) for name in names for n in counts}
    kernels: dict[tuple[str, int], list[float]] = {key: [] for key in scenes}
    contenders = {
        f"{name} {n}": timed(renderer, scene, size, kernels[name, n])
        for (name, n), scene in scenes.items()
    }
    harness.in_turn(contenders, turns)
    region, found = middle(size, 3), []
    for name in names:
        truth = converged(renderer, SCENES[name], size, count, region)
        for n in counts:
            picture = renderer.render(scenes[name, n], *size, region=region)
            kernel = kernels[name, n][1:]
            found.append({
                "name": name, "samples": n, "kernel": harness.summary(kernel),
                "kernel_ratio": ratio(kernel, kernels["hard shadow", 1][1:]),
                **errors(picture, truth),
            })  # fmt: skip
    return found


def closed_form(renderer: Renderer, size: Size, quick: bool) -> Figures:
    """Of a round light: the whole picture against that of many samples of the light, all at the
    middle of the pixels, so that nothing but the shadow differs."""
    kernels: dict[str, list[float]] = {"hard shadow": [], SOFT: []}
    contenders = {n: timed(renderer, SCENES[n], size, kernel) for n, kernel in kernels.items()}
    wall = harness.in_turn(contenders, 1 if quick else 5)
    count = 64 if quick else TRUTH // 4
    with mock.patch.object(samples, "offsets", lambda count: np.zeros((count, 2))):
        truth = converged(renderer, SCENES[SAMPLED], size, count, (0, 0, *size))
    return {
        **errors(renderer.render(SCENES[SOFT], *size), truth),
        "kernel": harness.summary(kernels[SOFT][1:]),
        "kernel_ratio": ratio(kernels[SOFT][1:], kernels["hard shadow"][1:]),
        "wall_ratio": ratio(wall[SOFT], wall["hard shadow"]),
    }  # fmt: skip


def antialiasing_table(figures: Figures) -> str:
    """What docs/samples.md shows, as the other tables."""
    head = (f"four-spheres, {'x'.join(map(str, figures['size']))}", "kernel, ms", "spread",
            "x one sample", "wall, ms", "x one sample", "within 1/255", "rmse x 255")  # fmt: skip
    rows = []
    for f in figures["antialiasing"]:
        wall = [ms(f["wall"]["median"]), f"{f['wall_ratio']:.2f}"] if "wall" in f else ["", ""]
        rows.append((f"{f['way']}, samples = {f['samples']}", ms(f["kernel"]["median"]),
                     spread(f["kernel"]), f"{f['kernel_ratio']:.2f}", *wall,
                     f"{100 * f['within']:.3f} %", f"{255 * f['rmse']:.3f}"))  # fmt: skip
    return harness.table(head, rows)


def effects_table(figures: Figures) -> str:
    found = figures["effects"]
    counts = list(dict.fromkeys(f["samples"] for f in found))
    rows = []
    for name in dict.fromkeys(f["name"] for f in found):
        cells = [f"{ms(f['kernel']['median'])} / {255 * f['rmse']:.2f}"
                 for f in found if f["name"] == name]  # fmt: skip
        rows.append((name, *cells))
    size = "x".join(map(str, figures["size"]))
    head = (f"four-spheres, {size}: ms / rmse x 255", *(f"samples = {n}" for n in counts))
    soft = figures["closed_form"]
    return (
        f"{harness.table(head, rows)}\n\n"
        f"The closed form takes {soft['kernel_ratio']:.2f} x the kernel time of a hard shadow and "
        f"{soft['wall_ratio']:.2f} x its\nwall time; it is off the sampled shadow by "
        f"{255 * soft['rmse']:.2f}/255 (rmse of the whole picture)."
    )


def ms(seconds: float) -> str:
    return f"{1e3 * seconds:,.1f}"


def spread(times: Figures) -> str:
    return f"{ms(times['min'])}-{ms(times['max'])}"


TABLES: dict[str, Callable[[Figures], str]] = {
    "samples-antialiasing": antialiasing_table,
    "samples-effects": effects_table,
}
"""By the name between the markers of docs/samples.md."""


def plot(figures: Figures, path: Path) -> None:
    """Error against time, both logarithmic: antialiasing and effects."""
    drawn, (left, right) = harness.figure(2)
    drawn.set_size_inches(11, 8)  # at 80 dpi; a page shows it at two thirds of that
    for way, style in (("adaptive", "o-"), ("uniform", "s:")):
        rows = [f for f in figures["antialiasing"] if f["way"] == way]
        curve(left, rows, [1e3 * f["kernel"]["median"] for f in rows], "rmse", style, way)
    for name in SCENES:
        rows = [f for f in figures["effects"] if f["name"] == name]
        curve(right, rows, [1e3 * f["kernel"]["median"] for f in rows], "rmse", "o-", name)
    left.set(title="four-spheres: antialiasing", xlabel="kernel, ms", ylabel="rmse")
    right.set(title="four-spheres: one thing each", xlabel="kernel, ms")
    for axes in (left, right):
        axes.tick_params(labelsize=15)
        axes.xaxis.set_minor_formatter("")  # they would overlap
        for words in (axes.title, axes.xaxis.label, axes.yaxis.label):
            words.set_fontsize(17)
        axes.legend(fontsize=14, loc="lower center", bbox_to_anchor=(0.45, 1.07))
    drawn.savefig(path, dpi=80)
    print(f"{path}: written")


def curve(
    axes: Any, rows: list[Figures], times: list[float], error: str, style: str, label: str
) -> None:
    axes.loglog(times, [f[error] for f in rows], style, label=label)
    for time, f in zip(times, rows, strict=True):
        if "samples" in f:
            axes.annotate(str(f["samples"]), (time, f[error]), fontsize=11)
