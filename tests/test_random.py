"""What is drawn at random, against closed forms: its mean, and how fast the error falls."""

import math
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from closed_forms import (
    FLAT,
    Array,
    between,
    cap_of,
    covered,
    down_on,
    hidden_sky,
    lens_beyond,
    on_ground,
    slope,
)
from hard_cases import BASE, made_of
from msgspec.structs import replace

import clrt
from clrt import reference
from clrt.film import metrics

COUNTS = (4, 16, 64, 256, 1024)
SIZE = (64, 32)
GRAY = (0.5, 0.5, 0.5)
MATERIALS = {
    # Shows what of the light of a sky, or of a lamp, reaches it.
    "open": clrt.Material(ambient=(1, 1, 1), diffuse=(0, 0, 0)),
    # Shows what other surfaces send it.
    "lit": clrt.Material(diffuse=(0.8, 0.6, 0.4)),
    "black": clrt.Material(diffuse=(0, 0, 0)),
    "rough": clrt.Material(diffuse=(0, 0, 0), reflection=0.5, roughness=0.5),
    "furnace": clrt.Material(ambient=GRAY, diffuse=(0, 0, 0), reflection=0.5, roughness=0.7),
}
SKY = clrt.AmbientLight(occlusion=True)
LAMP = clrt.Light((-4, 8, 0), radius=1.0)
SUN = clrt.DirectionalLight((1, -2, 0), half_angle=5.0)
SUN_ABOVE = clrt.DirectionalLight((0, -1, 0))
BLACK_LAMP = clrt.Light((0, 9, 0), (0, 0, 0), (0, 0, 0), (0, 0, 0), radius=1.0)
NEAR = clrt.Camera((1.8, 1, 0), (1.8, 0, 0), (0, 0, -1), 80, aperture_radius=1e-9, focus_distance=1)
"""Of the ground, from below what throws shadows on it. All rays of a lens need not be: with it
lights are sampled."""
AROUND = clrt.Camera((0, 2, 6), (0, 0, 0), projection="orthographic", height=4)
"""Of a ball of radius 1. The kind is that of most cases: one program serves all."""
EVEN = clrt.AmbientLight()
NOTHING = clrt.AmbientLight((0, 0, 0))
WHITE = (1.0, 1.0, 1.0)
BLUE_SKY = clrt.Film(background=(0, 0, 0.5))
Ball = tuple[tuple[float, float, float], float, str]


def made(
    camera: clrt.Camera, *balls: Ball, lights: Any = (EVEN,), color: Any = None, **others: Any
) -> clrt.Scene:
    centers, radii, names = zip(*balls, strict=True)
    materials = {name: MATERIALS[name] for name in sorted(set(names))}
    spheres = clrt.Spheres(np.array(centers), np.array(radii), names, color)
    return clrt.Scene(camera, lights, materials, spheres, **others)


def glowing(camera: clrt.Camera, *balls: Ball, **others: Any) -> clrt.Scene:
    """Of surfaces that light each other; one program serves all."""
    common = {"color": np.ones((len(balls), 3)), "film": BLUE_SKY, "indirect": True}
    return replace(made(camera, *balls, **{**common, **others}), materials=MATERIALS)


def ground(material: str) -> Ball:
    return (0, -FLAT, 0), FLAT, material


@dataclass(frozen=True)
class Case:
    scene: clrt.Scene
    truth: Array
    """Of red, (rows, columns) or what is alike in all rows, (columns,)."""
    error: float  # rms of 1024 samples, at most
    size: tuple[int, int] = SIZE


def beside_a_ball() -> Case:
    """A sky, of a point on the ground, near a ball that rests on it."""
    ball: Ball = (0.5, 0.5, 0), 0.5, "open"
    camera = down_on(1.6, 0, 0.5)
    _, b, g = cap_of(on_ground(camera, SIZE), *ball[:2])
    scene = made(camera, ball, ground("open"), lights=[SKY])
    return Case(scene, 1 - hidden_sky(b, g), 8e-4)


