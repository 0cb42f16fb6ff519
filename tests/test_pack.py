"""Packing: the dtypes are the kernel's structs, and giants are anchored where they should be."""

import math
from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from conftest import run_kernel
from msgspec.structs import replace

import clrt
from clrt import Camera, Material, Scene, Sphere, Spheres
from clrt.errors import RequestError
from clrt.opencl import tree
from clrt.opencl.program import kernel_source
from clrt.renderer import trial
from clrt.renderer.pack.arguments import arguments_of, sampling
from clrt.renderer.pack.features import SMALL, SMALLS_BASE, Features, base_samples, features_of
from clrt.renderer.pack.spheres import pack_spheres
from clrt.renderer.pack.structs import (
    PASSES,
    PRECISIONS,
    Precision,
    camera_dtype,
    glass_dtype,
    light_dtype,
    material_dtype,
    medium_dtype,
    shade_dtype,
    sphere_dtype,
)
from clrt.renderer.pack.world import World, pack_world
from clrt.scene import lens

STRUCTS: dict[str, Callable[[Any], np.dtype[Any]]] = {
    "Camera": camera_dtype,
    "Sphere": sphere_dtype,
    "Material": material_dtype,
    "Light": light_dtype,
    "Shade": shade_dtype,
    "Glass": glass_dtype,
    "Medium": medium_dtype,
    "Node": tree.node_dtype,
    "Leaf": tree.leaf_dtype,
    "CapsuleLeaf": tree.capsule_leaf_dtype,
    "Shape": tree.shape_dtype,
    "channel": lambda real: PASSES,
}


def layout_kernel() -> str:
    """A kernel that writes size and field offsets of every struct, as the device has them."""
    lines = []
    for name, dtype in STRUCTS.items():
        lines.append(f"*to++ = sizeof({name});")
        for field in dtype(np.float32).names or ():
            lines.append(
                f"{{ __private {name} s; "
                f"*to++ = (__private char *)&s.{field} - (__private char *)&s; }}"
            )
    return "__kernel void layout(__global int *to) {" + "\n".join(lines) + "}"


@pytest.mark.parametrize("precision", ["robust", "double"])
def test_dtypes_match_the_device_structs(device: cl.Device, precision) -> None:
    expected = []
    for dtype in (make(PRECISIONS[precision]) for make in STRUCTS.values()):
        expected.append(dtype.itemsize)
        expected += [offset for _, offset, *_ in (dtype.fields or {}).values()]
    found = np.zeros(len(expected), np.int32)
    used = Features(1, precision, "passes", tree=True).options
    run_kernel(device, layout_kernel(), "layout", used, 1, (), found)
    assert found.tolist() == expected


def packed(scene: clrt.Scene, precision: Precision = "robust") -> SimpleNamespace:
    """The kernel's arguments for a small picture, by name."""
    return SimpleNamespace(**arguments_of(pack_world(scene, precision), scene, 64, 36))


def test_only_the_plane_is_a_giant() -> None:
    found = packed(clrt.load_scene("four-spheres"))
    assert found.spheres["giant"].tolist() == [0, 0, 0, 1]
    plane = found.spheres[3]
    # The plane's top is 0.7 under the camera's height, which stands 1 beside its axis.
    scale = 1 / (plane["inv_radius"] * 8999.3)
    assert plane["anchor"] == pytest.approx([0, -0.7 * scale, 0], abs=2e-4)
    assert plane["offset"] == pytest.approx([0, 8999.3 * scale, scale], rel=1e-4)


@pytest.mark.parametrize("size", [1e-30, 1.0, 1e30])
def test_lengths_are_scaled_by_a_power_of_two_to_about_1(size: float) -> None:
    scene = clrt.load_scene("first-result")
    spheres = tuple(
        clrt.Sphere((c[0] * size, c[1] * size, c[2] * size), s.radius * size, "red")
        for s in scene.spheres
        for c in [s.center]
    )
    camera = clrt.Camera((0, 0, size), (0, 0, 0))
    found = packed(clrt.Scene(camera, (), scene.materials, spheres))
    reach = np.linalg.norm(found.spheres["anchor"], axis=1) + 1 / found.spheres["inv_radius"]
    assert 0.5 <= reach.max() <= 1
    scale = found.spheres["inv_radius"][0] * 0.7 * size
    assert np.log2(scale) == pytest.approx(round(np.log2(scale)), abs=1e-6)


