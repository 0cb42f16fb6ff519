"""Glass: how it nests, and pictures that must be equal whatever the truth is."""

import numpy as np
import pyopencl as cl
import pytest
from conftest import options, renderer_for, run_kernel
from hard_cases import BASE, MIDDLE, at, with_glass
from msgspec.structs import replace

import clrt
from clrt import reference
from clrt.errors import RequestError, SceneError, SceneWarning
from clrt.renderer import glass
from clrt.renderer.pack.features import Features, features_of
from clrt.renderer.pack.spheres import pack_spheres
from clrt.renderer.pack.structs import PRECISIONS
from clrt.renderer.pack.world import pack_world
from clrt.truth import glass as true_glass

SIZE = (150, 100)
BALL = at(MIDDLE, 0.5, "glass")


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"transmission": 1.1}, "transmission: expected a number from 0 to 1"),
        (
            {"transmission": 0.8, "reflection": 0.3},
            r"transmission: expected at most 1 - reflection",
        ),
        ({"ior": 0.9}, "ior: expected a number from 1 to 10"),
        ({"ior": 11}, "ior: expected a number from 1 to 10"),
        ({"fresnel": 1}, "fresnel: expected true or false"),
    ],
)
def test_bad_values(values, said: str) -> None:
    with pytest.raises(SceneError, match=said):
        clrt.Material(**values)


def nest_of(scene: clrt.Scene) -> int:
    return features_of(pack_world(scene, "robust"), scene, 16, "float").nest


def test_nest_is_found_from_the_scene() -> None:
    assert nest_of(BASE) == 0
    assert nest_of(with_glass(BALL)) == 1
    assert nest_of(with_glass(BALL, at((0, 2, 0), 0.5, "glass"))) == 1
    assert nest_of(with_glass(BALL, at(MIDDLE, 0.4, "air"))) == 2
    assert nest_of(with_glass(BALL, at((0, 0.9, -0.2), 0.5, "glass"))) == 2  # they touch
    assert nest_of(with_glass(*(at(MIDDLE, 0.5 - 0.05 * i, "glass") for i in range(7)))) == 4


def test_meetings_against_all_pairs() -> None:
    random = np.random.default_rng(3)
    center, radius = random.uniform(0, 1, (300, 3)), random.uniform(0, 0.15, 300)
    away = np.linalg.norm(center[:, np.newaxis] - center, axis=2)
    near = away < (radius[:, np.newaxis] + radius) * (1 + glass.TOUCH)
    assert (glass.meetings(center, radius) == near.sum(axis=1) - 1).all()
    assert near.sum() > 600


def test_literal_and_seed_know_no_glass(device: cl.Device) -> None:
    scene = with_glass(BALL)
    with pytest.raises(RequestError, match="literal knows no transmission"):
        renderer_for(device, 16, "literal").render(scene, *SIZE)
    with pytest.raises(RequestError, match="'seed' knows no transmission of materials"):
        reference.trace(scene, 9, 9, "seed")


def test_a_ray_that_needs_more_room_is_reported(device: cl.Device) -> None:
    """Six balls in each other: of the largest two the far side is not seen."""
    scene = with_glass(*(at(MIDDLE, 0.5 - 0.07 * i, "glass") for i in range(6)), depth=14)
    with pytest.warns(
        SceneWarning, match=r"in \d+ packets of rays some were inside of more than 4"
    ):
        image = renderer_for(device, 16).render(scene, *SIZE)
    assert np.isfinite(image).all()


@pytest.mark.parametrize(
    ("camera", "tree"),
    [
        ("perspective", False),
        ("perspective", True),
        ("orthographic", False),
        pytest.param("orthographic", True, marks=pytest.mark.slow),
    ],
)
def test_what_is_nothing_is_dropped(device: cl.Device, tree: bool, camera: str) -> None:
    """Indices stay: the ball comes first, the others keep their places."""
    nothing = clrt.Material(diffuse=(0, 0, 0), transmission=1.0, ior=1.0)
    places = [(0.1 * i - 1, -0.6, 0.05 * j - 1) for i in range(9) for j in range(9)]
    many = [at(place, 0.04, "green") for place in places]
    base = replace(BASE, spheres=(*BASE.spheres, *many * tree))
    if camera == "orthographic":
        beside = clrt.Camera((0, 0, 1), (0, 0, 0), projection="orthographic", height=1.5)
        base = replace(base, camera=beside)
    # Another glass ball, out of sight, so that both have a program with glass.
    other = at((0.0, 50.0, 0.0), 0.1, "diamond")
    materials = with_glass().materials | {"nothing": nothing}
    gone = at(MIDDLE, 0.5, "nothing")
    ghost = at((9.0, 90.0, 9.0), 0.1, "nothing")
    scenes = [
        replace(base, max_depth=5, materials=materials, spheres=(one, *base.spheres, other))
        for one in (gone, ghost)
    ]
    renderer = renderer_for(device, 16)
    one, two = (renderer.render(scene, *SIZE) for scene in scenes)
    # Not to the bit: what is not there still counts in how the scene is scaled.
    assert abs(one - two).max() < 1e-3
    paths = [renderer.paths(scene, *SIZE) for scene in scenes]
    assert (paths[0] != paths[1]).mean() < 1e-3


