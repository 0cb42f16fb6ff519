"""Samples: the points, which pixels get them and how many, and what these come to."""

import hashlib
import itertools
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from click.testing import CliRunner
from conftest import kept, kernels_of, renderer_for
from msgspec.structs import replace

import clrt
from clrt import reference
from clrt.commands.cli import main
from clrt.figure.rendering import Renderer
from clrt.film import metrics
from clrt.renderer import samples
from clrt.renderer.pack.arguments import BOUNCES, KINDS
from clrt.renderer.pack.features import (
    SMALLS_BASE,
    TREE_FROM,
    Features,
    base_samples,
    features_of,
    missed,
    stages,
)
from clrt.renderer.pack.world import pack_world
from clrt.scene import lens
from clrt.scene.spheres import Spheres
from clrt.truth import tracer

Array = np.ndarray[Any, Any]
PAIRS = 1 + BOUNCES * (KINDS + 1)
WHITE = clrt.Material(ambient=(1, 1, 1), diffuse=(0, 0, 0))
SHINE = clrt.AmbientLight()

# The points.


def test_every_pair_is_a_net() -> None:
    """The first 2^k points of a sequence, and each 2^k after them: one in each box of 2^-j x
    2^(j-k), for every j."""
    for pair in samples.table(1 << 10, PAIRS).astype(np.uint64):
        for k in range(11):
            for run in pair.reshape(-1, 1 << k, 2):
                for j in range(k + 1):
                    box = (run[:, 0] >> (32 - j) << (k - j)) + (run[:, 1] >> (32 - k + j))
                    assert len(np.unique(box)) == 1 << k


def test_pairs_do_not_know_of_each_other() -> None:
    """Of 2^k points that two sequences have at the same places, one coordinate each."""
    found = samples.table(1 << 12, PAIRS) / 2.0**32 - 0.5
    columns = found.transpose(0, 2, 1).reshape(2 * PAIRS, -1)
    apart = ~np.eye(2 * PAIRS, dtype=bool)
    assert np.abs(np.asarray(np.corrcoef(columns)))[apart].max() < 5 / 2**6  # 5 standard deviations
    assert (samples.table(8, 3, first=2) == samples.table(8, 5)[2:]).all()
    assert (samples.table(8, 3) == samples.table(99, 3)[:, :8]).all()


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 16, 1000])
def test_points_lie_in_the_pixel(count: int) -> None:
    found = samples.offsets(count)
    assert found.shape == (count, 2)
    assert (abs(found) < 1).all()
    if count in samples.CENTRED:
        assert not found.sum(axis=0).any()
    else:
        assert (found == samples.offsets(1024)[:count]).all()


def covered(radius: float, x: Array, y: Array, right: float, up: float) -> Array:
    """The share of boxes that a disc around 0 covers. Their middles are x, y, (n,); they reach so
    far right and up of them. A column of the disc is as long as it is: 1e-5 off."""
    across = x + right * (np.arange(0.5, 4000)[:, np.newaxis] / 2000 - 1)
    half = np.sqrt(np.maximum(radius**2 - across**2, 0))
    long = np.minimum(half, y + up) - np.maximum(-half, y - up)
    share: Array = np.maximum(long, 0).mean(axis=0) / (2 * up)
    return share


def test_no_straight_edge_is_a_sixteenth_off() -> None:
    """Where the first 16 samples are on one side of it, which then are enough."""
    angle = np.radians(np.arange(0, 360, 0.5))
    along = np.stack([np.cos(angle), np.sin(angle)])
    farthest = (samples.offsets(16) @ along).max(axis=0)
    grid = (np.indices((64, 64)).reshape(2, -1).T + 0.5) / 32 - 1
    assert (grid @ along > farthest).mean(axis=0).max() < 1 / 16