@pytest.mark.parametrize("radius", [1e3, 1e5, 1e7, 1e9])
def test_a_giants_surface_is_where_it_was(radius: float) -> None:
    """The point that float32 anchor, offset and c0 stand for lies on the sphere."""
    center = np.array([[0.6 * (radius + 1.5), -0.8 * (radius + 1.5), 0.0]])
    sphere = pack_spheres(center, np.array([radius]), 0.0, np.float32)[0]
    assert sphere["giant"]
    # c / 2r is the height of the anchor above the surface, as the kernel has it.
    height = float(sphere["c0"]) / (2 * radius)
    truth = np.linalg.norm(sphere["anchor"].astype(float) - center[0]) - radius
    assert height == pytest.approx(truth, abs=2e-7)


def test_materials_are_stored_once() -> None:
    scene = clrt.load_scene("sunflower")
    found = packed(scene)
    assert found.shades.shape == (len(scene.lights), len(scene.materials))
    assert len(found.materials) == len(scene.materials) < len(found.beads)
    names = list(scene.materials)
    for index, sphere in zip(found.materials_of, scene.spheres, strict=True):
        assert names[index] == sphere.material
    for listed, packed_sphere in zip(found.ids, found.spheres, strict=True):
        assert packed_sphere["material"] == found.materials_of[listed]


def test_shades_are_products_of_material_and_light() -> None:
    scene = clrt.load_scene("sunflower")
    found = packed(scene, "double")
    gold = list(scene.materials).index("gold")
    light = scene.lights[1]
    assert isinstance(light, clrt.Light)
    expected = np.array(scene.materials["gold"].diffuse) * light.diffuse
    assert (found.shades[1, gold]["diffuse"] == expected).all()


def used(world: World, scene: Scene, *wanted: Any) -> list[str]:
    """What a program is told that it has: the other features are 0."""
    options = features_of(world, scene, *wanted).options
    return [option[2:] for option in options if not option.endswith("=0")]


def test_a_program_has_what_its_scene_uses() -> None:
    scene = clrt.load_scene("four-spheres")
    world = pack_world(scene, "robust")
    assert used(world, scene, 16, "bytes") == ["LANES=16", "FILM_BYTES=1", "REFLECTION=1"]
    assert "REFLECTION=1" not in used(world, replace(scene, max_depth=1), 16, "bytes")
    matte = {name: replace(m, reflection=0.0) for name, m in scene.materials.items()}
    dull = replace(scene, materials=matte)
    assert "REFLECTION=1" not in used(pack_world(dull, "robust"), dull, 16, "bytes")
    far = replace(scene, camera=clrt.Camera((0, 0, 99), (0, 0, 0), fov=1.0))
    assert used(world, far, 16, "float") == ["LANES=16", "REFLECTION=1", "LONG_LENS=1"]
    lit = replace(scene, lights=[clrt.Light(scene.spheres[0].center)])
    assert used(pack_world(lit, "double"), lit, 1, "paths") == [
        "LANES=1", "DOUBLE=1", "FILM_PATHS=1", "REFLECTION=1", "LIGHT_INSIDE=1"
    ]  # fmt: skip


def test_passes_take_one_program_whatever_is_lit_and_how() -> None:
    found = set()
    for name in ("first-result", "four-spheres", "lights"):
        scene = replace(clrt.load_scene(name), film=clrt.Film(background=(1, 1, 1)))
        found.add(features_of(pack_world(scene, "robust"), scene, 16, "passes"))
    assert found == {Features(16, "robust", "passes")}


