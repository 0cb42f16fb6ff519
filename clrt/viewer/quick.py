"""Quick: how scenes look before the last picture of them is there."""

from collections.abc import Callable

import numpy as np
from msgspec.structs import replace

from clrt.film.color import to_linear
from clrt.renderer.pack.features import ENOUGH
from clrt.scene.light import AmbientLight, LightKind
from clrt.scene.scene import Scene
from clrt.values import Array

MOST_SKY = 2.0
"""What sky_of() says at most: where near spheres hide nearly all of a sky, nothing can be told."""


def quick(scene: Scene, sky: float | None = None) -> Scene:
    """A scene with less noise than its samples leave: filtered, and while it moves with the closed
    form of what near spheres hide, which has none.

    sky: what the closed form is multiplied by, see sky_of(); None: at rest, or not known yet.
    """
    scene = replace(scene, film=replace(scene.film, denoise=scene.samples < ENOUGH))
    if sky is None or not has_closed_form(scene):
        return scene
    return replace(scene, lights=tuple(_near(light, sky) for light in scene.lights))


def has_closed_form(scene: Scene) -> bool:
    """Whether it looks otherwise while it moves."""
    hides = any(isinstance(light, AmbientLight) and light.occlusion for light in scene.lights)
    return hides and not len(scene.capsules) and not scene.meshes


def sky_of(scene: Scene, picture: Callable[[Scene], Array]) -> float:
    """What to multiply the closed form by, so that a scene is as bright while it moves as at rest.

    Near spheres hide less than all, or more where they overlap: no form of them fits both
    (benchmarks/NOTES.md).

    picture: makes a small 8-bit one of a scene.
    """
    scene = replace(scene, samples=1)
    rest, moving, dark = (
        _brightness(picture(quick(scene, sky)), scene.film.transfer) for sky in (None, 1.0, 0.0)
    )
    if moving <= dark:
        return 1.0
    return min(max((rest - dark) / (moving - dark), 0.0), MOST_SKY)


def _near(light: LightKind, sky: float) -> LightKind:
    if isinstance(light, AmbientLight) and light.occlusion:
        red, green, blue = light.ambient
        return replace(light, occlusion="near", ambient=(sky * red, sky * green, sky * blue))
    return light


def _brightness(picture: Array, transfer: str) -> float:
    """The mean of an 8-bit picture, linear."""
    parts = np.arange(256) / 255
    return float((to_linear(parts) if transfer == "srgb" else parts)[picture].mean())