@pytest.mark.parametrize(("count", "radius"), [(16, 2), (48, 0.14), (48, 0.2), (48, 0.5), (48, 1)])
def test_no_disc_is_a_sixteenth_off(count: int, radius: float) -> None:
    """Where all of these samples are outside, or all inside."""
    points = samples.offsets(count).T / 2
    grid = (np.indices((40, 40)).reshape(2, -1) + 0.5) / 40 - 0.5
    reach = np.arange(-0.5 - radius, 0.5 + radius, 0.02)
    x, y = (c.ravel()[:, np.newaxis] for c in np.meshgrid(reach, reach))
    inside = (x - points[0]) ** 2 + (y - points[1]) ** 2 < radius**2
    for agree, share in (inside.all(axis=1), 1), (~inside.any(axis=1), 0):
        seen = (x[agree] - grid[0]) ** 2 + (y[agree] - grid[1]) ** 2 < radius**2
        assert abs(seen.mean(axis=1) - share).max(initial=0) < 1 / 16


COUNTS = [2**k for k in range(2, 11)]


def assert_falls(errors: list[float]) -> None:
    """As 0.3 N^-0.75 for N samples, each within half of it."""
    slope = np.polyfit(np.log(COUNTS), np.log(errors), 1)[0]
    assert -0.82 < slope < -0.68
    assert max(e / (0.3 * n**-0.75) for e, n in zip(errors, COUNTS, strict=True)) < 1.5


def test_a_disc_is_covered_as_it_is() -> None:
    radius = 20.3
    x, y = (np.indices((46, 46)) - np.array([22.87, 22.63])[:, np.newaxis, np.newaxis]).reshape(
        2, -1
    )
    share = covered(radius, x, y, 0.5, 0.5)
    edge = (share > 0.001) & (share < 0.999)
    errors = []
    for count in COUNTS:
        points = samples.offsets(count) / 2
        away = np.hypot(x[edge] + points[:, :1], y[edge] + points[:, 1:])
        errors.append(rms((away < radius).mean(axis=0) - share[edge]))
    assert_falls(errors)


def rms(error: Array) -> float:
    return float(np.sqrt((error**2).mean()))


# One ball, whose edge is a circle.

BALL = clrt.Sphere((0, 0, 0), 1.0, "white")
CAMERAS = {
    "perspective": clrt.Camera((0, 0, 3), (0, 0, 0), fov=60),
    "orthographic": clrt.Camera((0, 0, 3), (0, 0, 0), projection="orthographic", height=2.3),
}


def ball(camera: str = "orthographic", light: float = 1.0, **options: Any) -> clrt.Scene:
    shine = clrt.AmbientLight((light, light, light))
    return clrt.Scene(CAMERAS[camera], (shine,), {"white": WHITE}, (BALL,), **options)


def seen(camera: str, width: int, height: int) -> tuple[Array, Array]:
    """The share of each pixel that shows the ball, and whether its first 16 samples differ. Pixels
    are not square: there are width - 1 steps from the left to the right."""
    if camera == "perspective":
        right, radius = np.tan(np.radians(30)), np.tan(np.arcsin(1 / 3))
        top = right * height / width
    else:
        top, radius = 2.3 / 2, 1.0
        right = top * width / height
    grid = np.meshgrid(np.linspace(-right, right, width), np.linspace(top, -top, height))
    x, y = (one.ravel() for one in grid)
    step = np.array([right / (width - 1), top / (height - 1)])
    points = samples.offsets(16) * step
    inside = np.hypot(x + points[:, :1], y + points[:, 1:]) < radius
    share = covered(radius, x, y, *step)
    differ = inside.any(axis=0) & ~inside.all(axis=0)
    return share.reshape(height, width), differ.reshape(height, width)


@pytest.mark.parametrize("camera", CAMERAS)
def test_a_ball_is_covered_as_it_is(device: cl.Device, camera: str) -> None:
    """So bright that no sample is spared where the first ones differ. What they all miss is less
    than a sixteenth."""
    share, differ = seen(camera, 57, 41)
    errors = []
    for count in COUNTS:
        scene = ball(camera, 4.0, samples=count)
        image = renderer_for(device, 16).render(scene, 57, 41, alpha=True)
        assert (image[..., 0] == image[..., 2]).all()
        error = image[..., 0] / 4 - share
        errors.append(rms(error[differ]))
        if count >= 16:
            assert abs(error[~differ]).max() < 1 / 16
    assert_falls(errors)


RADII = (0.15, 0.2, 0.3, 0.5, 0.7, 1.5)  # pixels


