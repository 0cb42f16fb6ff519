"""The truth: the paper's algorithm in float64 NumPy, to check the kernel against.

The paper is Antonio Sirignano, "Lighting and Shading: il modello del Ray Tracing". Its own source
for the program is Omar Aflak, "Ray Tracing From Scratch in Python" (2020).

Two truths (docs/accuracy.md):

- ``"seed"``: the paper to the letter. A hit point is lifted off its surface by the scene's
  ``shadow_bias`` along the normal, and the sphere it lies on is tested like any other.
- ``"exact"``: the geometry with no bias. A ray never hits the sphere it leaves, and a light behind
  the surface (N.L < 0) does not reach it. There is one ray a pixel, whatever `samples` is.

Neither truth knows light that spreads over many directions: round lights, occlusion, lenses, rough
mirrors, indirect light. Closed forms are the truth there.

Written to be read beside the paper's sections 11.2 to 11.11, not to be fast. Vectors are arrays of
shape (3, n), one column a ray.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

from clrt.errors import RequestError
from clrt.scene.light import AmbientLight
from clrt.scene.scene import Scene, beyond_one_ray, beyond_paper
from clrt.truth import camera, glass, hits, lights, surface
from clrt.truth.rays import Array, Rays, dot
from clrt.truth.world import World

Truth: TypeAlias = Literal["seed", "exact"]

CHUNK_PIXELS = 1 << 16  # pixels traced at a time: their arrays stay in the cache
PRIME = np.uint32(16777619)
LEAST_WEIGHT = 2.0**-10  # of a ray that has gone through something


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
    """(height, width), or (n,), as the following: 1 less the product of 1 - opacity of the spheres
    that the camera sees, 0 where there is none."""
    depth: Array
    """How far along the camera's ray, world units; infinity where it meets none. Of an orthographic
    camera from the plane that it stands on, and negative behind it."""
    normal: Array
    """(height, width, 3): outwards, of unit length, in world space; 0 where there is none."""
    id: NDArray[np.int32]
    """The index of the sphere, capsule or face; -1 where there is none."""


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
    """The true picture and its paths: see clrt.reference.trace(), which reads files as well."""
    if truth not in ("seed", "exact"):
        raise RequestError(f"truth: expected 'seed' or 'exact', got {truth!r}")
    if key := beyond_one_ray(scene):
        raise RequestError(f"truth: {truth!r} knows no {key}: closed forms are the truth there")
    if truth == "seed" and (key := beyond_paper(scene)):
        raise RequestError(f"truth: 'seed' knows no {key}, expected 'exact'")
    if scene.particles:
        raise RequestError("particles: expected none that are in files: clrt.reference reads them")
    world = World(scene, truth == "exact", np.dtype(dtype))
    x, y = camera.screen(scene.camera, width, height, world.dtype)
    right, up = (np.array(offset) / np.maximum([width - 1, height - 1], 1)).astype(world.dtype)
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
    image, normal = np.zeros((n, 3), world.dtype), np.zeros((n, 3), world.dtype)
    left, paths, sphere = np.ones(n, world.dtype), np.zeros(n, np.uint32), np.full(n, -1, np.int32)
    depth = np.full(n, np.inf, world.dtype)
    for start in range(0, n, CHUNK_PIXELS):
        chunk = slice(start, start + CHUNK_PIXELS)
        first = First(sphere[chunk], depth[chunk], normal[chunk].T, left[chunk])
        color, paths[chunk] = _paths(world, grid_x[chunk], grid_y[chunk], first)
        image[chunk] = color.T
    alpha = 1 - left
    if not scene.film.transparent:
        image += (1 - alpha)[:, np.newaxis] * np.array(scene.film.background, world.dtype)
    return Trace(
        image.reshape(*shape, 3),
        paths.reshape(shape),
        world.rays,
        alpha.reshape(shape),
        depth.reshape(shape),
        normal.reshape(*shape, 3),
        sphere.reshape(shape),
    )


def mean(scene: Scene, width: int, height: int, offsets: Array) -> Array:
    """The mean of true pictures: see clrt.reference.mean()."""
    found = np.zeros((height, width, 4))
    for right, up in offsets:
        one = trace(scene, width, height, offset=(right, up))
        found[..., :3] += one.image
        found[..., 3] += one.alpha
    return found / len(offsets)


class First(NamedTuple):
    """The first surfaces that camera rays meet, and what these leave, to be filled in."""

    sphere: Array
    depth: Array
    normal: Array
    """(3, n)"""
    left: Array
    """The product of 1 - opacity of all surfaces on their straight way."""


def _paths(world: World, x: Array, y: Array, first: First) -> tuple[Array, NDArray[np.uint32]]:
    """Colours (3, n) and paths (n,) of the pixels at x, y on the screen (11.11)."""
    color = np.zeros((3, x.size), world.dtype)
    path = np.zeros(x.size, np.uint32)
    todo = [camera.first_rays(world, x, y)]
    while todo:
        todo += _segment(world, todo.pop(), color, path, first)
    return color, path


def _segment(
    world: World, rays: Rays, color: Array, path: NDArray[np.uint32], first: First
) -> list[Rays]:
    """Follows rays to their next hits, and adds these to colours and paths. Returns the rays that
    go on."""
    hit, distance = hits.nearest(world, rays)
    gone = hit < 0
    path[rays.pixel[gone]] += rays.path[gone]
    if rays.bounce > 0:  # the camera's own background is added where alpha is known
        color[:, rays.pixel[gone]] += rays.weight[gone] * world.background
    rays, distance, hit = rays.only(hit >= 0), distance[hit >= 0], hit[hit >= 0]
    if hit.size == 0:
        return []
    point = rays.origin + distance * rays.direction
    met = hits.met(world, rays, hit, point)
    normal = met.normal
    lifted = point + (world.bias + met.lift) * normal
    opacity = world.opacity[hit]
    if rays.bounce == 0:
        new = first.sphere[rays.pixel] < 0
        pixel = rays.pixel[new]
        first.sphere[pixel], first.normal[:, pixel] = hit[new], met.shaded[:, new]
        first.depth[pixel] = dot(point - world.camera, rays.direction)[new]
        first.left[rays.pixel] *= 1 - opacity
    gives = rays.weight * opacity
    rays.path = rays.path * PRIME + met.token
    # A far side is not shaded.
    of_hit = world.panes == hit[:, np.newaxis]
    out = (of_hit & rays.inside).any(axis=1)
    reached = np.zeros(hit.size, bool)
    for light in world.lights:
        if isinstance(light, AmbientLight):
            reached |= ~out
            ambient = gives * surface.ambient_term(world, light, met)
            color[:, rays.pixel[~out]] += ambient[:, ~out]
            continue
        to_light, far = lights.toward(world, light, lifted)
        cone = lights.cone(world, light, to_light)
        _, limit = lights.toward(world, light, point)
        shadow = rays.only(np.ones(hit.size, bool), origin=lifted, direction=to_light,
                           leaves=hit)  # fmt: skip
        shadow.bounce = 1
        clear = hits.clear(world, shadow, limit)
        lit = (cone > 0) & (clear > 0) & ~out
        if world.exact:
            lit &= dot(normal, to_light) >= 0
        dim = np.rint(-64 * np.log2(np.where(clear > 0, clear, 1)))  # to a hundredth
        token = np.where(lit, 1 + dim, 0).astype(np.uint32)
        rays.path = np.where(out, rays.path, rays.path * PRIME + token)
        reached |= lit
        term = surface.term(world, light, point, to_light, far, clear, met)
        color[:, rays.pixel[lit]] += (gives * cone * term)[:, lit]

    # Where each goes on: straight behind what it sees through, for as long as that matters.
    left = rays.weight * (1 - opacity)
    straight_on = (opacity < 1) & (left >= LEAST_WEIGHT)
    straight = rays.only(straight_on, weight=left, behind=distance, passed=hit)
    # Transmission counts on entering, total reflection takes nothing.
    material = world.material[hit]
    entering = ~out & (world.transmission[material] > 0)
    crossing = entering | out
    inside = rays.inside ^ (of_hit & crossing[:, np.newaxis])
    facing = np.where(out, -normal, normal)
    bent, total, mirrored = glass.refracted(
        rays.direction, facing, glass.medium(world, rays.inside), glass.medium(world, inside)
    )
    rays.path = np.where(crossing, rays.path * PRIME + total, rays.path)
    part = world.transmission[material] * world.fresnel[material] * mirrored
    through = world.transmission[material] - part
    transmitted = rays.weight * np.where(entering & ~total, through, 1)
    mirror = rays.weight * (world.reflection[material] + part)
    more = rays.bounce + 1 < world.max_depth
    goes_through = crossing & (transmitted > 0) & more
    mirrors = reached & ~out & ~(entering & total) & (mirror > 0) & more
    ends = ~goes_through & ~mirrors & ~straight_on
    path[rays.pixel[ends]] += rays.path[ends]
    rays.bounce += 1
    rays.leaves = hit
    inside = np.where(total[:, np.newaxis], rays.inside, inside)
    back = rays.direction - 2 * dot(rays.direction, normal) * normal
    rays = rays.turned()
    return [
        straight,
        rays.only(mirrors, weight=mirror, origin=lifted, direction=back),
        rays.only(goes_through, weight=transmitted, origin=point, direction=bent, inside=inside),
    ]