def test_a_shadow_of_glass_is_its_transmission_times_the_light(device: cl.Device) -> None:
    """Under a ball, on a plane without ambient light."""
    floor = clrt.Material(diffuse=(1, 1, 1))
    materials = {"floor": floor, "glass": clrt.Material(diffuse=(0, 0, 0), transmission=0.9)}
    plane = clrt.Sphere((0, -1e6, 0), 1e6, "floor")
    camera = clrt.Camera((0, 1, 2), (0, 0, 0), fov=3)
    light = clrt.Light((0, 50, 0))
    balls = [clrt.Sphere((0, 3 + 3 * i, 0), 1, "glass") for i in range(3)]
    lit = clrt.Scene(camera, [light], materials, [plane])
    renderer = renderer_for(device, 16, "double")
    full = renderer.render(lit, 9, 9)
    for n in range(4):
        shaded = renderer.render(replace(lit, spheres=[plane, *balls[:n]]), 9, 9)
        assert shaded == pytest.approx(0.9**n * full, rel=3e-7)


SNELL = """
__kernel void snell(__global const LANES_OF(FLOATING) *given, __global LANES_OF(FLOATING) *found) {
    int i = get_global_id(0);
    given += 8 * i;
    Refraction bent = refracted(vector(given[0], given[1], given[2]),
                                vector(given[3], given[4], given[5]), given[6], given[7]);
    found += 4 * i;
    found[0] = bent.direction.x, found[1] = bent.direction.y, found[2] = bent.direction.z;
    found[3] = PICK(bent.total, 1, 0);
}
"""