@pytest.mark.parametrize("kind", ["list", "tree"])
def test_a_ball_of_less_than_a_pixel_is_covered_as_it_is(device: cl.Device, kind: str) -> None:
    """Wherever it lies beside the points that are looked at first. They miss half of the smallest
    balls, each by itself, and up to 0.38 of a pixel."""
    cells = 6 if kind == "list" else 14
    side, count = 6 * cells, cells * cells
    random = np.random.default_rng(5)
    place = 6 * np.indices((cells, cells)).reshape(2, -1).T + random.uniform(2.5, 3.49, (count, 2))
    radius = np.resize(RADII, count)
    step = 1 / (side - 1)
    center = np.zeros((count, 3))
    center[:, :2] = (2 * place - (side - 1)) * step * (1, -1)
    if kind == "list":
        camera = clrt.Camera((0, 0, 3), (0, 0, 0), projection="orthographic", height=2)
        lights: tuple[Any, ...] = (SHINE,)
    else:  # the program of specks(); a disc looks 1.7 % longer in the corners
        camera = clrt.Camera((0, 0, 1 / np.tan(np.radians(7.5))), (0, 0, 0), fov=15)
        lights = (clrt.Light((5, 5, 5)),)
    matte = WHITE if kind == "list" else clrt.Material((0.1, 0.1, 0.1))
    spheres = clrt.Spheres(center, 2 * step * radius, "white")
    scene = clrt.Scene(camera, lights, {"white": matte}, spheres, samples=256)
    assert base_samples(scene) == (1 if kind == "list" else SMALLS_BASE)
    alpha = renderer_for(device, 16).render(scene, side, side, alpha=True)[..., 3]
    share = np.zeros((side, side))
    for r, (x, y) in zip(radius, place, strict=True):
        rows, columns = np.indices((5, 5)).reshape(2, -1) + np.array([[round(y)], [round(x)]]) - 2
        share[rows, columns] = covered(r, columns - x, rows - y, 0.5, 0.5)
    error = abs(alpha - share)
    assert error.max() < 1 / 16, np.argwhere(error > 1 / 16)


def test_there_are_enough_samples_when_an_edge_is_known_to_one_step(device: cl.Device) -> None:
    """Of contrast 0.1 after 32: 0.1 / 2 x 32^-0.75 < 1/255."""
    renderer = renderer_for(device, 16)

    def render(light: float, count: int) -> Array:
        return renderer.render(ball(light=light, samples=count), 57, 41)

    assert (render(0.1, 32) == render(0.1, 4096)).all()
    assert (render(0.1, 16) != render(0.1, 32)).any()
    assert (render(1, 32) != render(1, 4096)).any()
    share, differ = seen("orthographic", 57, 41)
    assert rms((render(1, 4096)[..., 0] - share)[differ]) < 1 / 255


@pytest.mark.parametrize("light", [0.0, 1.0])
def test_alpha_is_the_share_of_a_pixel_whatever_the_colour(device: cl.Device, light: float) -> None:
    share, differ = seen("orthographic", 57, 41)
    renderer = renderer_for(device, 16)
    image = renderer.render(ball(light=light, samples=64), 57, 41, alpha=True)
    assert image[..., 3].sum() / share.sum() == pytest.approx(1, abs=2e-3)
    assert abs(image[..., 3] - share)[differ].max() < 0.05
    assert (image[..., :3] == light * image[..., 3:]).all()  # premultiplied
    # Before a background as well.
    white = replace(ball(light=light, samples=64), film=clrt.Film(background=(1, 1, 1)))
    found = renderer.render(white, 57, 41)[..., 0]
    assert (found - (light * share + 1 - share))[differ] == pytest.approx(0, abs=0.05)


# Against the truth.

GLASS = clrt.Material((0, 0.02, 0), (0, 0.1, 0), (0.5, 0.5, 0.5), 50, transmission=0.8)


def beads() -> clrt.Scene:
    """With a tree."""
    return replace(clrt.load_scene("sunflower"), max_depth=2, shadow_bias=0.0)


def paper() -> clrt.Scene:
    return replace(clrt.load_scene("four-spheres"), shadow_bias=0.0)


def glass() -> clrt.Scene:
    scene = paper()
    clear = clrt.Sphere((0.2, 0.1, 0.1), 0.3, "glass")
    materials = scene.materials | {"glass": GLASS}
    return replace(scene, materials=materials, spheres=(*scene.spheres, clear))


