"""How scenes look before the last picture is there."""

from msgspec.structs import replace

import clrt
from clrt.viewer.quick import quick


def test_less_noise() -> None:
    sky, key = clrt.AmbientLight(occlusion=True, distance=2.0), clrt.Light((1, 2, 3))
    scene = replace(clrt.load_scene("four-spheres"), lights=(key, sky), shadow_bias=0.0, samples=4)
    moving = quick(scene, moves=True)
    assert moving.lights == (key, replace(sky, occlusion="near"))
    assert moving.film.denoise
    assert not moving.is_random
    assert quick(scene, moves=False) == replace(scene, film=replace(scene.film, denoise=True))
    assert quick(replace(scene, samples=16), moves=False) == replace(scene, samples=16)
    rod = clrt.Capsule((0, 0, 0), (1, 0, 0), 0.1, next(iter(scene.materials)))
    assert quick(replace(scene, capsules=(rod,)), moves=True).is_random
