"""The hard cases, and scenes that hypothesis makes up, against the exact truth."""

import functools
import math

import hypothesis.strategies as st
import numpy as np
import pyopencl as cl
import pytest
from conftest import kept, renderer_for
from hard_cases import CASES, HardCase, at, is_common, plane, with_glass
from hypothesis import assume, given, settings
from msgspec.structs import replace

from clrt import (
    AmbientLight,
    Camera,
    DirectionalLight,
    Light,
    Material,
    Scene,
    Sphere,
    SpotLight,
    reference,
)
from clrt.figure.rendering import Renderer
from clrt.film import metrics
from clrt.film.metrics import QUARTER_STEP
from clrt.renderer.pack.structs import Precision
from clrt.scene.light import LightKind

# Lanes: the two ways that the kernel's source can be read.
WAYS: list[tuple[Precision, int]] = [("robust", 1), ("robust", 16), ("double", 1), ("double", 16)]
WIDE = np.finfo(np.longdouble).nmant > np.finfo(np.float64).nmant

every_case = pytest.mark.parametrize("case", CASES, ids=lambda case: case.name)


def renderer_of(device: cl.Device, precision: Precision, lanes: int) -> Renderer:
    if precision == "double" and device.native_vector_width_double == 0:
        pytest.skip("no float64")
    return renderer_for(device, lanes, precision)


@functools.cache
def truth_of(case: HardCase) -> reference.Trace:
    if case.dtype == np.longdouble and not WIDE:
        pytest.skip("long double is no wider than double here: nothing to check against")
    with np.errstate(all="ignore"):  # the seed's formula overflows before it is right
        return reference.trace(case.scene, *case.size, "exact", case.dtype)


def faults(case: HardCase, image: np.ndarray, precision: Precision) -> list[str]:
    """What the picture has that the case does not allow."""
    if not np.isfinite(image).all():
        return ["NaN or infinity"]
    if case.check == "finite":
        return []
    if case.check == "black":
        return ["not black"] * bool(image.any())
    trace = truth_of(case)
    error = metrics.pixel_error(image, trace.image)
    flipped = error > QUARTER_STEP
    astray = flipped & ~metrics.edges(trace.paths)
    worst = error[~flipped].max(initial=0)
    found = []
    if astray.any():
        found.append(f"{astray.sum()} pixels off by up to {error[astray].max():.2g} at no edge")
    if flipped.sum() > case.flips:
        found.append(f"{flipped.sum()} flips")
    if worst > (case.double if precision == "double" else case.error):
        found.append(f"off by {worst:.2g}")
    return found and [*found, kept(image, trace.image)]


BOTH = {case.name for case in list(filter(is_common, CASES))[::4]}


def is_slow(case: HardCase, precision: Precision, lanes: int) -> bool:
    if lanes == 1 and precision == "double":
        return True
    return (precision, lanes) != ("robust", 16) and not is_common(case)


def is_tried(case: HardCase, precision: Precision, lanes: int) -> bool:
    """All are in one lane and in float64, but some in both at once."""
    return (precision, lanes) != ("double", 1) or case.name in BOTH


# The case is the slowest to change: one truth serves all.
@pytest.mark.parametrize(
    ("case", "precision", "lanes"),
    [
        pytest.param(
            case, *way, id=f"{case.name}-{way[0]}-{way[1]}",
            marks=[pytest.mark.slow] * is_slow(case, *way),
        )
        for case in CASES
        for way in WAYS
        if is_tried(case, *way)
    ],
)  # fmt: skip
def test_hard_case(
    request: pytest.FixtureRequest,
    device: cl.Device,
    case: HardCase,
    precision: Precision,
    lanes: int,
) -> None:
    if case.limit and precision == "robust":
        request.applymarker(pytest.mark.xfail(reason=case.limit, strict=True))
    image = renderer_of(device, precision, lanes).render(case.scene, *case.size)
    assert not faults(case, image, precision)


@every_case
def test_black_cases_are_black(case: HardCase) -> None:
    if case.check == "black":
        assert not truth_of(case).image.any()


@pytest.mark.filterwarnings("ignore:overflow encountered in cast")  # 2^70 squared, unscaled
@pytest.mark.parametrize("case", [c for c in CASES if c.literal_fails], ids=lambda c: c.name)
def test_the_papers_formula_fails(device: cl.Device, case: HardCase) -> None:
    image = renderer_of(device, "literal", 16).render(case.scene, *case.size)
    assert faults(case, image, "literal")


precisions: st.SearchStrategy[Precision] = st.sampled_from(["robust", "double"])
unit = st.floats(0, 1)
color = st.tuples(unit, unit, unit)
place = st.tuples(st.floats(-3, 3), st.floats(-2, 2), st.floats(-6, 0.5))


def decades(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high).map(lambda x: float(10**x))


KINDS = (Light, Light, SpotLight, DirectionalLight, AmbientLight)


@st.composite
def light(draw: st.DrawFn, kinds: tuple[type, ...] = KINDS) -> LightKind:
    position = draw(st.tuples(st.floats(-9, 9), st.floats(0, 9), st.floats(0, 9)))
    part = st.floats(0, 1)
    attenuation = draw(
        st.sampled_from([(1.0, 0.0, 0.0), (0.0, 0.0, 0.1), (draw(part), draw(part), 0.1)])
    )
    kind = draw(st.sampled_from(kinds))
    if kind is Light:
        return Light(position, attenuation=attenuation)
    if kind is SpotLight:
        outer = draw(st.floats(1, 120))
        return SpotLight(position, (0.0, -0.5, -1.0), attenuation=attenuation, outer_angle=outer,
                         inner_angle=draw(st.floats(0, 0.99)) * outer)  # fmt: skip
    if kind is DirectionalLight:
        return DirectionalLight((draw(st.floats(-1, 1)), draw(st.floats(-1, -0.1)), -0.5))
    return AmbientLight(draw(color))