def test_the_arguments_are_the_kernels_in_its_order(device: cl.Device) -> None:
    for uses in (), ("reflection", "tree", "nest", "background", "gather", "lens", "gloss"):
        features = Features(4, "robust", "float", **dict.fromkeys(uses, True))
        scene = trial.scene_for(features)
        given = arguments_of(pack_world(scene, "robust"), scene, 9, 9)
        given |= sampling(features, scene)
        context = cl.Context([device])  # Intel's kernels do not keep theirs
        program = cl.Program(context, kernel_source())
        kernel = program.build(options=[*features.options, "-cl-kernel-arg-info"]).render
        info = cl.kernel_arg_info.NAME
        names = [kernel.get_arg_info(i, info) for i in range(kernel.num_args)]
        assert names == ["film", "first_row", "width", "height", "first_column", *given]


def test_a_world_is_packed_again_only_if_it_changes() -> None:
    scene = clrt.load_scene("four-spheres")
    world = pack_world(scene, "robust")
    assert world.is_of(replace(scene, camera=clrt.Camera((1, 1, 1), (0, 0, 0))))
    assert world.is_of(replace(scene, max_depth=1))
    assert not world.is_of(replace(scene, spheres=scene.spheres[:2]))
    assert not world.is_of(replace(scene, lights=[clrt.Light((0, 0, 0))]))
    name, material = next(iter(scene.materials.items()))
    scene.materials[name] = replace(material, shininess=1.0)  # a dict can be changed where it is
    assert not world.is_of(scene)


LONG = clrt.Camera((0, 0, 1), (0, 0, -7), fov=10)
LINES = replace(LONG, projection="orthographic", fov=None, height=1.0)


@pytest.mark.parametrize("camera", [LONG, LINES], ids=["perspective", "orthographic"])
def test_rays_start_where_all_spheres_say(camera: clrt.Camera, monkeypatch) -> None:
    """Most are left out once one is nearer: those that are beside the picture do not count, nor do
    large ones where rays are lines."""
    random = np.random.default_rng(3)
    center = random.uniform((-3, -3, -9), (3, 3, -5), (500, 3))
    many = clrt.Spheres(center, 10 ** random.uniform(-2, 0.7, 500), "a")
    screen = lens.half_screen(camera, 16, 9)
    starts = set()
    for block in (500, 7, 1):
        monkeypatch.setattr(lens, "BLOCK", block)
        starts.add(float(lens.start(camera, many, clrt.Capsules.of(()), (), screen, np.float64)))
    assert len(starts) == 1


BEAD = Sphere((0, 0, 0), 0.01, "a")
AHEAD = Camera((0, 0, 2), (0, 0, 0))


def _base(camera: Camera, spheres: Sequence[Sphere], samples: int = 64) -> int:
    return base_samples(Scene(camera, (), {"a": Material()}, spheres, samples=samples))


def test_a_spheres_size_is_how_much_of_the_picture_it_takes() -> None:
    """Half a picture is as wide as it is far through a lens of 90 degrees."""
    assert lens.middle_size(AHEAD, [BEAD]) == pytest.approx(0.01 / 2)
    narrow = replace(AHEAD, fov=60)
    assert lens.middle_size(narrow, [BEAD]) == pytest.approx(0.01 / 2 * 3**0.5)
    flat = Camera((0, 0, 2), (0, 0, 0), projection="orthographic", height=9)
    assert lens.middle_size(flat, [BEAD]) == pytest.approx(0.01 / 8)
    near, far, behind = (replace(BEAD, center=(0, 0, z)) for z in (1, -2, 3))
    assert lens.middle_size(AHEAD, [near, BEAD, far]) == pytest.approx(0.01 / 2)
    assert lens.middle_size(AHEAD, [near, behind, behind]) == pytest.approx(0.01)
    assert lens.middle_size(AHEAD, [behind]) == lens.middle_size(AHEAD, []) == math.inf
    many = Spheres(
        np.zeros((5 * lens.LOOKED_AT, 3)), np.geomspace(1e-3, 1e-1, 5 * lens.LOOKED_AT), "a"
    )
    assert lens.middle_size(AHEAD, many) == pytest.approx(0.01 / 2, rel=0.01)