def flat(scene: clrt.Scene) -> clrt.Scene:
    camera = clrt.Camera((0.3, 0.5, 2), (0, 0, 0), projection="orthographic", height=2)
    return replace(scene, camera=camera)


def lined() -> clrt.Scene:
    film = clrt.Film((1, 0.9, 0.8), outline=2.5, outline_color=(0.3, 0, 0), depth_cue=(0.5, 4))
    return replace(paper(), film=film)


def specks(count: int = 300) -> clrt.Scene:
    """So small that every pixel gets four samples."""
    random = np.random.default_rng(3)
    center = random.uniform(-1, 1, (count, 3))
    spheres = clrt.Spheres(center, 0.012, "white")
    camera = clrt.Camera((0, 0, 2.5), (0, 0, 0))
    matte = clrt.Material((0.1, 0.1, 0.1))
    return clrt.Scene(camera, (clrt.Light((5, 5, 5)),), {"white": matte}, spheres)


MADE: dict[str, Callable[[], clrt.Scene]] = {
    "list": paper,
    "tree": beads,
    "glass": glass,
    "orthographic tree": lambda: flat(beads()),
    "specks": specks,
    "few specks": lambda: specks(TREE_FROM - 1),
}
SIZE = WIDTH, HEIGHT = 53, 31
COUNT = 16


@cache
def truth(name: str) -> tuple[Array, reference.Trace]:
    """Pixels at edges have the mean of 16 samples, others their middle, or the mean of four."""
    scene = MADE[name]()
    trace = reference.trace(scene, *SIZE)
    middle = np.dstack([trace.image, trace.alpha])
    paths = trace.paths
    if "specks" in name:
        points = samples.offsets(SMALLS_BASE)
        middle = reference.mean(scene, *SIZE, points)
        paths = np.zeros_like(trace.paths)
        for point in points:
            found = reference.trace(scene, *SIZE, offset=(point[0], point[1])).paths
            paths = paths * tracer.PRIME + found
    many = reference.mean(scene, *SIZE, samples.offsets(COUNT))
    often = listed(paths) | marked(scene)
    return np.where(often[..., np.newaxis], many, middle), trace


def marked(scene: clrt.Scene) -> Array:
    """The pixels into which the rectangle around a ball reaches, if it is so small that samples may
    miss it."""
    spheres, camera = Spheres.of(scene.spheres), scene.camera
    center = (spheres.center - np.array(camera.position)) @ np.array(camera.basis()).T
    box = lens.bounds(camera, center, spheres.radius)
    last = np.array(SIZE) - 1
    columns, rows = (
        (last[axis] + sign * sides / (lens.half_screen(camera, *SIZE)[axis] / last[axis])) / 2
        for axis, sign, sides in ((0, 1, box[:, :2]), (1, -1, box[:, 3:1:-1]))
    )
    found = np.zeros((HEIGHT, WIDTH), bool)
    radius = np.minimum(np.ptp(columns, axis=1), np.ptp(rows, axis=1)) / 2
    for k in np.flatnonzero(radius < missed(scene)):
        (left, right), (top, bottom) = np.floor(columns[k] + 0.5), np.floor(rows[k] + 0.5)
        found[
            max(int(top), 0) : max(int(bottom) + 1, 0), max(int(left), 0) : max(int(right) + 1, 0)
        ] = True
    return found


def listed(paths: Array) -> Array:
    """The pixels that get more samples: those that differ from a neighbour, and the outermost."""
    edge = metrics.edges(paths)
    edge[[0, -1]] = edge[:, [0, -1]] = True
    return edge


def slow(name: str, n: int) -> Any:
    """Programs of their own, for each of two stages."""
    return pytest.param(name, n, marks=pytest.mark.slow)


