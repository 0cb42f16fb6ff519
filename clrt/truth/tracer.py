"""The truth: the paper's algorithm in float64 NumPy, to check the kernel against.

The paper is Antonio Sirignano, "Lighting and Shading: il modello del Ray Tracing". Its own source
for the program is Omar Aflak, "Ray Tracing From Scratch in Python" (2020).

Two truths (docs/accuracy.md):

- ``"seed"``: the paper to the letter. A hit point is lifted off its surface by the scene's
  ``shadow_bias`` along the normal, and the sphere it lies on is tested like any other.
- ``"exact"``: the geometry with no bias. A ray never hits the sphere it leaves, and a light behind
  the surface (N.L < 0) does not reach it. There is one ray a pixel, whatever `samples` is.

What spreads over many directions (round lights, occlusion, lenses, rough mirrors, indirect light)
is held against closed forms instead: neither truth knows it.

Written to be read beside the paper's sections 11.2 to 11.11, not to be fast. Vectors are arrays of
shape (3, n), one column a ray.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

from clrt.errors import RequestError
from clrt.scene.camera import Camera
from clrt.scene.light import AmbientLight, DirectionalLight, Shining, SpotLight
from clrt.scene.scene import Scene, beyond_one_ray, beyond_paper
from clrt.scene.spheres import Spheres

Truth: TypeAlias = Literal["seed", "exact"]
Array: TypeAlias = NDArray[Any]

CHUNK_PIXELS = 1 << 16  # pixels traced at a time: what they need stays in the cache
BLOCK_PAIRS = 1 << 16  # of a ray and a sphere, that are tested at a time
PRIME = np.uint32(16777619)


@dataclass(frozen=True)
class Trace:
    """A picture and how it came about."""

    image: Array
    """(height, width, 3), or (n, 3) of n pixels; linear, not clipped, before the scene's background
    unless its film is transparent. Nothing else of its film is in it."""
    paths: NDArray[np.uint32]
    """(height, width), or (n,). A hash of the spheres that a pixel's path hits and of the lights
    that reach each hit: where two differ the paths have parted (a flip)."""
    rays: int
    """How many were cast: from the camera, to lights, reflected."""
    alpha: Array
    """(height, width), or (n,), as the following: 1 where the camera sees a sphere, else 0."""
    depth: Array
    """How far along the camera's ray, world units; infinity where it meets none. Of an orthographic
    camera from the plane that it stands on, and negative behind it."""
    normal: Array
    """(height, width, 3): outwards, of unit length, in world space; 0 where there is none."""
    id: NDArray[np.int32]
    """The index of the sphere; -1 where there is none."""


def trace(
    scene: Scene,
    width: int,
    height: int,
    truth: Truth = "exact",
    dtype: DTypeLike = np.float64,
    *,
    pixels: Sequence[tuple[int, int]] | None = None,
    offset: tuple[float, float] = (0.0, 0.0),
) -> Trace:
    """The true picture and its paths.

    Args:
        dtype: np.longdouble where float64 itself is in doubt.
        pixels: rows and columns of the pixels that are wanted, in whose order the trace's image is
            (n, 3) and its paths (n,); default: all of them.
        offset: where in its pixel each ray goes through: right and up of the middle, half pixels.

    Raises:
        RequestError: there is no such truth or pixel, or the truth does not know something of the
            scene.
    """
    if truth not in ("seed", "exact"):
        raise RequestError(f"truth: expected 'seed' or 'exact', got {truth!r}")
    if key := beyond_one_ray(scene):
        raise RequestError(f"truth: {truth!r} knows no {key}: closed forms are the truth there")
    if truth == "seed" and (key := beyond_paper(scene)):
        raise RequestError(f"truth: 'seed' knows no {key}, expected 'exact'")
    if scene.particles:
        raise RequestError("particles: expected none that are in files: clrt.reference reads them")
    tracer = _Tracer(scene, truth, np.dtype(dtype))
    x, y = _screen(scene.camera, width, height, tracer.dtype)
    right, up = (np.array(offset) / np.maximum([width - 1, height - 1], 1)).astype(tracer.dtype)
    x, y = x + abs(x[0]) * right, y + abs(y[0]) * up
    grid_x: Array
    grid_y: Array
    if pixels is None:
        grid_y, grid_x = np.meshgrid(y, x, indexing="ij")
        shape: tuple[int, ...] = height, width
    else:
        places = np.asarray(pixels, np.int64).reshape(-1, 2)
        if ((places < 0) | (places >= (height, width))).any():
            raise RequestError(f"pixels: expected rows and columns of a picture {width}x{height}")
        grid_y, grid_x = y[places[:, 0]], x[places[:, 1]]
        shape = (len(places),)
    grid_y, grid_x = grid_y.ravel(), grid_x.ravel()
    n = grid_x.size
    image, normal = np.zeros((n, 3), tracer.dtype), np.zeros((n, 3), tracer.dtype)
    paths, sphere = np.zeros(n, np.uint32), np.full(n, -1, np.int32)
    depth = np.full(n, np.inf, tracer.dtype)
    for start in range(0, n, CHUNK_PIXELS):
        chunk = slice(start, start + CHUNK_PIXELS)
        first = _First(sphere[chunk], depth[chunk], normal[chunk].T)
        color, paths[chunk] = tracer.trace(grid_x[chunk], grid_y[chunk], first)
        image[chunk] = color.T
    alpha = (sphere >= 0).astype(tracer.dtype)
    if not scene.film.transparent:
        image += (1 - alpha)[:, np.newaxis] * np.array(scene.film.background, tracer.dtype)
    return Trace(
        image.reshape(*shape, 3),
        paths.reshape(shape),
        tracer.rays,
        alpha.reshape(shape),
        depth.reshape(shape),
        normal.reshape(*shape, 3),
        sphere.reshape(shape),
    )


def mean(scene: Scene, width: int, height: int, offsets: Array) -> Array:
    """The mean of true pictures, (height, width, 4): colours and alpha.

    offsets: (n, 2), where in its pixel each ray goes through, see trace().
    """
    found = np.zeros((height, width, 4))
    for right, up in offsets:
        one = trace(scene, width, height, offset=(right, up))
        found[..., :3] += one.image
        found[..., 3] += one.alpha
    return found / len(offsets)


class _First(NamedTuple):
    """What camera rays meet first, to be filled in."""

    sphere: Array
    depth: Array
    normal: Array
    """(3, n)"""


def _screen(camera: Camera, width: int, height: int, dtype: np.dtype[Any]) -> tuple[Array, Array]:
    """Where the columns and rows of pixels are on the screen (11.1): of an orthographic camera as
    far from its axis as their rays are, in world units."""
    if camera.height is not None:
        top = dtype.type(camera.height) / 2
        right = top * width / height
    else:
        right = np.tan(np.radians(dtype.type(camera.fov)) / 2)
        if camera.fov == 90:
            right = dtype.type(1)  # which tan(pi / 4) misses by a rounding
        top = right * height / width
    x: Array = np.linspace(-right, right, width, dtype=dtype)
    return x, np.linspace(top, -top, height, dtype=dtype)


def _dot(a: Array, b: Array) -> Array:
    product: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


def _norm(a: Array) -> Array:
    length: Array = np.sqrt(_dot(a, a))
    return length


def _unit(a: Array) -> Array:
    length = _norm(a)
    return np.divide(a, length, out=np.zeros_like(a), where=length > 0)


@dataclass
class _Rays:
    """Rays that are at the same bounce, one a column."""

    pixel: Array
    """Whose light they bring, (n,): no two of them the same one's."""
    weight: Array
    """How much of it the pixel gets."""
    origin: Array
    direction: Array
    leaves: Array
    """The sphere that each comes from; -1: the camera."""
    inside: NDArray[np.bool_]
    """(n, transparent spheres): which it is inside of."""
    path: NDArray[np.uint32]
    """A hash of what it has met."""
    bounce: int

    def only(self, some: Array, **changes: Array) -> "_Rays":
        """Those of a mask, each quantity as it is or as it is given."""
        kept = {
            name: changes.get(name, getattr(self, name))[..., some]
            for name in ("pixel", "weight", "origin", "direction", "leaves", "path")
        }
        inside = changes.get("inside", self.inside)[some]
        return _Rays(**kept, inside=inside, bounce=self.bounce)


