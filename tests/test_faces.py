"""Faces of meshes in the kernels: no ray passes between them, and pictures are the truth's."""

import numpy as np
import pyopencl as cl
import pytest
from conftest import renderer_for
from msgspec.structs import replace

import clrt
from benchmarks.triangles import WAYS, ball, leaks, tile_leaks
from clrt import reference
from clrt.film import metrics


def skip_without_float64(device: cl.Device, precision: object) -> None:
    if precision == "double" and device.native_vector_width_double == 0:
        pytest.skip("no float64")


# Each way has a program. The others differ from these in one thing that another of these has.
ALONE = [{"lanes": 1}, {"fma": False}, {"precision": "double"}]


@pytest.mark.parametrize(
    "way",
    [pytest.param(way, marks=[pytest.mark.slow] * (way in ALONE), id=str(way)) for way in WAYS],
)
def test_no_ray_passes_between_faces(device: cl.Device, way) -> None:
    skip_without_float64(device, way.get("precision"))
    cast, missed = leaks(device, ball(20), 200_000, **way)
    assert cast >= 200_000
    assert missed == [0, 0, 0]


@pytest.mark.slow
@pytest.mark.parametrize("way", [{}, {"fma": False}], ids=str)
def test_of_ten_million_rays_none_passes_between_faces(device: cl.Device, way) -> None:
    assert leaks(device, ball(71), 10_000_000, **way)[1] == [0, 0, 0]


def test_no_camera_ray_of_a_tile_passes_between_faces(device: cl.Device) -> None:
    assert tile_leaks(device, 100_000, 256)[1] == 0


@pytest.mark.slow
def test_of_ten_million_camera_rays_none_passes_between_faces(device: cl.Device) -> None:
    assert tile_leaks(device, 10_000_000)[1] == 0


def test_plain_products_let_rays_pass(device: cl.Device) -> None:
    """So the rays are hard enough."""
    assert sum(leaks(device, ball(20), 1_000_000, plain=True)[1]) > 20


MATERIALS = {
    "plain": clrt.Material((0.1, 0.1, 0.1), (0.7, 0.5, 0.2), (0.3, 0.3, 0.3), 128),
    "mirror": clrt.Material((0, 0, 0.1), (0.3, 0.4, 0.5), (1, 1, 1), 300, reflection=0.5),
    "veil": clrt.Material((0, 0.1, 0), (0.3, 0.7, 0.3), (1, 1, 1), 60, opacity=0.6),
    "phong": clrt.Material((0.1, 0, 0), (0.7, 0.2, 0.2), (1, 1, 1), 40, highlight="phong"),
}
LIGHTS = (
    clrt.Light((5, 5, 4)),
    clrt.Light((-3, 2, 1), diffuse=(0.3, 0.3, 0.5), attenuation=(1, 0.1, 0.02)),
    clrt.AmbientLight((0.2, 0.2, 0.2)),
)
CAMERA = clrt.Camera((0, 0, 0), (0, 0, -1))
GROUND = clrt.Mesh(
    [(-8, -1, 8), (8, -1, 8), (8, -1, -8), (-8, -1, -8)], [(0, 1, 2), (0, 2, 3)], material="mirror"
)
SIZE = (97, 55)
BOUNDS = {"robust": 1 / 1020, "double": 1e-6}


def wavy(n: int = 24) -> clrt.Mesh:
    """A sheet with two sides, seen from both."""
    x, y = np.meshgrid(np.linspace(-1, 1, n), np.linspace(-1, 1, n), indexing="ij")
    z = 0.35 * np.sin(4 * x) * np.cos(3 * y)
    at = np.arange(n * n).reshape(n, n)
    a, b, c, d = at[:-1, :-1].ravel(), at[1:, :-1].ravel(), at[1:, 1:].ravel(), at[:-1, 1:].ravel()
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    points = np.column_stack([1.1 * x.ravel(), 0.5 * y.ravel() + z.ravel(), 0.8 * y.ravel() - 2.2])
    return clrt.Mesh(points, faces, material="plain")


def of(mesh: clrt.Mesh, **others) -> clrt.Mesh:
    """That mesh with some things changed."""
    kept = {name: getattr(mesh, name) for name in ("normals", "colors", "material", "shading")}
    return clrt.Mesh(mesh.vertices, mesh.faces, **{**kept, **others})


