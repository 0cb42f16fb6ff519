"""Lights: what they must be, and pictures that must be equal whatever the truth is."""

import numpy as np
import pyopencl as cl
import pytest
from conftest import renderer_for
from hard_cases import BASE, SUN, lit_by
from msgspec.structs import replace

import clrt
from clrt import AmbientLight, DirectionalLight, Light, PointLight, SceneError, SpotLight
from clrt.scene.light import LightKind

SIZE = (150, 100)


def test_kinds() -> None:
    assert Light is PointLight
    assert Light((1, 2, 3)).type == "point"
    assert DirectionalLight((0, -1, 0)).type == "directional"
    assert SpotLight((0, 1, 0), (0, 0, 0)).type == "spot"
    assert AmbientLight().type == "ambient"
    with pytest.raises(AttributeError):
        Light((1, 2, 3)).type = "spot"  # type: ignore[misc]


def test_defaults() -> None:
    spot = SpotLight((0, 1, 0), (0, 0, 0), outer_angle=20)
    assert spot.inner_angle == 15
    assert spot.attenuation == (1, 0, 0)
    assert AmbientLight().ambient == spot.diffuse == (1, 1, 1)
    assert AmbientLight() == AmbientLight(occlusion=False, distance=np.inf)


def test_round_lights() -> None:
    for light in (Light((0, 1, 0)), SpotLight((0, 1, 0), (0, 0, 0))):
        assert not light.is_round
        assert replace(light, radius=1e-9).is_round
    assert not DirectionalLight((0, 1, 0)).is_round
    assert DirectionalLight((0, 1, 0), half_angle=89.9).is_round


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Light((0, 0, 0), attenuation=(0, 0, 0)), "attenuation: expected three numbers"),
        (lambda: Light((0, 0, 0), attenuation=(1, -1, 0)), "attenuation: expected three numbers"),
        (lambda: Light((0, 0, 0), attenuation=(1, np.inf, 0)), "attenuation: expected three fin"),
        (lambda: DirectionalLight((0, 0, 0)), "direction: expected a vector apart from 0"),
        (lambda: SpotLight((1, 0, 0), (1, 0, 0)), "look_at: expected a point apart from position"),
        (lambda: SpotLight((1, 0, 0), (0, 0, 0), outer_angle=0), "outer_angle: expected degrees"),
        (lambda: SpotLight((1, 0, 0), (0, 0, 0), outer_angle=181), "outer_angle: expected degrees"),
        (
            lambda: SpotLight((1, 0, 0), (0, 0, 0), outer_angle=20, inner_angle=30),
            r"inner_angle: expected degrees from 0 to outer_angle \(20.0\), got 30",
        ),
        (lambda: Light((0, 0, 0), radius=-1), "radius: expected a finite number, at least 0, got"),
        (lambda: Light((0, 0, 0), radius=np.inf), "radius: expected a finite number, at least 0"),
        (lambda: SpotLight((1, 0, 0), (0, 0, 0), radius=np.nan), "radius: expected a finite num"),
        (
            lambda: DirectionalLight((0, 1, 0), half_angle=90),
            "half_angle: expected degrees from 0 to below 90, got 90",
        ),
        (lambda: DirectionalLight((0, 1, 0), half_angle=-1), "half_angle: expected degrees from"),
        (lambda: AmbientLight(distance=0), "distance: expected a number above 0, got 0"),
        (lambda: AmbientLight(distance=np.nan), "distance: expected a number above 0, got nan"),
        (
            lambda: AmbientLight(distance="far"),  # type: ignore[arg-type]
            "distance: expected a number above 0, got 'far'",
        ),
        (
            lambda: AmbientLight(occlusion=1),  # type: ignore[arg-type]
            "occlusion: expected true or false, got 1",
        ),
        (
            lambda: AmbientLight([1, 2]),  # type: ignore[arg-type]
            "ambient: expected three finite numbers",
        ),
        (
            lambda: clrt.Scene(BASE.camera, [1]),  # type: ignore[list-item]
            r"lights\[0\]: expected a light, got 1",
        ),
    ],
)
def test_bad_values(make, said: str) -> None:
    with pytest.raises(SceneError, match=said):
        make()


def picture(device: cl.Device, scene: clrt.Scene, precision="robust") -> np.ndarray:
    return renderer_for(device, 16, precision).render(scene, *SIZE)


