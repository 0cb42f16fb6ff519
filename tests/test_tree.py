"""The tree: its shape, what is in it, and that every way through it gives the bits of the list."""

import functools

import numpy as np
import pyopencl as cl
import pytest
from conftest import kernels_of, renderer_for
from msgspec.structs import replace

import clrt
from clrt import reference
from clrt.figure.rendering import Renderer
from clrt.film import metrics
from clrt.opencl import bands, program, tree
from clrt.opencl.tree import Plan, Tree
from clrt.renderer.pack.features import Features
from clrt.renderer.pack.spheres import tree_keys
from clrt.renderer.pack.structs import Precision

MATERIALS = {
    "mirror": clrt.Material((0.1, 0, 0), (0.6, 0.1, 0.1), (1, 1, 1), 100, reflection=0.5),
    "matte": clrt.Material((0, 0.1, 0.1), (0.1, 0.5, 0.6), (0, 0, 0), 10),
    "shiny": clrt.Material((0.1, 0.1, 0), (0.6, 0.6, 0.1), (1, 1, 1), 1000, reflection=0.2),
}
CAMERA = clrt.Camera((0, 0, 1), (0, 0, 0))
BESIDE = clrt.Camera((0.1, 0, -2), (0, -0.2, -3), projection="orthographic", height=1.5)
ABOVE = replace(BESIDE, look_at=(0.3, -1, -2.3), height=3.0)
LIGHTS = (clrt.Light((5, 5, 5)), clrt.Light((-3, 2, 1), diffuse=(0.3, 0.3, 0.5)))
SIZE = (97, 55)


def scene_of(center, radius, **others) -> clrt.Scene:
    random = np.random.default_rng(0)
    spheres = clrt.Spheres(center, radius, random.integers(0, 3, len(center)))
    scene = clrt.Scene(CAMERA, LIGHTS, MATERIALS, spheres, max_depth=4)
    return replace(scene, **others) if others else scene


def cloud(n: int, seed: int = 7) -> tuple[np.ndarray, np.ndarray]:
    random = np.random.default_rng(seed)
    center = random.uniform((-2, -1.2, -4), (2, 1.2, -0.5), (n, 3))
    return center, np.full(n, 0.25 * (16.8 / n) ** (1 / 3))


def all_radii(n: int) -> clrt.Scene:
    """From 1e-4 to 10, small ones on and between large ones."""
    center, _ = cloud(n)
    radius = 10 ** np.random.default_rng(3).uniform(-4, -1, n)
    center[:5] = [(0, -11, -2), (3, 1, -9), (-4, 2, -12), (0, 0, -30), (2, -2, -3)]
    radius[:5] = [10, 4, 6, 9, 1.2]
    return scene_of(center, radius)


def among_giants() -> clrt.Scene:
    """A plane, spheres around a light and the camera, and one close to it: not the tree's."""
    center, radius = cloud(300)
    special = [(0, -5001, 0), (5, 5, 5), (0, 0, 1.5), (0, 0.01, 0.96)]
    return scene_of(
        np.concatenate([center, special]), np.concatenate([radius, [5000, 0.5, 3, 0.03]])
    )


def in_rows() -> clrt.Scene:
    """Rows and columns, so that boxes' faces, rays and centres coincide; some twice."""
    line = np.arange(-1, 1.01, 0.25)
    center = np.stack(np.meshgrid(line, line, [-1.0, -1.5, -2.0]), -1).reshape(-1, 3)
    return scene_of(np.concatenate([center, center[::7]]), 0.125)


def touching() -> clrt.Scene:
    """Spheres that stand on rays of the middle row to a few roundings, and on shadow rays in its
    plane, y = 0: so the faces of boxes lie on rays."""
    random = np.random.default_rng(11)
    radius = random.uniform(0.005, 0.05, 960).astype(np.float32)
    depth, column = random.uniform(1.3, 5, 960), random.integers(0, SIZE[0], 960)
    center = np.zeros((960, 3), np.float32)
    center[:, 0] = depth * np.linspace(-1, 1, SIZE[0])[column]
    center[:, 2] = 1 - depth
    center[:, 1] = radius + random.integers(-6, 2, 960) * np.spacing(radius)
    return scene_of(center, radius, lights=[clrt.Light((3, 0, 2)), clrt.Light((0, 5, 0))])