def painted(mesh: clrt.Mesh, rows: int) -> np.ndarray:
    return np.random.default_rng(rows).uniform(0.2, 1, (rows, 3))


def scene_of(*meshes: clrt.Mesh, **others) -> clrt.Scene:
    return replace(clrt.Scene(CAMERA, LIGHTS, MATERIALS, meshes=meshes, max_depth=3), **others)


BALL, SHEET = of(ball(5), material="plain"), wavy()
SPHERES = (
    clrt.Sphere((0.4, -0.7, -1.5), 0.3, "mirror"),
    clrt.Sphere((-0.5, 0.2, -1.2), 0.2, "veil"),
)
CARD = clrt.Mesh([(-0.1, -4, 7), (0.1, -4, 7), (0, -4, 7.1)], [(0, 1, 2)], material="phong")
# Under the ground, behind the camera: one program serves all that have them.
ALL_KINDS = (
    GROUND,
    of(CARD, shading="phong"),
    of(CARD, shading="gouraud", colors=painted(CARD, 3)),
)
AFAR = np.full(3, 1e5)
SHARED = {
    "flat": scene_of(BALL, *ALL_KINDS),
    "sheet": scene_of(SHEET, *ALL_KINDS),
    "coplanar": scene_of(
        clrt.Mesh([(-1, -0.5, -2), (1, -0.5, -2), (0, 0.6, -2)], [(0, 1, 2)], material="plain"),
        clrt.Mesh([(-1, -0.5, -2), (1, -0.5, -2), (0, 0.6, -2)], [(0, 1, 2)], material="mirror"),
        *ALL_KINDS,
    ),
    "through the camera": scene_of(
        clrt.Mesh([(-1, -0.4, 1), (1, -0.4, 1), (0, 0.3, -2)], [(0, 1, 2)], material="plain"),
        *ALL_KINDS,
    ),
    "gouraud": scene_of(
        of(BALL, shading="gouraud", colors=painted(BALL, len(BALL.vertices))), *ALL_KINDS
    ),
    "phong": scene_of(of(BALL, shading="phong", material="phong"), *ALL_KINDS),
    "smooth sheet": scene_of(of(SHEET, shading="phong", material="mirror"), *ALL_KINDS),
    "gouraud sheet": scene_of(of(SHEET, shading="gouraud", material="phong"), *ALL_KINDS),
    "colors of faces": scene_of(of(BALL, colors=painted(BALL, len(BALL))), of(SHEET), *ALL_KINDS),
    "moved": scene_of(
        of(clrt.Mesh(ball(5).vertices + AFAR, ball(5).faces), material="plain"),
        *(of(clrt.Mesh(one.vertices + AFAR, one.faces), material=one.material,
             shading=one.shading, colors=one.colors) for one in ALL_KINDS),
        camera=clrt.Camera((1e5, 1e5, 1e5), (1e5, 1e5, 1e5 - 1)),
        lights=tuple(
            replace(one, position=tuple(AFAR + one.position)) for one in LIGHTS[:2]
        ) + LIGHTS[2:],
    ),
    "slivers": scene_of(
        clrt.Mesh([(-1, -0.5, -2), (1, -0.5, -2), (0, -0.5 + 2e-6, -2), (0, 0.6, -2.5)],
                  [(0, 1, 2), (0, 2, 3), (2, 1, 3)], material="plain"),
        *ALL_KINDS,
    ),
}  # fmt: skip
SCENES = {
    **SHARED,
    "veil": replace(
        scene_of(of(BALL, material="veil"), of(SHEET, material="veil")), spheres=SPHERES
    ),
    "with others": scene_of(
        SHEET, GROUND, spheres=SPHERES[:1],
        capsules=(clrt.Capsule((-1, -0.5, -2), (1, 0.5, -1.5), 0.1, "plain"),),
    ),
    "orthographic": scene_of(
        SHEET, of(BALL, shading="phong"), GROUND,
        camera=clrt.Camera((0.1, 0.5, 2), (0, 0, -2), projection="orthographic", height=2.5),
    ),
    "long lens": scene_of(
        of(BALL, shading="gouraud"), SHEET, camera=clrt.Camera((9, 8, 60), (0, 0, -2), fov=2.5)
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SCENES)
def test_pictures_are_the_truths(device: cl.Device, name: str) -> None:
    """Those that share a program are held against it where the path is the truth's, others where
    its neighbours' are."""
    scene = SCENES[name]
    truth = reference.trace(scene, *SIZE)
    for precision in ["robust", *["double"] * (name in {**SHARED, "veil": 0})]:
        skip_without_float64(device, precision)
        renderer = renderer_for(device, 16, precision)
        off = metrics.pixel_error(renderer.render(scene, *SIZE), truth.image) > BOUNDS[precision]
        if name in SHARED and precision == "robust":
            paths = renderer.paths(scene, *SIZE)
            assert not (off & (paths == truth.paths)).any()
            assert (paths != truth.paths).mean() < 0.004
        assert not (off & ~metrics.edges(truth.paths)).any()
        assert off.mean() < 0.004


@pytest.mark.parametrize("name", ["smooth sheet", "veil", "with others"])
def test_every_way_gives_the_same_bits(device: cl.Device, name: str) -> None:
    """Ray by ray, in packets, and a part of the picture."""
    scene = SCENES[name]
    whole = renderer_for(device, 16).render(scene, *SIZE)
    part = renderer_for(device, 16).render(scene, *SIZE, region=(13, 7, 60, 41))
    assert (whole[7:41, 13:60] == part).all()
    one = renderer_for(device, 1).render(scene, *SIZE)
    assert (abs(one - whole).max(axis=2) > 1e-5).mean() < 0.002


def test_a_mesh_is_one_thing_to_samples_and_its_faces_are_of_passes(device: cl.Device) -> None:
    scene = scene_of(of(BALL, shading="phong"), GROUND, max_depth=1, lights=())
    renderer = renderer_for(device, 16)
    assert len(np.unique(renderer.paths(scene, *SIZE))) == 3
    _, passes = renderer.render(SCENES["phong"], *SIZE, passes=["id", "normal"])
    assert len(np.unique(passes["id"])) > 100
    assert passes["id"].max() == len(BALL) + 1
    length = np.sqrt((passes["normal"] ** 2).sum(axis=2))
    assert np.allclose(length[passes["id"] >= 0], 1, atol=1e-6)


def test_skies_are_hidden_by_faces(device: cl.Device) -> None:
    """A plate close over the ground leaves a sliver of the sky; far from it the sky is open."""
    plate = clrt.Mesh([(-9, 0, 9), (9, 0, 9), (9, 0, -9), (-9, 0, -9)], [(0, 1, 2), (0, 2, 3)],
                      material="white")  # fmt: skip
    white = clrt.Material((1, 1, 1), (0, 0, 0), (0, 0, 0), 1)
    sky = clrt.AmbientLight((1, 1, 1), occlusion=True)
    low = clrt.Mesh(plate.vertices - (0, 0.02, 0), plate.faces, material="white")
    camera = clrt.Camera((0, -0.01, 0), (0, -0.012, -0.01))
    scene = clrt.Scene(camera, (sky,), {"white": white}, meshes=(low,), samples=64)
    assert np.allclose(renderer_for(device, 16).render(scene, 16, 9)[5:], 1, atol=1e-6)
    covered = replace(scene, meshes=(low, plate))
    assert renderer_for(device, 16).render(covered, 16, 9)[5:].max() < 0.01


def test_round_lights_have_soft_shadows_of_faces(device: cl.Device) -> None:
    card = clrt.Mesh([(-1, 0.5, -1), (-1, 0.5, -3), (0, 0.5, -3), (0, 0.5, -1)],
                     [(0, 1, 2), (0, 2, 3)], material="plain")  # fmt: skip
    lamp = clrt.Light((0, 4, -2), radius=0.8)
    scene = scene_of(card, GROUND, lights=(lamp,), samples=64, max_depth=1)
    soft = renderer_for(device, 16).render(scene, *SIZE)
    point = replace(scene, lights=(clrt.Light((0, 4, -2)),), samples=1)
    hard = renderer_for(device, 16).render(point, *SIZE)
    off = abs(soft - hard).max(axis=2)
    assert off.max() > 0.1
    assert (off < 0.01).mean() > 0.7
