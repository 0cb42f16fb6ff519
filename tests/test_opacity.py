"""Opacity: which scenes can say it, and what rays see on their straight way."""

from pathlib import Path
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from conftest import renderer_for
from msgspec.structs import replace

import clrt
from clrt import reference
from clrt.errors import RequestError, SceneError
from clrt.files.scenewriter import save_scene
from clrt.renderer.pack.features import features_of
from clrt.renderer.pack.world import pack_world

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


SIZE = (48, 32)
EYE = clrt.Camera((0, 0, 3), (0, 0, 0), fov=50)
LIGHTS = (clrt.Light((3, 5, 4)), clrt.Light((-3, 2, 1), diffuse=(0.3, 0.3, 0.6)))
LOOKS = {
    "matte": clrt.Material((0.1, 0.1, 0.1), (0.6, 0.5, 0.4), (0.3, 0.3, 0.3)),
    "veil": clrt.Material((0.1, 0.1, 0.1), (0.6, 0.5, 0.4), (0.3, 0.3, 0.3), opacity=0.5),
    "mirror": clrt.Material((0.1, 0.1, 0.1), (0.4, 0.5, 0.4), (1, 1, 1), 200, 0.6),
    "phong": clrt.Material((0.1, 0, 0), (0.6, 0.1, 0.1), (1, 1, 1), 30, highlight="phong"),
}
RANDOM = np.random.default_rng(31)


def made(center: Any, radius: Any, opacity: Any, look: Any = "matte", **more: Any) -> clrt.Scene:
    """A scene of spheres, each of its own colour."""
    n = len(center)
    colors = np.random.default_rng(n).uniform(0.2, 1, (n, 3))
    spheres = clrt.Spheres(center, radius, look, colors, opacity)
    scene = clrt.Scene(EYE, LIGHTS, LOOKS, spheres, film=clrt.Film(background=(0.1, 0.2, 0.4)))
    return replace(scene, **more)


def heap(n: int, mirrors: float = 0.0, **more: Any) -> clrt.Scene:
    """n spheres that are in each other, many of which can be seen through."""
    center, radius = RANDOM.uniform(-1, 1, (n, 3)), RANDOM.uniform(0.3, 1, n) * n ** (-1 / 3)
    look = np.where(RANDOM.uniform(size=n) < mirrors, "mirror", "matte")
    opacity = np.where(look == "mirror", 1, RANDOM.choice([0, 0.1, 0.4, 0.8, 1], n))
    return made(center, radius, opacity, look, **more)


def with_ground(scene: clrt.Scene, look: str) -> clrt.Scene:
    ground = clrt.Spheres([[0, -5001, 0]], 5000, look)
    return replace(scene, spheres=clrt.Spheres.joined([scene.spheres, ground]))  # type: ignore[list-item]


GRID = np.stack(np.meshgrid(*[np.arange(4) / 4 - 0.375] * 3), axis=-1).reshape(-1, 3)
EDGES = np.where(np.arange(200) % 3 == 0, 1 - 1 / 255, 1 / 255)
TWELVE = {
    "a list": heap(30),
    "a tree": heap(300),
    "in depth": made(
        RANDOM.normal(0, 0.02, (60, 3)) + np.arange(60)[:, np.newaxis] * (0, 0, -0.1), 0.4, 0.05
    ),
    "nested": made(np.zeros((50, 3)), np.linspace(1, 0.02, 50), 0.06),
    "equal centres": made(np.repeat(RANDOM.uniform(-1, 1, (20, 3)), 3, axis=0), 0.3, 0.4),
    "one of 255": made(
        RANDOM.uniform(-1, 1, (200, 3)), RANDOM.uniform(0.05, 0.3, 200), EDGES
    ),
    "mirrors behind": with_ground(heap(40, mirrors=0.5, max_depth=5), "mirror"),
    "mirrors in a tree": with_ground(heap(200, mirrors=0.3, max_depth=4), "mirror"),
    "touching": made(GRID, 0.125, np.tile([0.3, 0.6, 1, 0.1], 16)),
    "orthographic": with_ground(
        heap(100, camera=clrt.Camera((1, 1, 1), (0, 0, 0), projection="orthographic", height=2.2)),
        "veil",
    ),
    "around the eye and the light": made(
        [(0, 0, 3), (3, 5, 4), (0, 0, 0), (0, 0, 0.2), (0, 0, -3)], [1, 1, 0.8, 0.7, 1], 0.5
    ),
    "capsules under all lights": replace(
        heap(
            40,
            lights=(
                clrt.AmbientLight((0.2, 0.2, 0.3)),
                clrt.DirectionalLight((-1, -2, -1)),
                clrt.SpotLight((0, 3, 2), (0, 0, 0), outer_angle=30),
                clrt.Light((2, 2, 2), attenuation=(0.5, 0.1, 0.1)),
            ),
        ),
        capsules=clrt.Capsules(
            RANDOM.uniform(-1, 1, (30, 3)),
            RANDOM.uniform(-1, 1, (30, 3)),
            RANDOM.uniform(0.02, 0.2, 30),
            np.where(np.arange(30) % 3 == 0, "matte", "veil"),
        ),
    ),
    "a long lens": heap(80, camera=clrt.Camera((30, 40, 300), (0, 0, 0), fov=0.6)),
}  # fmt: skip