def dense() -> clrt.Scene:
    """No pixel without a sphere, and one beside the camera that reaches behind it."""
    center, radius = cloud(400)
    return scene_of(np.vstack([center, [(0.5, 0, 0.99)]]), np.append(radius + 0.3, 0.38))


def before_a_wall() -> clrt.Scene:
    """All rays of a tile end at a wall, 10 away, before one of them meets a sphere; the spheres
    begin 9.5 away. So a tile's beam that ends a tenth too early has none of them."""
    center = np.random.default_rng(2).uniform((-1.7, -0.9, -8.8), (1.7, 0.9, -8.6), (60, 3))
    wall = np.vstack([center, [(0, 0, -9 - 5000)]])
    return scene_of(wall, np.append(np.full(60, 0.1), 5000), camera=replace(CAMERA, fov=20.0))


def around_a_light(scene: clrt.Scene) -> clrt.Scene:
    """With a ball around a light that is out of sight: one program serves it and among_giants()."""
    spheres = clrt.Spheres.of(scene.spheres)
    center, radius = np.vstack([spheres.center, [(5, 5, 5)]]), np.append(spheres.radius, 0.5)
    return scene_of(center, radius, camera=scene.camera)


def glassy(scene: clrt.Scene) -> clrt.Scene:
    """A third of its spheres of glass, so that they overlap."""
    clear = clrt.Material((0, 0.02, 0), (0.1, 0.2, 0.1), (1, 1, 1), 100, transmission=0.7, ior=1.1)
    return replace(scene, materials={**MATERIALS, "matte": clear}, max_depth=6)


SCENES = {
    "touching": touching(),
    "cloud of 50": scene_of(*cloud(50)),
    "cloud of 5,000": scene_of(*cloud(5000)),
    "all radii": all_radii(500),
    "among giants": among_giants(),
    "in rows": in_rows(),
    "moved": scene_of(cloud(300)[0] + (1e5, -1e5, 1e5), cloud(300)[1],
                      camera=clrt.Camera((1e5, -1e5, 1e5 + 1), (1e5, -1e5, 1e5)),
                      lights=[clrt.Light((1e5 + 5, 5 - 1e5, 1e5 + 5))]),
    "long lens": scene_of(*cloud(300), camera=clrt.Camera((9, 8, 90), (0, 0, -2), fov=2.0)),
    "turned": scene_of(*cloud(300), camera=clrt.Camera((4, 3, -1), (0, 0, -2), (0.3, 1, 0.2))),
    "orthographic": around_a_light(scene_of(*cloud(300), camera=replace(BESIDE, height=3.0))),
    "orthographic in it": replace(among_giants(), camera=ABOVE),
    "glass": glassy(around_a_light(scene_of(*cloud(300)))),
    "glass among giants": glassy(among_giants()),
    "before a wall": before_a_wall(),
    "far light": scene_of(*cloud(300), lights=[clrt.Light((1e6, 2e6, 3e6))]),
    "biased": scene_of(*cloud(300), shadow_bias=1e-3),
    "dense": dense(),
    "wide angle": scene_of(*cloud(300), camera=replace(CAMERA, fov=170.0)),
}  # fmt: skip


LENS = replace(CAMERA, aperture_radius=0.05, focus_distance=2.5)
SKY = clrt.AmbientLight(occlusion=True, distance=0.7)
LAMPS = [replace(light, radius=1.0) for light in LIGHTS]
AT_RANDOM = {
    "glass, a lens, lamps and a sky": glassy(
        scene_of(*cloud(300), camera=LENS, lights=[*LAMPS, SKY], samples=3)
    ),
}
"""The truth knows none of it: see tests/test_random.py."""


OF_THEIR_OWN = ("orthographic", "long lens")
"""Scenes that share their programs with no other."""
SHARED = [name for name in SCENES if name not in OF_THEIR_OWN]


