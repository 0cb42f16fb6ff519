"""The paper's program, as sections 11.1 to 11.11 print it: one pixel at a time, in Python.

It serves as a peer to time and, in the tests, as the check of the "seed" reference. The only
difference is max(N.H, 0), without which a real exponent gives NaN; for one light, and a camera at
(0, 0, 1) that looks along -z.
"""

import math

import numpy as np
from numpy.typing import NDArray

from clrt.scene import Scene, Sphere

Vector = NDArray[np.float64]


def sphere_intersect(
    center: Vector, radius: float, ray_origin: Vector, ray_direction: Vector
) -> float | None:
    b = 2 * np.dot(ray_direction, ray_origin - center)
    c = np.linalg.norm(ray_origin - center) ** 2 - radius**2
    delta = b**2 - 4 * c
    if delta > 0:
        t1 = (-b + np.sqrt(delta)) / 2
        t2 = (-b - np.sqrt(delta)) / 2
        if t1 > 0 and t2 > 0:
            return float(min(t1, t2))
    return None


def nearest_intersected_object(
    spheres: tuple[Sphere, ...], ray_origin: Vector, ray_direction: Vector
) -> tuple[Sphere | None, float]:
    nearest, min_distance = None, math.inf
    for sphere in spheres:
        distance = sphere_intersect(
            np.array(sphere.center), sphere.radius, ray_origin, ray_direction
        )
        if distance and distance < min_distance:
            nearest, min_distance = sphere, distance
    return nearest, min_distance


def normalized(vector: Vector) -> Vector:
    unit: Vector = vector / np.linalg.norm(vector)
    return unit


def render(scene: Scene, width: int, height: int) -> NDArray[np.float64]:
    """(height, width, 3), linear, not clipped."""
    camera = np.array([0.0, 0.0, 1.0])
    ratio = width / height
    (light,) = scene.lights
    image = np.zeros((height, width, 3))
    for i, y in enumerate(np.linspace(1 / ratio, -1 / ratio, height)):
        for j, x in enumerate(np.linspace(-1, 1, width)):
            origin = camera
            direction = normalized(np.array([x, y, 0]) - origin)
            color = np.zeros(3)
            reflection = 1.0
            for _ in range(scene.max_depth):
                nearest, distance = nearest_intersected_object(scene.spheres, origin, direction)
                if nearest is None:
                    break
                point = origin + distance * direction
                normal = normalized(point - np.array(nearest.center))
                shifted = point + scene.shadow_bias * normal
                to_light = normalized(np.array(light.position) - shifted)
                _, distance = nearest_intersected_object(scene.spheres, shifted, to_light)
                if distance < np.linalg.norm(np.array(light.position) - point):
                    break
                material = scene.materials[nearest.material]
                half = normalized(to_light + normalized(camera - point))
                illumination = np.array(material.ambient) * light.ambient
                illumination += (
                    np.array(material.diffuse) * light.diffuse * np.dot(to_light, normal)
                )
                illumination += (
                    np.array(material.specular)
                    * light.specular
                    * max(np.dot(normal, half), 0) ** (material.shininess / 4)
                )
                color += reflection * illumination
                reflection *= material.reflection
                origin = shifted
                direction = direction - 2 * np.dot(direction, normal) * normal
            image[i, j] = color
    return image
