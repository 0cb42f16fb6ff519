"""Translucent atoms beside opaque ones, and beside OVITO's renderers with the same transparency."""

import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
import numpy as np
from msgspec.structs import replace

import clrt
from benchmarks import harness, many, ovito_peer
from clrt.figure.rendering import Renderer
from clrt.scene.scene import Scene

PART = 0.2
"""The opacity of every other atom."""


def scenes(n: int) -> dict[str, Scene]:
    """The same atoms: opaque, half of them translucent, and all."""
    opaque = many.scene_of(many.molecule(n), 1)
    spheres: Any = opaque.spheres
    half = np.where(np.random.default_rng(5).uniform(size=n) < 0.5, PART, 1.0)
    made = {"opaque": opaque}
    for name, opacity in {"half": half, "all": np.full(n, PART)}.items():
        some = clrt.Spheres(spheres.center, spheres.radius, spheres.material_index, opacity=opacity)
        made[name] = replace(opaque, spheres=some)
    return made


@click.command("translucent")
@click.pass_obj
def command(quick: bool) -> None:
    """Times atoms that are seen through beside opaque ones, one sample a pixel."""
    n, size, turns = (1000, (480, 270), 1) if quick else (10**5, (1920, 1080), 3)
    renderer = Renderer()
    contenders: dict[str, Callable[[], float]] = {}
    for name, scene in scenes(n).items():
        film = np.empty((size[1], size[0], 3), np.uint8)

        def draw(scene: Scene = scene, film: Any = film) -> None:
            renderer.render(scene, *size, out=film)

        def run(draw: Callable[[], None] = draw) -> float:
            draw()  # the tree is another scene's
            return harness.wall(draw)()

        contenders[f"clrt, {name}"] = run
    with tempfile.TemporaryDirectory() as folder:
        half: Any = scenes(n)["half"].spheres
        atoms, picture = Path(folder) / "atoms.npz", Path(folder) / "a.png"
        np.savez(atoms, center=half.center, radius=half.radius, opacity=half.opacity)
        for other in ovito_peer.renderers():
            options = ovito_peer.ONE_SAMPLE[other]
            words = ovito_peer.words(atoms, picture, other, options, size, size[1])

            def theirs(words: tuple[str, ...] = words) -> float:
                done = subprocess.run(
                    [sys.executable, "-c", *words],
                    capture_output=True,
                    text=True,
                    check=True,
                )
                return float(done.stdout.split()[-1])

            contenders[f"OVITO, {other}, half"] = theirs
        seconds = harness.in_turn(contenders, turns)
    figures = {name: harness.summary(taken) for name, taken in seconds.items()}
    least = figures["clrt, opaque"]["median"], figures["clrt, half"]["median"]
    rows = [
        (
            name,
            f"{1e3 * time['median']:,.0f}",
            f"{1e3 * time['min']:,.0f}-{1e3 * time['max']:,.0f}",
            *(f"{time['median'] / one:,.2f}" for one in least),
        )
        for name, time in figures.items()
    ]
    print(f"{n:,} atoms, half: every other of opacity {PART}, {size[0]}x{size[1]}, one sample\n")
    print(harness.table(("what", "ms", "spread", "x opaque", "x half"), rows))
    harness.record(harness.results_folder(quick), "translucent", {"size": size, "times": figures})