@pytest.mark.parametrize(
    ("before", "after", "bound"),
    [(1.0, 1.5, 5), (1.0, 1.0003, 5), (1.0, 1.000001, 5), (1.0, 1.0, 0)],
)
@pytest.mark.parametrize("precision", ["robust", "double"])
def test_snell(device: cl.Device, precision, before: float, after: float, bound: float) -> None:
    """Against long double, in units in the last place of 1: it does not cancel near eta = 1."""
    if precision == "double" and np.finfo(np.longdouble).nmant == 52:
        pytest.skip("long double is no wider than double here: nothing to check against")
    real = PRECISIONS[precision]
    random = np.random.default_rng(4)
    n = 1 << 16
    d, m = (v / np.linalg.norm(v, axis=0) for v in random.normal(size=(2, 3, n)))
    m = np.where((d * m).sum(axis=0) > 0, -m, m)
    indices = np.repeat(np.array([[before], [after]]), n, axis=1)
    given = np.concatenate([d, m, indices]).astype(real)
    blocks = np.ascontiguousarray(given.reshape(8, -1, 16).transpose(1, 0, 2))
    found = np.empty((n // 16, 4, 16), real)
    flags = options(16, precision, nest=1)
    run_kernel(device, SNELL, "snell", flags, n // 16, (blocks,), found)
    lines = found.transpose(1, 0, 2).reshape(4, n)
    d, m, (n1, n2) = (part.astype(np.longdouble) for part in (given[:3], given[3:6], given[6:]))
    cosine, eta = -(d * m).sum(axis=0), n1 / n2
    root = np.sqrt((eta * cosine) ** 2 - (n1 - n2) * (n1 + n2) / n2**2)
    truth = eta * d + (eta * cosine - root) * m
    off = abs(lines[:3] - truth).max() / (np.finfo(real).eps / 2)
    assert not lines[3].any()
    assert off <= bound


def test_split_is_needed_only_where_a_surface_does_both() -> None:
    scene = with_glass(BALL)
    world = pack_world(scene, "robust")
    assert features_of(world, scene, 16, "float") == Features(
        16, "robust", "float", reflection=True, nest=1
    )
    both = with_glass(BALL, fresnel=True)
    assert features_of(pack_world(both, "robust"), both, 16, "float").split


@pytest.mark.parametrize("precision", ["robust", "double"])
def test_a_background_shows_through_glass(device: cl.Device, precision) -> None:
    film = clrt.Film(background=(0.2, 0.5, 0.9))
    scene = replace(with_glass(BALL, at(MIDDLE, 0.3, "air"), fresnel=True), film=film)
    truth = reference.trace(scene, *SIZE)
    renderer = renderer_for(device, 16, precision)
    image = renderer.render(scene, *SIZE)
    _, passes = renderer.render(scene, *SIZE, passes=("id",))
    error = abs(np.clip(image, 0, 1) - np.clip(truth.image, 0, 1)).max(axis=2)
    assert (error > 1 / 1020).sum() <= 2
    assert np.median(error) < 1e-6
    assert (passes["id"] == truth.id).mean() > 0.9998
    alpha = renderer.render(scene, *SIZE, alpha=True)
    assert (alpha[..., 3] == (passes["id"] >= 0)).all()  # glass counts as hit


CHORD = """
__kernel void chord(__global const Sphere *spheres, __global const LANES_OF(FLOATING) *rays,
                    __global LANES_OF(FLOATING) *found) {
    int i = get_global_id(0);
    rays += 6 * i;
    Ray ray = {vector(rays[0], rays[1], rays[2]), vector(rays[3], rays[4], rays[5]), 0, -1};
    found[i] = way_out(quadratic(ray, spheres), (ints)(-1));
}
"""


@pytest.mark.parametrize(("radius", "away"), [(1.0, 3.0), (0.01, 1.0), (1e-4, 1.0), (1e3, 1.0)])
@pytest.mark.parametrize("precision", ["robust", "double"])
def test_a_chord_ends_on_its_sphere(
    device: cl.Device, precision, radius: float, away: float
) -> None:
    """Off it by no more than 4 units in the last place of |P| + t, for rays into a sphere from its
    own surface, steep and grazing; `away`: of its surface from the camera."""
    real = PRECISIONS[precision]
    wide, u = np.longdouble, np.finfo(real).eps / 2
    random = np.random.default_rng(8)
    n = 1 << 16
    center = np.array([[0.0, 0.0, -(radius + away)]], wide)
    sphere = pack_spheres(center, np.array([radius], wide), 0.0, real)
    out, aside = (v / np.linalg.norm(v, axis=0) for v in random.normal(size=(2, 3, n)))
    if radius > 4 * away:  # a giant: near the camera
        out = np.array([[0.0], [0.0], [1.0]]) + random.uniform(-1, 1, (3, n)) / radius
        out /= np.linalg.norm(out, axis=0)
    aside -= (aside * out).sum(axis=0) * out
    cosine = 10 ** random.uniform(-4, 0, n)
    direction = aside / np.linalg.norm(aside, axis=0) * np.sqrt(1 - cosine**2) - cosine * out
    direction /= np.linalg.norm(direction, axis=0)
    point = (center.T + radius * out.astype(wide)).astype(real)
    rays = np.concatenate([point, direction.astype(real)])
    blocks = np.ascontiguousarray(rays.reshape(6, -1, 16).transpose(1, 0, 2))
    found = np.empty((n // 16, 16), real)
    flags = options(16, precision, nest=1)
    run_kernel(device, CHORD, "chord", flags, n // 16, (sphere, blocks), found)
    chord = found.reshape(n).astype(wide)
    along = rays[3:].astype(wide) / np.linalg.norm(rays[3:].astype(wide), axis=0)
    end = point.astype(wide) + chord * along
    off = abs(np.linalg.norm(end - center.T, axis=0) - np.linalg.norm(point - center.T, axis=0))
    unit = u * (np.linalg.norm(point.astype(wide), axis=0) + chord)
    assert (chord > -4 * unit).all()  # not far back where the point itself is rounded inward
    assert (off / unit).max() <= 4


def test_a_ball_deviates_by_twice_the_difference_of_the_angles() -> None:
    """The reference itself, into a ball and out of it: 2 (ti - tt)."""
    angle = np.linspace(0.01, 1.5, 500)
    n = angle.size
    inward = np.stack([np.sin(angle), np.zeros(n), -np.cos(angle)])
    normal = np.repeat([[0.0], [0.0], [1.0]], n, axis=1)
    glass, air = np.full(n, 1.5), np.ones(n)
    inside, total, _ = true_glass.refracted(inward, normal, air, glass)
    assert not total.any()
    chord = -2 * (inside * normal).sum(axis=0)
    far = normal + chord * inside  # on the unit ball
    outward, total, _ = true_glass.refracted(inside, -far, glass, air)
    assert not total.any()
    deviation = np.arctan2(
        np.linalg.norm(np.cross(inward, outward, axis=0), axis=0), (inward * outward).sum(axis=0)
    )
    assert deviation == pytest.approx(2 * (angle - np.arcsin(np.sin(angle) / 1.5)), abs=1e-12)