def test_small_spheres_get_more_samples() -> None:
    small, large = [replace(BEAD, radius=x * SMALL * 2) for x in (0.99, 1.01)]
    assert _base(AHEAD, [small]) == SMALLS_BASE > 1
    assert _base(AHEAD, [large]) == _base(AHEAD, []) == 1
    assert _base(AHEAD, [small], samples=3) == 3  # no more than the scene says


def beside_a_far_ball(radius: float) -> Scene:
    """A sphere before the camera, and a ball seen from ten radii away, which is no giant."""
    matte = {"matte": clrt.Material((0.1, 0.1, 0.1), (0.6, 0.6, 0.6), (0, 0, 0), 10)}
    spheres = [
        clrt.Sphere((0.0, 0.0, -10 * radius), radius, "matte"),
        clrt.Sphere((0.3, 0.2, -1.0), 0.4, "matte"),
        clrt.Sphere((0.0, 0.0, -1.0), 1e-9, "matte"),  # a speck
    ]
    camera = clrt.Camera((0, 0, 1), (0, 0, 0))
    return Scene(camera, [clrt.Light((5, 5, 5))], matte, spheres)


@pytest.mark.parametrize("tree", [False, True])
def test_what_is_lost_beside_a_far_ball_is_refused(monkeypatch, tree: bool) -> None:
    """From 1e20 on robust drew pictures that were wrong, then black, and double from 1e160 on."""
    monkeypatch.setattr("clrt.renderer.pack.features.TREE_FROM", 0 if tree else 48)

    def packed(radius: float, precision: Precision) -> None:
        scene = beside_a_far_ball(radius)
        arguments_of(pack_world(scene, precision), scene, 64, 64)

    packed(1e19, "robust")
    with pytest.raises(RequestError, match=r"radius 0.4 and one that .* 1.1e\+21 .*, .* double$"):
        packed(1e20, "robust")
    packed(1e20, "double")
    with pytest.raises(RequestError, match="expected the farthest things nearer"):
        packed(1e162, "double")


def test_a_mesh_that_is_lost_beside_a_far_ball_is_refused() -> None:
    """Of 2^-46 of the scene its shading was off by 3e-5, of 2^-50 nothing was to be seen."""
    places = [(-1.0, -1.0, 0.0), (1, -1, 0), (0, 1, 0)]
    matte = {"matte": Material((0, 0, 0), (1, 1, 1), (0, 0, 0), 1)}

    def packed(size: float, precision: Precision, away: float = 3) -> None:
        mesh = clrt.Mesh(size / 2 * np.array(places), [(0, 1, 2)], material="matte")
        camera = Camera((0, 0, away * size), (0, 0, 0))
        ball = Sphere((0.9, 0, 0), 0.1, "matte")
        scene = Scene(camera, [clrt.Light((5, 5, 5))], matte, [ball], meshes=[mesh])
        arguments_of(pack_world(scene, precision), scene, 64, 64)

    packed(2.0**-46, "robust")
    lost = r"robust cannot show a mesh of size 7\.11e-15 and .* 1\.e\+00 from .* double$"
    with pytest.raises(RequestError, match=lost):
        packed(2.0**-47, "robust")
    packed(2.0**-47, "robust", 3e6)  # a speck
    packed(2.0**-47, "double")
    with pytest.raises(RequestError, match=r"mesh of .* the farthest things nearer"):
        packed(2.0**-356, "double")


def test_vertices_of_no_face_are_nowhere() -> None:
    """They were counted for where orthographic rays start and how large the scene is."""
    places = [(-1.0, -1.0, 0.0), (1, -1, 0), (0, 1, 0), (0, 0, 1e6)]
    mesh = clrt.Mesh(places, [(0, 1, 2)], material="matte")
    camera = Camera((0, 0, 5), (0, 0, 0), projection="orthographic", height=2)
    scenes = [
        Scene(camera, materials={"matte": Material()}, meshes=[one])
        for one in (mesh, clrt.Mesh(places[:3], [(0, 1, 2)], material="matte"))
    ]
    found, expected = (arguments_of(pack_world(one, "robust"), one, 64, 64) for one in scenes)
    assert found["camera"] == expected["camera"]
    assert (found["faces"] == expected["faces"]).all()
