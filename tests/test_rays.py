"""The kernel's own intersection functions on single rays: a million of each family.

The truth is computed in long double from the very numbers that the kernel gets. u is half a unit in
the last place of 1, D a ray's distance from a sphere's centre, r its radius, s the distance of the
centre from the ray's line.
"""

import functools
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from conftest import options, run_kernel
from numpy.typing import NDArray

from clrt.renderer.pack.spheres import pack_spheres
from clrt.renderer.pack.structs import PRECISIONS, Precision

Array = NDArray[Any]

PACKET = 16  # rays on one sphere
SPHERES = 1 << 16

# A packet is stored as three vectors, of each the x of its rays, then y, then z: the origins, the
# directions and what else the kernel needs. Its sphere is number 0 of a list of one.
KERNELS = """
#if LANES == 1
#define LOAD(from) (*(from))
#define STORE(v, to) (*(to) = (v))
#else
#define LOAD(from) JOIN(vload, LANES)(0, from)
#define STORE(v, to) JOIN(vstore, LANES)(v, 0, to)
#endif

static Vector load(__global const real *from) {
    return vector(LOAD(from), LOAD(from + 16), LOAD(from + 32));
}

// found: the distance, infinity for a miss.
__kernel void probe(__global const Sphere *spheres, __global const real *rays,
                    __global real *found) {
    int i = get_global_id(0) * LANES, s = i / 16;
    __global const real *from = rays + 144 * s + i % 16;
    Ray ray = {load(from), load(from + 48), -1, -1};
    STORE(nearest(ray, spheres + s, 1).distance, found + i);
}

// Goes on from where the ray hits, as the render kernel does, in the third vector's direction, or
// against it if that leads inward: once as a ray that leaves the sphere and once as any ray.
// found: the distances of the hit and of these two.
__kernel void leave_again(__global const Sphere *spheres, __global const real *rays,
                    __global real *found) {
    int i = get_global_id(0) * LANES, s = i / 16;
    __global const real *from = rays + 144 * s + i % 16;
    Ray ray = {load(from), load(from + 48), -1, -1};
    reals distance = nearest(ray, spheres + s, 1).distance;
    found += 48 * s + i % 16;
    STORE(distance, found);
    Vector point = along(ray.origin, distance, ray.direction);
    Vector normal = plus(minus(point, splat(spheres[s].anchor)), splat(spheres[s].offset));
    Vector outward = load(from + 96);
    outward = pick3(dot3(outward, normal) < 0, scaled(outward, -1), outward);
    Ray leaving = {point, outward, 0, -1};
    STORE(nearest(leaving, spheres + s, 1).distance, found + 16);
    leaving.leaves = -1;
    STORE(nearest(leaving, spheres + s, 1).distance, found + 32);
}

// found: 1 if the sphere stands between the origin and a light, the third vector's first numbers.
__kernel void shade(__global const Sphere *spheres, __global const real *rays,
                    __global real *found, __global const uchar *encloses) {
    int i = get_global_id(0) * LANES, s = i / 16;
    __global const real *from = rays + 144 * s + i % 16, *light = rays + 144 * s + 96;
    Vector to_light = minus(splat(light), load(from));
    reals distance = sqrt(dot3(to_light, to_light));
    Ray ray = {load(from), scaled(to_light, 1 / distance), -1, -1};
    ints hidden = occluded(ray, distance, encloses + s, spheres + s, 0, 1);
    STORE(PICK(hidden, 1, 0), found + i);
}
"""


@dataclass(frozen=True)
class Family:
    """Spheres (n,) and PACKET rays on each, (3, n, PACKET), all in the kernel's precision."""

    center: Array  # (3, n)
    radius: Array
    origin: Array
    direction: Array


@dataclass(frozen=True)
class Lines:
    """What is true of a family's rays, (n, PACKET) each, in long double."""

    radius: Array
    away: Array  # D
    aside: Array  # s
    ahead: Array  # the distance to the point of the line that is nearest to the centre
    half_chord: Array  # 0 where the line misses
    distance: Array  # to the hit; infinity where there is none


