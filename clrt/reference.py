"""The truth: the paper's algorithm in float64 NumPy, to check the kernel against.

The paper is Antonio Sirignano, "Lighting and Shading: il modello del Ray Tracing". Its own source
for the program is Omar Aflak, "Ray Tracing From Scratch in Python" (2020).

Two truths (docs/accuracy.md):

- ``"seed"``: the paper to the letter. A hit point is lifted off its surface by the scene's
  ``shadow_bias`` along the normal, and the sphere it lies on is tested like any other.
- ``"exact"``: the geometry with no bias. A ray never hits the sphere it leaves, and a light behind
  the surface (N.L < 0) does not reach it.

Written to be read beside the paper's sections 11.2 to 11.11, not to be fast. Vectors are arrays of
shape (3, n), one column a ray.
"""

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

from clrt.errors import RequestError
from clrt.scene import Scene

Truth: TypeAlias = Literal["seed", "exact"]
Array: TypeAlias = NDArray[Any]

CHUNK_PIXELS = 1 << 16  # pixels traced at a time: what they need stays in the cache
PRIME = np.uint32(16777619)


@dataclass(frozen=True)
class Trace:
    """A picture and how it came about."""

    image: Array
    """(height, width, 3), linear, not clipped."""
    paths: NDArray[np.uint32]
    """(height, width). A hash of the spheres that a pixel's path hits and of the lights that reach
    each hit: where two differ the paths have parted (a flip)."""
    rays: int
    """How many were cast: from the camera, to lights, reflected."""


def render(
    scene: Scene,
    width: int,
    height: int,
    truth: Truth = "exact",
    dtype: DTypeLike = np.float64,
) -> Array:
    """The true picture: (height, width, 3) of dtype, linear, not clipped."""
    return trace(scene, width, height, truth, dtype).image


