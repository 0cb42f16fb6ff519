"""Quick: how scenes look before the last picture of them is there."""

from msgspec.structs import replace

from clrt.renderer.pack.features import ENOUGH
from clrt.scene.light import AmbientLight, LightKind
from clrt.scene.scene import Scene


def quick(scene: Scene, *, moves: bool) -> Scene:
    """A scene with less noise than its samples leave: filtered, and while it moves with the closed
    form of what near spheres hide, which has none."""
    film = replace(scene.film, denoise=scene.samples < ENOUGH)
    if not moves or len(scene.capsules) or scene.meshes:
        return replace(scene, film=film)
    return replace(scene, film=film, lights=tuple(map(_near, scene.lights)))


def _near(light: LightKind) -> LightKind:
    if isinstance(light, AmbientLight) and light.occlusion:
        return replace(light, occlusion="near")
    return light