BEFORE = '#line 1 "cone.cl"'
BRUTE = """
#define FOR_ALL(leaf)                                                                        \\
    for (int e = 0, n = (tree->shape.node_count - tree->shape.lowest) * tree->shape.per_node; \\
         e < n; e++)                                                                          \\
        for (__global const void *leaf = leaf_of(tree, kind, tree->shape.node_count + e); leaf; \\
             leaf = 0)
static Hit nearest_of_all(const Tree *tree, int kind, Hit hit, Ray ray, ints on, bool common) {
    FOR_ALL(leaf) nearer_in_leaf(tree, kind, leaf, 0xffff, 0, &hit, ray, on);
    return hit;
}
static ints taken_by_all(const Tree *tree, int kind, Ray ray, reals distance, Vector light,
                         ints on, bool near) {
    Left left = {on, 0};
    FOR_ALL(leaf) left = left_by_leaf(tree, kind, leaf, 0xffff, 0, left, ray, distance, on, near);
    return VEILED ? left.veil : on & !left.clear;
}
#define nearest_in_tree nearest_of_all
#define taken_in_tree taken_by_all
"""
"""All that a tree of spheres has, one after the other: only faces need a beam."""
BEAM, PACKETS = "bool aimed = aim_tile(scene, tile);", "bool aimed = false;"
"""Of raster.cl: camera rays go through the tree packet by packet."""


@pytest.fixture
def ways(monkeypatch: pytest.MonkeyPatch):
    """Pictures of a scene by each way through its tree, the last one without: all, in turn."""

    def render(device: cl.Device, lanes: int, precision: Precision, scene: clrt.Scene):
        found = {}
        for way, (spheres, budget) in {
            "both": tree.BEAMS[0],
            "beams": (np.inf, 2**31 - 1),
            "single rays": (0, 0),
            "beams that give up": (np.inf, 7),
        }.items():
            monkeypatch.setattr(tree, "BEAMS", ((spheres, budget),) * 3)
            found[way] = renderer_for(device, lanes, precision).render(scene, *SIZE)
        packets = program.kernel_source().replace(BEAM, PACKETS)
        source = packets.replace(BEFORE, BRUTE + BEFORE)
        assert BRUTE in source
        assert PACKETS in source
        monkeypatch.setattr(program, "kernel_source", lambda: source)
        found["the list"] = Renderer(device=device, lanes=lanes, precision=precision).render(
            scene, *SIZE
        )
        return found

    return render


@pytest.mark.parametrize("lanes", [16])
@pytest.mark.parametrize("name", [*SCENES, *AT_RANDOM])
def test_every_way_gives_the_same_bits(device: cl.Device, ways, name: str, lanes: int) -> None:
    found = ways(device, lanes, "robust", {**SCENES, **AT_RANDOM}[name])
    assert found["the list"].any()
    for way, image in found.items():
        assert (image == found["the list"]).all(), way


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "lanes", "precision"),
    [
        *((name, *way) for name in SHARED for way in ((4, "robust"), (16, "double"))),
        *(("glass among giants", *way) for way in ((2, "robust"), (8, "robust"))),
    ],
)
def test_every_way_with_any_lanes(device: cl.Device, ways, name, lanes, precision) -> None:
    found = ways(device, lanes, precision, SCENES[name])
    for way, image in found.items():
        assert (image == found["the list"]).all(), way


@functools.cache
def truth_of(name: str) -> reference.Trace:
    scene = SCENES[name]
    if scene.shadow_bias:
        return reference.trace(scene, *SIZE, "seed")
    wide = np.longdouble if len(scene.spheres) < 1000 else np.float64  # ten times slower
    return reference.trace(scene, *SIZE, dtype=wide)


@pytest.mark.parametrize(
    ("name", "precision"),
    [
        *((name, "robust") for name in SCENES),
        *(
            pytest.param(name, "double", marks=[pytest.mark.slow] * (name in OF_THEIR_OWN))
            for name in SCENES
        ),
    ],
)
def test_against_the_truth(device: cl.Device, name: str, precision: Precision) -> None:
    scene, truth = SCENES[name], truth_of(name)
    image = renderer_for(device, 16, precision).render(scene, *SIZE)
    error = metrics.pixel_error(image, truth.image)
    off = error > metrics.QUARTER_STEP
    # Mirrors magnify: at edges of reflections of reflections.
    assert off.sum() <= (60 if precision == "robust" else 0)
    assert not (off & ~metrics.edges(truth.paths)).any()


