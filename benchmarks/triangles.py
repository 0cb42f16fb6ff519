"""Triangles: closed meshes to measure with, and rays that must not pass between their faces."""

from typing import Any

import click
import numpy as np
import pyopencl as cl
from numpy.typing import NDArray

import clrt
from benchmarks import harness
from clrt.figure.rendering import Renderer
from clrt.opencl import program
from clrt.opencl.device import find_device
from clrt.opencl.tree import Tree, face_leaf_dtype
from clrt.renderer.pack import kinds, meshes
from clrt.renderer.pack.features import Features
from clrt.renderer.pack.structs import PRECISIONS, Precision
from clrt.scene.mesh import Mesh

Array = NDArray[Any]
PLAIN_MATERIAL = clrt.Material((0.1, 0.1, 0.1), (0.7, 0.5, 0.2), (0.3, 0.3, 0.3), 128)
ITEMS = 4096
STEP = 1 << 22  # rays of a launch
# By packet and by ray; with fused multiply-add and without; fronts only and both sides.
WAYS: list[dict[str, Any]] = [
    {},
    {"closed": False},
    {"lanes": 1},
    {"fma": False},
    {"fma": False, "lanes": 1, "closed": False},
    {"precision": "double"},
    {"precision": "double", "fma": False},
]

KERNEL = """
static uint stirred(uint x) {
    x ^= x >> 16, x *= 0x7feb352dU, x ^= x >> 15, x *= 0x846ca68bU;
    return x ^ (x >> 16);
}
static real drawn_part(uint *s) {
    *s = stirred(*s + 0x9e3779b9U);
    return (*s >> 8) * REAL(5.9604644775390625e-8);
}

// Rays from around a point inside of a closed mesh, a packet from one origin: a third each at
// corners, at edges and anywhere. missed: how many of each have met nothing.
__kernel void leaks(__global const real *faces, int n, int packets, uint seed,
                    __global const real *middle, real around, __global const Node *nodes,
                    __global const FaceLeaf *leaves, __global const Shape *shape,
                    __global int *missed) {
    Tree tree = {nodes, leaves, shape[0], 0};
    for (int item = get_global_id(0); item < packets; item += get_global_size(0)) {
        uint s = stirred((uint)item ^ seed);
        __private reals all[6];
        __private real *each = (__private real *)all;
        int first = (int)(drawn_part(&s) * n), kind = item % 3;
        real origin[3];
        for (int a = 0; a < 3; a++) origin[a] = middle[a] + around * (2 * drawn_part(&s) - 1);
        for (int i = 0; i < LANES; i++) {
            __global const real *face = faces + 10 * (long)min(first + i / 2, n - 1);
            int c = i % 3;
            real w = drawn_part(&s), length2 = 0, d[3];
            for (int a = 0; a < 3; a++) {
                real p = face[3 * c + a], q = face[3 * ((c + 1) % 3) + a];
                real aim = kind == 0 ? p : p + w * (q - p);
                if (kind == 2) aim = origin[a] + (2 * drawn_part(&s) - 1);
                d[a] = aim - origin[a];
                length2 += d[a] * d[a];
            }
            for (int a = 0; a < 3; a++) {
                each[a * LANES + i] = origin[a];
                each[(3 + a) * LANES + i] = d[a] / sqrt(length2);
            }
        }
        Ray ray = {vector(all[0], all[1], all[2]), vector(all[3], all[4], all[5]), -1, -1};
        Hit hit = nearest_in_tree(&tree, OF_FACES, no_hit(), ray, (ints)(-1), true);
        uint bits = lane_bits(hit.id < 0);
        if (bits) atomic_add(missed + kind, popcount(bits));
    }
}
"""
# What a compiler without fused multiply-add says, and does: it joins no product and sum.
NO_FMA = """
#undef __FMA__
#undef __FMA4__
#undef FP_FAST_FMAF
#undef FP_FAST_FMA
#pragma OPENCL FP_CONTRACT OFF
"""
PLAIN = """
#undef DIFFERENCE_OF_PRODUCTS
#define DIFFERENCE_OF_PRODUCTS(type, x, a, b, c, d) type x = (a) * (b) - (c) * (d);
"""


def ball(parts: int, radius: float = 0.95, middle: tuple[float, ...] = (0.0, 0.0, -2.0)) -> Mesh:
    """An icosahedron, its sides in parts^2 faces each, blown up to a ball: 20 parts^2 faces."""
    golden = (1 + 5**0.5) / 2
    ends = np.array([(-1, golden, 0), (1, golden, 0), (-1, -golden, 0), (1, -golden, 0)])
    ends = np.concatenate([np.roll(ends, k, axis=1) for k in range(3)])
    pairs = np.argwhere(np.abs(ends @ ends.T - golden) < 1e-9)
    near = {(int(i), int(j)) for i, j in pairs}
    sides = [
        (i, j, k) for i, j in near for k in range(12) if i < j < k and {(i, k), (j, k)} <= near
    ]
    sides = [side if np.linalg.det(ends[list(side)]) > 0 else side[::-1] for side in sides]
    grid = [(i, j) for i in range(parts + 1) for j in range(parts + 1 - i)]
    at = {place: k for k, place in enumerate(grid)}
    up = [(at[i, j], at[i + 1, j], at[i, j + 1]) for i, j in grid if i + j < parts]
    down = [(at[i + 1, j], at[i + 1, j + 1], at[i, j + 1]) for i, j in grid if i + j < parts - 1]
    weights = np.column_stack([parts - np.sum(grid, axis=1), grid]) / parts
    points = np.einsum("kc,fcx->fkx", weights, ends[np.array(sides)]).reshape(-1, 3)
    points /= np.linalg.norm(points, axis=1, keepdims=True)
    local = np.array(up + down)
    faces = (local + (np.arange(20) * len(grid))[:, np.newaxis, np.newaxis]).reshape(-1, 3)
    _, first, which = np.unique(
        np.rint(points * 1e7).astype(np.int64), axis=0, return_index=True, return_inverse=True
    )
    places = (points[first] * radius + middle).astype(np.float32)
    return Mesh(places, which.reshape(-1)[faces].astype(np.int32))


