"""What a scene is.

The classes mirror the scene file table by table (README, "Scenes"). They check their values
whoever makes them: a file or Python code. Lengths are in world units, colours linear RGB.
"""

import math
import operator
from collections.abc import Callable, Iterable
from typing import Literal, TypeAlias

import msgspec
from msgspec.structs import force_setattr

from clrt.errors import SceneError

Vec3: TypeAlias = tuple[float, float, float]
Color: TypeAlias = tuple[float, float, float]

WHITE: Color = (1.0, 1.0, 1.0)


MAX_DEPTH = 1000
"""Between mirrors that face each other a path has no end: seconds at 4K, but not hours."""


def _require(good: bool, key: str, expected: str, value: object) -> None:
    if not good:
        raise SceneError(f"{key}: expected {expected}, got {_short(value)}")


def _short(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f"{text[:60]}... ({len(text)} characters)"


def _all(struct: msgspec.Struct, key: str, kind: type, what: str) -> None:
    """Makes a tuple of any sequence of that kind."""
    given = getattr(struct, key)
    try:
        found = tuple(given)
    except TypeError:
        found = (None,)
    for i, one in enumerate(found):
        where = key if not isinstance(given, list | tuple) else f"{key}[{i}]"
        _require(isinstance(one, kind), where, what, one if where != key else given)
    force_setattr(struct, key, found)


def _vectors(struct: msgspec.Struct, *keys: str) -> None:
    """Makes triples of floats of any sequences of three finite numbers."""
    for key in keys:
        given = getattr(struct, key)
        try:
            good = len(given) == 3 and all(map(math.isfinite, given))
        except (TypeError, OverflowError):
            good = False
        _require(good, key, "three finite numbers", given)
        force_setattr(struct, key, tuple(map(float, given)))


def _number(struct: msgspec.Struct, key: str, expected: str, good: Callable[[float], bool]) -> None:
    given = getattr(struct, key)
    try:
        fine = math.isfinite(given) and good(given)
    except (TypeError, OverflowError):
        fine = False
    _require(fine, key, expected, given)
    force_setattr(struct, key, float(given))


def _count(struct: msgspec.Struct, key: str, least: int, most: int) -> None:
    given = getattr(struct, key)
    try:
        good = least <= operator.index(given) <= most
    except TypeError:
        good = False
    _require(good, key, f"a whole number from {least} to {most}", given)
    force_setattr(struct, key, operator.index(given))


class Camera(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the picture is taken from. The screen stands one unit ahead."""

    position: Vec3
    look_at: Vec3
    up: Vec3 = (0.0, 1.0, 0.0)
    fov: float = 90.0
    """Horizontal, degrees, between 0 and 180."""

    def __post_init__(self) -> None:
        _vectors(self, "position", "look_at", "up")
        _number(self, "fov", "degrees between 0 and 180", lambda fov: 0 < fov < 180)
        ahead = _minus(self.look_at, self.position)
        _require(any(ahead), "look_at", "a point apart from position", self.look_at)
        good = all(map(math.isfinite, ahead))
        _require(good, "look_at", "a point less than 1.8e308 from position", self.look_at)
        ahead, up = _near_one(ahead), _near_one(self.up)
        # The sine of the angle between them; below 1e-9 float64 cannot tell where right is.
        good = math.hypot(*_cross(ahead, up)) > 1e-9 * math.hypot(*ahead) * math.hypot(*up)
        _require(good, "up", "a direction not parallel to look_at - position", self.up)

    def basis(self) -> tuple[Vec3, Vec3, Vec3]:
        """The unit vectors right, up and back (against the view), in world space."""
        back = _unit(_minus(self.position, self.look_at))
        right = _unit(_cross(_near_one(self.up), back))
        return right, _cross(back, right), back


class Light(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A point light."""

    position: Vec3
    type: Literal["point"] = "point"
    ambient: Color = WHITE
    diffuse: Color = WHITE
    specular: Color = WHITE

    def __post_init__(self) -> None:
        _require(self.type == "point", "type", "'point'", self.type)
        _vectors(self, "position", "ambient", "diffuse", "specular")


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
        _vectors(self, "ambient", "diffuse", "specular")
        _number(self, "shininess", "a finite number, at least 0", lambda alpha: alpha >= 0)
        _number(self, "reflection", "a number from 0 to 1", lambda part: 0 <= part <= 1)


class Sphere(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A sphere, seen from outside only."""

    center: Vec3
    radius: float
    material: str

    def __post_init__(self) -> None:
        _vectors(self, "center")
        _number(self, "radius", "a finite number above 0", lambda radius: radius > 0)
        _require(isinstance(self.material, str), "material", "a material's name", self.material)


FRAMES = 10**7
"""The most that an animation can have."""


class Key(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Where the camera is at a frame. What is None keeps the scene's camera's value."""

    frame: int
    position: Vec3 | None = None
    look_at: Vec3 | None = None
    up: Vec3 | None = None
    fov: float | None = None

    def __post_init__(self) -> None:
        _count(self, "frame", 0, FRAMES)
        _vectors(self, *(key for key in CAMERA_KEYS[:3] if getattr(self, key) is not None))
        if self.fov is not None:
            _number(self, "fov", "a finite number", lambda fov: True)


CAMERA_KEYS = ("position", "look_at", "up", "fov")
"""What of a camera a key can give: three vectors and a number."""


class Animation(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """How the camera moves. If the first and the last key say the same it goes round and round."""

    frames: int
    keys: tuple[Key, ...]
    fps: float = 30.0
    interpolation: Literal["smooth", "linear"] = "smooth"

    def __post_init__(self) -> None:
        good = self.interpolation in ("smooth", "linear")
        _require(good, "interpolation", "'smooth' or 'linear'", self.interpolation)
        _count(self, "frames", 1, FRAMES)
        _number(self, "fps", "a number from 0.001 to 1000", lambda fps: 0.001 <= fps <= 1000)
        _all(self, "keys", Key, "a Key")
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
        _require(isinstance(self.camera, Camera), "camera", "a Camera", self.camera)
        _all(self, "lights", Light, "a Light")
        _all(self, "spheres", Sphere, "a Sphere")
        good = isinstance(self.materials, dict)
        _require(good, "materials", "a dict of names and Materials", self.materials)
        for name, material in self.materials.items():
            good = isinstance(name, str) and isinstance(material, Material)
            _require(good, f"materials.{name}", "a Material", material)
        good = self.animation is None or isinstance(self.animation, Animation)
        _require(good, "animation", "an Animation", self.animation)
        _count(self, "max_depth", 1, MAX_DEPTH)
        _number(self, "shadow_bias", "a finite number, at least 0", lambda bias: bias >= 0)
        for i, sphere in enumerate(self.spheres):
            if sphere.material not in self.materials:
                expected = f"the name of a material ({_some(self.materials)})"
                _require(False, f"spheres[{i}].material", expected, sphere.material)


def _some(names: Iterable[str], most: int = 5) -> str:
    """The first few of them, and how many there are more."""
    found = list(map(repr, names))
    more = [f"{len(found) - most} more"] if len(found) > most else []
    return ", ".join(found[:most] + more) or "none"


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