def test_the_order_of_the_list_does_not_matter(device: cl.Device) -> None:
    center, radius = cloud(700)
    scene = scene_of(center, radius)
    shuffled = np.random.default_rng(5).permutation(700)
    spheres = scene.spheres
    assert isinstance(spheres, clrt.Spheres)
    index = spheres.material_index[shuffled]
    other = clrt.Spheres(spheres.center[shuffled], spheres.radius[shuffled], index)
    renderer = renderer_for(device, 16)
    expected = renderer.render(scene, *SIZE)
    assert (renderer.render(replace(scene, spheres=other), *SIZE) == expected).all()


def test_of_equal_spheres_the_first_counts(device: cl.Device) -> None:
    center = np.repeat([[0.0, 0.0, -2.0]], 64, axis=0)
    materials = {name: replace(MATERIALS["matte"], diffuse=(i, 0.5, 0)) for i, name in
                 enumerate(("first", "others"))}  # fmt: skip
    index = [0] + [1] * 63
    scene = clrt.Scene(CAMERA, LIGHTS, materials, clrt.Spheres(center, 0.5, index))
    assert not renderer_for(device, 16).render(scene, *SIZE)[..., 0].any()


def test_regions_are_crops(device: cl.Device) -> None:
    renderer = renderer_for(device, 16)
    scene = SCENES["among giants"]
    for dtype in (np.float32, np.uint8):
        whole = renderer.render(scene, *SIZE, dtype=dtype)
        for x0, y0, x1, y1 in ((0, 0, 1, 1), (13, 7, 58, 31), (90, 50, 97, 55)):
            part = renderer.render(scene, *SIZE, dtype=dtype, region=(x0, y0, x1, y1))
            assert (part == whole[y0:y1, x0:x1]).all()


@pytest.mark.parametrize("samples", [1, 16])
def test_bands_of_one_row_of_tiles_make_the_same_picture(
    device: cl.Device, monkeypatch: pytest.MonkeyPatch, samples: int
) -> None:
    renderer = renderer_for(device, 16)
    scene = replace(SCENES["among giants"], samples=samples)
    whole = renderer.render(scene, *SIZE)
    monkeypatch.setattr(bands, "FIRST_BAND_TESTS", 1)
    monkeypatch.setattr(bands, "BAND_PIXELS", 1)
    assert (renderer.render(scene, *SIZE) == whole).all()


def test_colors_of_spheres_multiply_ambient_and_diffuse(device: cl.Device) -> None:
    """With a tree and without; against materials of those colours."""
    for n in (10, 200):
        center, radius = cloud(n)
        color = np.random.default_rng(1).uniform(0, 1, (n, 3))
        base = MATERIALS["shiny"]
        materials = {
            str(i): replace(base, ambient=c * base.ambient, diffuse=c * base.diffuse)
            for i, c in enumerate(color)
        }
        names = [str(i) for i in range(n)]
        expected = clrt.Scene(CAMERA, LIGHTS, materials, clrt.Spheres(center, radius, names))
        own = clrt.Spheres(center, radius, "shiny", color)
        scene = clrt.Scene(CAMERA, LIGHTS, MATERIALS, own)
        renderer = renderer_for(device, 16, "robust")
        image = renderer.render(scene, *SIZE)
        assert abs(image - renderer.render(expected, *SIZE)).max() < 1e-6
        truth = reference.trace(scene, *SIZE)
        assert metrics.pixel_error(image, truth.image)[~metrics.edges(truth.paths)].max() < 1e-4


@pytest.mark.parametrize("n", [1, 15, 16, 17, 255, 256, 257, 4096, 4097, 70_000, 1 << 20, 10**7])
def test_a_plan_holds_all_and_wastes_little(n: int) -> None:
    plan = Plan.of(n)
    assert plan.leaf_count * tree.WIDE >= n
    assert 1 <= plan.root <= tree.WIDE
    assert 1 <= plan.leaves <= tree.WIDE
    assert n < 4096 or plan.leaf_count * tree.WIDE <= 1.13 * n


@pytest.fixture(scope="module")
def builder(device: cl.Device) -> tuple[cl.CommandQueue, dict[str, cl.Kernel]]:
    """What builds trees: a queue and kernels."""
    used = Features(4, "robust", "float", tree=True).options
    context, kernels = kernels_of(device, "", tuple(used))
    return cl.CommandQueue(context), kernels