class Prober:
    """Runs the test kernels in one precision and with one number of lanes."""

    def __init__(self, device: cl.Device, precision: Precision, lanes: int) -> None:
        self.real: Any = PRECISIONS[precision]
        self.u = np.finfo(self.real).eps / 2
        self.lanes = lanes
        self.device = device
        self.options = options(lanes, precision, light_inside=True)

    def run(
        self,
        name: str,
        family: Family,
        third: Array | None = None,
        encloses: Array | None = None,
    ) -> Array:
        """What a kernel finds: (results, n, PACKET).

        third: (3, n, PACKET), the vector that `leave` and `shade` take.
        encloses: (n,), for `shade`: whether the sphere encloses the light.
        """
        n = family.radius.size
        vectors = (family.origin, family.direction, family.origin if third is None else third)
        rays = np.concatenate(vectors).astype(self.real).transpose(1, 0, 2)
        spheres = pack_spheres(
            family.center.T.astype(np.longdouble),
            family.radius.astype(np.longdouble),
            0.0,
            self.real,
        )
        found = np.empty((n, 3 if name == "leave_again" else 1, PACKET), self.real)
        more = [] if encloses is None else [encloses]
        size = n * PACKET // self.lanes
        run_kernel(self.device, KERNELS, name, self.options, size, (spheres, rays), found, *more)
        return found.transpose(1, 0, 2)


@pytest.fixture(scope="module", params=["robust-1", "robust-16", "double-1", "double-16"])
def prober(request: pytest.FixtureRequest, device: cl.Device) -> Prober:
    precision, lanes = request.param.split("-")
    if precision == "double" and device.native_vector_width_double == 0:
        pytest.skip("no float64")
    if precision == "double" and np.finfo(np.longdouble).nmant == 52:
        pytest.skip("long double is no wider than double here: nothing to check against")
    return Prober(device, precision, int(lanes))


def norm(v: Array) -> Array:
    length: Array = np.sqrt((v * v).sum(axis=0))
    return length


def unit(v: Array) -> Array:
    """In long double, so that only the rounding to the kernel's precision is left."""
    v = v.astype(np.longdouble)
    return v / norm(v)


def directions(rng: np.random.Generator, *shape: int) -> Array:
    return unit(rng.normal(size=(3, *shape)))


def across(rng: np.random.Generator, v: Array) -> Array:
    """Unit vectors perpendicular to the unit vectors v."""
    return unit(np.cross(v, rng.normal(size=v.shape), axis=0))


def decades(rng: np.random.Generator, low: float, high: float, *shape: int) -> Array:
    """Numbers from 10^low to 10^high, as many of each decade."""
    return 10 ** rng.uniform(low, high, shape)


def close(rng: np.random.Generator, u: Any, *shape: int) -> Array:
    """Numbers from -1 to 1, as many of each decade from u up."""
    return decades(rng, np.log10(u), 0, *shape) * rng.choice([-1, 1], shape)


def lines(family: Family) -> Lines:
    wide = np.longdouble
    radius = family.radius.astype(wide)[:, np.newaxis]
    f = family.origin.astype(wide) - family.center.astype(wide)[:, :, np.newaxis]
    length = norm(family.direction.astype(wide))  # not quite 1
    direction = family.direction / length
    away = norm(f)
    aside = norm(np.cross(f, direction, axis=0))
    ahead = -(f * direction).sum(axis=0)
    half_chord = np.sqrt(np.maximum(radius - aside, 0) * (radius + aside))
    # Not ahead - half_chord, which cancels near a surface.
    distance = (away - radius) * (away + radius) / (ahead + half_chord)
    hit = (aside < radius) & (ahead > 0) & (away > radius)
    return Lines(radius, away, aside, ahead, half_chord, np.where(hit, distance / length, np.inf))


@functools.cache
def silhouettes(real: Any) -> tuple[Family, Lines]:
    """Spheres from D/r = 1.001 to 1e6, passed or hit at s/r = 1 +- u to 1. Where the camera stands,
    which decides what is a giant, has nothing to do with where the rays come from."""
    rng = np.random.default_rng(1)
    u = np.finfo(real).eps / 2
    radius = decades(rng, -3, 3, SPHERES)
    center = directions(rng, SPHERES) * radius * (1 + decades(rng, -4, 3, SPHERES))
    away = radius * (1 + decades(rng, -3, 6, SPHERES))
    aside = radius[:, np.newaxis] * (1 + close(rng, u, SPHERES, PACKET))
    sine = np.minimum(aside / away[:, np.newaxis], 1)
    toward = directions(rng, SPHERES, PACKET)
    direction = unit(toward * np.sqrt(1 - sine**2) + across(rng, toward) * sine)
    center = center.astype(real)
    origin = center[:, :, np.newaxis] - away[:, np.newaxis] * toward
    family = Family(center, radius.astype(real), origin.astype(real), direction.astype(real))
    return family, lines(family)


