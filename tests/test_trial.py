"""Trials: a program that is wrong, or a compiler that crashes or hangs, is found out."""

import itertools
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pyopencl as cl
import pytest
from msgspec.structs import replace

import clrt
from clrt import storage
from clrt.errors import DeviceError, DeviceWarning
from clrt.figure.rendering import Renderer
from clrt.opencl import program
from clrt.renderer import trial
from clrt.renderer.pack.features import USES, Features, Stage, features_of
from clrt.renderer.pack.structs import FILMS, PRECISIONS, Precision
from clrt.renderer.pack.world import pack_world

EXPOSE = "Exposure exposure = exposure_of(sample);"
PLAIN = Features(4, "robust", "float")
USED = [some for n in range(3) for some in itertools.combinations(USES, n)]
RANDOM = {"occlusion", "lens", "gloss", "indirect"}
SAMPLED = {"hashed", "refine", "gather", *RANDOM}


def can_be(precision: str, film: str, some: set[str]) -> bool:
    """Whether some scene needs all of these at once."""
    stages = {"hashed", "refine", "gather"} & some
    sampled = "round" in some and bool({"capsules", "faces"} & some)
    is_random = bool(RANDOM & some) or sampled
    return not (
        ({"capsules", "faces"} & some and "tree" not in some)
        or ({"smooth", "gouraud", "corner_colors"} & some and "faces" not in some)
        or ("corner_colors" in some and "sphere_colors" not in some)
        or (sampled and film == "paths")
        or {"orthographic", "long_lens"} <= some
        or {"orthographic", "lens"} <= some
        or ("split" in some and not {"nest", "reflection"} <= some)
        or ("opacity" in some and {"nest", "indirect"} & some)
        or ({"background", "gloss", "indirect"} & some and "reflection" not in some)
        or (
            precision == "literal"
            and {
                "near",
                "nest",
                "opacity",
                "round",
                "long_lens",
                "tree",
                "capsules",
                "faces",
                *SAMPLED,
            }
            & some
        )
        or (
            film == "passes"
            and some - {"orthographic", "long_lens", "tree", "capsules", "faces", "smooth", "nest"}
        )
        or (film == "paths" and SAMPLED & some)
        or (film == "guides" and not is_random)
        or (film == "paths" and "near" in some)
        or {"near", "occlusion"} <= some
        # Where there is one, the film has alpha.
        or (film in ("float", "bytes") and "background" in some)
        # All pixels of few samples and then the edges, or all of many.
        or ("refine" in some and len(stages) > 1)
        or (is_random and stages != {"gather"})
        or (stages == {"gather"} and not is_random)
    )


APART: tuple[set[str], ...] = (
    set(),
    *(
        stages | others
        for stages in (
            {"hashed", "refine", "near"},
            {"refine", *RANDOM},
            {"gather", "refine", *RANDOM},
        )
        for others in ({"opacity"}, {"nest", "split", "indirect"})
    ),
)
# Of three and more that need one another.
TOGETHER = [
    {"nest", "reflection", "split"},
    {"gather", "lens", "near"},
    {"faces", "smooth", "tree"},
    {"faces", "gouraud", "tree"},
    {"corner_colors", "faces", "sphere_colors", "tree"},
]
SETS = dict.fromkeys(tuple(sorted(some)) for some in TOGETHER) | dict.fromkeys(
    tuple(sorted(some - apart))
    for used in map(set, USED)
    for some in (used, set(USES) - used)
    for apart in (APART if len(some) > 3 else APART[:1])
)
EVERY = [
    Features(4, precision, film, **dict.fromkeys(some, True))
    for precision in PRECISIONS
    for film in FILMS
    for some in SETS
    if can_be(precision, film, set(some))
]


@pytest.mark.parametrize("features", EVERY, ids=lambda f: "".join(f.options[1:]) or "plain")
def test_a_trials_scene_needs_what_the_program_is_for(features: Features) -> None:
    scene = trial.scene_for(features)
    world = pack_world(scene, features.precision)
    stage: Stage = "edges" if features.refine else "picture"
    assert features_of(world, scene, features.lanes, features.film, stage) == features


def test_each_feature_shows_in_the_trials_picture(device: cl.Device) -> None:
    """Were it left out of the kernel, the trial would notice: where it does no more than speed
    things up or keep digits it cannot."""
    with_all = Features(4, "robust", "paths", reflection=True, light_inside=True)
    without = [replace(with_all, reflection=False), replace(with_all, light_inside=False)]
    source = program.kernel_source()
    trial.try_here(device, source, with_all)
    for less in without:
        lying = source
        for option in set(with_all.options) - set(less.options):
            name = option[2:].split("=")[0]
            lying = f"#undef {name}\n#define {name} 0\n" + lying
        with pytest.raises(DeviceError, match=r"is wrong about \d+ of 1313 pixels"):
            trial.try_here(device, lying, with_all)


LAST = "LANE == LANES - 1"
LIGHT = f"sample.color = scaled(sample.color, PICK({LAST}, REAL(0.98), 1));"
ALPHA = f"sample.alpha = PICK({LAST}, 1 - sample.alpha, sample.alpha);"
PATH = f"sample.path = PICK_INT({LAST}, sample.path ^ 1, sample.path);"
LIES = [
    ("float", LIGHT),
    ("bytes", LIGHT),
    ("alpha", LIGHT),
    ("alpha", ALPHA),
    ("paths", PATH),
    ("passes", f"sample.depth *= PICK({LAST}, REAL(1.01), 1);"),
    ("passes", f"sample.normal.y += PICK({LAST}, REAL(0.01), 0);"),
    ("passes", f"sample.id += PICK_INT({LAST}, 1, 0);"),
]


