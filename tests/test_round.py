"""Round lights in closed form: the functions alone and pictures, against integrals in float64."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from closed_forms import GROUND, Array, between, cap_of, covered, down_on, mean_cosine, on_ground
from conftest import options, run_kernel
from msgspec.structs import replace

import clrt
from clrt.film import metrics
from clrt.renderer.pack.structs import PRECISIONS, Precision

ANGLES = """
// given: an angle; found: its sine, its cosine, and the angle that these have.
__kernel void there_and_back(__global const LANES_OF(FLOATING) *given,
                             __global LANES_OF(FLOATING) *found) {
    int i = get_global_id(0);
    reals sine, cosine;
    sine_cosine(given[i], &sine, &cosine);
    found[3 * i] = sine, found[3 * i + 1] = cosine;
    found[3 * i + 2] = angle_of(absolute(sine), cosine);
}
"""
CAPS = """
// given: two directions, the sine of a cap about the first, angle and versine of one about the
// other. found: the part of the first cap that the second covers.
__kernel void parts(__global const LANES_OF(FLOATING) *given, __global LANES_OF(FLOATING) *found) {
    int i = get_global_id(0);
    given += 9 * i;
    Cap cap = cap_of(vector(given[0], given[1], given[2]), 1, given[6]);
    found[i] = part_covered(cap, vector(given[3], given[4], given[5]), given[7], given[8]);
}