@pytest.mark.parametrize("n", [1, 16, 100, 257, 5000, 66_000])
def test_each_sphere_is_in_one_leaf_and_in_all_boxes_above(builder, n: int) -> None:
    random = np.random.default_rng(n)
    beads = random.uniform(-1, 1, (n, 4)).astype(np.float32)
    beads[:, 3] = 0.01 * abs(beads[:, 3]) + 1e-5
    beads[::9, 3] = np.nan  # in the list beside it
    queue, kernels = builder
    made = Tree(beads, queue, kernels)
    found = made.fit(beads, kernels)
    shape, plan = found["shape"][0], made.plan
    nodes = np.zeros(shape["node_count"], tree.node_dtype(np.float32))
    leaves = np.zeros(plan.leaf_count, tree.leaf_dtype(np.float32))
    cl.enqueue_copy(queue, nodes, found["nodes"])
    cl.enqueue_copy(queue, leaves, found["leaves"])
    ids = leaves["id"][leaves["id"] >= 0]
    assert sorted(ids) == np.flatnonzero(beads[:, 3] > 0).tolist()

    def inside(e: int) -> np.ndarray:
        """The spheres below node or leaf e; checks the boxes on the way."""
        if e >= shape["node_count"]:
            found = leaves["id"][e - shape["node_count"]]
            return found[found >= 0]
        if e >= shape["lowest"]:
            below = shape["per_node"] * e + shape["outer"] + np.arange(plan.leaves)
        else:
            count = plan.root if e == 0 else tree.WIDE
            below = 16 * e + (shape["inner"] if e else 1) + np.arange(count)
        all_found = []
        for k, child in enumerate(below):
            found = inside(int(child))
            center, radius = beads[found, :3], beads[found, 3:]
            assert (nodes["lo"][e, :, k] <= center - radius).all()
            assert (nodes["hi"][e, :, k] >= center + radius).all()
            all_found.append(found)
        assert (nodes["lo"][e, :, len(below) :] == np.inf).all()
        return np.concatenate(all_found)

    assert len(inside(0)) == len(ids)


def surfaces(builder, keys: np.ndarray, spheres: np.ndarray) -> np.ndarray:
    """Of the boxes around leaves, the largest first: so often are leaves visited."""
    queue, kernels = builder
    made = Tree(keys, queue, kernels)
    found = made.fit(spheres.astype(np.float32), kernels)
    nodes = np.zeros(found["shape"]["node_count"][0], tree.node_dtype(np.float32))
    cl.enqueue_copy(queue, nodes, found["nodes"])
    with np.errstate(invalid="ignore"):
        x, y, z = np.maximum(nodes["hi"] - nodes["lo"], 0).transpose(1, 0, 2)
    lowest = nodes[found["shape"]["lowest"][0] :]
    return np.sort((x * y + y * z + z * x)[-len(lowest) :], axis=None)[::-1]


def keys_of(spheres: np.ndarray) -> np.ndarray:
    return tree_keys(clrt.Spheres(spheres[:, :3], spheres[:, 3], "matte"))


@pytest.mark.parametrize(
    "large",
    [
        [(0, -6.2, -2, 5)],
        [(0, -6.2, -2, 5), (0, 0, -2, 0.8), (3, 0, -2, 0.9)],
        [(0, -1e4 - 2, -2, 1e4)],
        [(0, -1e9 - 2, -2, 1e9)],
    ],
    ids=["one", "three", "a plane", "a ground"],
)
def test_a_few_large_spheres_leave_the_boxes_of_the_others_small(builder, large) -> None:
    """While the fourth side was as long as it is, they made the sum 3.1 x, and the ground 4.6 x."""
    small = np.column_stack(cloud(20_000))
    alone = surfaces(builder, keys_of(small), small).sum()
    both = np.concatenate([small, large])
    assert surfaces(builder, keys_of(both), both)[len(large) :].sum() < 1.25 * alone


@pytest.mark.parametrize(
    ("share", "times", "gain"), [(0.001, 100, 1.6), (0.01, 100, 7), (0.1, 30, 3)]
)
def test_many_large_spheres_are_kept_apart(
    builder, share: float, times: float, gain: float
) -> None:
    """Without the radius as a side to halve along the boxes' surfaces would be `gain` times."""
    spheres = np.column_stack(cloud(20_000))
    spheres[: int(share * len(spheres)), 3] *= times
    keys = keys_of(spheres)
    apart = surfaces(builder, keys, spheres).sum()
    keys[:, 3] = 0
    assert surfaces(builder, keys, spheres).sum() > gain * apart