SPOT = SpotLight((0.3, 1.4, 0.2), (-0.1, -0.2, -0.4), outer_angle=25)
EQUAL: dict[str, tuple[tuple[LightKind, ...], ...]] = {
    # A program with attenuation, of lights that do not use it.
    "attenuation 1 0 0": (
        (SUN, Light((9, 9, 9), attenuation=(0, 0, 1), ambient=(0, 0, 0), diffuse=(0, 0, 0),
                    specular=(0, 0, 0))),
        (SUN, Light((9, 9, 9), ambient=(0, 0, 0), diffuse=(0, 0, 0), specular=(0, 0, 0))),
    ),
    "spot of 180 degrees": (
        (SpotLight(SUN.position, (0, 0, 0), outer_angle=180, inner_angle=180),), (SUN,)
    ),
    "spot of 179.99 degrees": (
        (SpotLight(SUN.position, (0, 0, 0), outer_angle=180, inner_angle=179.99),), (SUN,)
    ),
    "a point light beside a spot": ((SUN, replace(SPOT, look_at=(9, 9, 9))), (SUN,)),
    "two ambient lights": (
        (AmbientLight((0.25, 0.5, 0)), SUN, AmbientLight((0.5, 0.25, 1))),
        (SUN, AmbientLight((0.75, 0.75, 1))),
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", EQUAL)
@pytest.mark.parametrize("precision", ["robust", "double"])
def test_equal_to_the_bit(device: cl.Device, name: str, precision) -> None:
    one, other = (picture(device, lit_by(*lights), precision) for lights in EQUAL[name])
    assert one.any()
    assert (one == other).all()


def test_a_directional_light_is_a_point_very_far_away(device: cl.Device) -> None:
    direction = (-0.3, -0.6, -0.2)
    x, y, z = direction
    far = (-1e200 * x, -1e200 * y, -1e200 * z)
    one, other = lit_by(DirectionalLight(direction)), lit_by(Light(far))
    assert abs(picture(device, one) - picture(device, other)).max() < 1e-6


def test_attenuation_leaves_the_ambient_part(device: cl.Device) -> None:
    one = lit_by(Light((5, 5, 5), attenuation=(0, 0, 1e30)))
    other = lit_by(Light((5, 5, 5), diffuse=(0, 0, 0), specular=(0, 0, 0)))
    assert abs(picture(device, one) - picture(device, other)).max() < 1e-6


def test_a_spot_is_full_inside_and_dark_outside(device: cl.Device) -> None:
    """Looked at from the lamp itself the cone is a disc, and its edge is where the tangents say."""
    plane = clrt.Spheres([[0, 0, -1e6 - 1.0]], 1e6, "white")
    lamp = SpotLight((0, 0, 0), (0, 0, -1), diffuse=(0, 0, 0), specular=(0, 0, 0),
                     outer_angle=30, inner_angle=20)  # fmt: skip
    white = clrt.Material(ambient=(1, 1, 1))
    camera = clrt.Camera((0, 0, 0), (0, 0, -1))
    scene = clrt.Scene(camera, [lamp], {"white": white}, plane)
    row = renderer_for(device, 16).render(scene, 1001, 1)[0, :, 0]
    angle = np.degrees(np.arctan(abs(np.linspace(-1, 1, 1001))))
    assert (row[angle < 19.999] == 1).all()
    assert (row[angle > 30.001] == 0).all()
    t = (np.cos(np.radians(angle)) - np.cos(np.radians(30))) / (
        np.cos(np.radians(20)) - np.cos(np.radians(30))
    )
    expected = np.clip(t, 0, 1) ** 2 * (3 - 2 * np.clip(t, 0, 1))
    assert abs(row - expected).max() < 1e-5


def test_a_path_goes_on_in_the_shadow_of_an_ambient_light(device: cl.Device) -> None:
    """In a mirror that no other light reaches."""
    shadowed = lit_by(Light((0.0, -5000.0, 0.0)))  # inside the plane
    assert not picture(device, shadowed).any()
    lit = lit_by(AmbientLight(), *shadowed.lights)
    deep, flat = picture(device, lit), picture(device, replace(lit, max_depth=1))
    assert (deep >= flat).all()
    assert (deep > flat).any()