def leaks(
    device: cl.Device,
    mesh: Mesh,
    rays: int,
    *,
    lanes: int = 16,
    precision: Precision = "robust",
    closed: bool = True,
    fma: bool = True,
    plain: bool = False,
    seed: int = 1,
) -> tuple[int, list[int]]:
    """How many rays from inside of a closed mesh were cast, and how many of those at corners, at
    edges and anywhere have passed between its faces.

    closed: only fronts are met, which are turned inwards; else both sides are.
    fma: else as where a device has none.
    plain: differences of products are taken as they stand, which leaks.
    """
    real = PRECISIONS[precision]
    context = cl.Context([device])
    profiling = cl.command_queue_properties.PROFILING_ENABLE
    queue = cl.CommandQueue(context, properties=profiling)
    source = ("" if fma else NO_FMA) + program.kernel_source() + KERNEL
    if plain:
        source = source.replace('#line 1 "face.cl"', PLAIN + '#line 1 "face.cl"')
    options = Features(lanes, precision, "float", tree=True, faces=True).options
    kernels = program.kernels(program.compiled(context, device, source, options))
    rows = meshes.rows([mesh], np.zeros(3), 0.5, real)
    if closed:
        rows[:, :9] = rows[:, :9].reshape(-1, 3, 3)[:, ::-1].reshape(-1, 9)
    else:
        rows[:, 9] = 1
    tree = Tree(meshes.tree_keys([mesh]), queue, kernels, kinds.FACES.number, face_leaf_dtype)
    fitted = tree.fit(rows, kernels)
    middle = (mesh.vertices.min(axis=0) + mesh.vertices.max(axis=0)) / 4
    buffers = [
        cl.Buffer(context, cl.mem_flags.READ_WRITE | cl.mem_flags.COPY_HOST_PTR, hostbuf=array)
        for array in (middle.astype(real), fitted["shape"], np.zeros(3, np.int32))
    ]
    around = real(0.08 * np.ptp(mesh.vertices, axis=0).min())
    packets, done = max(min(rays, STEP) // lanes, 1), 0
    while done < rays:
        kernels["leaks"].set_args(
            fitted["things"], np.int32(len(rows)), np.int32(packets),
            np.uint32(done // STEP * 7919 + seed), buffers[0], around,
            fitted["nodes"], fitted["leaves"], buffers[1], buffers[2],
        )  # fmt: skip
        cl.enqueue_nd_range_kernel(queue, kernels["leaks"], (ITEMS,), (1,)).wait()
        done += packets * lanes
    missed = np.empty(3, np.int32)
    cl.enqueue_copy(queue, missed, buffers[2])
    return done, missed.tolist()


def tile_leaks(device: cl.Device, rays: int, side: int = 1024, **options: Any) -> tuple[int, int]:
    """How many camera rays were cast, by tiles, and how many have passed between faces.

    Each picture shows a rough sheet that fills it. One of nine rays is aimed at a corner, six at
    edges; of each two pictures one has a camera that is turned at random.

    side: columns and rows of a picture.
    options: of the renderer.
    """
    draw = np.random.default_rng(side)
    renderer, done, missed = Renderer(device=device, **options), 0, 0
    places = np.arange(-3, side + 5, 3)
    j, i = (grid.ravel() for grid in np.meshgrid(places, places))
    at = np.arange(len(places) ** 2).reshape(len(places), -1)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[1:, :-1], at[1:, 1:], at[:-1, 1:]))
    faces = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    while done < rays:
        look_at = (0.0, 0.0, -1.0) if done // side**2 % 2 else tuple(draw.normal(size=3))
        camera = clrt.Camera((0, 0, 0), look_at)
        last = side - 1
        across = np.column_stack([(2 * j - last) / last, (last - 2 * i) / last, 0 * i - 1.0])
        vertices = across * draw.uniform(1, 1.02, (len(at.ravel()), 1)) @ np.array(camera.basis())
        scene = clrt.Scene(camera, (), {"": PLAIN_MATERIAL}, meshes=(Mesh(vertices, faces),))
        _, found = renderer.render(scene, side, side, dtype="uint8", passes=("id",))
        done, missed = done + side**2, missed + int((found["id"] < 0).sum())
    return done, missed


@click.command("meshes")
@click.pass_obj
def command(quick: bool) -> None:
    """Rays from inside of a closed mesh, a third each at corners, at edges and anywhere: how many
    pass between its faces, by each way to trace them, and by plain products."""
    device, mesh, rays = find_device(), ball(71), 10**5 if quick else 10**8
    found = []
    for way in [*WAYS, {"plain": True}]:
        cast, missed = leaks(device, mesh, rays, **way)
        found.append({"way": way, "rays": cast, "missed": missed})
        print(f"{cast:,} rays, {way or 'as on this device'}: {sum(missed):,} passed", flush=True)
    cast, lost = tile_leaks(device, rays)
    found.append({"way": "tiles", "rays": cast, "missed": lost})
    print(f"{cast:,} camera rays by tiles: {lost:,} passed", flush=True)
    harness.record(
        harness.results_folder(quick), "meshes", {"faces": len(mesh.faces), "ways": found}
    )