def test_structs() -> None:
    assert tree.node_dtype(np.float32).itemsize == 384
    assert tree.leaf_dtype(np.float32).itemsize == 320
    assert tree.node_dtype(np.float64).itemsize == 768
    assert tree.leaf_dtype(np.float64).itemsize == 576


def test_spheres_that_move_keep_their_order_while_that_is_sooner(device: cl.Device) -> None:
    center, radius = cloud(3000)
    moved = scene_of(center + np.random.default_rng(4).normal(0, 0.01, center.shape), radius)
    other = scene_of(*cloud(3000, seed=8))  # all of them elsewhere: every box would be the whole
    expected = [Renderer(device=device).render(scene, *SIZE) for scene in (moved, other)]
    renderer = Renderer(device=device)
    renderer.render(scene_of(center, radius), *SIZE)
    made = renderer._dispatcher.trees[0]
    assert made is not None
    made.build_seconds = np.inf
    assert (renderer.render(moved, *SIZE) == expected[0]).all()
    assert renderer._dispatcher.trees[0] is made
    assert 0.9 < made.looseness() < 2
    made.build_seconds = 1e-9
    assert (renderer.render(other, *SIZE) == expected[1]).all()
    assert renderer._dispatcher.trees[0] not in (None, made)
    made = renderer._dispatcher.trees[0]
    renderer.render(scene_of(*cloud(3001)), *SIZE)
    assert renderer._dispatcher.trees[0] not in (None, made)


def test_what_does_not_move_is_kept(device: cl.Device) -> None:
    """Camera and lights move, as those of figures do, and then colours are others: each time the
    bits are those of a renderer that knows nothing."""
    center, radius = cloud(200)
    colors = np.random.default_rng(1).uniform(0, 1, (2, 200, 3))
    some, others = (clrt.Spheres(center, radius, "shiny", color) for color in colors)
    first = clrt.Scene(CAMERA, LIGHTS, MATERIALS, some)
    camera, lights = replace(CAMERA, position=(0.3, 0, 1)), (clrt.Light((-5, 5, 1)), LIGHTS[1])
    moved = replace(first, camera=camera, lights=lights)
    changed = replace(moved, spheres=others)
    expected = [Renderer(device=device).render(scene, *SIZE) for scene in (moved, changed)]
    renderer = Renderer(device=device)
    renderer.render(first, *SIZE)
    packed, made = renderer._dispatcher.world(first), renderer._dispatcher.trees[0]
    on_device = dict(renderer._dispatcher._uploaded)
    assert (renderer.render(moved, *SIZE) == expected[0]).all()
    assert renderer._dispatcher.world(moved).colors is packed.colors
    assert renderer._dispatcher._uploaded == on_device
    assert renderer._dispatcher.trees[0] is made
    assert (renderer.render(changed, *SIZE) == expected[1]).all()


def test_an_order_of_other_spheres_is_not_used(device: cl.Device) -> None:
    """Were it, each ray would meet every box, and a million spheres would take an hour."""
    renderer = Renderer(device=device)
    renderer.render(scene_of(*cloud(100_000)), *SIZE)
    made = renderer._dispatcher.trees[0]
    renderer.render(scene_of(*cloud(100_000, seed=8)), *SIZE)
    assert renderer._dispatcher.trees[0] is not made


@pytest.mark.slow
@pytest.mark.parametrize(("n", "count", "part"), [(10**5, 300, 0.97), (10**6, 100, 0.95)])
def test_many(n: int, count: int, part: float) -> None:
    """So many pixels against the truth, which goes through all spheres for each; `part` show
    the same. Not all, for mirrors magnify, and few pixels tell the part less well."""
    scene = scene_of(*cloud(n))
    random = np.random.default_rng(2)
    pixels = [(int(r), int(c)) for r, c in random.integers(0, (540, 960), (count, 2))]
    truth = reference.trace(scene, 960, 540, pixels=pixels)
    with Renderer() as renderer:
        image = renderer.render(scene, 960, 540)
        paths = renderer.paths(scene, 960, 540)
    rows, columns = np.transpose(pixels)
    same = paths[rows, columns] == truth.paths
    assert same.mean() > part
    assert abs(image[rows, columns] - truth.image)[same].max() < 5e-3