def on_a_ball() -> Case:
    """The ground is half of all directions, whatever the way up is: (1 + cosine) / 2 is left."""
    camera = down_on(0.8, 0, 0.1)
    points = on_ground(camera, SIZE)
    cosine = np.sqrt(1 - points[..., 0] ** 2 - points[..., 2] ** 2)
    scene = made(camera, ((0, 1, 0), 1, "open"), ground("open"), lights=[SKY])
    return Case(scene, (1 + cosine) / 2, 1.1e-3)


def within(distance: float) -> Case:
    """What is farther than `distance` does not hide a sky: of a ball what is nearer is a cap."""
    center, radius = np.array([1.5, 1.5, 0]), 0.7
    camera = down_on(0, 0, 0.3)
    points = on_ground(camera, SIZE)
    away2 = ((points - center) ** 2).sum(axis=-1)
    _, b, g = cap_of(points, (1.5, 1.5, 0), radius)
    cosine = (distance**2 + away2 - radius**2) / (2 * distance * np.sqrt(away2))
    cap = np.where(distance**2 < away2 - radius**2, np.arccos(np.minimum(cosine, 1)), b)
    balls: tuple[Ball, ...] = ((1.5, 1.5, 0), radius, "open"), ground("open")
    scene = made(camera, *balls, lights=[replace(SKY, distance=distance)])
    return Case(scene, 1 - hidden_sky(cap, g), 9e-4)


def behind_a_ball(light: Any) -> Case:
    """What of a light is seen."""
    center, radius = (-1, 4, 0), 0.7
    points = on_ground(NEAR, SIZE)
    place, size = (LAMP.position, LAMP.radius) if light is LAMP else FAR_SUN
    to, a, _ = cap_of(points, place, size)
    other, b, _ = cap_of(points, center, radius)
    scene = made(NEAR, (center, radius, "open"), ground("open"), lights=[light, NOTHING])
    return Case(scene, 1 - covered(a, b, between(to, other)), 2.5e-3)


FAR_SUN = ((-1e12, 2e12, 0), math.hypot(1e12, 2e12) * math.sin(math.radians(5)))


def out_of_focus(distance: float, focus: float, aperture: float, radius: float, fov: float) -> Case:
    """The edge of a large ball, straight ahead, as a lens blurs it."""
    camera = clrt.Camera(
        (0, 0, 0), (0, 0, -1), fov=fov, aperture_radius=aperture, focus_distance=focus
    )
    ball: Ball = (-radius, 0, -distance), radius, "open"
    scene = made(camera, ball, lights=[EVEN, BLACK_LAMP])
    x = np.linspace(-1, 1, 512) * np.tan(np.radians(fov) / 2)
    blur = aperture * abs(distance - focus) / (distance * focus)
    return Case(scene, lens_beyond(x / blur), 2e-3, (512, 12))


def rough_mirror() -> Case:
    """A floor below a shining ball: the share of the cone that it fills, of half the light."""
    center, radius = (1.5, 2.5, 0), 0.9
    camera = down_on(0, 0, 0.2)
    _, b, g = cap_of(on_ground(camera, SIZE), center, radius)
    scene = glowing(camera, (center, radius, "open"), ground("rough"))
    return Case(scene, 0.5 * covered(np.arcsin(0.5), b, g), 1.3e-3)


def lit_by_a_ball() -> Case:
    ball: Ball = (0.5, 0.5, 0), 0.5, "open"
    camera = down_on(1.6, 0, 0.5)
    _, b, g = cap_of(on_ground(camera, SIZE), *ball[:2])
    scene = glowing(camera, ball, ground("lit"))
    return Case(scene, 0.8 * hidden_sky(b, g), 1.8e-3)


CASES: dict[str, Callable[[], Case]] = {
    "a sky beside a ball": beside_a_ball,
    "a sky on a ball": on_a_ball,
    "a sky near the near side": lambda: within(1.6),
    "a sky near the far side": lambda: within(1.95),
    "a sky far from the ball": lambda: within(3.0),
    "a lamp behind a ball": lambda: behind_a_ball(LAMP),
    "the sun behind a ball": lambda: behind_a_ball(SUN),
    "an edge before the focus": lambda: out_of_focus(1, 1000, 0.02, 0.6, 15),
    "an edge far away": lambda: out_of_focus(100, 200, 0.08, 60, 0.1),
    "an edge behind the focus": lambda: out_of_focus(100, 50, 0.02, 60, 0.1),
    "a rough mirror": rough_mirror,
    "a surface lit by a ball": lit_by_a_ball,
}


