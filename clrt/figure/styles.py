"""Styles: the lights and surfaces of figures. docs/styles.md has the same table.

A figure that was published must be made again: whoever changes a style gives the table a new
version.
"""

from typing import NamedTuple

from msgspec.structs import replace

from clrt.errors import RequestError
from clrt.scene.camera import Camera
from clrt.scene.light import AmbientLight, DirectionalLight, LightKind
from clrt.scene.material import Material
from clrt.scene.scene import Scene
from clrt.values import BLACK, Color, Vec3, did_you_mean

KEY: Vec3 = (0.6, -0.8, -2.0)
"""The way that the key light travels, from the upper left: right, up and back of the camera."""


class Style(NamedTuple):
    """A row of the table."""

    material: Material
    outline: float = 0.0
    """Pixels."""
    half_angle: float = 0.0
    """Of the key light, degrees."""
    reach: float = 0.0
    """How far away spheres hide the ambient light, in extents of the figure; 0: they do not."""
    balls: bool = False
    """Particles are small, and have their bonds: see clrt.ParticleFile."""


def _surface(ambient: float, diffuse: float, **more: float | Color) -> Material:
    return Material((ambient,) * 3, (diffuse,) * 3, **more)  # type: ignore[arg-type]


STYLES = {
    "soft": Style(_surface(0.5, 0.5), half_angle=10.0, reach=0.25),
    "matte": Style(_surface(0.3, 0.7)),
    "outline": Style(_surface(0.4, 0.6), outline=1.0),
    "mirror": Style(_surface(0.1, 0.7, specular=(1.0, 1.0, 1.0), shininess=100.0, reflection=0.5)),
    "ball-and-stick": Style(_surface(0.5, 0.5), half_angle=10.0, reach=0.25, balls=True),
}


def style(name: str) -> Style:
    """A row of the table.

    Raises:
        RequestError: there is none of this name.
    """
    if name not in STYLES:
        expected = f"expected one of {', '.join(STYLES)}, got {name!r}{did_you_mean(name, STYLES)}"
        raise RequestError(f"style: {expected}")
    return STYLES[name]


def lights(style: Style, camera: Camera, extent: float) -> tuple[LightKind, ...]:
    """The key light and the fill light, fixed to the camera.

    extent: of the figure, world units.
    """
    key = _key(camera, style.half_angle)
    if style.reach == 0:
        return key, AmbientLight()
    return key, AmbientLight(occlusion=True, distance=style.reach * extent)


def seen_by(figure: Scene, camera: Camera) -> Scene:
    """A figure with another camera, and its lights fixed to that."""
    key, *rest = figure.lights
    assert isinstance(key, DirectionalLight)
    return replace(figure, camera=camera, lights=(_key(camera, key.half_angle), *rest))


def _key(camera: Camera, half_angle: float) -> DirectionalLight:
    way = zip(*camera.basis(), strict=True)
    x, y, z = (sum(part * of for part, of in zip(axis, KEY, strict=True)) for axis in way)
    return DirectionalLight((x, y, z), ambient=BLACK, half_angle=half_angle)
