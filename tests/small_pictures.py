"""Renders the suite's small pictures, to be watched by a checker:

oclgrind --data-races --uninitialized .venv/bin/python tests/small_pictures.py [LANES ...]
"""

import sys
from collections.abc import Callable, Sequence
from contextlib import suppress

import numpy as np
import pyopencl as cl
from hard_cases import CASES, program_of
from msgspec.structs import replace

import clrt
from clrt.figure.rendering import Renderer
from clrt.opencl import program
from clrt.renderer import maker
from clrt.renderer.pack.features import LANES, TREE_FROM, Features
from clrt.renderer.pack.structs import PRECISIONS

WIDTH, HEIGHT = 37, 3  # whole packets and a part of one, for any number of lanes
ALONE = 9  # columns of one lane: a pixel takes it as long as others a packet


def untried(
    device: cl.Device,
    source: str,
    wanted: Sequence[Features],
    waiting: Callable[[float], object] | None = None,
) -> list[bytes]:
    """Programs without their trials, which a checker would watch for as long as ten pictures."""
    context = cl.Context([device])
    return [
        program.binary(program.compiled(context, device, source, features.options))
        for features in wanted
    ]


def main(all_lanes: list[int]) -> None:
    maker.made = untried
    scenes = [clrt.load_scene(name) for name in clrt.builtin_scenes()]
    # One for each program, and some more.
    programs = [program_of(case) for case in CASES]
    scenes += [
        case.scene for i, case in enumerate(CASES) if i % 4 == 0 or programs[i] not in programs[:i]
    ]
    # It crashes where it compiles a tree of spheres; for one of faces see faces().
    scenes = [scene for scene in scenes if len(scene.spheres) < TREE_FROM and not scene.meshes]
    # It crashes where it compiles a program with glass as well.
    scenes = [
        scene
        for scene in scenes
        if not any(material.transmission > 0 for material in scene.materials.values())
    ]
    for lanes in all_lanes:
        width = WIDTH if lanes > 1 else ALONE
        region = (3, 1, width - 1, HEIGHT)
        for precision in PRECISIONS:
            renderer = Renderer(lanes=lanes, precision=precision)
            for scene in scenes if lanes == 4 else scenes[::3]:  # that takes minutes as it is
                with suppress(clrt.RequestError):  # beyond what a precision can show
                    renderer.render(scene, width, HEIGHT)
            for scene in scenes[:8]:
                renderer.paths(scene, width, HEIGHT)
                renderer.render(scene, width, HEIGHT, dtype=np.uint8, region=region)
                white = replace(scene, film=clrt.Film(background=(1, 1, 1)))
                renderer.render(white, width, HEIGHT, region=region, passes=["id"])
            print(f"{renderer.device.name}: {lanes} lanes, {precision}: {len(scenes)} scenes")


def faces() -> None:
    """A tree of faces. Not to be watched for what is uninitialised: Oclgrind 21.10 takes all that
    stays in the host's memory for such, and a tree is fitted to things there."""
    maker.made = untried
    renderer = Renderer(lanes=16)
    renderer.render(clrt.load_scene("shading"), WIDTH, HEIGHT)
    print(f"{renderer.device.name}: faces")


if __name__ == "__main__":
    main([int(word) for word in sys.argv[1:]] or list(LANES))