@pytest.mark.parametrize("tree", [False, True], ids=["list", "tree"])
@pytest.mark.parametrize("name", CASES)
def test_closed_forms(render, name: str, tree: bool) -> None:
    """The error falls with the samples as n^-0.75, the mean of it is 0."""
    case = CASES[name]()
    rms = []
    for n in COUNTS:
        image = render(replace(case.scene, samples=n), case.size, tree, alpha=True)
        error = image[..., 0] - case.truth
        rms.append(np.sqrt((error**2).mean()))
        # Lanes of a packet may share what they draw.
        assert abs(error.mean()) <= 4 * rms[-1] / np.sqrt(error.size / 16)
    # Of a mirror the first four samples err more than their part, so its slope is -0.84.
    assert -0.85 <= slope(COUNTS, rms) <= -0.68
    assert rms[-1] <= case.error


@pytest.mark.parametrize(
    ("tree", "lanes"),
    [(False, 16), (True, 16), (False, 1), pytest.param(True, 4, marks=pytest.mark.slow)],
)
def test_an_open_sky_is_open(render, tree: bool, lanes: int) -> None:
    """To the bit: a plane, and a ball alone, hide nothing of the half of it above each point. In
    float32 41 times 1 / 41 is not 1."""
    for camera, *balls in ((down_on(0, 0, 1), ground("open")), (AROUND, ((0, 0, 0), 1, "open"))):
        scene = made(camera, *balls, lights=[SKY], samples=41)
        image = render(scene, (37, 21), tree, lanes, alpha=True)
        assert image[..., 3].any()
        assert (image[..., :3] == image[..., 3:]).all()


def test_a_rough_mirror_in_a_uniform_surround(render) -> None:
    """Half of it is its own light, half that around it. No ray goes into it, where it is black."""
    white = clrt.Film(background=(1, 1, 1))
    scene = glowing(
        AROUND, ((0, 0, 0), 1, "furnace"), ((0, 0, 0), 0.9, "black"), film=white, samples=16
    )
    for tree in (False, True):
        assert (render(scene, (37, 21), tree) == 1).all()


def test_lights_are_exact_outside_of_the_penumbra(render) -> None:
    for light in (LAMP, SUN):
        case = behind_a_ball(light)
        scene = replace(case.scene, samples=20)
        for tree in (False, True):
            image = render(scene, case.size, tree, alpha=True)[..., 0]
            for part in (0, 1):
                # A pixel's samples, and points of the edge.
                sure = ~metrics.edges(abs(case.truth - part) > 1e-9)
                assert (image[sure & (abs(case.truth - part) < 1e-9)] == part).all()
    assert (case.truth > 1 - 1e-9).any()
    assert (abs(case.truth) < 1e-9).any()
    # What is beyond a lamp is not in its way.
    beyond: Ball = (-8, 14, 0), 2, "open"
    scene = made(NEAR, beyond, ground("open"), lights=[LAMP, NOTHING], samples=20)
    for tree in (False, True):
        assert (render(scene, SIZE, tree, alpha=True)[..., 0] == 1).all()


def test_glass_hides_a_sky(render) -> None:
    case = beside_a_ball()
    materials = {**case.scene.materials, "open": replace(MATERIALS["open"], transmission=1.0)}
    materials["ground"] = MATERIALS["open"]
    given = clrt.Spheres.of(case.scene.spheres)
    spheres = clrt.Spheres(given.center, given.radius, ["open", "ground"])
    scene = replace(case.scene, materials=materials, spheres=spheres, max_depth=1, samples=1024)
    for tree in (False, True):
        error = render(scene, case.size, tree)[..., 0] - case.truth
        assert np.sqrt((error**2).mean()) <= case.error


