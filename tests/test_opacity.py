"""Opacity: which scenes can say it, and what rays see on their straight way."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from clrt import reference
from clrt.errors import RequestError, SceneError
from clrt.files.scenewriter import save_scene

MATTE = clrt.Material()
SKY = clrt.AmbientLight()
CAMERA = clrt.Camera((0, 0, 0), (0, 0, -1), fov=1.0)
SHOWN = {
    name: clrt.Material(ambient=color, diffuse=(0, 0, 0))
    for name, color in {"red": (1, 0, 0), "green": (0, 1, 0), "blue": (0, 0, 1)}.items()
}


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: clrt.Material(opacity=1.1), "opacity: expected a number from 0 to 1, got 1.1"),
        (lambda: clrt.Material(opacity=0.5, reflection=0.1), "opacity: expected 1 beside refl"),
        (lambda: clrt.Material(opacity=0.5, transmission=0.1), "opacity: expected 1 beside trans"),
        (lambda: clrt.Sphere((0, 0, 0), 1, "m", opacity=-1), "opacity: expected a number from 0"),
        (
            lambda: clrt.Spheres(np.zeros((3, 3)), 1, "m", opacity=[0, 1, 2]),
            r"spheres.opacity\[2\]: expected a number from 0 to 1, got 2",
        ),
        (lambda: clrt.Spheres(np.zeros((3, 3)), 1, "m", opacity=[1, 1]), "opacity: expected 3"),
    ],
)
def test_refuses(make: Any, said: str) -> None:
    with pytest.raises(SceneError, match=said):
        make()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"shadow_bias": 0.1}, "shadow_bias: expected 0 beside opacity of"),
        ({"indirect": True}, "indirect: expected false beside opacity of"),
        (
            {"materials": {"m": MATTE, "g": clrt.Material(transmission=0.5)}},
            "materials.g.transmission: expected 0 beside opacity of",
        ),
        (
            {"materials": {"m": clrt.Material(reflection=0.5)}},
            r"spheres\[1\].opacity: expected 1 beside reflection of its material, got 0.5",
        ),
    ],
)
@pytest.mark.parametrize("as_arrays", [False, True])
def test_refuses_beside_opacity(changes: Any, said: str, as_arrays: bool) -> None:
    spheres: Any = [clrt.Sphere((0, 0, z), 1, "m", opacity=a) for z, a in ((0, 1.0), (9, 0.5))]
    if as_arrays:
        spheres = clrt.Spheres.of(spheres)
    scene = clrt.Scene(CAMERA, [SKY], {"m": MATTE}, spheres)
    with pytest.raises(SceneError, match=said):
        replace(scene, **changes)


def test_the_paper_knows_none() -> None:
    scene = clrt.Scene(CAMERA, [SKY], {"m": replace(MATTE, opacity=0.5)})
    with pytest.raises(RequestError, match="literal knows no opacity of"):
        clrt.Renderer(precision="literal").render(scene, 9, 9)
    with pytest.raises(RequestError, match="'seed' knows no opacity of"):
        reference.trace(scene, 9, 9, "seed")


def test_a_scene_comes_back(tmp_path: Path) -> None:
    ball = clrt.Sphere((0, 0, 1), 2, "m", opacity=0.3)
    materials = {"m": replace(MATTE, opacity=0.7)}
    scene = clrt.Scene(CAMERA, [SKY], materials, [ball, replace(ball, opacity=1.0)])
    save_scene(tmp_path / "a.toml", scene)
    assert clrt.load_scene(tmp_path / "a.toml") == scene


def test_spheres_as_arrays_are_the_same() -> None:
    balls = [clrt.Sphere((0, 0, i), 1 + i, "m", opacity=i / 4) for i in range(5)]
    many = clrt.Spheres.of(balls)
    assert list(many) == balls
    assert many[1:3] == clrt.Spheres.of(balls[1:3])
    opaque = clrt.Spheres([[0, 0, 0]], 1, "m")
    assert opaque.opacity is None
    joined = clrt.Spheres.joined([many[:2], opaque])
    assert joined.opacity is not None
    assert joined.opacity.tolist() == [0, 0.25, 1]
    assert many[1:2] != clrt.Spheres.of([replace(balls[1], opacity=1.0)])


def in_a_row(*balls: tuple[str, float, float, float], **more: Any) -> clrt.Scene:
    """Balls of a colour, an opacity and a radius ahead of a camera, so far away."""
    spheres = [
        clrt.Sphere((0, 0, -away), radius, name, opacity=opacity)
        for name, opacity, radius, away in balls
    ]
    return clrt.Scene(CAMERA, [SKY], SHOWN, spheres, **more)


@pytest.mark.parametrize(
    ("balls", "color", "alpha"),
    [
        # One behind another, in any order of the list.
        ([("red", 0.5, 1, 5), ("green", 0.25, 1, 9)], (0.5, 0.125, 0), 0.625),
        ([("green", 0.25, 1, 9), ("red", 0.5, 1, 5)], (0.5, 0.125, 0), 0.625),
        # Equal places: the first of the list is seen first.
        ([("red", 0.5, 1, 5), ("green", 0.5, 1, 5)], (0.5, 0.25, 0), 0.75),
        # One in another; the back of neither is seen.
        ([("red", 0.5, 1, 5), ("green", 1, 0.5, 5), ("blue", 1, 1, 9)], (0.5, 0.5, 0), 1),
        # Around the camera: it is not seen.
        ([("red", 0.5, 2, 0), ("green", 0.5, 1, 5)], (0, 0.5, 0), 0.5),
        # As if it were not there.
        ([("red", 0, 1, 5), ("green", 0.25, 1, 9)], (0, 0.25, 0), 0.25),
        # 2^-10 is enough to go on, less is not.
        ([("red", 0.5, 1, 5)] * 10 + [("green", 1, 1, 9)], (1023 / 1024, 1 / 1024, 0), 1),
        ([("red", 0.5, 1, 5)] * 11 + [("green", 1, 1, 9)], (2047 / 2048, 0, 0), 2047 / 2048),
    ],
)
def test_what_is_seen_in_a_row(balls: Any, color: Any, alpha: float) -> None:
    trace = reference.trace(in_a_row(*balls), 3, 3)
    assert trace.image[1, 1] == pytest.approx(color, abs=1e-12)
    assert trace.alpha[1, 1] == pytest.approx(alpha, abs=1e-12)
    first = next(i for i, (_, part, radius, away) in enumerate(balls) if part and away > radius)
    if sorted(balls, key=lambda ball: ball[3]) == balls:
        assert trace.id[1, 1] == first
        assert trace.depth[1, 1] == pytest.approx(balls[first][3] - balls[first][2])


def test_straight_on_is_no_segment() -> None:
    balls = [("red", 0.5, 1, 5.0 + 3 * i) for i in range(5)]
    one, many = (reference.trace(in_a_row(*balls, max_depth=d), 3, 3).image for d in (1, 9))
    assert (one == many).all()
    assert one[1, 1, 0] == 1 - 2.0**-5


def test_a_background_shows_through() -> None:
    film = clrt.Film(background=(0, 0, 1))
    trace = reference.trace(in_a_row(("red", 0.25, 1, 5), film=film), 3, 3)
    assert trace.image[1, 1] == pytest.approx((0.25, 0, 0.75))


def test_a_shadow_is_a_product() -> None:
    """Under balls, on a plane."""
    plane = clrt.Sphere((0, -1e6, 0), 1e6, "m")
    camera = clrt.Camera((0, 1, 2), (0, 0, 0), fov=3)
    lit = clrt.Scene(camera, [clrt.Light((0, 50, 0))], {"m": MATTE}, [plane])
    full = reference.trace(lit, 5, 5).image
    for n in range(4):
        balls = [clrt.Sphere((0, 3 + i, 0), 1, "m", opacity=0.3) for i in range(n)]
        image = reference.trace(replace(lit, spheres=[plane, *balls]), 5, 5).image
        assert image == pytest.approx(0.7**n * full)
