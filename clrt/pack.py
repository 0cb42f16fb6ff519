"""Packing: a Scene as the flat buffers that the kernel reads.

Each dtype stands for the struct of the same name in ``kernels/*.cl``, byte for byte; what the
fields mean is said there.
"""

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from clrt.scene import Scene

Array: TypeAlias = NDArray[Any]
Real: TypeAlias = type[np.float32] | type[np.float64]

GIANT = 4.0
"""A sphere is a giant if its radius is over this many times the camera's distance from its surface.

Near the surface of any other sphere |f|^2 - r^2 is off by up to 3 * 2^-24 r^2, which moves it by
1.5 * 2^-24 r: at most 6 units in the last place of that distance.
"""

# Beyond these a larger value gives the same picture: the host takes it down to them, so that no
# finite scene makes a kernel compute infinity - infinity or 0 * infinity.
FLAT = 2.0**53  # a radius, in units of the scene's extent: a plane to the last bit of a float64
FAR = 2.0**40  # a light's distance and the bias, in the same units
BRIGHT = 2.0**50  # a colour: white is 1
SHARP = 2.0**100  # an exponent

COLORS = ("ambient", "diffuse", "specular")


def camera_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype([("step", real, 2), ("eye", real, 3), ("last", np.int32, 2)], align=True)


def sphere_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype(
        [
            ("anchor", real, 3),
            ("c0", real),
            ("offset", real, 3),
            ("camera_c", real),
            ("view", real, 4),
            ("inv_radius", real),
            ("horizon", real),
            ("giant", np.int32),
            ("material", np.int32),
        ],
        align=True,
    )


def material_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype([("exponent", real), ("reflection", real)], align=True)


def light_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype([("position", real, 3)], align=True)


def shade_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype([(color, real, 3) for color in COLORS], align=True)


@dataclass(frozen=True)
class Packed:
    """A scene for a picture of one size, in camera space, rounded once to the kernel's precision.

    Lengths are scaled by a power of two, which is exact and cannot be seen, so that the spheres
    reach about 1 from the camera: neither their squares nor those of anything larger than 1e-19 of
    that leave float32's range.
    """

    camera: Array
    spheres: Array
    materials: Array
    lights: Array
    shades: Array
    encloses: Array
    """(lights, spheres): 1 where a light is inside a sphere."""
    shadow_bias: float


def pack(scene: Scene, width: int, height: int, real: Real, literal: bool = False) -> Packed:
    """The buffers for a picture of width x height pixels.

    Args:
        real: what the kernel's numbers are.
        literal: for the kernel's LITERAL: the scene is turned but stays where and as large as it
            is in the world, and no sphere is treated in a special way.
    """
    # "literal" lets float32 overflow to infinity, as the paper's formula would; anything else that
    # overflows is a bug.
    with np.errstate(over="ignore" if literal else "raise"):
        return _pack(scene, width, height, real, literal)


def _pack(scene: Scene, width: int, height: int, real: Real, literal: bool) -> Packed:
    # Where long double is wider than float64 it has the digits for r = 1e9 and the range for 1e300.
    wide = np.longdouble
    eye = np.array(scene.camera.position, wide)
    basis = np.array(scene.camera.basis(), wide)

    def turned(points: list[tuple[float, float, float]]) -> Array:
        away = np.array(points, wide).reshape(-1, 3) - (0 if literal else eye)
        moved: Array = away @ basis.T
        return moved

    center = turned([s.center for s in scene.spheres])
    radius = np.array([s.radius for s in scene.spheres], wide)
    position = turned([light.position for light in scene.lights])
    # tan(pi / 4) is a rounding below 1, which is what the paper's screen has.
    fov = wide(scene.camera.fov)
    half = wide(1) if fov == 90 else np.tan(np.radians(fov) / 2)
    eye_now = turned([scene.camera.position])
    if scene.camera.long_lens and not literal:
        ahead = _start(center, radius, half * np.hypot(1, wide(height) / width))
        for points in (center, position, eye_now):
            points[:, 2] += ahead
    light_distance = np.linalg.norm(position, axis=1)
    extent = _extent(center, radius) or light_distance.max(initial=0) or wide(1)
    scale = wide(1) if literal else np.ldexp(wide(1), -np.frexp(extent)[1])

    camera = np.zeros(1, camera_dtype(real))
    camera["last"] = np.maximum([width - 1, height - 1], 1)
    camera["step"] = half * np.array([1, wide(height) / width]) / camera["last"]
    camera["eye"] = scale * eye_now

    materials = np.zeros(len(scene.materials), material_dtype(real))
    materials["exponent"] = [min(m.shininess / 8, SHARP) for m in scene.materials.values()]
    materials["reflection"] = [m.reflection for m in scene.materials.values()]
    lights = np.zeros(len(scene.lights), light_dtype(real))
    nearer = 1 / np.maximum(light_distance / (FAR * extent), 1)
    lights["position"] = scale * nearer[:, np.newaxis] * position
    shades = np.zeros((len(lights), len(materials)), shade_dtype(real))
    for k, light in enumerate(scene.lights):
        for color in COLORS:
            of_material = np.array([getattr(m, color) for m in scene.materials.values()], wide)
            product = of_material.reshape(-1, 3) * np.array(getattr(light, color), wide)
            shades[color][k] = np.clip(product, -BRIGHT, BRIGHT)

    bias = float(scale * min(scene.shadow_bias, FAR * extent))
    spheres = _pack_spheres(scale * center, scale * radius, bias, real, literal)
    index = {name: i for i, name in enumerate(scene.materials)}
    spheres["material"] = [index[s.material] for s in scene.spheres]
    return Packed(
        camera,
        spheres,
        materials,
        lights,
        shades,
        encloses=encloses(scene),
        shadow_bias=bias,
    )


