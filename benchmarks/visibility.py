"""Visibility: the ways to find which sphere each pixel shows, their times and wrong pixels."""

import runpy
import sys
import time
from pathlib import Path
from typing import Any

import click

from benchmarks import harness, many

EXAMPLE = runpy.run_path(str(Path(__file__).parents[1] / "examples" / "visible_surfaces.py"))
SCANLINE_TO, SCANLINE_EVERY = 10**4, 10  # spheres; and rows of more than 1000, for it is slow


@click.command("visibility")
@click.pass_obj
def command(quick: bool) -> None:
    """Finds the visible surfaces of random spheres and of molecules by rays, tiles with a z-buffer,
    the painter's order and scanlines, against the truth."""
    size = (240, 136) if quick else (960, 540)
    counts = [100] if quick else [10**3, 10**4, 10**5]
    figures = [
        {"kind": kind, "spheres": n, **found}
        for kind, make in (("random", many.random), ("molecule", many.molecule))
        for n in counts
        for found in measure(make(n) - (0, 0, 1, 0), size)
    ]
    results = {"size": size, "figures": figures}
    print(tabulated(results))
    harness.record(harness.results_folder(quick), "visibility", results)


def measure(spheres: Any, size: tuple[int, int]) -> list[dict[str, Any]]:
    """What each way takes, and where it is wrong."""
    right = EXAMPLE["truth"](spheres, size)
    found = []
    for name, way in EXAMPLE["WAYS"].items():
        if name == "scanline" and len(spheres) > SCANLINE_TO:
            continue
        every = SCANLINE_EVERY if name == "scanline" and len(spheres) > 1000 else 1
        way(spheres[:100], (32, 18))  # compiles
        started = time.perf_counter()
        shown = EXAMPLE["by_scanline"](spheres, size, every) if every > 1 else way(spheres, size)
        seconds = every * (time.perf_counter() - started)
        truth = right[::every]
        wrong, seen = int((shown != truth).sum()), int((truth >= 0).sum())
        found.append({"way": name, "seconds": seconds, "wrong": wrong, "seen": seen})
        print(f"{len(spheres):,} spheres, {name}: done", file=sys.stderr)
    return found


def tabulated(results: dict[str, Any]) -> str:
    """Markdown."""
    width, height = results["size"]
    head = (f"{width}x{height}", "way", "seconds", "wrong pixels", "of those that show a sphere")
    return harness.table(head, [row(figure) for figure in results["figures"]])


def row(figure: dict[str, Any]) -> tuple[str, ...]:
    return (
        f"{figure['kind']} {figure['spheres']:,}",
        figure["way"],
        f"{figure['seconds']:.2f}",
        f"{figure['wrong']:,}",
        f"{100 * figure['wrong'] / figure['seen']:.2f} %",
    )
