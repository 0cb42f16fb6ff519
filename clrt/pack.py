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

GIANT = 30.0
"""A sphere is a giant if its radius is over this many times the camera's distance from its surface.

Below it float32 loses at most half of this, 15 units in the last place, of that distance.
"""

COLORS = ("ambient", "diffuse", "specular")


def camera_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype([("step", real, 2), ("origin", real, 3), ("last", np.int32, 2)], align=True)


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
    """A scene for a picture of one size, rounded once from float64 to the kernel's precision."""

    camera: Array
    spheres: Array
    materials: Array
    lights: Array
    shades: Array


def pack(scene: Scene, width: int, height: int, real: Real, literal: bool = False) -> Packed:
    """The buffers for a picture of width x height pixels.

    Args:
        real: what the kernel's numbers are.
        literal: for the kernel's LITERAL: the scene is turned but stays where it is in the world,
            and no sphere is treated in a special way.
    """
    eye = np.array(scene.camera.position)
    basis = np.array(scene.camera.basis())

    def turned(points: list[tuple[float, float, float]]) -> Array:
        away = np.array(points).reshape(-1, 3) - (0 if literal else eye)
        moved: Array = away @ basis.T
        return moved

    # tan(pi / 4) is a rounding below 1, which is what the paper's screen has.
    fov = scene.camera.fov
    half = 1.0 if fov == 90 else np.tan(np.radians(fov) / 2)
    camera = np.zeros(1, camera_dtype(real))
    camera["last"] = np.maximum([width - 1, height - 1], 1)
    camera["step"] = half * np.array([1.0, height / width]) / camera["last"]
    camera["origin"] = turned([scene.camera.position])

    materials = np.zeros(len(scene.materials), material_dtype(real))
    materials["exponent"] = [m.shininess / 4 for m in scene.materials.values()]
    materials["reflection"] = [m.reflection for m in scene.materials.values()]
    lights = np.zeros(len(scene.lights), light_dtype(real))
    lights["position"] = turned([light.position for light in scene.lights])
    shades = np.zeros((len(lights), len(materials)), shade_dtype(real))
    for k, light in enumerate(scene.lights):
        for color in COLORS:
            of_material = [getattr(m, color) for m in scene.materials.values()]
            shades[color][k] = np.array(of_material).reshape(-1, 3) * getattr(light, color)

    center = turned([s.center for s in scene.spheres])
    radius = np.array([s.radius for s in scene.spheres])
    spheres = _pack_spheres(center, radius, scene.shadow_bias, real, literal)
    index = {name: i for i, name in enumerate(scene.materials)}
    spheres["material"] = [index[s.material] for s in scene.spheres]
    return Packed(camera, spheres, materials, lights, shades)


def _pack_spheres(
    center: Array, radius: Array, bias: float, real: Real, literal: bool = False
) -> Array:
    """Spheres from centres (n, 3) in camera space and radii (n,), float64.

    The rounding of a giant's anchor to float32 moves it off the surface. c0 takes that up: it is
    computed from the rounded anchor.
    """
    distance = np.linalg.norm(center, axis=1)
    giant = (radius > GIANT * abs(distance - radius)) & (not literal)
    toward = np.where(giant, 1 - radius / np.where(giant, distance, 1), 1)
    anchor = (toward[:, np.newaxis] * center).astype(real)
    offset = np.where(giant[:, np.newaxis], anchor - center, 0)

    spheres = np.zeros(len(radius), sphere_dtype(real))
    spheres["anchor"] = anchor
    spheres["offset"] = offset
    spheres["c0"] = (offset**2).sum(axis=1) - radius**2
    spheres["camera_c"] = (distance - radius) * (distance + radius)
    spheres["view"] = _view(center, radius)
    spheres["inv_radius"] = 1 / radius
    # A point lifted by `bias` off its sphere sees a light past the sphere down to this cosine: the
    # paper's shadow test, without a sphere tested against its own rounding.
    horizon = -np.sqrt(2 * bias * radius + bias**2) / (radius + bias)
    spheres["horizon"] = -2 if literal else horizon
    spheres["giant"] = giant
    return spheres


def _view(center: Array, radius: Array) -> Array:
    """Where each sphere can show on the screen one unit ahead: left, right, bottom, top, (n, 4).

    Along each axis a sphere lies between two angles as seen from the camera, which is at the
    origin. The margin of 1e-6 is ten times what float32 can move a silhouette by.
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