def trace(
    scene: Scene,
    width: int,
    height: int,
    truth: Truth = "exact",
    dtype: DTypeLike = np.float64,
) -> Trace:
    """The true picture and its paths.

    dtype: np.longdouble where float64 itself is in doubt.
    """
    if truth not in ("seed", "exact"):
        raise RequestError(f"truth: expected 'seed' or 'exact', got {truth!r}")
    tracer = _Tracer(scene, truth, np.dtype(dtype))
    half = np.tan(np.radians(np.asarray(scene.camera.fov, tracer.dtype)) / 2)
    if scene.camera.fov == 90:
        half = tracer.dtype.type(1)  # which tan(pi / 4) misses by a rounding
    x = np.linspace(-half, half, width, dtype=tracer.dtype)
    y = np.linspace(half * height / width, -half * height / width, height, dtype=tracer.dtype)
    image = np.zeros((height, width, 3), tracer.dtype)
    paths = np.zeros((height, width), np.uint32)
    rows = max(1, CHUNK_PIXELS // width)
    for top in range(0, height, rows):
        band = slice(top, top + rows)
        grid_y, grid_x = np.meshgrid(y[band], x, indexing="ij")
        color, path = tracer.trace(grid_x.ravel(), grid_y.ravel())
        image[band] = color.T.reshape(*grid_x.shape, 3)
        paths[band] = path.reshape(grid_x.shape)
    return Trace(image, paths, tracer.rays)


def _dot(a: Array, b: Array) -> Array:
    product: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


def _norm(a: Array) -> Array:
    length: Array = np.sqrt(_dot(a, a))
    return length


def _unit(a: Array) -> Array:
    length = _norm(a)
    return np.divide(a, length, out=np.zeros_like(a), where=length > 0)


class _Tracer:
    def __init__(self, scene: Scene, truth: Truth, dtype: np.dtype[Any]) -> None:
        self.dtype = dtype
        self.exact = truth == "exact"
        self.bias = dtype.type(0 if self.exact else scene.shadow_bias)
        self.max_depth = scene.max_depth
        self.rays = 0
        self.camera = self._column(scene.camera.position)
        self.right, self.up, self.back = map(self._column, scene.camera.basis())
        self.centers = [self._column(s.center) for s in scene.spheres]
        self.radii = [dtype.type(s.radius) for s in scene.spheres]
        self.lights = scene.lights
        materials = [scene.materials[s.material] for s in scene.spheres]
        # (3, spheres) and (spheres,): what a hit's sphere index selects from
        self.ambient = np.array([m.ambient for m in materials], dtype).reshape(-1, 3).T
        self.diffuse = np.array([m.diffuse for m in materials], dtype).reshape(-1, 3).T
        self.specular = np.array([m.specular for m in materials], dtype).reshape(-1, 3).T
        self.exponent = np.array([m.shininess for m in materials], dtype) / 4
        self.reflection = np.array([m.reflection for m in materials], dtype)

    def _column(self, v: tuple[float, float, float]) -> Array:
        return np.array(v, self.dtype)[:, np.newaxis]

    def nearest(self, origin: Array, direction: Array, leaves: Array) -> tuple[Array, Array]:
        """The sphere hit first, -1 if none, and its distance, infinity if none (11.4, 11.5)."""
        self.rays += origin.shape[1]
        hit = np.full(origin.shape[1], -1)
        distance = np.full(origin.shape[1], np.inf, self.dtype)
        for s, (center, radius) in enumerate(zip(self.centers, self.radii, strict=True)):
            from_center = origin - center
            b = 2 * _dot(direction, from_center)
            c = _norm(from_center) ** 2 - radius**2
            delta = b**2 - 4 * c
            smaller = (-b - np.sqrt(np.maximum(delta, 0))) / 2
            closer = (delta > 0) & (smaller > 0) & (smaller < distance)
            if self.exact:
                closer &= leaves != s
            hit[closer] = s
            distance[closer] = smaller[closer]
        return hit, distance

    def trace(self, x: Array, y: Array) -> tuple[Array, NDArray[np.uint32]]:
        """Colours (3, n) and paths (n,) of the pixels at x, y on the screen (11.11)."""
        color = np.zeros((3, x.size), self.dtype)
        path = np.zeros(x.size, np.uint32)
        # Of the rays that go on: which pixel, and how much of their light it gets.
        pixel = np.arange(x.size)
        weight = np.ones(x.size, self.dtype)
        origin = np.repeat(self.camera, x.size, axis=1)
        direction = _unit(x * self.right + y * self.up - self.back)
        hit = np.full(x.size, -1)
        for _ in range(self.max_depth):
            hit, distance = self.nearest(origin, direction, hit)
            met = hit >= 0
            pixel, weight, hit, distance = pixel[met], weight[met], hit[met], distance[met]
            origin, direction = origin[:, met], direction[:, met]
            if pixel.size == 0:
                break
            path[pixel] = path[pixel] * PRIME + (hit + 1).astype(np.uint32)

            point = origin + distance * direction
            centers = np.concatenate(self.centers, axis=1)
            normal = _unit(point - centers[:, hit])
            lifted = point + self.bias * normal
            reached = np.zeros(pixel.size, bool)
            for light in self.lights:
                position = self._column(light.position)
                to_light = _unit(position - lifted)
                lit = self.lit(position, point, lifted, to_light, normal, hit)
                path[pixel] = path[pixel] * PRIME + lit
                reached |= lit
                term = self.blinn_phong(light, point, to_light, normal, hit)
                color[:, pixel[lit]] += (weight * term)[:, lit]

            weight = weight * self.reflection[hit]
            on = reached & (weight > 0)
            pixel, weight, hit = pixel[on], weight[on], hit[on]
            normal, direction, origin = normal[:, on], direction[:, on], lifted[:, on]
            direction = direction - 2 * _dot(direction, normal) * normal
        return color, path

    def lit(
        self, light: Array, point: Array, lifted: Array, to_light: Array, normal: Array, hit: Array
    ) -> Array:
        """Whether nothing stands between a hit point and a light (11.7)."""
        _, distance = self.nearest(lifted, to_light, hit)
        free: Array = distance >= _norm(light - point)
        if self.exact:
            free &= _dot(normal, to_light) >= 0
        return free

    def blinn_phong(
        self, light: Any, point: Array, to_light: Array, normal: Array, hit: Array
    ) -> Array:
        """What a hit point sends to the camera of a light that reaches it (11.8)."""
        half_way = _unit(to_light + _unit(self.camera - point))
        highlight = np.maximum(_dot(normal, half_way), 0) ** self.exponent[hit]
        term: Array = (
            self.ambient[:, hit] * self._column(light.ambient)
            + self.diffuse[:, hit] * self._column(light.diffuse) * _dot(to_light, normal)
            + self.specular[:, hit] * self._column(light.specular) * highlight
        )
        return term