class _Tracer:
    def __init__(self, scene: Scene, truth: Truth, dtype: np.dtype[Any]) -> None:
        self.dtype = dtype
        self.exact = truth == "exact"
        self.bias = dtype.type(0 if self.exact else scene.shadow_bias)
        self.max_depth = scene.max_depth
        self.rays = 0
        self.camera = self._column(scene.camera.position)
        self.right, self.up, self.back = map(self._column, scene.camera.basis())
        self.orthographic = scene.camera.orthographic
        self.look_at = self._column(scene.camera.look_at)
        self.lights = scene.lights
        spheres = Spheres.of(scene.spheres)
        self.center = spheres.center.astype(dtype).T  # (3, spheres)
        self.radius = spheres.radius.astype(dtype)
        # What a hit's sphere selects from: its material, of that (3, materials) or (materials,).
        places = {name: i for i, name in enumerate(scene.materials)}
        index = np.array([places[name] for name in spheres.names or ()], np.int64)
        self.material = index[spheres.material_index]
        materials = scene.materials.values()
        self.ambient = np.array([m.ambient for m in materials], dtype).reshape(-1, 3).T
        self.diffuse = np.array([m.diffuse for m in materials], dtype).reshape(-1, 3).T
        self.specular = np.array([m.specular for m in materials], dtype).reshape(-1, 3).T
        self.shininess = np.array([m.shininess for m in materials], dtype)
        self.phong = np.array([m.highlight == "phong" for m in materials], bool)
        self.reflection = np.array([m.reflection for m in materials], dtype)
        # Glass. The medium of a point is the smallest transparent sphere around it.
        self.transmission = np.array([m.transmission for m in materials], dtype)
        self.ior = np.array([m.ior for m in materials], dtype)
        self.fresnel = np.array([m.fresnel for m in materials], bool)
        self.panes = np.flatnonzero(self.transmission[self.material] > 0)
        self.size = np.argsort(np.argsort(self.radius[self.panes], kind="stable"))
        self.background = self._column(scene.film.background)
        self.color = None if spheres.color is None else spheres.color.astype(dtype).T

    def _column(self, v: tuple[float, float, float]) -> Array:
        return np.array(v, self.dtype)[:, np.newaxis]

    def first(self, x: Array, y: Array) -> _Rays:
        """The rays through points of the screen (11.2)."""
        n = x.size
        inside = np.zeros((n, len(self.panes)), bool)
        if self.orthographic:  # they have no start: any of their points will do
            origin = self.look_at + x * self.right + y * self.up
            direction = np.repeat(-self.back, n, axis=1)
        else:
            origin = np.repeat(self.camera, n, axis=1)
            direction = _unit(x * self.right + y * self.up - self.back)
            inside[:] = _norm(self.camera - self.center[:, self.panes]) < self.radius[self.panes]
        pixel, nothing = np.arange(n), np.full(n, -1)
        weight, path = np.ones(n, self.dtype), np.zeros(n, np.uint32)
        return _Rays(pixel, weight, origin, direction, nothing, inside, path, 0)

    def to_camera(self, point: Array) -> Array:
        """The direction from where a point is looked at."""
        return self.back if self.orthographic else _unit(self.camera - point)

    def meetings(self, rays: _Rays) -> Iterator[tuple[slice, Array, Array]]:
        """Where rays meet spheres, some of these at a time: which, whether from inside and the
        distances, (rays, spheres), infinity where they do not (11.4)."""
        self.rays += rays.pixel.size
        # All rays against one sphere, or few rays against many: what fits into the cache.
        block = max(1, BLOCK_PAIRS // max(rays.pixel.size, 1))
        for start in range(0, len(self.radius), block):
            some = slice(start, min(start + block, len(self.radius)))
            within = np.zeros((rays.pixel.size, some.stop - start), bool)
            here = (self.panes >= start) & (self.panes < some.stop)
            within[:, self.panes[here] - start] = rays.inside[:, here]
            from_center = rays.origin[:, :, np.newaxis] - self.center[:, np.newaxis, some]
            b = 2 * _dot(rays.direction[:, :, np.newaxis], from_center)
            c = _norm(from_center) ** 2 - self.radius[some] ** 2
            delta = b**2 - 4 * c
            root = np.sqrt(np.maximum(delta, 0))
            distance = np.where(within, -b + root, -b - root) / 2
            line = self.orthographic and rays.bounce == 0
            met = (delta > 0) & (line | (distance > 0))
            if self.exact:  # the sphere that a ray leaves is met from inside only
                met &= within | (rays.leaves[:, np.newaxis] != np.arange(start, some.stop))
            distance[~met] = np.inf
            yield some, within, distance

    def nearest(self, rays: _Rays) -> tuple[Array, Array]:
        """The sphere hit first, -1 if none, and its distance, infinity if none (11.5)."""
        hit = np.full(rays.pixel.size, -1)
        distance = np.full(rays.pixel.size, np.inf, self.dtype)
        for some, _, distances in self.meetings(rays):
            first = distances.argmin(axis=1)  # of equal ones that which comes first
            nearest = np.take_along_axis(distances, first[:, np.newaxis], axis=1)[:, 0]
            closer = nearest < distance
            hit[closer] = some.start + first[closer]
            distance[closer] = nearest[closer]
        return hit, distance

    def clear(self, rays: _Rays, limit: Array) -> Array:
        """How much of a light that is `limit` away the spheres leave that a ray to it enters on its
        way: 0 or 1 if all are opaque (11.7)."""
        left = np.ones(rays.pixel.size, self.dtype)
        for some, within, distances in self.meetings(rays):
            enters = (distances < limit[:, np.newaxis]) & ~within
            part = self.transmission[self.material[some]]
            left *= np.where(enters, part, self.dtype.type(1)).prod(axis=1)
        return left

    def trace(self, x: Array, y: Array, first: _First) -> tuple[Array, NDArray[np.uint32]]:
        """Colours (3, n) and paths (n,) of the pixels at x, y on the screen (11.11)."""
        color = np.zeros((3, x.size), self.dtype)
        path = np.zeros(x.size, np.uint32)
        todo = [self.first(x, y)]
        while todo:
            todo += self.segment(todo.pop(), color, path, first)
        return color, path

    def segment(
        self, rays: _Rays, color: Array, path: NDArray[np.uint32], first: _First
    ) -> list[_Rays]:
        """Adds what some rays meet to colours and paths. Returns those that go on from there."""
        hit, distance = self.nearest(rays)
        gone = hit < 0
        path[rays.pixel[gone]] += rays.path[gone]
        if rays.bounce > 0:  # what the camera sees directly is added where alpha is known
            color[:, rays.pixel[gone]] += rays.weight[gone] * self.background
        rays, distance, hit = rays.only(hit >= 0), distance[hit >= 0], hit[hit >= 0]
        if hit.size == 0:
            return []
        point = rays.origin + distance * rays.direction
        normal = _unit(point - self.center[:, hit])
        lifted = point + self.bias * normal
        if rays.bounce == 0:
            first.sphere[rays.pixel], first.normal[:, rays.pixel] = hit, normal
            first.depth[rays.pixel] = _dot(point - self.camera, rays.direction)
        rays.path = rays.path * PRIME + (hit + 1).astype(np.uint32)
        # A far side is not shaded.
        of_hit = self.panes == hit[:, np.newaxis]
        out = (of_hit & rays.inside).any(axis=1)
        reached = np.zeros(hit.size, bool)
        for light in self.lights:
            if isinstance(light, AmbientLight):
                reached |= ~out
                ambient = rays.weight * self.ambient_term(light, hit)
                color[:, rays.pixel[~out]] += ambient[:, ~out]
                continue
            to_light, far = self.toward(light, lifted)
            cone = self.cone(light, to_light)
            _, limit = self.toward(light, point)
            shadow = rays.only(np.ones(hit.size, bool), origin=lifted, direction=to_light,
                               leaves=hit)  # fmt: skip
            shadow.bounce = 1
            clear = self.clear(shadow, limit)
            lit = (cone > 0) & (clear > 0) & ~out
            if self.exact:
                lit &= _dot(normal, to_light) >= 0
            dim = np.rint(-64 * np.log2(np.where(clear > 0, clear, 1)))  # to a hundredth
            token = np.where(lit, 1 + dim, 0).astype(np.uint32)
            rays.path = np.where(out, rays.path, rays.path * PRIME + token)
            reached |= lit
            term = self.term(light, point, to_light, far, clear, normal, hit)
            color[:, rays.pixel[lit]] += (rays.weight * cone * term)[:, lit]

        # Where each goes on. Transmission counts on entering, total reflection takes nothing.
        material = self.material[hit]
        entering = ~out & (self.transmission[material] > 0)
        crossing = entering | out
        inside = rays.inside ^ (of_hit & crossing[:, np.newaxis])
        facing = np.where(out, -normal, normal)
        bent, total, mirrored = _refracted(
            rays.direction, facing, self.medium(rays.inside), self.medium(inside)
        )
        rays.path = np.where(crossing, rays.path * PRIME + total, rays.path)
        part = self.transmission[material] * self.fresnel[material] * mirrored
        through = self.transmission[material] - part
        transmitted = rays.weight * np.where(entering & ~total, through, 1)
        mirror = rays.weight * (self.reflection[material] + part)
        more = rays.bounce + 1 < self.max_depth
        goes_through = crossing & (transmitted > 0) & more
        mirrors = reached & ~out & ~(entering & total) & (mirror > 0) & more
        ends = ~goes_through & ~mirrors
        path[rays.pixel[ends]] += rays.path[ends]
        rays.bounce += 1
        rays.leaves = hit
        inside = np.where(total[:, np.newaxis], rays.inside, inside)
        back = rays.direction - 2 * _dot(rays.direction, normal) * normal
        return [
            rays.only(mirrors, weight=mirror, origin=lifted, direction=back),
            rays.only(
                goes_through, weight=transmitted, origin=point, direction=bent, inside=inside
            ),
        ]

    def medium(self, inside: NDArray[np.bool_]) -> Array:
        """The index of refraction of what rays are in: the smallest sphere's, 1 in none."""
        if len(self.panes) == 0:
            return np.ones(len(inside), self.dtype)
        size = np.where(inside, self.size, len(self.panes))
        smallest = self.panes[size.argmin(axis=1)]
        ior = self.ior[self.material[smallest]]
        found: Array = np.where(inside.any(axis=1), ior, self.dtype.type(1))
        return found

    def toward(self, light: Shining, point: Array) -> tuple[Array, Array]:
        """The direction of a light from some points, and its distance."""
        if isinstance(light, DirectionalLight):
            opposite = -_unit(self._column(light.direction))
            return np.repeat(opposite, point.shape[1], axis=1), np.full(point.shape[1], np.inf)
        position = self._column(light.position)
        return _unit(position - point), _norm(position - point)

    def cone(self, light: Shining, to_light: Array) -> Array:
        """The part of its light that a spot's cone leaves (section 2)."""
        if not isinstance(light, SpotLight) or light.inner_angle == 180:
            return np.ones(to_light.shape[1], self.dtype)
        axis = _unit(self._column(light.look_at) - self._column(light.position))
        outer, inner = np.radians(np.array([light.outer_angle, light.inner_angle], self.dtype))
        # 1 - cosine of the angle from the axis is |L + axis|^2 / 2, which does not cancel.
        versine = _dot(to_light + axis, to_light + axis) / 2
        edges = 2 * np.sin(outer / 2) ** 2, 2 * np.sin(inner / 2) ** 2
        if edges[0] == edges[1]:
            return np.where(versine < edges[0], self.dtype.type(1), 0)
        t = np.clip((edges[0] - versine) / (edges[0] - edges[1]), 0, 1)
        smooth: Array = t**2 * (3 - 2 * t)
        return smooth

    def ambient_term(self, light: Shining | AmbientLight, hit: Array) -> Array:
        """What a hit point sends of a light whatever its place (section 3)."""
        term: Array = self.ambient[:, self.material[hit]] * self._column(light.ambient)
        return term if self.color is None else term * self.color[:, hit]

    def term(
        self,
        light: Shining,
        point: Array,
        to_light: Array,
        distance: Array,
        clear: Array,
        normal: Array,
        hit: Array,
    ) -> Array:
        """What a hit point sends to the camera of a light that reaches it (section 3, 11.8)."""
        material = self.material[hit]
        to_camera = self.to_camera(point)
        half_way = _unit(to_light + to_camera)
        mirrored = 2 * _dot(normal, to_light) * normal - to_light
        shininess = self.shininess[material]
        highlight = np.where(
            self.phong[material],
            np.maximum(_dot(mirrored, to_camera), 0) ** shininess,
            np.maximum(_dot(normal, half_way), 0) ** (shininess / 4),
        )
        diffuse = self.diffuse[:, material] * self._column(light.diffuse) * _dot(to_light, normal)
        if self.color is not None:
            diffuse = diffuse * self.color[:, hit]
        specular = self.specular[:, material] * self._column(light.specular) * highlight
        ambient = self.ambient_term(light, hit)
        found: Array = ambient + _left(light, distance) * clear * (diffuse + specular)
        return found


def _refracted(
    direction: Array, normal: Array, before: Array, after: Array
) -> tuple[Array, NDArray[np.bool_], Array]:
    """Where rays go that meet a surface, `normal` towards them, between two media (section 8):
    Snell's law, or total reflection; where that is, and Fresnel's mirrored part of unpolarised
    light."""
    cosine = -_dot(direction, normal)
    eta = before / after
    k = 1 - eta**2 * (1 - cosine**2)
    total = k < 0
    other = np.sqrt(np.where(total, 0, k))  # the cosine on the other side
    through = eta * direction + (eta * cosine - other) * normal
    back = direction + 2 * cosine * normal
    with np.errstate(invalid="ignore"):
        across = (before * cosine - after * other) / (before * cosine + after * other)
        aligned = (before * other - after * cosine) / (before * other + after * cosine)
    mirrored = np.fmin((across**2 + aligned**2) / 2, 1)
    return np.where(total, back, through), total, mirrored


def _left(light: Shining, distance: Array) -> Array | float:
    """What attenuation leaves of a light (section 2), at most 2^50."""
    if isinstance(light, DirectionalLight) or light.attenuation == (1, 0, 0):
        return 1.0
    constant, linear, quadratic = map(distance.dtype.type, light.attenuation)
    with np.errstate(divide="ignore"):
        left = 1 / (constant + linear * distance + quadratic * distance**2)
    most: Array = np.minimum(left, 2.0**50)
    return most
