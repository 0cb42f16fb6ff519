"""Material: how a surface answers light."""

from typing import Literal

import msgspec

from clrt.values import (
    BLACK,
    WHITE,
    Color,
    number,
    require,
    switches,
    vectors,
)


class Material(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a surface answers light (paper, section 11.8)."""

    ambient: Color = BLACK
    diffuse: Color = WHITE
    specular: Color = BLACK
    shininess: float = 100.0
    """At least 0. Blinn-Phong's alpha: the exponent is a quarter of it. Phong's exponent."""
    reflection: float = 0.0
    """The part of the mirrored light that is added, in [0, 1]."""
    highlight: Literal["blinn-phong", "phong"] = "blinn-phong"
    transmission: float = 0.0
    """The part of the light that goes through, in [0, 1]. reflection + transmission <= 1."""
    ior: float = 1.5
    """Index of refraction inside, 1 to 10."""
    fresnel: bool = False
    """Of the transmission the part that Fresnel's formulas say is mirrored."""
    roughness: float = 0.0
    """Of the mirrored ray only, in [0, 1]: the sine of the half angle of a cone about it. Rays are
    drawn uniformly over the cone's cap; those that would go into the surface are mirrored at it."""

    opacity: float = 1.0
    """The part of its light that a surface gives, in [0, 1]. A ray goes on straight with the rest
    of its weight. Below 1 it neither mirrors nor transmits."""

    def __post_init__(self) -> None:
        good = self.highlight in ("blinn-phong", "phong")
        require(good, "highlight", "'blinn-phong' or 'phong'", self.highlight)
        vectors(self, "ambient", "diffuse", "specular")
        number(self, "shininess", "a finite number, at least 0", lambda alpha: alpha >= 0)
        number(self, "reflection", "a number from 0 to 1", lambda part: 0 <= part <= 1)
        number(self, "transmission", "a number from 0 to 1", lambda part: 0 <= part <= 1)
        both = self.reflection + self.transmission
        expected = f"at most 1 - reflection ({1 - self.reflection:g})"
        require(both <= 1 + 1e-12, "transmission", expected, self.transmission)
        number(self, "ior", "a number from 1 to 10", lambda ior: 1 <= ior <= 10)
        switches(self, "fresnel")
        number(self, "roughness", "a number from 0 to 1", lambda sine: 0 <= sine <= 1)
        number(self, "opacity", "a number from 0 to 1", lambda part: 0 <= part <= 1)
        for key in ("transmission", "reflection"):
            require(
                self.opacity == 1 or getattr(self, key) == 0,
                "opacity",
                f"1 beside {key}",
                self.opacity,
            )

    @property
    def is_glossy(self) -> bool:
        """Whether it mirrors, into a cone."""
        mirrors = self.reflection > 0 or (self.fresnel and self.transmission > 0)
        return mirrors and self.roughness > 0