@st.composite
def camera(draw: st.DrawFn, eye: tuple[float, float, float]) -> Camera:
    if draw(st.sampled_from([False, False, True])):
        height = draw(st.sampled_from([0.5, 3.0, 20.0]))
        return Camera(eye, draw(place), projection="orthographic", height=height)
    return Camera(eye, draw(place), fov=draw(st.sampled_from([0.5, 10.0, 40.0, 90.0, 140.0])))


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    """1 to 20 spheres around the view: small and large, giant, nested, touching, coincident.

    All have each kind of light, highlights of both kinds and mirrors: few programs serve them.
    """
    names = ("a", "b", "c")
    materials = {
        name: Material(
            ambient=draw(color),
            diffuse=draw(color),
            specular=draw(color),
            shininess=draw(st.sampled_from([4.0, 30.0, 100.0, 1e4])),
            reflection=draw(st.sampled_from([0.3, 0.9, 1.0] if name == "a" else [0.0, 0.3, 0.9])),
            highlight="phong" if name == "a" else "blinn-phong",
        )
        for name in names
    }
    spheres: list[Sphere] = [Sphere(draw(place), draw(decades(-1, 0)), "a")]
    for _ in range(draw(st.integers(1, 20))):
        kind = draw(st.sampled_from(["free", "free", "giant", "nested", "touching", "coincident"]))
        last = spheres[-1] if spheres else plane(1e4)
        center, radius = last.center, last.radius
        if kind == "free":
            center, radius = draw(place), draw(decades(-3, 0.3))
        elif kind == "giant":
            up = (draw(st.floats(-0.5, 0.5)), 1.0, draw(st.floats(-0.5, 0.5)))
            ground = plane(draw(decades(3, 9)), up, (0.0, draw(st.floats(-3, -0.5)), 0.0))
            center, radius = ground.center, ground.radius
        elif kind == "nested":
            radius *= draw(st.floats(0.2, 0.99))
        elif kind == "touching":
            other = draw(decades(-2, 0))
            angle = draw(st.floats(0, math.pi))
            reach = radius + other
            center = (
                center[0] + reach * math.cos(angle),
                center[1] + reach * math.sin(angle),
                center[2],
            )
            radius = other
        spheres.append(Sphere(center, radius, draw(st.sampled_from(names))))
    eye = draw(st.tuples(st.floats(-1, 1), st.floats(0, 1), st.floats(1, 4)))
    lights = draw(st.lists(light(), max_size=3))
    fading = replace(draw(light((SpotLight,))), attenuation=(0.5, 0.0, 0.1))
    lights += [fading, draw(light((AmbientLight,)))]
    # Ill-posed: whether a point on a surface sees it.
    places = [one.position for one in lights if isinstance(one, Light | SpotLight)]
    for point in (eye, *places):
        assume(all(abs(math.dist(point, s.center) - s.radius) > 1e-5 for s in spheres))
    return Scene(
        camera=draw(camera(eye)),
        lights=tuple(lights),
        materials=materials,
        spheres=tuple(spheres),
        max_depth=draw(st.integers(2, 5)),
    )


# Four in each other, out of sight: whatever else there is, one program serves it.
NEST = tuple(at((0.0, 90.0, 9.0), radius, "glass") for radius in (0.1, 0.09, 0.08, 0.07))


@st.composite
def glass_scenes(draw: st.DrawFn) -> Scene:
    """One to four balls of glass in, over and beside each other."""
    kinds = ("glass", "air", "diamond")
    balls: list[Sphere] = []
    for _ in range(draw(st.integers(1, 4))):
        near = st.floats(-0.3, 0.3)
        center = (draw(near), draw(near), draw(near) - 0.2)
        concentric: bool = draw(st.booleans())
        if balls and concentric:
            center = balls[-1].center
        balls.append(Sphere(center, draw(st.floats(0.1, 0.5)), draw(st.sampled_from(kinds))))
    depth: int = draw(st.integers(2, 7))
    scene = with_glass(*balls, *NEST, depth=depth, fresnel=draw(st.booleans()))
    scene = replace(scene, lights=(*scene.lights, AmbientLight(draw(color))))
    for one in balls:
        assume(all(abs(math.dist(one.center, s.center) - abs(one.radius - s.radius)) > 1e-4
                   for s in scene.spheres if s is not one))  # fmt: skip
        assume(abs(math.dist(one.center, scene.camera.position) - one.radius) > 1e-3)
    return scene


@settings(max_examples=15, derandomize=True, deadline=None)
@given(scene=glass_scenes(), precision=precisions)
def test_made_up_glass(device: cl.Device, scene: Scene, precision: Precision) -> None:
    case = HardCase("made up", "", scene, (48, 32), np.longdouble, flips=9, double=1e-6)
    image = renderer_of(device, precision, 16).render(scene, *case.size)
    assert not faults(case, image, precision)


@settings(max_examples=20, derandomize=True, deadline=None)
@given(scene=scenes(), precision=precisions)
def test_made_up_scenes(device: cl.Device, scene: Scene, precision: Precision) -> None:
    case = HardCase("made up", "", scene, size=(48, 32), dtype=np.longdouble, flips=9)
    image = renderer_of(device, precision, 16).render(scene, *case.size)
    assert not faults(case, image, precision)
