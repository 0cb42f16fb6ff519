"""Scenes built in Python check themselves."""

# What is refused, and sequences that are taken, have other types than the fields.
# mypy: disable-error-code="arg-type, dict-item, list-item"

import math

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from clrt.scene.scene import beyond_one_ray, beyond_paper

RED = clrt.Material((0.1, 0, 0), (0.7, 0, 0), (1, 1, 1), shininess=100)
CAMERA = clrt.Camera((0, 0, 1), (0, 0, 0))


def test_built_in_python_equals_read_from_file() -> None:
    red = clrt.Material((0.1, 0, 0), (0.7, 0, 0), (1, 1, 1), 100)
    first = clrt.load_scene("first-result")
    assert first.materials["red"] == red
    assert first.spheres[0] == clrt.Sphere((-0.2, 0, -1), 0.7, "red")
    assert first.camera == CAMERA


def test_is_frozen() -> None:
    with pytest.raises(AttributeError):
        CAMERA.fov = 50  # type: ignore[misc]


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: clrt.Sphere((0, 0, 0), 0, "red"), "radius: expected a finite number above 0"),
        (lambda: clrt.Sphere((0, 0, 0), math.inf, "red"), "radius"),
        (lambda: clrt.Sphere((0, math.nan, 0), 1, "red"), "center"),
        (lambda: clrt.Sphere((0, 0), 1, "red"), "center: expected three"),
        (lambda: clrt.Light((0, 0, -math.inf)), "position"),
        (lambda: replace(RED, reflection=1.5), "reflection"),
        (lambda: replace(RED, shininess=-1.0), "shininess"),
        (lambda: replace(RED, roughness=1.5), "roughness: expected a number from 0 to 1, got 1.5"),
        (lambda: replace(RED, roughness=math.nan), "roughness: expected a number from 0 to 1"),
        (lambda: replace(RED, fresnel=1), "fresnel: expected true or false, got 1"),
        (lambda: clrt.Camera((0, 0, 1), (0, 0, 1)), "look_at"),
        (lambda: clrt.Camera((0, 0, 1), (0, 0, 0), up=(0, 0, 2)), "up"),
        (lambda: clrt.Camera((0, 0, 1), (0, 0, 0), fov=180), "fov"),
        (lambda: clrt.Camera((0, 0, 1), (0, 0, 0), up=(0, 0, 0)), "up"),
        (lambda: clrt.Camera((0, 0, 1e308), (0, 0, -1e308)), "look_at: expected a point less than"),
        (
            lambda: clrt.Camera((0, 0, 1), (0, 0, 0), aperture_radius=-0.1, focus_distance=1),
            "aperture_radius: expected a finite number, at least 0, got -0.1",
        ),
        (
            lambda: clrt.Camera((0, 0, 1), (0, 0, 0), aperture_radius=0.1),
            "focus_distance: expected a finite number above 0, which aperture_radius needs, got No",
        ),
        (
            lambda: clrt.Camera((0, 0, 1), (0, 0, 0), focus_distance=0),
            "focus_distance: expected a finite number above 0, got 0",
        ),
        (
            lambda: clrt.Camera((0, 0, 1), (0, 0, 0), aperture_radius=1, focus_distance=math.inf),
            "focus_distance: expected a finite number above 0, got inf",
        ),
        (
            lambda: clrt.Camera(
                *((0, 0, 1), (0, 0, 0)), projection="orthographic", height=1, aperture_radius=0.1
            ),
            "aperture_radius: expected 0 with projection 'orthographic', got 0.1",
        ),
        (lambda: clrt.Camera((0, 0, 1), "abc"), "look_at: expected three finite numbers"),
        (lambda: clrt.Camera((0, 0, 1), 5), "look_at: expected three finite numbers"),
        (lambda: clrt.Camera((0, 0, 1), (0, 0, 10**400)), "look_at: expected three"),
        (lambda: clrt.Camera((0, 0, 1), (0, 0, 0), fov="90"), "fov: expected degrees"),
        (lambda: clrt.Sphere((0, 0, 0), None, "red"), "radius: expected a finite number"),
        (lambda: clrt.Film(background=(1, 1)), "background: expected three finite numbers"),
        (lambda: clrt.Film(outline_color="red "), "outline_color: expected three finite"),
        (lambda: clrt.Film(transparent=1), "transparent: expected true or false, got 1"),
        (lambda: clrt.Film(denoise="yes"), "denoise: expected true or false, got 'yes'"),
        (lambda: clrt.Film(transfer="gamma"), "transfer: expected 'linear' or 'srgb', got 'gamma'"),
        (lambda: clrt.Film(outline=-1), "outline: expected a number from 0 to 100, got -1"),
        (lambda: clrt.Film(outline=101), "outline: expected a number from 0 to 100"),
        (lambda: clrt.Film(depth_cue=(2, 1)), "depth_cue: expected two finite numbers, the first"),
        (lambda: clrt.Film(depth_cue=(1, 1)), "depth_cue: expected two finite numbers"),
        (lambda: clrt.Film(depth_cue=(1, math.inf)), "depth_cue: expected two finite numbers"),
        (lambda: clrt.Film(depth_cue=5), "depth_cue: expected two finite numbers"),
        (lambda: clrt.Film(colorbar=5), "colorbar: expected a line of text, got 5"),
        (lambda: clrt.Film(colorbar="a\nb"), "colorbar: expected a line of text"),
        (lambda: clrt.Film(colorbar_cmap="jett"), "^colorbar_cmap: expected one of viridis"),
        (lambda: clrt.Film(colorbar_cmap=["turbo"]), "colorbar_cmap: expected the name of a col"),
        (lambda: clrt.Film(colorbar_clim=(2, 1)), "^colorbar_clim: expected two finite numbers"),
        (lambda: clrt.Film(colorbar_clim=(0, math.nan)), "colorbar_clim: expected two finite"),
        (lambda: clrt.Film(legend=[("H", (1, 1, 1))]), r"legend\[0\]: expected a LegendEntry, got"),
        (lambda: clrt.LegendEntry("H", 5), "color: expected three finite numbers, got 5"),
        (lambda: clrt.LegendEntry(1, (1, 1, 1)), "name: expected a line of text, got 1"),
        (lambda: clrt.Film(cells=5), "cells: expected a Cell, got 5"),
        (lambda: clrt.Cell(((1, 0, 0), (0, 1, 0))), "edges: expected three rows of three finite"),
        (lambda: clrt.Cell(((1, 0, 0), (0, 1, 0), (0, 0))), "edges: expected three rows of three"),
        (lambda: clrt.Cell(np.full((3, 3), np.inf)), "edges: expected three rows of three finite"),
        (lambda: clrt.Cell("abc"), "edges: expected three rows of three finite numbers"),
        (lambda: clrt.Cell(np.eye(3), (0, 1)), "origin: expected three finite numbers"),
        (
            lambda: clrt.Scene(CAMERA, film=clrt.Film(colorbar="speed")),
            "film.colorbar_clim: expected two numbers beside colorbar, got None",
        ),
        (lambda: clrt.Scene(CAMERA, film=5), "film: expected a Film, got 5"),
        (lambda: clrt.Animation(5, (), interpolation="cubic"), "interpolation: expected"),
        (lambda: clrt.Key(-1), "frame: expected a whole number from 0"),
        (lambda: clrt.Key("a"), "frame: expected a whole number from 0"),
        (lambda: clrt.Animation(2.5, ()), "frames: expected a whole number from 1"),
        (lambda: clrt.Scene(CAMERA, max_depth=0), "max_depth: expected a whole number from 1 to"),
        (lambda: clrt.Scene(CAMERA, max_depth=1001), "max_depth"),
        (lambda: clrt.Scene(CAMERA, max_depth=2.5), "max_depth"),
        (lambda: clrt.Scene(CAMERA, shadow_bias=-1e-5), "shadow_bias"),
        (lambda: clrt.Scene(CAMERA, samples=0), "samples: expected a whole number from 1 to 65536"),
        (lambda: clrt.Scene(CAMERA, samples=65537), "samples: expected a whole number from 1 to"),
        (lambda: clrt.Scene(CAMERA, samples=4.0), "samples: expected a whole number from 1 to"),
        (lambda: clrt.Scene(CAMERA, indirect=1), "indirect: expected true or false, got 1"),
        (
            lambda: clrt.Scene(CAMERA, spheres=(clrt.Sphere((0, 0, 0), 1, "blue"),)),
            r"spheres\[0\].material: expected the name of a material",
        ),
        (lambda: clrt.Scene(camera=5), "camera: expected a Camera, got 5"),
        (lambda: clrt.Scene(CAMERA, lights=[5]), r"lights\[0\]: expected a light, got 5"),
        (lambda: clrt.Scene(CAMERA, spheres=7), "spheres: expected a Sphere, got 7"),
        (lambda: clrt.Scene(CAMERA, materials=[RED]), "materials: expected a dict of names and"),
        (lambda: clrt.Scene(CAMERA, materials={"a": 1}), "materials.a: expected a Material, got 1"),
        (lambda: clrt.Scene(CAMERA, animation=3), "animation: expected an Animation"),
        (lambda: clrt.Animation(5, [1, 2]), r"keys\[0\]: expected a Key"),
        (lambda: clrt.Sphere((0, 0, 0), 1, material=5), "material: expected a material's name"),
    ],
)
def test_refuses(make, said: str) -> None:
    with pytest.raises(clrt.SceneError, match=said):
        make()