def test_silhouettes(prober: Prober) -> None:
    """A ray is judged wrongly only if it passes within 4 u (D + r) of the silhouette."""
    family, true = silhouettes(prober.real)
    found = prober.run("probe", family)[0]
    wrong = np.isfinite(found) != np.isfinite(true.distance)
    margin = abs(true.aside - true.radius) / (prober.u * (true.away + true.radius))
    level = abs(true.ahead) < 4 * prober.u * true.away  # ahead or behind?
    assert wrong.any()  # else the rays are too easy
    assert margin[wrong & ~level].max() <= 4


def test_distances(prober: Prober) -> None:
    """A hit is off by 9 u (D + r), times r / half a chord where the ray grazes the sphere."""
    family, true = silhouettes(prober.real)
    found = prober.run("probe", family)[0]
    # Where the half chord itself is known to an eighth.
    sure = true.radius - true.aside > 32 * prober.u * (true.away + true.radius)
    hit = sure & np.isfinite(true.distance)
    unit_error = prober.u * (true.away + true.radius) * true.radius
    off = abs(found[hit] - true.distance[hit]) * true.half_chord[hit]
    assert (off / unit_error[hit]).max() <= 9


@functools.cache
def giants(real: Any) -> tuple[Family, Lines]:
    """A camera at heights of 1e-2 to 1e2 above spheres of 4 to 1e9 times that, and rays from within
    some ten heights of it: half of them close to the horizon."""
    rng = np.random.default_rng(2)
    u = np.finfo(real).eps / 2
    flat = 9 if u > 1e-10 else 2  # what long double can tell from the truth in double
    height = decades(rng, -2, 2, SPHERES)
    radius = (height * decades(rng, 0.7, flat, SPHERES)).astype(real)
    up = directions(rng, SPHERES)
    center = (-up * (radius + height)).astype(real)
    # The rounding has moved the surface: the height above where it is now.
    height = (norm(center.astype(np.longdouble)) - radius).astype(float)
    over = height[:, np.newaxis] * (decades(rng, -1, 1, SPHERES, PACKET) - 1)
    up = np.repeat(up[:, :, np.newaxis], PACKET, axis=2)
    level = across(rng, up)
    beside = height[:, np.newaxis] * decades(rng, -2, 1, SPHERES, PACKET)
    origin = over * up + beside * across(rng, up)
    away = radius[:, np.newaxis] + height[:, np.newaxis] + over
    dip = np.sqrt(np.maximum(1 - (radius[:, np.newaxis] / away) ** 2, 0))  # of the horizon
    slope = np.where(
        rng.random((SPHERES, PACKET)) < 0.5,
        dip * (1 + close(rng, u, SPHERES, PACKET)),
        decades(rng, -5, 1, SPHERES, PACKET),
    )
    direction = unit(level - slope * up)
    family = Family(center, radius, origin.astype(real), direction.astype(real))
    return family, lines(family)


def test_giants(prober: Prober) -> None:
    """A hit lies 4 u (|o| + t) off a giant's surface, however large its radius; its horizon is off
    by the angle u."""
    family, true = giants(prober.real)
    found = prober.run("probe", family)[0]
    reach = norm(family.origin.astype(np.longdouble))
    outside = true.away - true.radius > 1e-3 * reach
    wrong = outside & (np.isfinite(found) != np.isfinite(true.distance))
    level = abs(true.ahead) < 4 * prober.u * true.away  # ahead or behind?
    margin = abs(true.aside - true.radius) / (prober.u * (abs(true.ahead) + reach))
    assert margin[wrong & ~level].max(initial=0) <= 1

    hit = outside & np.isfinite(found) & np.isfinite(true.distance)
    t = np.where(hit, found, 0).astype(np.longdouble)
    center = family.center.astype(np.longdouble)[:, :, np.newaxis]
    off = abs(norm(family.origin + t * family.direction - center) - true.radius)
    assert (off / (prober.u * (reach + t)))[hit].max() <= 4


