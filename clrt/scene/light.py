"""Lights: the paper's four kinds (section 2). Their colours are linear RGB, lengths world units.

clrt/truth/surface.py has the light that each adds at a hit.
"""

import math
from typing import Literal, TypeAlias, get_args

import msgspec
from msgspec.structs import force_setattr

from clrt.values import WHITE, Color, Vec3, number, require, switches, vectors


class PointLight(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="point"):
    """It shines from a point to all sides (paper, section 2)."""

    position: Vec3
    ambient: Color = WHITE
    diffuse: Color = WHITE
    specular: Color = WHITE
    attenuation: Vec3 = (1.0, 0.0, 0.0)
    """A, B and C of 1 / (A + B D + C D^2), which multiplies diffuse and specular. D: how far away
    the light is, world units."""
    radius: float = 0.0
    """World units. Above 0 the light is a ball, which may be hidden in part."""

    type = property(lambda self: "point")

    def __post_init__(self) -> None:
        vectors(self, "position", "ambient", "diffuse", "specular")
        _attenuation(self)
        _radius(self)

    @property
    def is_round(self) -> bool:
        """Whether its shadows are soft."""
        return self.radius > 0


class DirectionalLight(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="directional"):
    """It is infinitely far away: the same everywhere."""

    direction: Vec3
    """The way that it travels, of any length but 0."""
    ambient: Color = WHITE
    diffuse: Color = WHITE
    specular: Color = WHITE
    half_angle: float = 0.0
    """Degrees below 90. Above 0 the light is a disc in the sky; half the angle that it fills."""

    type = property(lambda self: "directional")

    def __post_init__(self) -> None:
        vectors(self, "direction", "ambient", "diffuse", "specular")
        require(any(self.direction), "direction", "a vector apart from 0", self.direction)
        number(self, "half_angle", "degrees from 0 to below 90", lambda angle: 0 <= angle < 90)

    @property
    def is_round(self) -> bool:
        """Whether its shadows are soft."""
        return self.half_angle > 0


class SpotLight(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="spot"):
    """It shines from a point into a cone."""

    position: Vec3
    look_at: Vec3
    """A point on the cone's axis."""
    ambient: Color = WHITE
    diffuse: Color = WHITE
    specular: Color = WHITE
    attenuation: Vec3 = (1.0, 0.0, 0.0)
    """As a PointLight's."""
    outer_angle: float = 45.0
    """Between the cone's axis and where its light ends, degrees, up to 180."""
    inner_angle: float | None = None
    """To where it is full, degrees; three quarters of outer_angle if it is not given."""
    radius: float = 0.0
    """As a PointLight's."""

    type = property(lambda self: "spot")

    def __post_init__(self) -> None:
        vectors(self, "position", "look_at", "ambient", "diffuse", "specular")
        _attenuation(self)
        apart = self.position != self.look_at
        require(apart, "look_at", "a point apart from position", self.look_at)
        number(self, "outer_angle", "degrees above 0, up to 180", lambda angle: 0 < angle <= 180)
        outer = self.outer_angle
        inner = 0.75 * outer if self.inner_angle is None else self.inner_angle
        force_setattr(self, "inner_angle", inner)
        expected = f"degrees from 0 to outer_angle ({outer})"
        number(self, "inner_angle", expected, lambda angle: 0 <= angle <= outer)
        _radius(self)

    @property
    def is_round(self) -> bool:
        """Whether its shadows are soft."""
        return self.radius > 0


class AmbientLight(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag="ambient"):
    """It reaches every point of every surface alike."""

    ambient: Color = WHITE
    occlusion: bool | Literal["near"] = False
    """Of each point the light comes from where nothing is in the way. "near": a preview of that,
    without noise, by what spheres within four median radii hide each by itself."""
    distance: float = math.inf
    """How far away something can be in the way, world units; infinity: however far."""

    type = property(lambda self: "ambient")

    def __post_init__(self) -> None:
        vectors(self, "ambient")
        if self.occlusion != "near":
            switches(self, "occlusion")
        number(self, "distance", "a number above 0", lambda far: far > 0, finite=False)


Light = PointLight
Shining: TypeAlias = PointLight | DirectionalLight | SpotLight
"""The kinds that cast shadows."""
LightKind: TypeAlias = Shining | AmbientLight
LIGHT_KINDS: tuple[type[LightKind], ...] = get_args(LightKind)


def _attenuation(light: PointLight | SpotLight) -> None:
    vectors(light, "attenuation")
    good = min(light.attenuation) >= 0 and any(light.attenuation)
    require(good, "attenuation", "three numbers, at least 0 and not all 0", light.attenuation)


def _radius(light: PointLight | SpotLight) -> None:
    number(light, "radius", "a finite number, at least 0", lambda radius: radius >= 0)
