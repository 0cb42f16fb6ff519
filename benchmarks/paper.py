"""A naive ray tracer in Python, one pixel at a time: what a reader of the paper would write.

It takes the steps that Antonio Sirignano describes in "Lighting and Shading: il modello del Ray
Tracing" (sections 11.1 to 11.11), and that he has from Omar Aflak's article "Ray Tracing From
Scratch in Python" (2020). The code is our own. It serves as a peer to time and, in the tests, as a
check of the "seed" reference that shares no code with it.
"""

import math

import numpy as np
from numpy.typing import NDArray

from benchmarks import harness
from clrt.scene.light import Light
from clrt.scene.material import Material
from clrt.scene.scene import Scene
from clrt.scene.spheres import Sphere

Vector = NDArray[np.float64]


def render(scene: Scene, width: int, height: int) -> NDArray[np.float64]:
    """(height, width, 3), linear, not clipped."""
    right, up, back = map(np.array, scene.camera.basis())
    eye = np.array(scene.camera.position)
    assert scene.camera.fov is not None
    reach = math.tan(math.radians(scene.camera.fov / 2))  # half the screen's width
    film = np.empty((height, width, 3))
    for row in range(height):
        y = reach * height / width * (1 - 2 * row / (height - 1))
        for column in range(width):
            x = reach * (2 * column / (width - 1) - 1)
            film[row, column] = seen(scene, eye, unit(x * right + y * up - back), scene.max_depth)
    return film


def seen(scene: Scene, start: Vector, way: Vector, segments: int) -> Vector:
    """The colour that a ray brings back, which may still go so many segments."""
    black = np.zeros(3)
    sphere, length = first_met(scene, start, way)
    if sphere is None:
        return black
    spot = start + length * way
    outward = unit(spot - np.array(sphere.center))
    outside = spot + scene.shadow_bias * outward
    material = scene.materials[sphere.material]
    lights = [
        light for light in harness.point_lights(scene) if reaches(scene, light, spot, outside)
    ]
    color = sum((shade(scene, light, material, spot, outside, outward) for light in lights), black)
    if lights and segments > 1:
        mirrored = way - 2 * (way @ outward) * outward
        color = color + material.reflection * seen(scene, outside, mirrored, segments - 1)
    return color


def first_met(scene: Scene, start: Vector, way: Vector) -> tuple[Sphere | None, float]:
    """The sphere that a ray meets first and how far away, if any."""
    met, length = None, math.inf
    for sphere in scene.spheres:
        # A point start + t way lies on the sphere where t² + 2 p t + q = 0.
        offset = start - np.array(sphere.center)
        p = way @ offset
        q = np.linalg.norm(offset) ** 2 - sphere.radius**2
        if p * p > q:
            t = -p - math.sqrt(p * p - q)
            if 0 < t < length:
                met, length = sphere, t
    return met, length


def reaches(scene: Scene, light: Light, spot: Vector, outside: Vector) -> bool:
    """Whether a point sees a light: no sphere stands between them."""
    lamp = np.array(light.position)
    _, free = first_met(scene, outside, unit(lamp - outside))
    return free >= float(np.linalg.norm(lamp - spot))


def shade(
    scene: Scene, light: Light, material: Material, spot: Vector, outside: Vector, outward: Vector
) -> Vector:
    """Blinn and Phong's colour of a point in a light, as the camera sees it."""
    lightward = unit(np.array(light.position) - outside)
    eyeward = unit(np.array(scene.camera.position) - spot)
    gloss = max(float(outward @ unit(lightward + eyeward)), 0.0) ** (material.shininess / 4)
    ambient = np.array(light.ambient) * np.array(material.ambient)
    diffuse = np.array(light.diffuse) * np.array(material.diffuse)
    specular = np.array(light.specular) * np.array(material.specular)
    result: Vector = ambient + lightward @ outward * diffuse + gloss * specular
    return result


def unit(v: Vector) -> Vector:
    """The same direction, one long."""
    result: Vector = v / np.linalg.norm(v)
    return result