@pytest.mark.parametrize(
    ("precision", "film", "lie"),
    [
        pytest.param(precision, *lie, marks=[pytest.mark.slow] * (precision != "robust" and i > 0))
        for precision in PRECISIONS
        for i, lie in enumerate(LIES)
    ],
)
def test_a_wrong_program_is_found(device: cl.Device, precision, film, lie) -> None:
    """Wrong in each packet's last lane only, by a little of its light."""
    source = program.kernel_source()
    wrong = source.replace(EXPOSE, f"{lie}\n{EXPOSE}")
    assert wrong != source
    features = Features(8, precision, film, reflection=film != "passes")
    if precision == "double" and device.native_vector_width_double == 0:
        pytest.skip("no float64")
    assert trial.try_here(device, source, features)
    with pytest.raises(DeviceError, match=r"is wrong about \d+ of 1313 pixels"):
        trial.try_here(device, wrong, features)


@pytest.mark.parametrize("uses", [("hashed", "gather"), ("refine",)])
def test_wrong_samples_are_found(device: cl.Device, uses: tuple[str, ...]) -> None:
    """One of a pixel's is left out."""
    source = program.kernel_source()
    wrong = source.replace(
        "block = with(block, sample,", "if (i == 0) continue; block = with(block, sample,"
    )
    features = Features(8, "robust", "alpha", reflection=True, **dict.fromkeys(uses, True))
    assert trial.try_here(device, source, features)
    with pytest.raises(DeviceError, match=r"is wrong about \d+ of 185 pixels"):
        trial.try_here(device, wrong, features)


def test_a_wrong_background_is_found(device: cl.Device) -> None:
    features = Features(4, "robust", "alpha", reflection=True, background=True)
    source = program.kernel_source()
    background = "splat(scene->background)"
    wrong = source.replace(background, f"scaled({background}, REAL(0.9))")
    assert trial.try_here(device, source, features)
    with pytest.raises(DeviceError, match=r"is wrong about \d+ of 1313 pixels"):
        trial.try_here(device, wrong, features)


def plant(monkeypatch: pytest.MonkeyPatch, cache: Path, code: str) -> None:
    """Makes a kernel that is wrong in some way for more than two lanes."""
    source = program.kernel_source()
    planted = source.replace(EXPOSE, f"#if LANES > 2\n{code}\n#endif\n{EXPOSE}")
    monkeypatch.setattr("clrt.opencl.program.kernel_source", lambda: planted)
    monkeypatch.setenv("XDG_CACHE_HOME", str(cache))


def test_narrower_lanes_are_tried(
    device: cl.Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    scene = clrt.load_scene("four-spheres")
    right = Renderer(device=device, lanes=2).render(scene, 33, 9)
    plant(monkeypatch, tmp_path, "sample.color.x += REAL(0.1);")
    for _ in range(2):  # the wrong ones are not kept
        renderer = Renderer(device=device, lanes=8)
        with pytest.warns(DeviceWarning) as said:
            image = renderer.render(scene, 33, 9)
        for lanes, warning in zip((8, 4), said, strict=True):
            what = f"{lanes} lanes cannot be used, {lanes // 2} are: its compiler is wrong about"
            assert what in str(warning.message)
        assert renderer.lanes == 2
        assert (image == right).all()
        assert len(list((tmp_path / "clrt").glob("?" * storage.KEY_LENGTH))) == 1


def test_the_command_says_so(tmp_path: Path) -> None:
    code = (
        "import sys; from clrt.opencl import program; source = program.kernel_source()\n"
        "lie = '#if LANES > 2\\nsample.color.y = 0;\\n#endif\\n'\n"
        f"wrong = source.replace('{EXPOSE}', lie + '{EXPOSE}')\n"
        "program.kernel_source = lambda: wrong\n"
        "sys.argv = 'clrt render --lanes 4 --width 40 --height 23'.split()\n"
        "from clrt.__main__ import main; main()"
    )
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path / "cache")}
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=tmp_path, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0
    first, second = done.stderr.strip().split("\n")
    assert first.startswith("clrt: ")
    assert "4 lanes cannot be used, 2 are: its compiler is wrong about" in first
    assert second.startswith("four-spheres.png: 40x23")


def test_none_works(device: cl.Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = program.kernel_source().replace(EXPOSE, "sample.color.x = 1;\n" + EXPOSE)
    monkeypatch.setattr("clrt.opencl.program.kernel_source", lambda: wrong)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    with pytest.raises(DeviceError, match=r"cannot be used: its compiler is wrong about"):
        Renderer(device=device, lanes=1).render(clrt.load_scene("four-spheres"), 9, 9)


def test_picture_of_a_device_that_is_narrow(monkeypatch: pytest.MonkeyPatch) -> None:
    scene = clrt.load_scene("four-spheres")
    right = Renderer(lanes=4).render(scene, 33, 9)
    monkeypatch.setattr("clrt.opencl.pocl.is_narrow", lambda device: True)
    cases: list[tuple[Precision, int]] = [("robust", 4), ("double", 2)]
    for precision, lanes in cases:
        with pytest.warns(DeviceWarning, match=f"16 lanes cannot be used, {lanes} are: PoCL"):
            renderer = Renderer(precision=precision)
        assert renderer.lanes == lanes
    image = Renderer(lanes=4).render(scene, 33, 9)
    assert np.array_equal(image, right)