def test_indirect_light_has_the_colors_of_both_surfaces(render) -> None:
    case = lit_by_a_ball()
    colors = ((0.9, 0.5, 0.2), (1, 0.8, 0.6))
    white = clrt.Spheres.of(case.scene.spheres)
    spheres = clrt.Spheres(white.center, white.radius, white.material_index, colors)
    scene = replace(case.scene, spheres=spheres.with_names(white.names or ()))
    weight = np.prod(colors, axis=0) * MATERIALS["lit"].diffuse
    for tree in (False, True):
        plain = render(replace(case.scene, samples=16), case.size, tree)
        image = render(replace(scene, samples=16), case.size, tree)
        assert image.any()
        assert abs(image - plain[..., :1] / 0.8 * weight).max() <= 1e-6


def test_what_scattered_rays_do_not_see(render) -> None:
    """Highlights, the background, and anything beyond max_depth."""
    case = lit_by_a_ball()
    scene = replace(case.scene, lights=[EVEN, SUN_ABOVE], samples=16)
    for tree in (False, True):
        image = render(scene, case.size, tree)
        shiny = replace(MATERIALS["open"], specular=WHITE, shininess=1.0)
        shining = replace(scene, materials={**MATERIALS, "open": shiny})
        assert (render(shining, case.size, tree) == image).all()
        white = replace(scene, film=clrt.Film(background=WHITE))
        assert (render(white, case.size, tree) == image).all()
    straight = render(replace(scene, max_depth=1, samples=1), case.size)
    assert abs(straight - MATERIALS["lit"].diffuse).max() <= 1e-6
    assert image.mean() > straight.mean() + 0.05


def test_no_aperture_is_a_pinhole(render) -> None:
    camera = replace(BASE.camera, focus_distance=3.0)
    assert (render(replace(BASE, camera=camera), SIZE) == render(BASE, SIZE)).all()


def test_next_to_none_is_none(render) -> None:
    """An aperture, a roughness and the radius of a lamp of 1e-9, at the pixels' point."""
    camera = replace(BASE.camera, aperture_radius=1e-9, focus_distance=2.0)
    rough = made_of(roughness=1e-9)
    lights = [replace(light, radius=1e-9) for light in BASE.lights]
    scene = replace(rough, camera=camera, lights=lights)
    paths = reference.trace(BASE, *SIZE).paths
    for tree in (False, True):
        error = abs(render(scene, SIZE, tree) - render(BASE, SIZE, tree)).max(axis=2)
        assert error[~metrics.edges(paths)].max() <= 1e-4
        assert np.median(error) <= 1e-6


@pytest.mark.parametrize(("fov", "distance", "aperture"), [(15, 3.0, 0.05), (1, 100.0, 0.8)])
def test_what_is_in_focus_is_sharp(render, fov: float, distance: float, aperture: float) -> None:
    case = out_of_focus(distance, distance + 1e-9, aperture, distance / 10, fov)
    for tree in (False, True):
        image = render(replace(case.scene, samples=64), (129, 3), tree, alpha=True)[..., 0]
        assert (image[:, :64] == 1).all()
        assert (image[:, 65:] == 0).all()


@pytest.mark.parametrize("fov", [1, 15])
def test_a_ball_beside_the_view_is_before_the_lens(render, fov: float) -> None:
    """The pinhole does not see it. The lens has it in the way from where it is, a tenth nearer the
    middle, as a shadow that is a tenth larger than it."""
    camera = clrt.Camera((0, 0, 0), (0, 0, -1), fov=fov, aperture_radius=0.8, focus_distance=200)
    balls: tuple[Ball, ...] = ((0.4, 0, -20), 0.2, "black"), ((0, 0, -400), 200, "open")
    scene = made(camera, *balls, lights=[EVEN, BLACK_LAMP], samples=8192)
    for tree in (False, True):
        image = render(scene, (33, 3), tree, alpha=True)[:, 16, 0]
        assert abs(image.mean() - (1 - (0.2 / 0.9 / 0.8) ** 2)) <= 3e-3


EVERYTHING = replace(
    made_of(roughness=0.2),
    camera=replace(BASE.camera, aperture_radius=0.02, focus_distance=2.0),
    lights=[replace(light, radius=1.0) for light in BASE.lights] + [replace(SKY, ambient=GRAY)],
    film=BLUE_SKY,
    indirect=True,
    samples=5,
)
ODD = (53, 31)


