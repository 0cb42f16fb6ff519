"""Camera: where a picture is taken from."""

import math
from typing import Literal

import msgspec
from msgspec.structs import force_setattr

from clrt.values import (
    Vec3,
    number,
    require,
    vectors,
)

LENSES = {"perspective": "fov", "orthographic": "height"}
"""The key that says how much of the world a camera sees."""

CAMERA_VECTORS = ("position", "look_at", "up")
"""The vectors that an animation's key can give, beside the number that LENSES names."""


class Camera(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the picture is taken from.

    "perspective": all rays start at `position`, and the screen stands one unit ahead.
    "orthographic": all rays go along the view, from before everything: nothing is behind the
    camera, and it is inside nothing.
    """

    position: Vec3
    look_at: Vec3
    up: Vec3 = (0.0, 1.0, 0.0)
    fov: float | None = None
    """Perspective: horizontal, degrees, between 0 and 180; 90 if it is not given."""
    projection: Literal["perspective", "orthographic"] = "perspective"
    height: float | None = None
    """Orthographic: the height of the part of the world that the picture shows, world units."""
    aperture_radius: float = 0.0
    """Perspective: radius of the lens, world units. Above 0 only points at focus_distance are
    sharp."""
    focus_distance: float | None = None
    """How far along the view the plane is that is in focus, world units."""

    def __post_init__(self) -> None:
        vectors(self, "position", "look_at", "up")
        good = self.projection in LENSES
        require(good, "projection", "'perspective' or 'orthographic'", self.projection)
        for projection, key in LENSES.items():
            if projection != self.projection:
                good = getattr(self, key) is None
                expected = f"none, which goes with projection {projection!r} only"
                require(good, key, expected, getattr(self, key))
        if self.orthographic:
            number(self, "height", "a finite number above 0", lambda height: height > 0)
        else:
            force_setattr(self, "fov", 90.0 if self.fov is None else self.fov)
            number(self, "fov", "degrees between 0 and 180", lambda fov: 0 < fov < 180)
        number(self, "aperture_radius", "a finite number, at least 0", lambda radius: radius >= 0)
        if self.has_lens:
            expected = "0 with projection 'orthographic'"
            require(not self.orthographic, "aperture_radius", expected, self.aperture_radius)
        if self.has_lens or self.focus_distance is not None:
            needed = ", which aperture_radius needs" if self.focus_distance is None else ""
            expected = f"a finite number above 0{needed}"
            number(self, "focus_distance", expected, lambda distance: distance > 0)
        ahead = _minus(self.look_at, self.position)
        require(any(ahead), "look_at", "a point apart from position", self.look_at)
        good = all(map(math.isfinite, ahead))
        require(good, "look_at", "a point less than 1.8e308 from position", self.look_at)
        ahead, up = _near_one(ahead), _near_one(self.up)
        # The sine of the angle between them; below 1e-9 float64 cannot tell where right is.
        good = math.hypot(*_cross(ahead, up)) > 1e-9 * math.hypot(*ahead) * math.hypot(*up)
        require(good, "up", "a direction not parallel to look_at - position", self.up)

    @property
    def orthographic(self) -> bool:
        return self.projection == "orthographic"

    @property
    def has_lens(self) -> bool:
        """Whether points out of focus are blurred."""
        return self.aperture_radius > 0

    def basis(self) -> tuple[Vec3, Vec3, Vec3]:
        """The unit vectors right, up and back (against the view), in world space."""
        back = _unit(_minus(self.position, self.look_at))
        right = _unit(_cross(_near_one(self.up), back))
        return right, _cross(back, right), back


def _minus(a: Vec3, b: Vec3) -> Vec3:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _cross(a: Vec3, b: Vec3) -> Vec3:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _near_one(a: Vec3) -> Vec3:
    """Scaled by a power of two, which is exact, so that products stay in range."""
    _, exponent = math.frexp(max(map(abs, a)))
    return math.ldexp(a[0], -exponent), math.ldexp(a[1], -exponent), math.ldexp(a[2], -exponent)


def _unit(a: Vec3) -> Vec3:
    a = _near_one(a)
    length = math.hypot(*a)
    return a[0] / length, a[1] / length, a[2] / length
