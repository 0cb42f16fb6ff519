"""Speed against error: what each precision costs, and how far its picture is from the truth."""

from dataclasses import asdict
from typing import Any

import click
import numpy as np
from msgspec.structs import replace

import clrt
from benchmarks import harness
from clrt import reference
from clrt.figure.rendering import Renderer
from clrt.film import metrics
from clrt.renderer.pack.structs import PRECISIONS, Precision
from clrt.scene.scene import Scene
from clrt.values import Vec3

TRUTHS: tuple[tuple[reference.Truth, float], ...] = (("exact", 0.0), ("seed", 1e-5))


def moved(scene: Scene, by: Vec3) -> Scene:
    """The scene, camera and all, somewhere else in the world."""

    def shift(point: Vec3) -> Vec3:
        return point[0] + by[0], point[1] + by[1], point[2] + by[2]

    return replace(
        scene,
        camera=replace(
            scene.camera,
            position=shift(scene.camera.position),
            look_at=shift(scene.camera.look_at),
        ),
        lights=tuple(
            replace(light, position=shift(light.position)) for light in harness.point_lights(scene)
        ),
        spheres=tuple(replace(s, center=shift(s.center)) for s in scene.spheres),
    )


def with_plane(scene: Scene, radius: float) -> Scene:
    """four-spheres on a plane of another radius, at the same height."""
    plane = replace(scene.spheres[3], center=(0.0, -0.7 - radius, 0.0), radius=radius)
    return replace(scene, spheres=(*scene.spheres[:3], plane))


@click.command("accuracy")
@click.pass_obj
def command(quick: bool) -> None:
    """Times each precision and compares its picture with both truths, pixel by pixel."""
    width, height, turns = (480, 270, 1) if quick else (1920, 1080, 3)
    base = clrt.load_scene("four-spheres")
    scenes = {
        "four-spheres": base,
        "moved by (1e5, -1e5, 1e5)": moved(base, (1e5, -1e5, 1e5)),
        "plane of radius 1e7": with_plane(base, 1e7),
        "lights": clrt.load_scene("lights"),
        "glass": clrt.load_scene("glass"),
    }
    rows, points = [], []
    for name, scene in scenes.items():
        truths = {
            truth: reference.trace(replace(scene, shadow_bias=bias), width, height, truth)
            for truth, bias in TRUTHS
            if (name, truth) != ("glass", "seed")
        }
        # The paper knows no glass.
        known = [p for p in PRECISIONS if (name, p) != ("glass", "literal")]
        renderers = {(p, lanes): Renderer(precision=p, lanes=lanes) for p in known
                     for lanes in (1, 16)}  # fmt: skip
        seconds = harness.in_turn(
            {
                f"{precision} {lanes}": harness.kernel_time(
                    renderer, scene, width, height, np.float32, 1 if lanes == 1 else 3
                )
                for (precision, lanes), renderer in renderers.items()
            },
            turns,
        )
        for (precision, lanes), renderer in renderers.items():
            time = harness.summary(seconds[f"{precision} {lanes}"])
            point: dict[str, Any] = {"scene": name, "precision": precision, "lanes": lanes, **time}
            cells = []
            for truth, bias in TRUTHS:
                if truth not in truths:
                    cells += [""] * 4
                    continue
                error = against(renderer, replace(scene, shadow_bias=bias), truths[truth])
                point[truth] = asdict(error)
                cells += [
                    f"{error.max_off_flips:.1e}",
                    f"{error.p999:.1e}",
                    f"{error.over_1020}",
                    f"{error.flips} ({error.interior_flips})",
                ]
            points.append(point)
            label = f"{name}, {precision}, {lanes} lane{'s' * (lanes > 1)}"
            rows.append((label, f"{1e3 * time['median']:.1f}", *cells))
    errors = ("max off flips", "p99.9", "> 1/1020", "flips (interior)")
    head = ("scene, precision, lanes", "ms", *(f"{t}: {e}" for t, _ in TRUTHS for e in errors))
    print(f"{width}x{height}, errors of colours in [0, 1]\n")
    print(harness.table(head, rows))
    folder = harness.results_folder(quick)
    harness.record(folder, "accuracy", {"size": [width, height], "points": points})
    plot(points, folder / "accuracy.png")


def against(renderer: Renderer, scene: Scene, truth: reference.Trace) -> metrics.Difference:
    """The error figures of a renderer's picture of this scene."""
    height, width = truth.paths.shape
    image = renderer.render(scene, width, height)
    return metrics.difference(image, truth.image, renderer.paths(scene, width, height), truth.paths)


def plot(points: list[dict[str, Any]], path: Any) -> None:
    """Time on one axis, error on the other, a mark for each precision and number of lanes."""
    figure, axes = harness.figure()
    colors: dict[Precision, str] = {
        "robust": "tab:green",
        "literal": "tab:red",
        "double": "tab:blue",
    }
    marks = dict(zip(dict.fromkeys(p["scene"] for p in points), "osD^v", strict=True))
    for point in points:
        lanes = point["lanes"]
        axes.scatter(
            1e3 * point["median"],
            point["exact"]["rmse"],
            s=70,
            marker=marks[point["scene"]],
            color=colors[point["precision"]],
            facecolor=colors[point["precision"]] if lanes > 1 else "none",
        )
        if point["scene"] == "four-spheres":
            axes.annotate(
                f" {point['precision']}, {lanes} lane{'s' * (lanes > 1)}",
                (1e3 * point["median"], point["exact"]["rmse"]),
                fontsize=11,
            )
    for scene, mark in marks.items():
        axes.scatter([], [], marker=mark, color="gray", label=scene)
    axes.legend(fontsize=11)
    axes.set(
        xscale="log",
        yscale="log",
        xlabel="kernel time of the picture, ms",
        ylabel="RMS error against the exact truth",
        title="Speed against error: lower left is better",
    )
    figure.savefig(path, dpi=110)
    print(f"{path}: written")
