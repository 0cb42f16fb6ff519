"""The kernel's test of a ray and a face, on single rays that are hard to judge.

u is half a unit in the last place of 1; f are the corners of a face from where a ray starts. Errors
are counted in u |f| of the farthest.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from conftest import kernels_of, options
from numpy.typing import NDArray

from clrt.renderer.pack.structs import PRECISIONS, Precision

Array = NDArray[Any]

VERDICT, OFF = 2, 8
"""The bounds of face.cl."""

PAIRS = """
// Ray i against triangle i, which is alone in its leaf; found: distances, infinity of a miss.
__kernel void pairs(__global const real *rays, __global const Face *faces,
                    __global FaceLeaf *leaves, __global real *found) {
    int i = get_global_id(0);
    __global FaceLeaf *leaf = leaves + i;
    Box box = {{0, 0, 0}, {0, 0, 0}};
    for (int j = 0; j < WIDE; j++) put_face_into(leaf, j, j ? -1 : 0, j ? 0 : faces + i, &box);
    Single ray = {{rays[6 * i], rays[6 * i + 1], rays[6 * i + 2]},
                  {rays[6 * i + 3], rays[6 * i + 4], rays[6 * i + 5]}, -1};
    real distance = INFINITY;
    INTEGER id = -1;
    Tree tree = {0};
    nearest_face(&tree, leaf, &ray, &distance, &id);
    found[i] = distance;
}
"""
AT_ONCE = 1 << 14


@dataclass(frozen=True)
class Family:
    """Triangles around points of a cube, and rays from its points that pass some roundings beside
    one of their edges."""

    size: float
    thin: float | None = None  # how wide they are as a part of how long; None: as it comes
    diagonal: bool = False  # rays go along a diagonal of the cube, about: they are sheared most

    def made(self, real: Any, n: int, seed: int) -> tuple[Array, Array]:
        """Rays (n, 6) and corners (n, 3, 3)."""
        rng, i, u = np.random.default_rng(seed), np.arange(n), np.finfo(real).eps / 2
        origin = rng.uniform(-1, 1, (n, 3)).astype(real)
        middle = rng.uniform(-1, 1, (n, 1, 3))
        if self.diagonal:
            away = rng.uniform(0.5, 2, (n, 1)) * rng.choice([-1, 1], (n, 3))
            middle = (origin + away)[:, np.newaxis]
        corners = middle + self.size * rng.normal(size=(n, 3, 3))
        if self.thin is not None:
            a, b, aside = corners[:, 0], corners[:, 1], rng.normal(size=(n, 3))
            corners[:, 2] = a + rng.random((n, 1)) * (b - a) + self.thin * self.size * aside
        corners = corners.astype(real)
        part, c = rng.random((n, 1)), rng.integers(0, 3, n)
        aim = corners[i, c].astype(np.longdouble) * (1 - part) + corners[i, (c + 1) % 3] * part
        aim += 2 * u * rng.normal(size=aim.shape)
        direction = aim - origin
        direction /= norm(direction)[:, np.newaxis]
        return np.concatenate([origin, direction.astype(real)], axis=1), corners


FAMILIES = {
    "small": Family(1e-3),
    "middling": Family(0.1),
    "large": Family(3),
    "small slivers": Family(1e-3, 1e-3),
    "slivers": Family(0.1, 1e-3),
    "large slivers": Family(3, 1e-3),
    "needles": Family(1, 1e-6),
    "diagonal": Family(0.1, diagonal=True),
}


def found(device: cl.Device, precision: Precision, rays: Array, corners: Array) -> Array:
    """The distances, (n,)."""
    real, n = PRECISIONS[precision], len(rays)
    faces = np.concatenate([corners.reshape(-1, 9), np.ones((n, 1), real)], axis=1)
    context, kernels = kernels_of(
        device, PAIRS, tuple(options(1, precision, tree=True, faces=True))
    )
    queue, flags = cl.CommandQueue(context), cl.mem_flags
    sent = [
        cl.Buffer(context, flags.READ_ONLY | flags.COPY_HOST_PTR, hostbuf=np.ascontiguousarray(a))
        for a in (rays, faces)
    ]
    leaves = cl.Buffer(context, flags.READ_WRITE, n * 1280)
    distances = np.empty(n, real)
    where = cl.Buffer(context, flags.WRITE_ONLY, distances.nbytes)
    kernels["pairs"](queue, (n,), None, *sent, leaves, where)
    cl.enqueue_copy(queue, distances, where)
    return distances


# The truth of float32 is in float64, that of float64 in long double. The 11 bits that this has more
# are not enough where a difference of products is small, as in slivers: of rounded products planes
# are off by 13 u |f|. So these are as of twice as many bits.
# T. J. Dekker, "A floating-point technique for extending the available precision", 1971.


def lost(x: Array, y: Array, rounded: Array) -> Array:
    """What a product lacks that is rounded."""
    parts = np.longdouble(2) ** ((np.finfo(np.longdouble).nmant + 2) // 2) + 1

    def halves(z: Array) -> tuple[Array, Array]:
        high = parts * z - (parts * z - z)
        return high, z - high

    (a, b), (c, d) = halves(x), halves(y)
    return ((a * c - rounded) + a * d + b * c) + b * d


def cross(p: Array, q: Array) -> Array:
    """Of vectors (n, 3)."""
    columns = []
    for i, j in ((1, 2), (2, 0), (0, 1)):
        one, other = p[:, i] * q[:, j], p[:, j] * q[:, i]
        columns.append(one - other)
        if p.dtype != np.float64:
            columns[-1] += lost(p[:, i], q[:, j], one) - lost(p[:, j], q[:, i], other)
    return np.stack(columns, axis=1)


def dot(p: Array, q: Array) -> Array:
    return p[:, 0] * q[:, 0] + p[:, 1] * q[:, 1] + p[:, 2] * q[:, 2]


def norm(p: Array) -> Array:
    return np.sqrt(dot(p, p))


def to_segments(p: Array, q: Array, d: Array) -> Array:
    """How far the segments from p to q are from the lines from 0 along d, of unit length."""
    from_p, from_q, e = cross(p, d), cross(q, d), q - p
    along, across = cross(e, d), cross(d, e)
    between = -dot(from_p, along)
    inside = abs(dot(p, across)) / np.maximum(norm(across), 1e-300)
    inside = np.where(between >= dot(along, along), norm(from_q), inside)
    return np.where(between <= 0, norm(from_p), inside)


def errors(rays: Array, corners: Array, distance: Array) -> tuple[Array, Array]:
    """By how much verdicts are wrong, and how far hits lie off the plane."""
    u: Any = np.finfo(rays.dtype).eps / 2
    wide: Any = np.float64 if rays.dtype == np.float32 else np.longdouble
    origin, d, corners = rays[:, :3].astype(wide), rays[:, 3:].astype(wide), corners.astype(wide)
    length = norm(d)
    a, b, c = (corners[:, k] - origin for k in range(3))
    signs = [dot(d, cross(p, q)) for p, q in ((c, b), (a, c), (b, a))]
    normal = cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.maximum(norm(normal), 1e-300)[:, np.newaxis]
    facing, far = dot(d, normal), dot(a, normal)
    inside = np.all([s >= 0 for s in signs], 0) | np.all([s <= 0 for s in signs], 0)
    true, met = inside & (far * facing > 0), np.isfinite(distance)
    most = np.maximum(np.maximum(norm(a), norm(b)), norm(c))
    # Of those that start in the plane nothing is said.
    wrong = (met != true) & (abs(far) > OFF * u * most)
    edges = [(p[wrong], q[wrong]) for p, q in ((a, b), (b, c), (c, a))]
    way = (d / length[:, np.newaxis])[wrong]
    beside = np.min([to_segments(p, q, way) for p, q in edges], axis=0)
    hit = met & (norm(normal) > 0)
    off = abs(np.where(hit, distance, 0) * facing - far)
    return beside / (u * most[wrong]), (off / (u * most))[hit]


def check(device: cl.Device, precision: Precision, name: str, n: int) -> None:
    if precision == "double":
        if device.native_vector_width_double == 0:
            pytest.skip("no float64")
        if np.finfo(np.longdouble).nmant == 52:
            pytest.skip("long double is no wider than double here: nothing to check against")
    for seed in range(max(n // AT_ONCE, 1)):
        rays, corners = FAMILIES[name].made(PRECISIONS[precision], min(n, AT_ONCE), seed)
        distance = found(device, precision, rays, corners)
        assert 0.2 < np.isfinite(distance).mean() < 0.8
        wrong, off = errors(rays, corners, distance)
        assert wrong.max(initial=0) <= VERDICT
        assert off.max() <= OFF


@pytest.mark.parametrize("precision", ["robust", "double"])
@pytest.mark.parametrize("name", FAMILIES)
def test_within_the_bounds(device: cl.Device, precision: Precision, name: str) -> None:
    check(device, precision, name, 4096)


@pytest.mark.slow
@pytest.mark.parametrize("name", FAMILIES)
def test_a_million_in_all_within_the_bounds(device: cl.Device, name: str) -> None:
    check(device, "robust", name, 1 << 17)
