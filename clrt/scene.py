"""What a scene is.

The classes mirror the scene file table by table (README, "Scenes"). They check their values
whoever makes them: a file or Python code. Lengths are in world units, colours linear RGB.
"""

import math
from collections.abc import Iterable
from typing import Literal, TypeAlias

import msgspec

Vec3: TypeAlias = tuple[float, float, float]
Color: TypeAlias = tuple[float, float, float]

WHITE: Color = (1.0, 1.0, 1.0)


def _require(good: bool, key: str, expected: str, value: object) -> None:
    if not good:
        raise ValueError(f"{key}: expected {expected}, got {value!r}")


def _finite(struct: msgspec.Struct, keys: Iterable[str]) -> None:
    for key in keys:
        value = getattr(struct, key)
        if isinstance(value, tuple):
            good = len(value) == 3 and all(map(math.isfinite, value))
            _require(good, key, "three finite numbers", value)
        else:
            _require(math.isfinite(value), key, "a finite number", value)


class Camera(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the picture is taken from. The screen stands one unit ahead."""

    position: Vec3
    look_at: Vec3
    up: Vec3 = (0.0, 1.0, 0.0)
    fov: float = 90.0
    """Horizontal, degrees, between 0 and 180."""

    def __post_init__(self) -> None:
        _finite(self, ("position", "look_at", "up", "fov"))
        _require(0 < self.fov < 180, "fov", "degrees between 0 and 180", self.fov)
        ahead = _minus(self.look_at, self.position)
        _require(math.hypot(*ahead) > 0, "look_at", "a point apart from position", self.look_at)
        right = math.hypot(*_cross(ahead, self.up))
        # The sine of the angle between them; below 1e-9 float64 cannot tell where right is.
        good = right > 1e-9 * math.hypot(*ahead) * math.hypot(*self.up)
        _require(good, "up", "a direction not parallel to look_at - position", self.up)

    @property
    def long_lens(self) -> bool:
        """Whether what fills the picture may be far away against its size."""
        return self.fov < 14

    def basis(self) -> tuple[Vec3, Vec3, Vec3]:
        """The unit vectors right, up and back (against the view), in world space."""
        back = _unit(_minus(self.position, self.look_at))
        right = _unit(_cross(self.up, back))
        return right, _cross(back, right), back


class Light(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A point light."""

    position: Vec3
    type: Literal["point"] = "point"
    ambient: Color = WHITE
    diffuse: Color = WHITE
    specular: Color = WHITE

    def __post_init__(self) -> None:
        _finite(self, ("position", "ambient", "diffuse", "specular"))


class Material(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How a surface answers light (paper, section 11.8)."""

    ambient: Color
    diffuse: Color
    specular: Color
    shininess: float
    """Blinn-Phong's alpha, at least 0. The exponent is a quarter of it."""
    reflection: float = 0.0
    """The part of the mirrored light that is added, in [0, 1]."""

    def __post_init__(self) -> None:
        _finite(self, ("ambient", "diffuse", "specular"))
        good = 0 <= self.shininess < math.inf
        _require(good, "shininess", "a finite number, at least 0", self.shininess)
        good = 0 <= self.reflection <= 1
        _require(good, "reflection", "a number from 0 to 1", self.reflection)


class Sphere(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A sphere, seen from outside only."""

    center: Vec3
    radius: float
    material: str

    def __post_init__(self) -> None:
        _finite(self, ("center",))
        good = 0 < self.radius < math.inf
        _require(good, "radius", "a finite number above 0", self.radius)


class Key(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the camera is at a frame. What is None keeps the scene's camera's value."""

    frame: int
    position: Vec3 | None = None
    look_at: Vec3 | None = None
    up: Vec3 | None = None
    fov: float | None = None

    def __post_init__(self) -> None:
        given = [key for key in MOVING if getattr(self, key) is not None]
        _finite(self, given)


MOVING = ("position", "look_at", "up", "fov")
"""What of a camera a key can give."""


class Animation(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How the camera moves. If the first and the last key say the same it goes round and round."""

    frames: int
    keys: tuple[Key, ...]
    fps: float = 30.0
    interpolation: Literal["smooth", "linear"] = "smooth"

    def __post_init__(self) -> None:
        _require(1 <= self.frames <= 10**7, "frames", "a number from 1 to 10000000", self.frames)
        _require(0.001 <= self.fps <= 1000, "fps", "a number from 0.001 to 1000", self.fps)
        _require(len(self.keys) >= 2, "keys", "at least two keys", len(self.keys))
        before = -1
        for i, key in enumerate(self.keys):
            good = before < key.frame <= self.frames
            expected = f"a frame from {before + 1} to {self.frames}, after that of the key before"
            _require(good, f"keys[{i}].frame", expected, key.frame)
            before = key.frame


class Scene(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Everything that a picture depends on but its size."""

    camera: Camera
    lights: tuple[Light, ...] = ()
    materials: dict[str, Material] = {}
    spheres: tuple[Sphere, ...] = ()
    max_depth: int = 3
    """Ray segments from the camera; 1 means no reflection."""
    shadow_bias: float = 0.0
    """World units that a hit point is lifted off its surface; 0 is the exact geometry."""
    animation: Animation | None = None

    def __post_init__(self) -> None:
        good = 1 <= self.max_depth < 2**31
        _require(good, "max_depth", "a whole number, at least 1 and below 2^31", self.max_depth)
        good = 0 <= self.shadow_bias < math.inf
        _require(good, "shadow_bias", "a finite number, at least 0", self.shadow_bias)
        for i, sphere in enumerate(self.spheres):
            if sphere.material not in self.materials:
                known = ", ".join(map(repr, self.materials)) or "none"
                expected = f"the name of a material ({known})"
                _require(False, f"spheres[{i}].material", expected, sphere.material)

    @property
    def reflects(self) -> bool:
        """Whether a path can go on after its first hit."""
        return self.max_depth > 1 and any(m.reflection > 0 for m in self.materials.values())


def _minus(a: Vec3, b: Vec3) -> Vec3:
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def _cross(a: Vec3, b: Vec3) -> Vec3:
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _unit(a: Vec3) -> Vec3:
    length = math.hypot(*a)
    return a[0] / length, a[1] / length, a[2] / length