def encloses(scene: Scene) -> Array:
    """Which spheres the lights are inside of: (lights, spheres), uint8 0 or 1."""
    center = np.array([s.center for s in scene.spheres], np.longdouble).reshape(-1, 3)
    radius = np.array([s.radius for s in scene.spheres], np.longdouble)
    inside = np.zeros((len(scene.lights), len(radius)), np.uint8)
    for row, light in zip(inside, scene.lights, strict=True):
        row[:] = np.linalg.norm(np.array(light.position, np.longdouble) - center, axis=1) < radius
    return inside


def _is_giant(center: Array, radius: Array) -> Array:
    giant: Array = radius > GIANT * abs(np.linalg.norm(center, axis=1) - radius)
    return giant


def _start(center: Array, radius: Array, corner: Any) -> Any:
    """How far ahead of the camera rays can start: a little before the first hit.

    corner: the distance of the screen's corners from its middle.
    """
    distance = np.linalg.norm(center, axis=1)
    outside = distance > radius  # from inside a sphere cannot be seen
    center, radius, distance = center[outside], radius[outside], distance[outside]
    # A sphere is met first by the ray closest to its centre. `off` is the angle between them.
    off = np.arccos(np.clip(-center[:, 2] / distance, -1, 1)) - np.arctan(corner)
    off = np.clip(off, 0, np.pi / 2)
    half_chord2 = radius**2 - (distance * np.sin(off)) ** 2
    met = half_chord2 > 0
    first = (distance * np.cos(off))[met] - np.sqrt(half_chord2[met])
    # From there what is seen is as wide as far, as through a lens of 90 degrees.
    return max(first.min(initial=np.inf) * (1 - corner), 0) if met.any() else 0


def _extent(center: Array, radius: Array) -> Any:
    """How far the spheres reach from the camera; of giants, the distance of their anchors."""
    distance = np.linalg.norm(center, axis=1)
    reach = np.where(_is_giant(center, radius), abs(distance - radius), distance + radius)
    return reach.max(initial=0)


def _pack_spheres(
    center: Array, radius: Array, bias: float, real: Real, literal: bool = False
) -> Array:
    """Spheres from centres (n, 3) in camera space and radii (n,), of about unit extent.

    The rounding of a giant's anchor moves it off the surface. c0 takes that up: it is computed from
    the rounded anchor, before it is rounded itself.
    """
    giant = _is_giant(center, radius) & (not literal)
    distance = np.linalg.norm(center, axis=1)
    toward = np.where(giant, (distance - radius) / np.where(giant, distance, 1), 1)
    anchor = (toward[:, np.newaxis] * center).astype(real)
    offset = np.where(giant[:, np.newaxis], anchor - center, 0)
    flat = np.minimum(radius, FLAT)

    spheres = np.zeros(len(radius), sphere_dtype(real))
    spheres["anchor"] = anchor
    spheres["offset"] = (flat / radius)[:, np.newaxis] * offset
    above = np.linalg.norm(offset, axis=1) - radius  # the anchor, above the surface
    spheres["c0"] = above * (2 * flat + above)
    above = distance - radius  # the camera
    spheres["camera_c"] = above * (2 * flat + above)
    spheres["view"] = _view(center, radius)
    spheres["inv_radius"] = 1 / np.maximum(flat, np.finfo(real).tiny)
    # A point lifted by `bias` off its sphere sees a light past the sphere down to this cosine: the
    # paper's shadow test, without a sphere tested against its own rounding.
    horizon = -np.sqrt(bias * (2 * radius + bias)) / (radius + bias)
    spheres["horizon"] = -2 if literal else horizon
    spheres["giant"] = giant
    return spheres


def _view(center: Array, radius: Array) -> Array:
    """Where each sphere can show on the screen one unit ahead: left, right, bottom, top, (n, 4).

    Along each axis a sphere lies between two angles as seen from the camera, which is at the
    origin. The margin of 1e-6 is more than the 4 * 2^-24 (1 + r/D) that float32 moves a silhouette.
    """
    view = np.empty((len(radius), 4))
    behind = np.pi / 2
    for axis in (0, 1):
        away = np.hypot(center[:, axis], center[:, 2])
        outside = away > radius
        middle = np.arctan2(center[:, axis], -center[:, 2])
        half = np.where(outside, np.arcsin(radius / np.where(outside, away, radius)), np.inf)
        for end, angle in enumerate((middle - half, middle + half)):
            ahead = abs(angle) < behind
            position = np.tan(np.where(ahead, angle, 0))
            position += (2 * end - 1) * 1e-6 * (1 + abs(position))
            view[:, 2 * axis + end] = np.where(ahead, position, np.copysign(np.inf, angle))
    return view