def test_a_ray_never_hits_the_sphere_it_leaves(prober: Prober) -> None:
    """Radii from 1e-4 to 1e4, seen from gaps of 1e-4 to 1e4, left at all angles down to u: there is
    no epsilon that would fit them all."""
    rng = np.random.default_rng(3)
    real = prober.real
    radius = decades(rng, -4, 4, SPHERES)
    center = directions(rng, SPHERES) * (radius + decades(rng, -4, 4, SPHERES))
    normal = directions(rng, SPHERES, PACKET)
    normal *= np.sign(-(normal * center[:, :, np.newaxis]).sum(axis=0))  # towards the camera
    aim = unit(center[:, :, np.newaxis] + 0.999 * radius[:, np.newaxis] * normal)
    family = Family(
        center.astype(real), radius.astype(real), np.zeros_like(aim, real), aim.astype(real)
    )
    t = lines(family).distance
    sure = np.isfinite(t)
    point = np.where(sure, t, 0) * aim
    normal = unit(point - center[:, :, np.newaxis]).astype(float)
    outward = unit(across(rng, normal) + close(rng, prober.u, SPHERES, PACKET) * normal)
    hit, left, stayed = prober.run("leave_again", family, outward)
    assert np.isfinite(hit).mean() > 0.9
    assert not np.isfinite(left).any()
    # Nor would it if nothing were skipped: rounding turns a ray inward by u, but one that starts
    # u D above the surface meets it again only if it leads inward by sqrt(2 u D / r).
    assert not np.isfinite(stayed).any()


def test_shadows(prober: Prober) -> None:
    """Lights in, before and behind spheres, 1e-6 to 1 radii off the surface, seen from up to 1e5
    radii away: only rays that graze the sphere are judged wrongly."""
    rng = np.random.default_rng(4)
    real = prober.real
    radius = decades(rng, -3, 3, SPHERES)
    center = (directions(rng, SPHERES) * radius * (1 + decades(rng, -4, 3, SPHERES))).astype(real)
    radius = radius.astype(real)
    out = directions(rng, SPHERES)
    light = (center + out * radius * (1 + close(rng, 1e-6, SPHERES))).astype(real)
    toward = directions(rng, SPHERES, PACKET)
    away = radius[:, np.newaxis] * (1 + decades(rng, -3, 5, SPHERES, PACKET))
    origin = (center[:, :, np.newaxis] - away * toward).astype(real)
    third = np.zeros_like(origin)
    third[0, :, :3] = light.T
    to_light = light[:, :, np.newaxis].astype(np.longdouble) - origin
    length = norm(to_light)
    family = Family(center, radius, origin, to_light / length)
    true = lines(family)
    hidden = np.isfinite(true.distance) & (true.distance < length)
    height = norm(light.astype(np.longdouble) - center) - radius
    encloses = (height < 0).astype(np.uint8)
    wrong = (prober.run("shade", family, third, encloses)[0] > 0) != hidden
    margin = abs(true.aside - true.radius) / (prober.u * (true.away + true.radius))
    assert 0.1 < hidden.mean() < 0.9
    sure = (abs(height) > 4 * prober.u * radius)[
        :, np.newaxis
    ]  # the light's rounding took it so close
    assert margin[wrong & sure].max(initial=0) <= 5  # 1 of it the rounding of the direction


@pytest.mark.parametrize(
    ("center", "radius", "origin", "hit"),
    [
        ((0.5, 0, -1), 0.5, (0, 0, 1), False),  # tangent
        ((0.5, 0, -1), "the number after 0.5", (0, 0, 1), True),
        ((0, 0, -1e3), 1e-6, (0, 0, 0), True),  # small and far
        ((0, 0, -1e6), 1e-6, (0, 0, 0), True),
        ((0, 0, -1e6), 1e-6, (0, 0, 1), True),
        ((0, 0, -1), 1.0, (0, 0, 0), False),  # from its surface inward
        ((0, 0, -1), 2.0, (0, 0, 0), False),  # from inside
        ((0, 0, 3), 1.0, (0, 0, 0), False),  # behind
        ((0, -1e6 - 1, 0), 1e6, (0, 0, 0), False),  # level, above a giant
        ((0, -1024, 0), 1024.0, (0, 0, 0), False),  # along a giant
        ((0, 0, -1025), 1024.0, (0, 0, 0), True),  # straight at a giant
    ],
)
def test_single_rays(prober: Prober, center, radius, origin, hit) -> None:
    real: Any = prober.real
    if isinstance(radius, str):
        radius = np.nextafter(real(0.5), real(1))
    rays = np.zeros((3, 1, PACKET), real)
    family = Family(
        np.array(center, real)[:, np.newaxis],
        np.array([radius], real),
        rays + np.array(origin, real)[:, np.newaxis, np.newaxis],
        rays + np.array((0, 0, -1), real)[:, np.newaxis, np.newaxis],
    )
    assert (np.isfinite(prober.run("probe", family)) == hit).all()