BALL = clrt.Light((0, 9, 0), radius=1)
LENS = replace(CAMERA, aperture_radius=0.1, focus_distance=2)
SKY = clrt.AmbientLight(occlusion=True)
FOG = replace(RED, reflection=0.5, roughness=0.1)
PANE = clrt.Material(transmission=0.9, fresnel=True, roughness=0.1)


@pytest.mark.parametrize(
    ("lights", "indirect", "said"),
    [
        ([clrt.AmbientLight(), BALL], False, r"radius of lights\[1\]"),
        ([clrt.SpotLight((0, 1, 0), (0, 0, 0), radius=0.1)], False, r"radius of lights\[0\]"),
        ([clrt.DirectionalLight((0, 1, 0), half_angle=1)], False, r"half_angle of lights\[0\]"),
        ([SKY], False, r"occlusion of lights\[0\]"),
        ([], True, "indirect"),
    ],
)
def test_no_shadow_bias_where_light_is_spread(lights, indirect: bool, said: str) -> None:
    scene = clrt.Scene(CAMERA, lights, indirect=indirect)
    with pytest.raises(clrt.SceneError, match=f"shadow_bias: expected 0 beside {said}, got 1e-05"):
        replace(scene, shadow_bias=1e-5)


@pytest.mark.parametrize(
    ("changes", "random", "key"),
    [
        ({}, False, None),
        ({"shadow_bias": 1e-5}, False, None),
        ({"samples": 2}, False, "samples > 1"),
        ({"lights": (BALL,)}, False, "radius of lights[0]"),  # it has a closed form
        ({"lights": (BALL, SKY)}, True, "radius of lights[0]"),
        ({"lights": (clrt.AmbientLight(distance=1), SKY)}, True, "occlusion of lights[1]"),
        ({"lights": (clrt.AmbientLight(distance=1),)}, False, None),
        ({"camera": LENS}, True, "aperture_radius of camera"),
        ({"camera": replace(CAMERA, focus_distance=2)}, False, None),
        ({"materials": {"a": RED, "fog": FOG}}, True, "roughness of materials.fog"),
        ({"materials": {"fog": FOG}, "max_depth": 1}, False, "roughness of materials.fog"),
        ({"materials": {"a": replace(FOG, reflection=0)}}, False, "roughness of materials.a"),
        ({"materials": {"pane": PANE}}, True, "transmission of materials.pane"),
        (
            {"materials": {"pane": replace(PANE, fresnel=False)}},
            False,
            "transmission of materials.pane",
        ),
        ({"indirect": True}, True, "indirect"),
        ({"indirect": True, "max_depth": 1}, False, "indirect"),
        ({"film": clrt.Film(denoise=True)}, False, None),
    ],
)
def test_what_spreads_rays_and_what_the_paper_does_not_know(changes, random: bool, key) -> None:
    scene = replace(clrt.Scene(CAMERA), **changes)
    assert scene.is_random == random
    assert beyond_paper(scene) == key
    # Glass and samples are no matter of directions.
    only = {"samples > 1": None, "transmission of materials.pane": "roughness of materials.pane"}
    assert beyond_one_ray(scene) == only.get(key, key)


