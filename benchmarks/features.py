"""What a feature costs where a scene uses it. Where none does, the machine code is the same
(scripts/same_code)."""

from collections.abc import Callable
from typing import Any

import click
import numpy as np
from msgspec.structs import replace

import clrt
from benchmarks import harness
from clrt.figure.rendering import Renderer
from clrt.scene.scene import Scene

ABOVE = (0.3, 2.4, 1.5)
BASE = clrt.load_scene("four-spheres")
SUN = harness.point_lights(BASE)[0]


def lit_by(
    *lights: clrt.Light | clrt.DirectionalLight | clrt.SpotLight | clrt.AmbientLight,
) -> Scene:
    return replace(BASE, lights=lights)


def made_of(**changes: Any) -> Scene:
    """BASE with something changed in all its materials."""
    materials = {name: replace(m, **changes) for name, m in BASE.materials.items()}
    return replace(BASE, materials=materials)


def with_ball(**values: Any) -> Scene:
    """BASE with a ball before its spheres."""
    ball = clrt.Material(diffuse=(0.05, 0.05, 0.05), specular=(0.5, 0.5, 0.5), **values)
    return replace(
        BASE,
        max_depth=8,
        materials={**BASE.materials, "ball": ball},
        spheres=(*BASE.spheres, clrt.Sphere((0.0, -0.1, -0.2), 0.5, "ball")),
    )


# Each beside what it is compared with.
SCENES: dict[str, tuple[Scene, str]] = {
    "a point light": (BASE, ""),
    "a directional light": (lit_by(clrt.DirectionalLight((-5, -5, -5))), "a point light"),
    "attenuation": (lit_by(replace(SUN, attenuation=(0.5, 0.05, 0.01))), "a point light"),
    "a spot that leaves nothing dark": (
        lit_by(clrt.SpotLight(SUN.position, (0, 0, 0), outer_angle=170)), "a point light"
    ),
    "a spot of 20 degrees": (
        lit_by(clrt.SpotLight(ABOVE, (-0.2, -0.2, -0.4), outer_angle=20)), "a point light"
    ),
    "Phong's highlight": (made_of(highlight="phong"), "a point light"),
    "an ambient light more": (lit_by(SUN, clrt.AmbientLight()), "a point light"),
    "a ball that mirrors, depth 8": (with_ball(reflection=0.9), ""),
    "a ball of glass, depth 8": (
        with_ball(transmission=0.9), "a ball that mirrors, depth 8"
    ),
    "a ball that does both, depth 8": (
        with_ball(transmission=0.8, reflection=0.1), "a ball that mirrors, depth 8"
    ),
    "orthographic": (
        replace(BASE, camera=clrt.Camera((0, 0, 1), (0, 0, 0), projection="orthographic",
                                         height=1.6)), "a point light"
    ),
}  # fmt: skip


@click.command("features")
@click.pass_obj
def command(quick: bool) -> None:
    """Times four-spheres with each thing that a scene can have and need not."""
    width, height, turns, frames = (480, 270, 1, 1) if quick else (3840, 2160, 5, 5)
    contenders: dict[str, Callable[[], float]] = {}
    with Renderer() as renderer:
        for name, (scene, _) in SCENES.items():
            contenders[name] = harness.kernel_time(renderer, scene, width, height, np.uint8, frames)
        seconds = harness.in_turn(contenders, turns)
    found: dict[str, Any] = {}
    for name, (_, beside) in SCENES.items():
        found[name] = harness.summary(seconds[name])
        if beside:
            pairs = zip(seconds[name], seconds[beside], strict=True)
            found[name]["ratio"] = float(np.median([mine / its for mine, its in pairs]))
            found[name]["beside"] = beside
    print(table([width, height], found))
    harness.record(
        harness.results_folder(quick), "features", {"size": [width, height], "features": found}
    )


def table(size: list[int], found: dict[str, Any]) -> str:
    """What docs/speed.md shows."""
    rows = [
        (
            name,
            f"{1e3 * t['median']:.1f}",
            f"{1e3 * t['min']:.1f}-{1e3 * t['max']:.1f}",
            f"{t['ratio']:.2f} x {t['beside']}" if "ratio" in t else "",
        )
        for name, t in found.items()
    ]
    return harness.table(
        (f"four-spheres, {size[0]}x{size[1]}, with", "ms", "spread", "ratio"), rows
    )