@pytest.mark.parametrize("tree", [False, True], ids=["list", "tree"])
def test_bits(device: cl.Device, render, monkeypatch: pytest.MonkeyPatch, tree: bool) -> None:
    """Those of the same picture once more, of a part of it, of bands, and of pieces of these."""
    whole = render(EVERYTHING, ODD, tree)
    assert np.isfinite(whole).all()
    assert (render(EVERYTHING, ODD, tree) == whole).all()
    for x0, y0, x1, y1 in ((0, 0, 1, 1), (7, 3, 50, 30), (17, 13, 18, 31), (51, 29, 53, 31)):
        part = render(EVERYTHING, ODD, tree, region=(x0, y0, x1, y1))
        assert (part == whole[y0:y1, x0:x1]).all()
    monkeypatch.setattr("clrt.opencl.bands.BAND_SECONDS", 0.0)
    monkeypatch.setattr("clrt.opencl.bands.FIRST_BAND_TESTS", 1)
    assert (render(EVERYTHING, ODD, tree) == whole).all()
    monkeypatch.setattr("clrt.opencl.bands.ROW_SAMPLES", 1)
    monkeypatch.setattr("clrt.opencl.bands.PIECE_SAMPLES", 1)
    monkeypatch.setattr("clrt.opencl.bands.UNIT_ROWS", 3)
    rows: list[int] = []
    assert (render(EVERYTHING, ODD, tree, progress=rows.append) == whole).all()
    assert 0 in rows
    assert sum(rows) == 31
    # In another process, by one thread.
    code = (
        "import sys; import numpy as np; import test_random as this\n"
        "from clrt.renderer.pack import features\n"
        f"features.TREE_FROM = 1 if {tree} else np.inf\n"
        f"with this.clrt.Renderer(device={device.name!r}, lanes=16, threads=1) as renderer:\n"
        "    picture = renderer.render(this.EVERYTHING, *this.ODD)\n"
        "sys.stdout.buffer.write(picture.tobytes())"
    )
    folder = str(Path(__file__).parent)
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=folder, capture_output=True, check=True, timeout=120
    )
    assert (np.frombuffer(done.stdout, np.float32).reshape(whole.shape) == whole).all()


def test_lanes_do_not_show_in_noise(render) -> None:
    """A list's lanes draw as their pixels do; a hit is met or missed by a rounding."""
    scene = replace(beside_a_ball().scene, samples=16)
    error = abs(render(scene, SIZE, alpha=True) - render(scene, SIZE, lanes=1, alpha=True))[..., :3]
    assert (error > 1e-6).mean() <= 1e-3


@pytest.mark.parametrize(
    ("changes", "key"),
    [
        ({"lights": [LAMP]}, r"radius of lights\[0\]"),
        ({"lights": [clrt.Light((1, 2, 3)), SUN]}, r"half_angle of lights\[1\]"),
        ({"lights": [SKY]}, r"occlusion of lights\[0\]"),
        ({"camera": EVERYTHING.camera}, "aperture_radius of camera"),
        ({"materials": EVERYTHING.materials}, "roughness of materials"),
        ({"indirect": True}, "indirect"),
        ({"samples": 2}, "samples > 1"),
    ],
)
def test_literal_refuses(render, changes: dict, key: str) -> None:
    with pytest.raises(clrt.RequestError, match=f"literal knows no {key}"):
        render(replace(BASE, **changes), SIZE, precision="literal")


def test_memory_does_not_grow_with_samples(render) -> None:
    scene = beside_a_ball().scene

    def peak(samples: int) -> int:
        render(replace(scene, samples=samples), (192, 108), alpha=True)
        lines = Path("/proc/self/status").read_text().splitlines()
        return next(int(line.split()[1]) for line in lines if line.startswith("VmHWM"))

    peak(16)
    Path("/proc/self/clear_refs").write_text("5")  # the peak is that of now
    few = peak(16)
    assert peak(1024) - few < 8000  # kB: a float of each sample would be 80,000
