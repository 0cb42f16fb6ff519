"""The kernel's test of a ray and a capsule, on single rays: a million of each family.

u is half a unit in the last place of 1; |f| is how far the farther end of an axis is from where a
ray starts, and r the radius. Errors are counted in u (|f| + r).
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from conftest import options, run_kernel
from numpy.typing import NDArray

from clrt.renderer.pack.structs import PRECISIONS, Precision

Array = NDArray[Any]

VERDICT, OFF = 5, 8
"""The bounds of capsule.cl. Verdicts are wrong by up to 4.4 of exact tangents: by the rounding of
f, and of m, which turns it. To sum f.m in twice as many bits changes none of the worst. 4 would
take the digits that m lacks: some twenty operations a capsule."""

KERNELS = """
#define ROW(k, from) vload16(0, (from) + (k) * n + i)
#define OF(k, from) (from)[(k) * n + i]
// found: the distance, infinity for a miss: one by one, and 16 at a time.
__kernel void one_by_one(__global const real *rays, __global const real *capsules,
                         __global real *found) {
    int i = get_global_id(0), n = get_global_size(0);
    CAPSULE(real, int, OF(0, rays), OF(1, rays), OF(2, rays), OF(3, rays), OF(4, rays), OF(5, rays),
            OF(0, capsules), OF(1, capsules), OF(2, capsules), OF(4, capsules), OF(5, capsules),
            OF(6, capsules), OF(7, capsules), OF(3, capsules))
    CAPSULE_HIT(real, int)
    found[i] = met ? t : INFINITY;
}
__kernel void in_leaves(__global const real *rays, __global const real *capsules,
                        __global real *found) {
    int i = 16 * get_global_id(0), n = 16 * get_global_size(0);
    CAPSULE(wides, wide_ints, ROW(0, rays), ROW(1, rays), ROW(2, rays), ROW(3, rays), ROW(4, rays),
            ROW(5, rays), ROW(0, capsules), ROW(1, capsules), ROW(2, capsules), ROW(4, capsules),
            ROW(5, capsules), ROW(6, capsules), ROW(7, capsules), ROW(3, capsules))
    CAPSULE_HIT(wides, wide_ints)
    __private wides all[1] = {met ? t : (wides)INFINITY};
    for (int k = 0; k < 16; k++) found[i + k] = ((__private real *)all)[k];
}
"""


@dataclass(frozen=True)
class Family:
    """Rays, each with a capsule of its own, as the kernel gets them: rows."""

    rays: Array  # (6, n): origin, direction
    capsules: Array  # (8, n): start, radius, axis, length


def found(device: cl.Device, precision: Precision, family: Family) -> Array:
    """The distances, (n,)."""
    some = options(16, precision, tree=True, capsules=True)
    n = family.rays.shape[1]
    distances = [np.empty(n, family.rays.dtype) for _ in range(2)]
    inputs = [family.rays, family.capsules]
    run_kernel(device, KERNELS, "one_by_one", some, n, inputs, distances[0])
    run_kernel(device, KERNELS, "in_leaves", some, n // 16, inputs, distances[1])
    assert np.array_equal(distances[0], distances[1])
    return distances[0]


def norm(v: Array) -> Array:
    return np.sqrt((v * v).sum(axis=0))


def family(radius: float, length: float, along: bool, n: int, precision: Precision) -> Family:
    """Half of the rays aim at the silhouette, as near as rounding lets them, half across it.

    along: they are nearly along the axis, by 1e-7 to 0.1.
    """
    random = np.random.default_rng(6)
    real: Any = PRECISIONS[precision]
    origin = random.uniform(-1, 1, (3, n)).astype(real)
    start = random.uniform(-1, 1, (3, n))
    axis = random.normal(size=(3, n))
    if along:
        tilt = random.normal(size=(3, n)) * 10.0 ** random.uniform(-7, -1, n)
        axis = (start - origin) / norm(start - origin) + tilt
    axis /= norm(axis)
    capsules = np.empty((8, n), real)
    capsules[:3], capsules[3], capsules[4:7], capsules[7] = start, radius, axis, length
    aim = start + random.random(n) * length * axis
    side = np.cross(aim - origin, axis, axis=0)
    side /= np.maximum(norm(side), 1e-30)
    u = np.finfo(real).eps / 2
    near = radius * (1 + random.normal(size=n) * 4 * u / radius)
    # A tangent passes beside the axis a little farther off than it touches.
    away = norm(np.cross(start - origin, axis, axis=0))
    near = near / np.sqrt(np.maximum(1 - (near / np.maximum(away, 1e-30)) ** 2, 0.01))
    off = np.where(random.random(n) < 0.5, near, radius * random.random(n))
    way = aim + off * side - origin
    return Family(np.concatenate([origin, (way / norm(way)).astype(real)]).astype(real), capsules)


def from_axis(capsules: Array, point: Array) -> Array:
    """How far points are from the axes."""
    aside = point - capsules[:3]
    there = np.clip((aside * capsules[4:7]).sum(axis=0), 0, capsules[7])
    return norm(aside - there * capsules[4:7])


def errors(some: Family, distance: Array, wide: Any) -> tuple[Array, Array]:
    """By how much verdicts are wrong, and how far hits lie off the surface."""
    u = np.finfo(some.rays.dtype).eps / 2
    rays, capsules = some.rays.astype(wide), some.capsules.astype(wide)
    capsules[4:7] /= norm(capsules[4:7])
    origin, way = rays[:3], rays[3:] / norm(rays[3:])
    start, radius, axis, length = capsules[:3], capsules[3], capsules[4:7], capsules[7]
    # The point of the axis that is nearest to the line, and of the line to that.
    aside = start - origin
    cosine = (axis * way).sum(axis=0)
    across = 1 - cosine**2
    y = cosine * (aside * way).sum(axis=0) - (aside * axis).sum(axis=0)
    y = np.clip(y / np.maximum(across, 1e-300), 0, length)
    nearest = aside + y * axis
    ahead = (nearest * way).sum(axis=0)
    apart = norm(nearest - ahead * way)
    reach = np.maximum(norm(aside), norm(aside + length * axis)) + radius
    outside = from_axis(capsules, origin) > radius + VERDICT * u * reach
    met, true = distance < np.inf, (apart < radius) & (ahead > 0)
    wrong = outside & (met != true)
    point = origin + np.where(met, distance, 0) * rays[3:]
    off = abs(from_axis(capsules, point) - radius)
    return (abs(apart - radius) / (u * reach))[wrong], (off / (u * reach))[met & true & outside]


FAMILIES = {
    "specks": (1e-3, 1e-2, False),
    "bonds": (1e-2, 0.3, False),
    "sausages": (0.1, 0.5, False),
    "pills": (0.3, 0.1, False),
    "bonds along": (1e-2, 0.3, True),
    "sausages along": (0.1, 1.0, True),
}


@pytest.mark.parametrize(
    "n", [80_000, pytest.param(1_000_000, marks=pytest.mark.slow)], ids=["some", "a million"]
)
@pytest.mark.parametrize("name", FAMILIES)
def test_within_the_bounds(device: cl.Device, name: str, n: int) -> None:
    some = family(*FAMILIES[name], n, "robust")
    distance = found(device, "robust", some)
    assert 0.2 < (distance < np.inf).mean() < 0.97
    wrong, off = errors(some, distance, np.float64)
    assert wrong.max(initial=0) <= VERDICT
    assert off.max() <= OFF


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILIES)
def test_within_the_bounds_of_float64(device: cl.Device, name: str) -> None:
    if device.native_vector_width_double == 0:
        pytest.skip("no float64")
    some = family(*FAMILIES[name], 80_000, "double")
    wrong, off = errors(some, found(device, "double", some), np.longdouble)
    assert wrong.max(initial=0) <= VERDICT
    assert off.max() <= OFF


# Rays and capsules of which it is known where they meet. Each: origin, direction, start, radius,
# axis, length, and the distance.
ACROSS, AXIS, UP = (0, 0, -1), (0, 0, 1), (0, 1, 0)
HARD: dict[str, tuple[Any, Any, Any, float, Any, float, float]] = {
    "end-on": ((0, 0, 3), ACROSS, (0, 0, 0), 0.5, AXIS, 1, 1.5),
    "end-on, from the start": ((0, 0, -3), AXIS, (0, 0, 0), 0.5, AXIS, 1, 2.5),
    "along, off the axis": ((0.3, 0, 3), ACROSS, (0, 0, 0), 0.5, AXIS, 1, 1.6),
    "along, beside": ((0.6, 0, 3), ACROSS, (0, 0, 0), 0.5, AXIS, 1, np.inf),
    "along, away": ((0, 0, 3), AXIS, (0, 0, 0), 0.5, AXIS, 1, np.inf),
    "along, inside": ((0.1, 0, 0.5), ACROSS, (0, 0, 0), 0.5, AXIS, 1, np.inf),
    "across": ((0, 0, 3), ACROSS, (0, -1, 0), 0.5, UP, 2, 2.5),
    "across, beyond the end": ((0, 1.3, 3), ACROSS, (0, -1, 0), 0.5, UP, 2, 2.6),
    "across, behind": ((0, 0, -3), ACROSS, (0, -1, 0), 0.5, UP, 2, np.inf),
    "from inside": ((0, 0.9, 0.2), ACROSS, (0, -1, 0), 0.5, UP, 2, np.inf),
    "from inside the end": ((0, 1.2, 0), ACROSS, (0, -1, 0), 0.5, UP, 2, np.inf),
    "from inside, below the end": ((0.45, 0.6, 0), (-1, 0.1, 0), (0, -1, 0), 0.5, UP, 2, np.inf),
    "a ball": ((0, 0, 3), ACROSS, (0, 0, 0), 0.5, (0, 0, 0), 0, 2.5),
    "a ball, off its middle": ((0.3, 0, 3), ACROSS, (0, 0, 0), 0.5, (0, 0, 0), 0, 2.6),
    "nearly a ball": ((0.3, 0, 3), ACROSS, (0, 0, 0), 0.5, UP, 5e-7, 2.6),
    "a hair": ((0, 0, 3), ACROSS, (0, -0.5, 0), 1e-6, UP, 1, 3 - 1e-6),
    "a hair, beside": ((3e-6, 0, 3), ACROSS, (0, -0.5, 0), 1e-6, UP, 1, np.inf),
    "a hair, end-on": ((0, 0, 3), ACROSS, (0, 0, 0), 1e-6, AXIS, 1, 2 - 1e-6),
    "onto the seam": ((0, 1, 3), ACROSS, (0, -1, 0), 0.5, UP, 2, 2.5),
}


@pytest.mark.parametrize("precision", ["robust", "double"])
def test_hard_cases(device: cl.Device, precision: Precision) -> None:
    if precision == "double" and device.native_vector_width_double == 0:
        pytest.skip("no float64")
    rays, capsules = np.zeros((6, 32)), np.ones((8, 32))
    for i, (origin, way, start, radius, axis, length, _) in enumerate(HARD.values()):
        rays[:, i] = *origin, *(np.array(way) / np.linalg.norm(way))
        capsules[:, i] = *start, radius, *axis, length
    real: Any = PRECISIONS[precision]
    distance = found(device, precision, Family(rays.astype(real), capsules.astype(real)))
    for (name, case), given in zip(HARD.items(), distance, strict=False):
        assert given == pytest.approx(case[-1], rel=2e-6 if precision == "robust" else 1e-9), name