def test_of_many_names_a_few_are_told() -> None:
    many = {f"m{i}": RED for i in range(20_000)}
    with pytest.raises(clrt.SceneError) as error:
        clrt.Scene(CAMERA, materials=many, spheres=[clrt.Sphere((0, 0, 0), 1, "x" * 9999)])
    assert "('m0', 'm1', 'm2', 'm3', 'm4', 19995 more), got" in str(error.value)
    assert len(str(error.value)) < 300


def test_any_sequence_of_spheres_and_lights() -> None:
    sphere = clrt.Sphere((0, 0, 0), 1, "red")
    scene = clrt.Scene(CAMERA, [clrt.Light((0, 9, 0))], {"red": RED}, spheres=[sphere])
    assert scene.spheres == (sphere,)


def test_any_three_numbers_are_a_vector() -> None:
    camera = clrt.Camera([0, 0, 1], np.zeros(3, np.float32), fov=np.float32(90))
    assert camera == CAMERA
    assert all(type(x) is float for x in (*camera.position, *camera.look_at, camera.fov))


@pytest.mark.parametrize("size", [5e-324, 1e-300, 1e300])
def test_a_cameras_vectors_can_be_of_any_length(size: float) -> None:
    camera = clrt.Camera((0, 0, size), (0, 0, 0), up=(0, size, 0))
    assert camera.basis() == CAMERA.basis()


def test_camera_basis_is_orthonormal_and_right_handed() -> None:
    camera = clrt.Camera((1, 2, 3), (-4, 0.5, 2), up=(0.1, 1, 0.3))
    right, up, back = camera.basis()
    cross = (
        right[1] * up[2] - right[2] * up[1],
        right[2] * up[0] - right[0] * up[2],
        right[0] * up[1] - right[1] * up[0],
    )
    assert cross == pytest.approx(back, abs=1e-15)
    assert [math.hypot(*v) for v in (right, up, back)] == pytest.approx([1, 1, 1], abs=1e-15)
