"""How scenes look before the last picture is there."""

import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from clrt.film.color import to_srgb
from clrt.viewer.quick import MOST_SKY, quick, sky_of

FOUR = replace(clrt.load_scene("four-spheres"), shadow_bias=0.0)


def test_less_noise() -> None:
    sky, key = clrt.AmbientLight(occlusion=True, distance=2.0), clrt.Light((1, 2, 3))
    scene = replace(FOUR, lights=(key, sky), samples=4)
    moving = quick(scene, sky=1.0)
    assert moving.lights == (key, replace(sky, occlusion="near"))
    assert moving.film.denoise
    assert not moving.is_random
    assert quick(scene) == replace(scene, film=replace(scene.film, denoise=True))
    assert quick(replace(scene, samples=16)) == replace(scene, samples=16)
    rod = clrt.Capsule((0, 0, 0), (1, 0, 0), 0.1, next(iter(scene.materials)))
    assert quick(replace(scene, capsules=(rod,)), sky=1.0).is_random


@pytest.mark.parametrize(
    ("open_sky", "expected"),
    [(0.8, 0.625), (0.5, 1.0), (0.3, 1.0 / 0.6), (0.1, MOST_SKY), (0.0, 1.0)],
)
def test_as_bright_while_it_moves(open_sky: float, expected: float) -> None:
    """Of a sky that is half open, what near spheres leave open. A lamp shines as well."""
    sky = clrt.AmbientLight((0.5, 0.5, 0.5), occlusion=True)
    scene = replace(FOUR, lights=(clrt.Light((1, 2, 3)), sky))

    def picture(scene: clrt.Scene) -> np.ndarray:
        assert scene.samples == 1
        _, sky = scene.lights
        assert isinstance(sky, clrt.AmbientLight)
        part = 0.5 if sky.occlusion is True else open_sky
        linear = np.array([0.1, 0.4]) + part * sky.ambient[0]
        return np.rint(255 * to_srgb(linear)).astype(np.uint8)

    srgb = replace(scene, film=replace(scene.film, transfer="srgb"))
    assert sky_of(srgb, picture) == pytest.approx(expected, abs=0.02)


def test_a_sky_of_its_own() -> None:
    sky = clrt.AmbientLight((0.5, 0.4, 0.3), occlusion=True)
    scene = replace(FOUR, lights=(sky, clrt.AmbientLight()))
    dimmed, other = quick(scene, sky=0.5).lights
    assert dimmed == clrt.AmbientLight((0.25, 0.2, 0.15), occlusion="near")
    assert other == clrt.AmbientLight()