SLOW = {
    "a long lens",
    "orthographic",
    "around the eye and the light",
    "capsules under all lights",
}  # programs of their own


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name in SLOW)) for name in TWELVE]
)
def test_against_the_truth(device: cl.Device, name: str) -> None:
    scene = TWELVE[name]
    truth = reference.trace(scene, *SIZE)
    renderer = renderer_for(device, 16)
    image = renderer.render(scene, *SIZE)
    flips = renderer.paths(scene, *SIZE) != truth.paths
    assert flips.mean() < 0.01
    assert (abs(image - truth.image).max(axis=2) > 1 / 1020)[~flips].sum() == 0
    alpha = renderer.render(scene, *SIZE, alpha=True)[..., 3]
    assert abs(alpha - truth.alpha)[~flips].max() < 1e-5
    assert ((truth.alpha > 0.01) & (truth.alpha < 0.99)).mean() > 0.02


def test_passes_have_the_first_that_is_there(device: cl.Device) -> None:
    scene = TWELVE["a tree"]
    truth = reference.trace(scene, *SIZE)
    renderer = renderer_for(device, 16)
    _, passes = renderer.render(scene, *SIZE, passes=("id", "depth", "normal"))
    same = passes["id"] == truth.id
    assert same.mean() > 0.998
    there = same & (truth.id >= 0)
    assert (scene.spheres.opacity[truth.id[there]] > 0).all()  # type: ignore[attr-defined]
    assert passes["depth"][there] == pytest.approx(truth.depth[there], rel=1e-5)
    assert abs(passes["normal"] - truth.normal)[there].max() < 1e-4


@pytest.mark.parametrize("name", ["a list", "a tree", "mirrors in a tree"])
def test_the_order_of_the_list_does_not_matter(device: cl.Device, name: str) -> None:
    spheres: Any = TWELVE[name].spheres
    order = np.random.default_rng(1).permutation(len(spheres))
    looks = np.array(spheres.names)[spheres.material_index[order]]
    parts = (spheres.center[order], spheres.radius[order])
    shuffled = clrt.Spheres(*parts, looks, spheres.color[order], spheres.opacity[order])
    renderer = renderer_for(device, 16)
    one, two = (
        renderer.render(replace(TWELVE[name], spheres=some), *SIZE) for some in (spheres, shuffled)
    )
    assert abs(one - two).max() < 1e-6


def test_a_thousand_in_depth_are_their_sum(device: cl.Device) -> None:
    """On one ray, of light from all sides: sum of a (1 - a)^i c of the i-th."""
    n, a = 1000, 1 / 255
    center = np.array([(0, 0, -1 - 0.01 * i) for i in range(n)])
    order = np.random.default_rng(2).permutation(n)
    scene = made(center[order], 0.5, a, lights=(SKY,), film=clrt.Film())
    colors = np.empty((n, 3))
    colors[order] = scene.spheres.color  # type: ignore[attr-defined]
    left = (1 - a) ** np.arange(n)[:, np.newaxis]
    image = renderer_for(device, 16).render(scene, 3, 3, alpha=True)[1, 1]
    assert image[:3] == pytest.approx((0.1 * a * left * colors).sum(axis=0), abs=1e-5)
    assert image[3] == pytest.approx(1 - (1 - a) ** n, abs=1e-5)


def test_what_is_opaque_has_the_program_of_before(device: cl.Device) -> None:
    """And its bits: of materials and of spheres."""
    spheres: Any = TWELVE["a tree"].spheres
    plain = clrt.Spheres(spheres.center, spheres.radius, "matte")
    said = clrt.Spheres(spheres.center, spheres.radius, "matte", opacity=1)
    scenes = [replace(TWELVE["a tree"], spheres=some) for some in (plain, said)]
    used = [features_of(pack_world(one, "robust"), one, 16, "float") for one in scenes]
    assert used[0] == used[1]
    assert not used[0].opacity
    one, two = (renderer_for(device, 16).render(scene, *SIZE) for scene in scenes)
    assert (one == two).all()


@pytest.mark.parametrize("many", [False, True])
@pytest.mark.parametrize(
    "light",
    [clrt.Light((0, 9, 0), radius=2.0), clrt.AmbientLight(occlusion=True)],
    ids=["round", "sky"],
)
def test_what_is_hidden_in_part_grows_with_the_opacity(
    device: cl.Device, light: Any, many: bool
) -> None:
    """Of one ball above a floor: as much as the opaque one hides, times its opacity."""
    floor = clrt.Sphere((0, -1e4, 0), 1e4, "floor")
    far = [clrt.Sphere((50 + 3.0 * i, 1, 60), 0.01, "floor") for i in range(60 * many)]
    materials = {"floor": clrt.Material(ambient=(0.5, 0.5, 0.5))}
    if isinstance(light, clrt.Light):
        light = replace(light, ambient=(0, 0, 0))
    samples = 1 if isinstance(light, clrt.Light) else 4  # the round light has a closed form
    camera = clrt.Camera((0, 1, 3), (0, 0, 0), fov=40)

    def seen(opacity: float) -> Any:
        ball = clrt.Sphere((0.3, 3, 0), 1, "floor", opacity=opacity)
        scene = clrt.Scene(camera, [light], materials, [floor, ball, *far], samples=samples)
        return renderer_for(device, 16).render(scene, 32, 16)

    # Nearly nothing, lest the program is the opaque one's and rounds otherwise.
    clear, half, full = seen(1e-9), seen(0.4), seen(1 - 1e-7)
    assert abs(full - clear).max() > 0.05
    assert half == pytest.approx(0.6 * clear + 0.4 * full, abs=3e-6)
