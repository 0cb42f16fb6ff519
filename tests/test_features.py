"""Every feature has been compiled and tried in every film and precision that knows it.

Other tests say what a feature does. They do so in few films, and mostly in float32 for 16 lanes.
"""

from collections.abc import Iterator
from itertools import product

import pyopencl as cl
import pytest
from conftest import renderer_for
from msgspec.structs import replace
from test_trial import EVERY

from clrt.renderer import trial
from clrt.renderer.pack.features import ENOUGH, USES, Features, features_of, stages
from clrt.renderer.pack.structs import FILMS, PRECISIONS, FilmKind, Precision
from clrt.renderer.pack.world import pack_world
from clrt.scene.scene import Scene

RANDOM = {"occlusion", "lens", "gloss", "indirect"}
MESHES = {"faces", "smooth", "gouraud", "corner_colors"}
NO_STAGE = {"hashed", "refine", "gather"}
BEYOND_PAPER = {
    "long_lens",
    "tree",
    "capsules",
    *MESHES,
    "nest",
    "split",
    "opacity",
    "round",
    "near",
    *RANDOM,
    *NO_STAGE,
}
# Together they use all that a precision knows. Samples at edges take two programs, and what is
# drawn at random a third. What is seen through is in no scene with glass or indirect light.
SCENES: dict[str, set[str]] = {
    "as the paper": set(USES) - BEYOND_PAPER,
    "edges": {"hashed"}
    | set(USES) - RANDOM - NO_STAGE - MESHES - {"long_lens", "tree", "capsules", "nest", "split"},
    "random": {"gather"} | set(USES) - NO_STAGE - {"orthographic", "opacity", "near"},
    "guided": {"gather", "near", "gloss", "reflection", "orthographic", "opacity"},
}
LANES_OF: dict[Precision, dict[str, int]] = {
    "robust": {"edges": 16, "random": 4, "guided": 16}, "literal": {"as the paper": 1},
    "double": {"edges": 1, "random": 1, "guided": 1},
}  # fmt: skip
# Passes come beside another film.
PICTURES: dict[str, tuple[FilmKind, ...]] = {
    "float": ("float",), "bytes": ("bytes",), "alpha": ("alpha", "passes"),
    "guides": ("guides",), "paths": ("paths",)
}  # fmt: skip
TRIED: list[tuple[Precision, str, str]] = [
    (precision, scene, picture)
    for precision in PRECISIONS
    for scene in SCENES
    for picture in PICTURES
    if (precision == "literal") == (scene == "as the paper")
    and (scene in ("random", "guided") if picture == "guides" else scene != "guided")
]


def scene_of(precision: Precision, name: str, picture: str) -> Scene:
    uses = SCENES[name] - ({"background"} if picture in ("float", "bytes") else set())
    wanted = Features(LANES_OF[precision][name], precision, "float", **dict.fromkeys(uses, True))
    made = trial.scene_for(wanted)
    if picture == "guides":
        return replace(made, film=replace(made.film, denoise=True), samples=ENOUGH - 1)
    return made


def programs(precision: Precision, name: str, picture: str) -> Iterator[Features]:
    scene = scene_of(precision, name, picture)
    world = pack_world(scene, precision)
    for film in PICTURES[picture]:
        for stage in stages(scene, film):
            yield features_of(world, scene, LANES_OF[precision][name], film, stage)


# What stands in trees, each without the other, of lanes that are in no other test.
ALONE: list[tuple[Precision, int, set[str]]] = [
    ("robust", 4, {"tree", "faces", "opacity"}),
    ("double", 4, {"tree", "capsules", "opacity"}),
]


@pytest.mark.parametrize(("precision", "lanes", "uses"), ALONE)
def test_tried_alone(device: cl.Device, precision: Precision, lanes: int, uses: set[str]) -> None:
    if precision == "double" and device.native_vector_width_double == 0:
        pytest.skip("no float64")
    wanted = Features(lanes, precision, "float", **dict.fromkeys(uses, True))
    scene = trial.scene_for(wanted)
    renderer = renderer_for(device, lanes, precision)
    renderer.prepare(scene, "float32", alpha=False)
    used = features_of(pack_world(scene, precision), scene, lanes, "float")
    known = ("tree", "faces", "capsules", "opacity")
    assert {name for name in known if getattr(used, name)} == uses
    assert used in renderer._programs


def test_every_cell_is_tried() -> None:
    """A cell is a feature in a film and a precision. EVERY is all that some scene can need."""

    def cells(some: list[Features]) -> set[tuple[str, str, str]]:
        return {
            (name, one.film, one.precision) for one in some for name in USES if getattr(one, name)
        }

    tried = [one for words in TRIED for one in programs(*words)]
    assert {(one.film, one.precision) for one in tried} == set(product(FILMS, PRECISIONS)) - {
        ("guides", "literal")
    }
    assert cells(tried) == cells(EVERY)


@pytest.mark.parametrize(("precision", "scene", "picture"), TRIED)
def test_tried(device: cl.Device, precision: Precision, scene: str, picture: str) -> None:
    """A program that a renderer has, has passed its trial; it has one, and of no fewer lanes."""
    if precision == "double" and device.native_vector_width_double == 0:
        pytest.skip("no float64")
    renderer = renderer_for(device, LANES_OF[precision][scene], precision)
    made = scene_of(precision, scene, picture)
    if picture == "paths":
        renderer.paths(made, 9, 9)
    else:
        dtype = "uint8" if picture == "bytes" else "float32"
        passes = ["id"] if picture == "alpha" else None
        renderer.prepare(made, dtype, alpha=picture in ("alpha", "guides"), passes=passes)
    assert set(programs(precision, scene, picture)) <= set(renderer._programs)
