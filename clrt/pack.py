"""Packing: a Scene as the flat buffers that the kernel reads.

Each dtype stands for the struct of the same name in ``kernels/*.cl``, byte for byte; the comments
on the fields are there.
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


def camera_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype([("step", real, 2), ("last", np.int32, 2)], align=True)


def sphere_dtype(real: Real) -> np.dtype[Any]:
    return np.dtype(
        [
            ("anchor", real, 3),
            ("c0", real),
            ("offset", real, 3),
            ("inv_radius", real),
            ("radius2", real),
            ("horizon", real),
            ("giant", np.int32),
            ("material", np.int32),
        ],
        align=True,
    )


def material_dtype(real: Real) -> np.dtype[Any]:
    colors = [(name, real, 3) for name in ("ambient", "diffuse", "specular")]
    return np.dtype([*colors, ("exponent", real), ("reflection", real)], align=True)


def light_dtype(real: Real) -> np.dtype[Any]:
    names = ("position", "ambient", "diffuse", "specular")
    return np.dtype([(name, real, 3) for name in names], align=True)


@dataclass(frozen=True)
class Packed:
    """A scene in camera space, rounded once from float64 to the kernel's precision."""

    spheres: Array
    materials: Array
    lights: Array


def pack_camera(scene: Scene, width: int, height: int, real: Real) -> Array:
    """The screen of a picture of width x height pixels: one camera_dtype."""
    fov = scene.camera.fov
    # tan(pi / 4) is a rounding below 1, which is what the paper's screen has.
    half = 1.0 if fov == 90 else np.tan(np.radians(fov) / 2)
    last = np.maximum([width - 1, height - 1], 1)
    camera = np.zeros(1, camera_dtype(real))
    camera["step"] = half * np.array([1.0, height / width]) / last
    camera["last"] = last
    return camera


def pack(scene: Scene, real: Real) -> Packed:
    """The scene's spheres, materials and lights for kernels whose numbers are `real`."""
    position = np.array(scene.camera.position)
    to_camera = np.array(scene.camera.basis())

    def camera_space(points: list[tuple[float, float, float]]) -> Array:
        moved: Array = (np.array(points).reshape(-1, 3) - position) @ to_camera.T
        return moved

    names = list(scene.materials)
    materials = np.zeros(len(names), material_dtype(real))
    for packed, material in zip(materials, scene.materials.values(), strict=True):
        for color in ("ambient", "diffuse", "specular"):
            packed[color] = getattr(material, color)
        packed["exponent"] = material.shininess / 4
        packed["reflection"] = material.reflection

    lights = np.zeros(len(scene.lights), light_dtype(real))
    lights["position"] = camera_space([light.position for light in scene.lights])
    for packed, light in zip(lights, scene.lights, strict=True):
        for color in ("ambient", "diffuse", "specular"):
            packed[color] = getattr(light, color)

    spheres = _pack_spheres(
        camera_space([s.center for s in scene.spheres]),
        np.array([s.radius for s in scene.spheres]),
        scene.shadow_bias,
        real,
    )
    index = {name: i for i, name in enumerate(names)}
    spheres["material"] = [index[s.material] for s in scene.spheres]
    return Packed(spheres, materials, lights)


def _pack_spheres(center: Array, radius: Array, bias: float, real: Real) -> Array:
    """Spheres from centres (n, 3) in camera space and radii (n,), float64.

    The rounding of an anchor to float32 moves it off its surface; c0 takes that up, because it is
    computed in float64 from the rounded anchor.
    """
    distance = np.linalg.norm(center, axis=1)
    giant = radius > GIANT * abs(distance - radius)
    toward = np.where(giant, 1 - radius / np.where(giant, distance, 1), 1)
    anchor = (toward[:, np.newaxis] * center).astype(real)
    offset = np.where(giant[:, np.newaxis], anchor - center, 0)

    spheres = np.zeros(len(radius), sphere_dtype(real))
    spheres["anchor"] = anchor
    spheres["offset"] = offset
    spheres["c0"] = np.where(giant, (offset**2).sum(axis=1) - radius**2, 0)
    spheres["inv_radius"] = 1 / radius
    spheres["radius2"] = radius**2
    # A point lifted by `bias` off its sphere sees a light past the sphere down to this cosine: the
    # paper's shadow test, without a sphere tested against its own rounding.
    spheres["horizon"] = -np.sqrt(2 * bias * radius + bias**2) / (radius + bias)
    spheres["giant"] = giant
    return spheres