@pytest.mark.parametrize(
    ("name", "n"),
    [
        *((name, 16) for name in MADE),
        *((name, 1) for name in ("tree", "glass")),
        *(slow(name, 1) for name in ("orthographic tree", "specks")),
        *(slow(name, 4) for name in ("tree", "glass")),
    ],
)
def test_robust_against_truth(device: cl.Device, name: str, n: int) -> None:
    expected, _ = truth(name)
    scene = replace(MADE[name](), samples=COUNT)
    renderer = renderer_for(device, n)
    image = renderer.render(scene, *SIZE, alpha=True)
    error = metrics.pixel_error(image, expected)
    # A sample that flips is a sixteenth of its pixel.
    bad = error > metrics.QUARTER_STEP
    assert bad.sum() <= 4, f"{bad.sum()}: {kept(image[..., :3], expected[..., :3])}"


def test_every_film_has_the_same_colours(device: cl.Device) -> None:
    scene, renderer = replace(specks(TREE_FROM - 1), samples=COUNT), renderer_for(device, 16)
    film = renderer.render(scene, *SIZE)
    assert (film == renderer.render(scene, *SIZE, alpha=True)[..., :3]).all()
    byte = np.rint(255 * np.clip(film.astype(np.float64), 0, 1))
    assert (renderer.render(scene, *SIZE, dtype=np.uint8) == byte).all()


@pytest.mark.parametrize(
    ("name", "n"),
    [
        *((name, 16) for name in ("tree", "few specks")),
        slow("glass", 16),
        slow("orthographic tree", 16),
        slow("tree", 1),
    ],
)
def test_double_against_truth(device: cl.Device, name: str, n: int) -> None:
    if device.native_vector_width_double == 0:
        pytest.skip("no float64")
    expected, _ = truth(name)
    renderer = renderer_for(device, n, "double")
    image = renderer.render(replace(MADE[name](), samples=COUNT), *SIZE, alpha=True)
    assert metrics.pixel_error(image, expected).max() < 1e-6


def test_specks_have_more_samples_and_others_have_not() -> None:
    for name, made in MADE.items():
        scene = replace(made(), samples=COUNT)
        assert base_samples(scene) == (SMALLS_BASE if "specks" in name else 1)
        world = pack_world(scene, "robust")
        first, second = (features_of(world, scene, 16, "float", s) for s in stages(scene, "float"))
        assert (first.hashed, first.gather, first.refine) == (True, "specks" in name, False)
        assert (second.hashed, second.gather, second.refine) == (False, False, True)
        for kind in ("passes", "paths"):
            assert stages(scene, kind) == ["picture"]
        one = replace(scene, samples=1)
        assert stages(one, "float") == ["picture"]
        plain = features_of(world, one, 16, "float")
        assert (plain.hashed, plain.gather, plain.refine) == (False, False, False)


@pytest.mark.parametrize("name", ["list", "tree", "glass"])
def test_what_is_at_no_edge_has_the_bits_of_one_sample(device: cl.Device, name: str) -> None:
    scene, renderer = MADE[name](), renderer_for(device, 16)
    edge = listed(renderer.paths(scene, *SIZE)) | marked(scene)
    one = renderer.render(scene, *SIZE, alpha=True)
    many = renderer.render(replace(scene, samples=64), *SIZE, alpha=True)
    assert (one == many)[~edge].all()
    assert (one != many).any(axis=2)[edge].mean() > 0.4


# What is an edge, and how many fit into which memory.


