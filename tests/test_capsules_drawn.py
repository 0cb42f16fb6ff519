"""Capsules as the kernels draw them, against the truth."""

import functools
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from conftest import renderer_for
from msgspec.structs import replace

import clrt
from clrt import Camera, Capsule, Capsules, Material, Scene, Sphere, reference
from clrt.film import metrics
from clrt.renderer.pack.structs import Precision

SIZE = 64, 40
RED = Material((0.1, 0, 0), (0.7, 0.2, 0.2), (1, 1, 1), shininess=100, reflection=0.3)
LIGHTS = (clrt.Light((3, 4, 5)), clrt.AmbientLight((0.2, 0.2, 0.2)))
CAMERA = Camera((0, 0, 3), (0, 0, 0))
BESIDE = Camera((0, 0, 3), (0, 0, 0), projection="orthographic", height=2.5)


def scene_of(*capsules: Capsule, **more: Any) -> Scene:
    given: dict[str, Any] = {"camera": CAMERA, "lights": LIGHTS, "materials": {"red": RED}}
    return Scene(**given | {"capsules": capsules} | more)


def bonds(n: int, **more: Any) -> Scene:
    """n capsules between atoms, in colours of their own."""
    random = np.random.default_rng(n)
    start = random.uniform(-1.2, 1.2, (n, 3))
    end = start + random.normal(size=(n, 3)) * 0.15
    capsules = Capsules(start, end, random.uniform(0.01, 0.05, n), "red", random.random((n, 3)))
    atoms = tuple(Sphere(tuple(place), 0.06, "red") for place in start[: n // 2])
    return replace(scene_of(**more), capsules=capsules, spheres=atoms)


def one(start: Any, end: Any, radius: float, **more: Any) -> Scene:
    """Of a colour of its own, as `bonds` are: one program serves both."""
    return scene_of(Capsule(start, end, radius, "red", (0.9, 0.8, 1)), **more)


ON_GROUND = {"spheres": (Sphere((0, -1e4 - 0.6, 0), 1e4, "red"),)}
CASES: dict[str, Scene] = {
    "bonds": bonds(300),
    "bonds, orthographic": bonds(300, camera=BESIDE),
    "bonds, a long lens": bonds(300, camera=Camera((20, 15, 60), (0, 0, 0), fov=2.5)),
    "bonds far from 0": replace(
        bonds(20, camera=Camera((1e5, 0, 3), (1e5, 0, 0))),
        capsules=Capsules([[1e5 - 1, 0, 0]], [[1e5 + 1, 0.5, 0]], 0.2, "red", [[0.9, 0.8, 1]]),
    ),
    "along the view": one((0, 0, -1), (0, 0, 1), 0.3, **ON_GROUND),
    "nearly along the view": one((0.2, 0, -1), (0.2001, 0, 1), 0.3, **ON_GROUND),
    "end-on, beside": one((0.5, 0.2, -2), (0.5, 0.2, 1), 0.3, camera=BESIDE),
    "of no length": one((0.1, 0.2, 0), (0.1, 0.2, 0), 0.5, **ON_GROUND),
    "nearly of no length": one((0.1, 0.2, 0), (0.1, 0.2 + 5e-7, 0), 0.5, **ON_GROUND),
    "as thin as a hair": one((-1, -0.3, 0), (1, 0.3, 0), 0.02, **ON_GROUND),
    "around the camera": scene_of(
        Capsule((0, 0, 9), (0, 0, 2), 0.5, "red", (1, 0.2, 0.2)),
        Capsule((-1, 0, 0), (1, 0, 0), 0.2, "red", (0.2, 0.2, 1)),
    ),
    "among equal spheres": scene_of(
        Capsule((-0.5, 0, 0), (0.5, 0, 0), 0.3, "red", (0.9, 0.8, 1)),
        spheres=(Sphere((-0.5, 0, 0), 0.3, "red"), Sphere((0.5, 0, 0), 0.3, "red")),
    ),
    "two halves": scene_of(
        Capsule((-0.8, 0, 0), (0, 0.1, 0), 0.2, "red", (1, 0.2, 0.2)),
        Capsule((0.8, 0.2, 0), (0, 0.1, 0), 0.2, "red", (0.2, 0.2, 1)),
    ),
    "a light inside": one((-0.5, 0, 0), (0.5, 0, 0), 0.3, lights=(*LIGHTS, clrt.Light((0, 0, 0)))),
    "seen through": bonds(100, materials={"red": replace(RED, reflection=0.0, opacity=0.5)}),
    "among glass": replace(
        bonds(50, materials={"red": RED, "glass": Material(transmission=0.8, specular=(1, 1, 1))}),
        spheres=(Sphere((0, 0, 1), 0.5, "glass"), Sphere((0.8, 0, 0.5), 0.3, "glass")),
    ),
}


@functools.cache
def truth_of(name: str) -> reference.Trace:
    return reference.trace(CASES[name], *SIZE)


@pytest.mark.parametrize(
    ("name", "precision"),
    [
        *((name, "robust") for name in CASES),
        ("bonds", "double"),
        *(pytest.param(name, "double", marks=pytest.mark.slow) for name in list(CASES)[1:]),
    ],
)
def test_against_the_truth(device: cl.Device, name: str, precision: Precision) -> None:
    if precision == "double" and device.native_vector_width_double == 0:
        pytest.skip("no float64")
    truth, renderer = truth_of(name), renderer_for(device, 16, precision)
    off = metrics.pixel_error(renderer.render(CASES[name], *SIZE), truth.image)
    assert not (off[~metrics.edges(truth.paths)] > metrics.QUARTER_STEP).any()
    assert (truth.id >= 0).sum() > 50
    if precision == "double":
        assert off[~metrics.edges(truth.paths)].max() < 1e-6


def test_of_no_length_it_is_a_sphere_to_the_bit(device: cl.Device) -> None:
    """Of spheres in the tree, all tests are by one formula."""
    renderer = renderer_for(device, 16, "robust")
    centers = np.random.default_rng(5).uniform(-1, 1, (100, 3))
    balls = Capsules(centers, centers, 0.1, "red")
    spheres = clrt.Spheres(centers, 0.1, "red")
    aside = Capsules([[0, 0, -50]], [[0, 0, -50]], 0.1, "red")
    drawn = renderer.render(replace(scene_of(), capsules=balls), *SIZE)
    expected = renderer.render(replace(scene_of(), spheres=spheres, capsules=aside), *SIZE)
    assert abs(drawn - expected).max() == 0


def test_regions_are_crops(device: cl.Device) -> None:
    renderer = renderer_for(device, 16, "robust")
    whole = renderer.render(CASES["bonds"], *SIZE)
    part = renderer.render(CASES["bonds"], *SIZE, region=(13, 7, 50, 33))
    assert (part == whole[7:33, 13:50]).all()


def test_round_lights_are_sampled(device: cl.Device) -> None:
    """The shadow of a ball is that of a capsule of no length, but for its noise."""
    lamp = (clrt.Light((0, 3, 1), radius=0.5),)
    ground = Sphere((0, -100.5, 0), 100, "red")
    ball = one((0, 0.3, 0), (0, 0.3, 0), 0.4, spheres=(ground,), lights=lamp, samples=64)
    sphere = replace(ball, capsules=(), spheres=(ground, Sphere((0, 0.3, 0), 0.4, "red")))
    renderer = renderer_for(device, 16, "robust")
    drawn, expected = (renderer.render(some, 32, 20) for some in (ball, sphere))
    assert abs(drawn - expected).mean() < 0.005
    assert abs(drawn - expected).max() > 0


@pytest.mark.slow
def test_occlusion_and_indirect_light_know_them(device: cl.Device) -> None:
    renderer = renderer_for(device, 16, "robust")
    sky = (clrt.AmbientLight((1, 1, 1), occlusion=True),)
    ground = Sphere((0, -100.4, 0), 100, "red")
    flat = replace(RED, reflection=0.0, ambient=(1.0, 1.0, 1.0))
    given = one(
        (-1, 0, 0), (1, 0, 0), 0.3,
        spheres=(ground,), lights=sky, samples=32, materials={"red": flat},
    )  # fmt: skip
    open_sky = renderer.render(replace(given, capsules=()), 33, 21)
    assert (renderer.render(given, 33, 21) < 0.8 * open_sky).mean() > 0.02
    assert renderer.render(replace(given, indirect=True), 33, 21).any()


def test_passes(device: cl.Device) -> None:
    renderer, truth = renderer_for(device, 16, "robust"), truth_of("two halves")
    _, found = renderer.render(CASES["two halves"], *SIZE, passes=["id", "depth", "normal"])
    inner = ~metrics.edges(truth.paths) & (truth.id >= 0)
    assert (found["id"] == truth.id)[inner].all()
    assert set(truth.id.ravel().tolist()) == {-1, 0, 1}
    assert abs(found["depth"][inner] - truth.depth[inner]).max() < 1e-4
    assert abs(found["normal"][inner] - truth.normal[inner]).max() < 1e-3