// given: the sine of a cap, and the cosine of the angle between its middle and the normal.
__kernel void cosines(__global const LANES_OF(FLOATING) *given,
                      __global LANES_OF(FLOATING) *found) {
    int i = get_global_id(0);
    found[i] = mean_cosine(cap_of(vector(0, 0, 1), 1, given[2 * i]), given[2 * i + 1]);
}
"""


def run(
    device: cl.Device, code: str, name: str, precision: Precision, given: Array, n: int = 1
) -> tuple[Array, Array]:
    """What a kernel finds, (n, of each column of `given`), and what it was given, rounded."""
    if precision == "double" and device.native_vector_width_double == 0:
        pytest.skip("no float64")
    real: Any = PRECISIONS[precision]
    rounded = given.astype(real)
    blocks = rounded.reshape(len(given), -1, 16).transpose(1, 0, 2)
    found = np.empty((len(blocks), n, 16), real)
    flags = options(16, precision, round=True)
    run_kernel(device, code, name, flags, len(blocks), (blocks,), found)
    return found.transpose(1, 0, 2).reshape(n, -1).astype(np.float64), rounded.astype(np.float64)


def within(found: Array, low: float, high: float) -> bool:
    """Whether all of it is, and a number."""
    return bool(((found >= low) & (found <= high)).all())


def spans(found: Array, low: float, high: float) -> bool:
    """Whether it is not all alike, as where a test shows nothing."""
    return bool(found.min() <= low and found.max() >= high)


@pytest.mark.parametrize(("precision", "bound"), [("robust", 2e-7), ("double", 5e-16)])
def test_angles(device: cl.Device, precision: Precision, bound: float) -> None:
    given = np.linspace(-np.pi / 2, np.pi / 2, 1 << 16)[np.newaxis]
    (sine, cosine, back), (angle,) = run(device, ANGLES, "there_and_back", precision, given, 3)
    assert abs(sine - np.sin(angle)).max() <= bound
    assert abs(cosine - np.cos(angle)).max() <= bound
    assert abs(back - abs(angle)).max() <= bound


@dataclass(frozen=True)
class Caps:
    """Pairs of caps at random."""

    half_angle: tuple[float, float]  # of the first, degrees: from, to
    times: tuple[float, float]  # as wide is the other one, up to 90 degrees
    place: tuple[float, float]  # -1: the inner touches from inside; 1: they touch from outside
    error: float
    double: float = 1e-14


CAPS_AT_RANDOM = {
    "crossing": Caps((0.5, 60), (0.1, 10), (-0.999, 0.999), 3e-6),
    "apart": Caps((0.5, 60), (0.1, 10), (1.001, 1.5), 0, 0),
    "one in the other": Caps((0.5, 60), (0.1, 10), (-2, -1.001), 5e-7),
    "touching from inside": Caps((0.5, 60), (0.1, 10), (-1, -1), 5e-7),
    "the sun's": Caps((0.27, 0.27), (0.1, 10), (-1.5, 1.5), 4e-6),
    # 1 - cosine of what is wide has no more digits than 1 has.
    "the sun's before what is wide": Caps((0.27, 0.27), (10, 300), (-1, 1), 1e-4, 4e-13),
    "half the sky": Caps((60, 89), (0.01, 1), (-1.5, 1.5), 5e-7),
}


@pytest.mark.parametrize("precision", ["robust", "double"])
@pytest.mark.parametrize("kind", CAPS_AT_RANDOM)
def test_what_one_cap_covers_of_another(device: cl.Device, precision: Precision, kind: str) -> None:
    random, n = np.random.default_rng(5), 1 << 11
    caps = CAPS_AT_RANDOM[kind]
    low, high = np.log10(caps.half_angle).tolist()
    a = np.radians(10 ** random.uniform(low, high, n))
    low, high = np.log10(caps.times).tolist()
    b = np.minimum(a * 10 ** random.uniform(low, high, n), np.pi / 2)
    place = random.uniform(*caps.place, n)
    inner = abs(a - b)
    g = np.where(place < -1, inner * (2 + place), inner + np.minimum(a, b) * (place + 1))
    to, aside = random.normal(size=(2, 3, n))
    to /= np.linalg.norm(to, axis=0)
    aside -= (aside * to).sum(axis=0) * to
    other = np.cos(g) * to + np.sin(g) * aside / np.linalg.norm(aside, axis=0)
    numbers = np.stack([np.sin(a), b, 2 * np.sin(b / 2) ** 2])
    given = np.concatenate([to, other, numbers])
    (found,), given = run(device, CAPS, "parts", precision, given)
    g = between(given[3:6].T, given[:3].T)
    truth = covered(np.arcsin(given[6]), given[7], g)
    assert abs(found - truth).max() <= (caps.double if precision == "double" else caps.error)
    assert within(found, 0, 1)
    assert truth.max() > 0.98 or kind == "apart"


@pytest.mark.parametrize("precision", ["robust", "double"])
@pytest.mark.parametrize(("half_angle", "error"), [(0.27, 4e-5), (5, 2e-6), (80, 3e-7)])
def test_mean_cosine(device: cl.Device, precision, half_angle: float, error: float) -> None:
    """Of lights that are above the horizon, below and across it."""
    random = np.random.default_rng(6)
    a = np.full(1 << 12, np.radians(half_angle))
    g = np.clip(np.pi / 2 + a * random.uniform(-1.5, 1.5, a.size), 0, np.pi)
    given = np.stack([np.sin(a), np.cos(g)])
    (found,), (sine, cosine) = run(device, CAPS, "cosines", precision, given)
    truth = mean_cosine(np.arcsin(sine), np.arccos(cosine))
    assert abs(found - truth).max() <= (5e-14 if precision == "double" else error)
    assert spans(truth / np.sin(a[0]), 0, 0.5)


SIZE = (60, 12)
MATERIALS = {
    # Red shows how much of a light is seen, green that times the cosine.
    "ground": clrt.Material(ambient=(1, 0, 0), diffuse=(0, 1, 0)),
    "ball": clrt.Material(),
    "pane": clrt.Material(transmission=0.6),
    "smoke": clrt.Material(transmission=0.1),
    "mirror": clrt.Material(ambient=(1, 0, 0), diffuse=(0, 0, 0), reflection=0.5),
}
LAMP = clrt.Light((-4, 8, 0), radius=1.0)
NARROW = np.sin(np.radians(0.27))
FAR = (-4e12, 8e12, 0.0)
SUN = clrt.Light(FAR, radius=np.hypot(4e12, 8e12) * NARROW)
BALL = clrt.Sphere((-1, 4, 0), 0.7, "ball")
BEADS = tuple(clrt.Sphere((x, 3, z), 0.08, "ball") for x in (-0.4, -0.8, -1.2) for z in (-0.3, 0.3))
SHADOW = down_on(2.1, 0, 0.9)
"""What is under the balls is hidden from above; their shadows lie beside that."""


def scene(light, *spheres: clrt.Sphere, camera=SHADOW, **others: Any) -> clrt.Scene:
    lights = light if isinstance(light, tuple) else (light,)
    return clrt.Scene(camera, lights, MATERIALS, (*spheres, GROUND), **others)


def parts_hidden(light: clrt.Light, *balls: clrt.Sphere) -> list[Array]:
    """The part of a light that each ball hides, of every pixel; no two hide the same."""
    points = on_ground(SHADOW, SIZE)
    to, a, _ = cap_of(points, light.position, light.radius)
    caps = [cap_of(points, ball.center, ball.radius) for ball in balls]
    for i, (first, b, _) in enumerate(caps):
        for other, c, _ in caps[:i]:
            assert (between(first, other) > b + c).all()
    return [covered(a, b, between(to, other)) for other, b, _ in caps]


LIT = {
    "a ball": (LAMP, (BALL,), 1e-5),
    "beads": (replace(LAMP, radius=2.0), BEADS, 1e-5),
    "the sun": (SUN, (BALL,), 1e-4),
    "a lamp larger than the ball": (replace(LAMP, radius=3.0), (replace(BALL, radius=0.3),), 1e-5),
    "beyond the lamp": (LAMP, (clrt.Sphere((-8, 14, 0), 2, "ball"),), 1e-9),
    "around the lamp": (LAMP, (clrt.Sphere((-4, 8, 0), 1.5, "ball"),), 1e-9),
}


# The ball around a lamp needs programs of its own.
WAYS: list[tuple[bool, int, Precision]] = [
    (False, 16, "robust"),
    (True, 16, "robust"),
    (False, 1, "robust"),
    (True, 16, "double"),
    (True, 4, "robust"),
    (False, 16, "double"),
]


@pytest.mark.parametrize(
    ("name", "tree", "lanes", "precision"),
    [
        pytest.param(
            name, *way, id=f"{name}-{'tree' if way[0] else 'list'}-{way[1]}-{way[2]}",
            marks=[pytest.mark.slow] * (i > (1 if "around" in name else 2)),
        )
        for name in LIT
        for i, way in enumerate(WAYS[: 3 if "around" in name else None])
    ],
)  # fmt: skip
def test_penumbra(render, name: str, tree: bool, lanes: int, precision: Precision) -> None:
    light, balls, error = LIT[name]
    hidden = sum(parts_hidden(light, *balls))
    if name == "beyond the lamp":
        hidden = np.zeros_like(hidden)
    visible = np.maximum(1 - hidden, 0)
    image = render(scene(light, *balls), SIZE, tree, lanes, precision)
    bound = 1e-7 if precision == "double" else error  # that of the film, and of a ground so large
    assert abs(image[..., 0] - visible).max() <= bound
    cosine = mean_cosine(*cap_of(on_ground(SHADOW, SIZE), light.position, light.radius)[1:])
    assert abs(image[..., 1] - visible * cosine).max() <= bound + 1e-6


def test_a_lamp_on_the_horizon(render) -> None:
    """It sinks into the ground: part of it is seen, and the cosine is the mean over that."""
    light = clrt.Light((4, 0.4, 0), radius=1.0)
    _, a, g = cap_of(on_ground(SHADOW, SIZE), light.position, light.radius)
    for tree in (False, True):
        image = render(scene(light), SIZE, tree)
        assert abs(image[..., 0] - (1 - covered(a, np.pi / 2, np.pi - g))).max() <= 1e-5
        assert abs(image[..., 1] - mean_cosine(a, g)).max() <= 1e-5
        assert 0 < image.min(axis=(0, 1))[0] < 0.9


def test_glass_before_a_round_light(render) -> None:
    """It covers a part p, and takes 1 - T of that: not of the ambient term."""
    panes = [replace(BALL, material="pane"), clrt.Sphere((-0.8, 2, 0.2), 0.6, "smoke")]
    light = replace(LAMP, radius=2.0)
    left = np.ones(SIZE[::-1])
    for pane in panes:
        (part,) = parts_hidden(light, pane)
        left *= 1 - part * (1 - MATERIALS[pane.material].transmission)
    cosine = mean_cosine(*cap_of(on_ground(SHADOW, SIZE), light.position, light.radius)[1:])
    for tree in (False, True):
        image = render(scene(light, *panes), SIZE, tree)
        assert (image[..., 0] == 1).all()
        assert abs(image[..., 1] - left * cosine).max() <= 1e-5
    assert spans(left, 0.1, 0.85)


def test_a_spot_with_a_radius(render) -> None:
    light = clrt.SpotLight(LAMP.position, (1.5, 0, 0), outer_angle=12, inner_angle=4, radius=1.0)
    points = on_ground(SHADOW, SIZE)
    to, a, _ = cap_of(points, light.position, light.radius)
    axis = np.subtract(light.look_at, light.position)
    cosine = -(to @ (axis / np.linalg.norm(axis)))
    inner, outer = np.cos(np.radians([4, 12]))
    t = np.clip((cosine - outer) / (inner - outer), 0, 1)
    other, b, _ = cap_of(points, BALL.center, BALL.radius)
    expected = t * t * (3 - 2 * t) * (1 - covered(a, b, between(to, other)))
    image = render(scene(light, BALL), SIZE)
    assert abs(image[..., 0] - expected).max() <= 1e-5
    assert spans(image[..., 0], 0, 0.2)


def test_a_disc_in_the_sky_is_a_ball_far_away(render) -> None:
    disc = clrt.DirectionalLight((1, -2, 0), half_angle=0.27)
    for precision, bound in (("robust", 1e-5), ("double", 1e-7)):
        image = render(scene(disc, BALL), SIZE, precision=precision)
        assert abs(image - render(scene(SUN, BALL), SIZE, precision=precision)).max() <= bound
        assert ((image[..., 0] > 0) & (image[..., 0] < 1)).sum() >= 20


def test_a_small_lamp_is_a_point(render) -> None:
    point = replace(LAMP, radius=0.0)
    expected = render(scene(point, BALL, camera=down_on(2.1, 0, 0.9)), SIZE)
    for light in (replace(LAMP, radius=1e-9), replace(LAMP, radius=1e-30)):
        assert abs(render(scene(light, BALL), SIZE) - expected).max() <= 1e-6
    # Beside another that is not.
    other = clrt.Light((3, 6, 2), radius=1.5)
    both = render(scene((other, point), BALL), SIZE)
    assert abs(both - render(scene(other, BALL), SIZE) - expected).max() <= 1e-6
    assert (expected == 0).any()


@pytest.mark.parametrize(
    "light",
    [
        clrt.Light((1.5, 0.3, 0), radius=0.5),
        clrt.Light((1.5, 0, 0), radius=0.5),
        clrt.Light((1e12, 1e12, 0), radius=1e9),
        clrt.Light((1e150, 1e150, 0), radius=1e300),
        clrt.DirectionalLight((0, -1, 0), half_angle=89.999),
        clrt.DirectionalLight((1, 0, 0), half_angle=1e-30),
    ],
    ids=str,
)
def test_it_is_finite(render, light) -> None:
    for tree in (False, True):
        image = render(scene(light, BALL), SIZE, tree)
        assert within(image, 0, 1)


def test_samples_do_not_change_it(render) -> None:
    """But at the edge of the umbra, where paths end, and at the picture's border, where one may lie
    outside."""
    image = render(scene(LAMP, BALL), SIZE)
    sampled = render(scene(LAMP, BALL, samples=64), SIZE)
    same = (sampled == image).all(axis=2) | metrics.edges(image[..., 0] == 0)
    soft = (image[..., 0] > 0) & (image[..., 0] < 1)
    assert same[1:-1, 1:-1].all()
    assert (same & soft).mean() > 0.3


def test_mirrored_light_fades_with_what_is_seen_of_the_lights(render) -> None:
    """A path goes on by the part that some light reaches, so that mirrors have soft shadows too."""
    other = clrt.Light((-5, 8, 0), radius=1.5)
    missed = parts_hidden(LAMP, BALL)[0] * parts_hidden(other, BALL)[0]
    floor = replace(GROUND, material="mirror")
    sky = clrt.Film(background=(0, 0, 1))
    seen = clrt.Scene(SHADOW, (LAMP, other), MATERIALS, (BALL, floor), film=sky)
    for tree in (False, True):
        image = render(seen, SIZE, tree)
        assert abs(image[..., 2] - 0.5 * (1 - missed)).max() <= 1e-5
    assert spans(missed, 0.01, 0.5)