@pytest.mark.parametrize("width", [1, 2, 15, 16, 17, 18, 34, 50])
def test_edges_are_where_a_neighbour_differs(device: cl.Device, width: int) -> None:
    random, height = np.random.default_rng(width), 9
    paths = np.where(random.random((height, width)) < 0.04, 7, 5).astype(np.uint32)
    options = Features(1, "robust", "float", refine=True).options
    context, kernels = kernels_of(device, "", tuple(options))
    kernel = kernels["edges"]
    queue, flags = cl.CommandQueue(context), cl.mem_flags.COPY_HOST_PTR
    marked, small = random.random((2, height, width + 16)) < 0.02
    expected = listed(paths) | marked[:, :width]
    for left, top, right, bottom in [
        (0, 0, width, height),
        (width // 2, 3, width, 7),
        (0, 8, 1, 9),
    ]:
        count, places = np.zeros(1, np.int32), np.zeros(width * height, np.int32)
        size = -(-(right - left) // 16), bottom - top
        items = 16 * size[0]
        bits = np.zeros((bottom - top, 2, items), np.uint8)  # the lower half is listed
        for half, marks in enumerate((marked, small)):
            part = marks[top:bottom, left:right]
            bits[:, half, : right - left] = part
        words = bits.reshape(-1, 2, size[0], 16).swapaxes(1, 2)
        packed = np.packbits(words.reshape(-1, 32), axis=1, bitorder="little").view(np.uint32)
        given = [cl.Buffer(context, flags, hostbuf=a) for a in (paths, packed, places, count)]
        numbers = map(np.int32, (width, height, left, top, right))
        kernel(queue, size, None, given[0], *numbers, *given[1:])
        cl.enqueue_copy(queue, count, given[3])
        cl.enqueue_copy(queue, places, given[2])
        found = np.zeros((height, width), bool)
        some = places[: count[0]]
        row, column = np.divmod(np.sort(np.where(some < 0, ~some, some)), width)
        found[top + row, column] = True
        row_of_small, column_of_small = np.divmod(~some[some < 0], width)
        tiny = np.zeros((height, width), bool)
        tiny[top + row_of_small, column_of_small] = True
        inside = np.zeros((height, width), bool)
        inside[top:bottom, left:right] = True
        assert len(row) == found.sum()
        assert (found == (expected & inside)).all()
        assert (tiny == (found & small[:, :width])).all()


MANY = 64
REGIONS = [(0, 0, 1, 1), (7, 3, 50, 29), (17, 5, 18, 31), (52, 30, 53, 31), (1, 0, 53, 2)]


SCENES = [paper, beads, glass, specks, lined]


@pytest.mark.parametrize(("made", "n"), [*((made, 16) for made in SCENES), (beads, 4), (glass, 1)])
def test_a_region_is_the_crop_of_the_whole(device: cl.Device, made, n: int) -> None:
    scene, renderer = replace(made(), samples=MANY), renderer_for(device, n)
    whole, passes = renderer.render(scene, *SIZE, alpha=True, passes=["id", "depth"])
    assert (whole == renderer.render(scene, *SIZE, alpha=True)).all()
    for x0, y0, x1, y1 in REGIONS:
        region = x0, y0, x1, y1
        part, looks = renderer.render(
            scene, *SIZE, region=region, alpha=True, passes=["id", "depth"]
        )
        assert (part == whole[y0:y1, x0:x1]).all()
        assert all((looks[name] == passes[name][y0:y1, x0:x1]).all() for name in passes)


def test_passes_are_those_of_the_middle(device: cl.Device) -> None:
    renderer = renderer_for(device, 16)
    one, many = (
        renderer.render(replace(paper(), samples=n), *SIZE, passes=["depth", "normal", "id"])[1]
        for n in (1, MANY)
    )
    assert all((one[name] == many[name]).all() for name in one)


def pieces(monkeypatch: pytest.MonkeyPatch) -> None:
    """Bands of few rows, blocks of two, few edges at a time."""
    monkeypatch.setattr("clrt.opencl.bands.BAND_PIXELS", WIDTH * 7)
    monkeypatch.setattr("clrt.opencl.bands.FIRST_BAND_TESTS", 64 * WIDTH * 2)
    monkeypatch.setattr("clrt.opencl.bands.GROWTH", 1.0)
    monkeypatch.setattr("clrt.opencl.edges.BLOCK_PIXELS", WIDTH * 2 + 3)
    monkeypatch.setattr("clrt.opencl.edges.FIRST_SAMPLES", MANY * 9)


@pytest.mark.parametrize("made", SCENES)
def test_bands_do_not_show(device: cl.Device, made, monkeypatch: pytest.MonkeyPatch) -> None:
    scene, renderer = replace(made(), samples=MANY), renderer_for(device, 16)
    whole = renderer.render(scene, *SIZE, alpha=True)
    pieces(monkeypatch)
    rows: list[int] = []
    assert (renderer.render(scene, *SIZE, alpha=True, progress=rows.append) == whole).all()
    assert sum(rows) == HEIGHT
    assert min(rows) == 0
    assert len(rows) > 20


def test_progress_of_a_region_and_of_nothing(device: cl.Device) -> None:
    rows: list[int] = []
    renderer = renderer_for(device, 16)
    scene = replace(paper(), samples=MANY)
    renderer.render(scene, *SIZE, region=(3, 5, 9, 22), progress=rows.append)
    assert sum(rows) == 17
    rows.clear()
    renderer.render(replace(scene, spheres=()), *SIZE, progress=rows.append)
    assert sum(rows) == HEIGHT


@pytest.mark.parametrize("call", [0, 3, 12, 30])
def test_ctrl_c_ends_it(device: cl.Device, call: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the first pass and in the second, and the next picture is right."""
    scene, renderer = replace(paper(), samples=MANY), renderer_for(device, 16)
    whole = renderer.render(scene, *SIZE)
    pieces(monkeypatch)
    calls = itertools.count()

    def stop(rows: int) -> None:
        if next(calls) == call:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        renderer.render(scene, *SIZE, progress=stop)
    assert next(calls) == call + 1
    assert (renderer.render(scene, *SIZE) == whole).all()


def test_threads_do_not_show() -> None:
    """Neither Python's nor PoCL's."""
    scenes = [replace(made(), samples=MANY) for made in (paper, beads, glass, specks)]
    renderer = Renderer()
    alone = [renderer.render(scene, *SIZE, alpha=True) for scene in scenes]
    with ThreadPoolExecutor(4) as threads:
        found = threads.map(lambda i: renderer.render(scenes[i % 4], *SIZE, alpha=True), range(16))
        assert all((picture == alone[i % 4]).all() for i, picture in enumerate(found))
    code = (
        "import hashlib, clrt; from msgspec.structs import replace\n"
        "scene = replace(clrt.load_scene('four-spheres'), shadow_bias=0.0, samples=64)\n"
        f"picture = clrt.render(scene, {WIDTH}, {HEIGHT}, alpha=True, threads=1)\n"
        "print(hashlib.sha256(picture.tobytes()).hexdigest())"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)
    assert done.stdout.strip() == hashlib.sha256(alone[0].tobytes()).hexdigest()


@pytest.mark.parametrize("dtype", [np.float32, np.uint8, np.uint16])
def test_out_is_filled(device: cl.Device, dtype) -> None:
    renderer, scene = renderer_for(device, 16), replace(paper(), samples=MANY)
    # Films of 16 bits are made of one with alpha, whose edges get as many samples as white needs.
    whole = renderer.render(scene, *SIZE, alpha=dtype == np.uint16)[..., :3]
    if dtype != np.float32:
        most = np.iinfo(dtype).max
        whole = np.rint(most * np.clip(whole.astype(np.float64), 0, 1)).astype(dtype)
    film = np.zeros((HEIGHT, WIDTH, 3), dtype)
    assert renderer.render(scene, *SIZE, out=film) is film
    assert (film == whole).all()
    wide = np.zeros((HEIGHT, 2 * WIDTH, 5), dtype)
    assert (renderer.render(scene, *SIZE, out=wide[::-1, ::2, 1:4]) == whole).all()
    assert not wide[:, 1::2].any()
    part = np.zeros((10, 20, 3), dtype)[::-1]
    renderer.render(scene, *SIZE, region=(13, 5, 33, 15), out=part)
    assert (part == whole[5:15, 13:33]).all()


def test_memory_does_not_grow_with_samples(device: cl.Device) -> None:
    renderer, resident = renderer_for(device, 16), []
    for count in (2, 8192):
        renderer.render(ball(light=9.0, samples=count), 300, 200)
        resident.append(int(Path("/proc/self/statm").read_text().split()[1]) * 4096)
    assert resident[1] - resident[0] < 4e6


def test_literal_has_one_sample(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["render", "--precision", "literal", "--samples", "2"]
    result = CliRunner().invoke(main, words)
    assert result.exit_code == 2
    assert result.stderr.strip() == (
        "clrt: precision: literal knows no samples > 1, expected robust or double"
    )
    assert not list(tmp_path.iterdir())


def test_the_command_takes_samples(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["render", "-o", "a.npy", "--samples", "64", "--width", "53", "--height", "31", "-q"]
    assert CliRunner().invoke(main, words).exit_code == 0
    scene = replace(clrt.load_scene("four-spheres"), samples=64)
    assert (np.load("a.npy") == clrt.render(scene, *SIZE)).all()
