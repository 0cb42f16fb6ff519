"""The kernel against both truths, on every device and for every number of lanes."""

import gc
import math
import multiprocessing
import os
import subprocess
import sys
import tempfile
import threading
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import numpy as np
import pyopencl as cl
import pytest
from conftest import in_lanes, kept, renderer_for
from msgspec.structs import replace

import clrt
from clrt import reference
from clrt.figure.rendering import Renderer
from clrt.film import color, metrics
from clrt.renderer.pack.features import exposures

TRUTHS: list[tuple[reference.Truth, float]] = [("seed", 1e-5), ("exact", 0.0)]
SIZES = [(240, 135), (101, 67), (1, 1), (1, 7), (7, 1), (17, 2)]


# The paper has no glass, and no meshes.
NAMES_AND_TRUTHS = [
    (name, truth)
    for name in clrt.builtin_scenes()
    for truth, _ in TRUTHS
    if (name, truth) not in (("glass", "seed"), ("shading", "seed"))
]


REGIONS = [(0, 0, 101, 67), (0, 0, 1, 1), (17, 3, 50, 64), (50, 30, 51, 67), (99, 66, 101, 67)]
SOME = ("four-spheres", "sunflower")  # a list and a tree
SOME_AND_TRUTHS = [case for case in NAMES_AND_TRUTHS if case[0] in SOME]


@pytest.fixture(scope="session")
def truths() -> dict:
    """(scene, size, truth) -> (scene to render, its trace)."""
    found = {}
    for name in clrt.builtin_scenes():
        for size in SIZES:
            for truth, bias in TRUTHS:
                if (name, truth) not in NAMES_AND_TRUTHS:
                    continue
                scene = replace(clrt.load_scene(name), shadow_bias=bias)
                found[name, size, truth] = scene, reference.trace(scene, *size, truth)
    return found


def check(image: np.ndarray, trace: reference.Trace, flips: int, bound: float = 5e-5) -> None:
    """That away from edges nothing is off by more, and at edges at most `flips` pixels."""
    error = metrics.pixel_error(image, trace.image)
    worst = float(error[~metrics.edges(trace.paths)].max(initial=0))
    flipped = int((error > metrics.QUARTER_STEP).sum())
    good = not np.isnan(image).any() and flipped <= flips and worst < bound
    assert good, f"{flipped} flips, off by {worst:.2g}: {kept(image, trace.image)}"


@pytest.mark.parametrize("size", SIZES, ids=lambda s: f"{s[0]}x{s[1]}")
@pytest.mark.parametrize(("lanes", "case"), in_lanes(NAMES_AND_TRUTHS, SOME_AND_TRUTHS))
def test_robust_against_truth(renderer: Renderer, truths, case, size) -> None:
    name, truth = case
    scene, trace = truths[name, size, truth]
    image = renderer.render(scene, *size)
    assert image.shape == (size[1], size[0], 3)
    assert image.dtype == np.float32
    # In sunflower each of six bounces off a small mirror magnifies a rounding, most at its edge.
    # Glass does so as well.
    check(image, trace, flips=3 if name in ("sunflower", "glass") else 1,
          bound=5e-4 if name == "glass" else 5e-5)  # fmt: skip


@pytest.mark.parametrize("truth", ["seed", "exact"])
def test_paths_are_those_of_the_truth(renderer: Renderer, truths, truth) -> None:
    scene, trace = truths["four-spheres", SIZES[0], truth]
    flips = renderer.paths(scene, *SIZES[0]) != trace.paths
    assert flips.sum() <= 1
    assert len(np.unique(trace.paths)) > 20


# Of the other numbers of lanes robust says enough, and each program's trial.
@pytest.mark.parametrize(
    ("lanes", "case"),
    [
        one
        for one in in_lanes(NAMES_AND_TRUTHS, SOME_AND_TRUTHS)
        if one.values[0] in (1, 16) or (one.values[0] == 4 and one.values[1] in SOME_AND_TRUTHS)
    ],
)
def test_double_against_truth(double_renderer: Renderer, truths, case) -> None:
    name, truth = case
    scene, trace = truths[name, SIZES[0], truth]
    image = double_renderer.render(scene, *SIZES[0])
    # The film is float32: half a unit in the last place of 1.
    check(image, trace, flips=0, bound=6.1e-8)


@pytest.mark.parametrize(("lanes", "name"), in_lanes(SOME, SOME[:1]))
def test_8_bit_is_the_film_rounded(renderer: Renderer, name) -> None:
    scene = clrt.load_scene(name)
    film = renderer.render(scene, 101, 67)
    image = renderer.render(scene, 101, 67, dtype=np.uint8)
    assert image.dtype == np.uint8
    assert (image == np.rint(255 * np.clip(film.astype(np.float64), 0, 1))).all()
    for x0, y0, x1, y1 in REGIONS:
        part = renderer.render(scene, 101, 67, dtype=np.uint8, region=(x0, y0, x1, y1))
        assert (part == image[y0:y1, x0:x1]).all()


def test_bands_do_not_show(renderer: Renderer, monkeypatch: pytest.MonkeyPatch) -> None:
    scene = clrt.load_scene("four-spheres")
    whole = renderer.render(scene, 75, 40)
    monkeypatch.setattr("clrt.opencl.bands.BAND_PIXELS", 75 * 7)
    monkeypatch.setattr("clrt.opencl.bands.BAND_SECONDS", math.inf)
    rows: list[int] = []
    monkeypatch.setattr("clrt.opencl.bands.FIRST_BAND_TESTS", 64 * 75 * 2)
    assert (renderer.render(scene, 75, 40, progress=rows.append) == whole).all()
    assert rows == [2, 2, 2, 7, 7, 7, 7, 6]
    rows = []
    monkeypatch.setattr("clrt.opencl.bands.BAND_SECONDS", 0.0)  # a slow device: row by row
    assert (renderer.render(scene, 75, 40, progress=rows.append) == whole).all()
    assert rows == [2, 2, 2, *34 * [1]]


@pytest.mark.parametrize(("lanes", "name"), in_lanes(clrt.builtin_scenes(), SOME))
def test_a_region_is_the_crop_of_the_whole(renderer: Renderer, name: str) -> None:
    scene = clrt.load_scene(name)
    whole = renderer.render(scene, 101, 67)
    for x0, y0, x1, y1 in REGIONS:
        part = renderer.render(scene, 101, 67, region=(x0, y0, x1, y1))
        assert part.shape == (y1 - y0, x1 - x0, 3)
        assert (part == whole[y0:y1, x0:x1]).all()


@pytest.mark.parametrize("region", [(0, 0, 0, 9), (0, 0, 9, 10), (-1, 0, 5, 5), (5, 0, 4, 5), (1,)])
def test_refuses_a_region(region) -> None:
    with pytest.raises(clrt.RequestError, match="region: expected X0 Y0 X1 Y1 with 0 <= X0 < X1"):
        Renderer().render(clrt.load_scene("four-spheres"), 9, 9, region=region)


@pytest.mark.parametrize("size", [(0, 1), (2.5, 2), ("3", 3), (2**31, 1), (None, 1)])
def test_refuses_a_size(size) -> None:
    with pytest.raises(clrt.RequestError, match="size: expected 1 to 16777216 pixels each way"):
        Renderer().render(clrt.load_scene("four-spheres"), *size)


@pytest.mark.parametrize("dtype", [np.uint32, "float64", "nonsense", 7])
def test_refuses_a_dtype(dtype) -> None:
    with pytest.raises(clrt.RequestError, match="dtype: expected float32, uint8 or uint16"):
        Renderer().render(clrt.load_scene("four-spheres"), 9, 9, dtype=dtype)


def test_numpys_whole_numbers_are_sizes() -> None:
    width: Any = np.int64(8)
    height: Any = np.uint16(5)
    image = Renderer().render("four-spheres", width, height)
    assert image.shape == (5, 8, 3)


def test_literal_is_the_papers_formula(device: cl.Device, lanes: int, truths) -> None:
    """In float32, so only nearly so: NumPy's float32 has as many flips."""
    scene, trace = truths["four-spheres", SIZES[0], "seed"]
    image = renderer_for(device, lanes, "literal").render(scene, *SIZES[0])
    assert (metrics.pixel_error(image, trace.image) > metrics.QUARTER_STEP).sum() <= 20


def test_empty_and_unlit_scenes_are_black(renderer: Renderer) -> None:
    scene = clrt.load_scene("four-spheres")
    assert not renderer.render(replace(scene, spheres=()), 33, 9).any()
    assert not renderer.render(replace(scene, lights=()), 33, 9).any()
    assert not renderer.render(clrt.Scene(scene.camera), 33, 9).any()


def test_depth_is_run_time_data(renderer: Renderer) -> None:
    scene = clrt.load_scene("four-spheres")
    for depth in (1, 2, 5, 9):
        deeper = replace(scene, max_depth=depth, shadow_bias=0.0)
        trace = reference.trace(deeper, 120, 68)
        check(renderer.render(deeper, 120, 68), trace, flips=1)


def test_a_turned_camera_sees_the_turned_picture(renderer: Renderer) -> None:
    scene = replace(clrt.load_scene("four-spheres"), shadow_bias=0.0)
    camera = clrt.Camera((2.0, 1.5, 2.5), (0.1, -0.4, -0.3), up=(0.2, 1.0, 0.1), fov=42.0)
    scene = replace(scene, camera=camera)
    trace = reference.trace(scene, 120, 68)
    assert trace.image.any()
    check(renderer.render(scene, 120, 68), trace, flips=1)


@pytest.mark.filterwarnings("ignore:.*fork:DeprecationWarning")
def test_a_forked_process_is_refused_not_hung() -> None:
    """Even while another thread renders."""
    scene = clrt.load_scene("four-spheres")
    renderer = Renderer()
    other = threading.Thread(target=renderer.render, args=(scene, 8000, 8000))

    def in_child(results) -> None:
        for use in (
            lambda: renderer.render(scene, 8, 8),
            lambda: renderer.paths(scene, 8, 8),
            lambda: renderer.prepare(scene),
            lambda: Renderer(device=renderer.device),
            Renderer,
        ):
            try:
                use()
            except clrt.DeviceError as error:
                results.put(str(error))

    context = multiprocessing.get_context("fork")
    results = context.Queue()
    child = context.Process(target=in_child, args=(results,))
    other.start()
    child.start()
    said = [results.get(timeout=20) for _ in range(5)]
    child.join(20)
    other.join()
    assert all("was forked off one that had started OpenCL" in text for text in said)


def test_started_by_many_threads_at_once() -> None:
    """In a process of its own, whose environment stays as it was."""
    program = """
import os, threading
from concurrent.futures import ThreadPoolExecutor
import clrt
from clrt.renderer import maker
from clrt.storage import cache_folder
before, scene = dict(os.environ), clrt.load_scene("four-spheres")
with ThreadPoolExecutor(8) as threads:
    pictures = list(threads.map(lambda i: clrt.render(scene, 20, 10), range(8)))
assert all((picture == pictures[0]).all() for picture in pictures)
assert dict(os.environ) == before
assert len(list(cache_folder().glob("run-*"))) == 1 + len(maker._idle)  # a child has its own
"""
    with tempfile.TemporaryDirectory() as cache:
        environment = {**os.environ, "XDG_CACHE_HOME": cache}
        done = subprocess.run([sys.executable, "-c", program], env=environment, timeout=60)
        assert done.returncode == 0
        assert not list(Path(cache).glob("clrt/run-*"))


def test_render_of_one_picture() -> None:
    image = clrt.render(clrt.load_scene("four-spheres"), width=32, height=18)
    assert image.shape == (18, 32, 3)
    assert image.dtype == np.float32


def test_an_exception_leaves_the_renderer_usable() -> None:
    def stop(rows: int) -> None:
        raise KeyboardInterrupt

    scene = clrt.load_scene("four-spheres")
    with Renderer() as renderer:
        before = renderer.render(scene, 64, 36)
        renderer.render(scene, 64, 36, progress=lambda rows: renderer.render(scene, 9, 9))
        with pytest.raises(KeyboardInterrupt):
            renderer.render(scene, 64, 36, progress=stop)
        gc.collect()
        assert (renderer.render(scene, 64, 36) == before).all()


@pytest.mark.parametrize("shared", [True, False])
def test_threads(device: cl.Device, shared: bool) -> None:
    switching = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    scenes = [clrt.load_scene(name) for name in clrt.builtin_scenes()]
    one = Renderer(device=device)
    expected = [one.render(scene, 97, 55) for scene in scenes]

    def same(i: int) -> bool:
        used = one if shared else Renderer(device=device)
        return bool(
            (used.render(scenes[i % len(scenes)], 97, 55) == expected[i % len(scenes)]).all()
        )

    try:
        with ThreadPoolExecutor(8) as threads:
            assert all(threads.map(same, range(48)))
    finally:
        sys.setswitchinterval(switching)


def test_closed_twice() -> None:
    renderer = Renderer()
    before = renderer.render(clrt.load_scene("four-spheres"), 8, 8)
    renderer.close()
    renderer.close()
    assert (renderer.render(clrt.load_scene("four-spheres"), 8, 8) == before).all()


def test_memory_stays_flat(device: cl.Device) -> None:
    scenes = [clrt.load_scene(name) for name in (*SOME, "orbit")]
    renderer = Renderer(device=device)
    resident = []
    for i in range(2000):
        renderer.render(scenes[i % len(scenes)], 64, 36, dtype=(np.float32, np.uint8)[i % 2])
        if i in (99, 1999):
            resident.append(int(Path("/proc/self/statm").read_text().split()[1]) * 4096)
    assert resident[1] - resident[0] < 4e6  # 2 kB a picture; its film has 28 kB


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"lanes": 3}, "lanes: expected one of"),
        ({"precision": "single"}, "precision: expected one of"),
        ({"device": "Voodoo 2"}, "no OpenCL device is called 'Voodoo 2'; there are: "),
    ],
)
def test_refuses(options: dict, said: str) -> None:
    with pytest.raises(clrt.ClrtError, match=said):
        Renderer(**options)


def test_refuses_a_size_of_none() -> None:
    with pytest.raises(clrt.RequestError, match="size"):
        clrt.render(clrt.load_scene("four-spheres"), 0, 5)


@pytest.mark.parametrize("dtype", [np.float32, np.uint8])
def test_out_is_filled(device: cl.Device, dtype) -> None:
    renderer = renderer_for(device, 16)
    expected = renderer.render("sunflower", 101, 67, dtype=dtype)
    film = np.zeros((67, 101, 3), dtype)
    assert renderer.render("sunflower", 101, 67, out=film) is film
    assert (film == expected).all()
    wide = np.zeros((67, 202, 4), dtype)
    assert (renderer.render("sunflower", 101, 67, out=wide[:, ::2, :3]) == expected).all()
    assert not wide[:, 1::2].any()
    part = np.zeros((10, 20, 3), dtype)[::-1]
    renderer.render("sunflower", 101, 67, region=(33, 5, 53, 15), out=part)
    assert (part == expected[5:15, 33:53]).all()


@pytest.mark.parametrize(
    ("out", "options", "said"),
    [
        (np.zeros((9, 8, 3)), {}, "dtype: expected float32, uint8 or uint16, got float64"),
        (np.zeros((9, 8, 3), np.float32), {"dtype": "uint8"}, "dtype: expected that of out, float"),
        (np.zeros((8, 9, 3), np.float32), {}, r"out: expected a writeable array of \(9, 8, 3\)"),
        (np.broadcast_to(np.float32(0), (9, 8, 3)), {}, "out: expected a writeable array"),
        ([[0.0]], {}, "out: expected an array, got list"),
    ],
)
def test_refuses_an_out(out, options: dict, said: str) -> None:
    with pytest.raises(clrt.RequestError, match=said):
        Renderer().render("four-spheres", 8, 9, out=out, **options)


LOOKS = {
    "background": clrt.Film(background=(0.2, 0.5, 0.9)),
    "transparent": clrt.Film(background=(0.2, 0.5, 0.9), transparent=True),
    "everything": clrt.Film(
        background=(1, 0.9, 0.8), transfer="srgb", outline=3, outline_color=(0.3, 0, 0),
        depth_cue=(0.5, 4),
    ),
    "decorated": clrt.Film(
        background=(1, 0.9, 0.8), transfer="srgb", outline=1,
        colorbar="speed", colorbar_clim=(-1, 5),
        cells=[clrt.Cell((np.eye(3) - 0.1).tolist(), (-1, -0.5, -2)),
            clrt.Cell(((5, 0, 0), (0, 5, 0), (0, 0, 5)), (-2, -2, -2)),],
    ),
    "legend": clrt.Film(
        transparent=True, colorbar="element", legend=[clrt.LegendEntry("Na", (0.5, 0, 1))]
    ),
}  # fmt: skip


def looking(film: clrt.Film, name: str = "four-spheres") -> clrt.Scene:
    return replace(clrt.load_scene(name), film=film, shadow_bias=0.0)


@pytest.mark.parametrize("name", ["four-spheres", "sunflower"])
def test_background_and_alpha_against_truth(renderer: Renderer, name: str) -> None:
    """Seen directly, and in mirrors."""
    scene = looking(LOOKS["background"], name)
    trace = reference.trace(scene, 101, 67)
    check(renderer.render(scene, 101, 67), trace, flips=3)
    clear = looking(LOOKS["transparent"], name)
    trace = reference.trace(clear, 101, 67)
    image = renderer.render(clear, 101, 67)
    assert image.shape == (67, 101, 4)
    check(image[..., :3], trace, flips=3)
    assert (image[..., 3] != trace.alpha).sum() <= 1
    assert not image[trace.alpha == 0].any()
    # Mirrors show it, directly seen it is gone.
    black = renderer.render(looking(clrt.Film(), name), 101, 67)
    assert (abs(image[..., :3] - black).max(axis=2) > 0.1).mean() > 0.01


@pytest.mark.parametrize("precision", ["literal", "double"])
def test_every_precision_has_a_background(device: cl.Device, precision) -> None:
    truth: reference.Truth = "seed" if precision == "literal" else "exact"
    scene = replace(looking(LOOKS["background"]), shadow_bias=1e-5 if truth == "seed" else 0.0)
    image = renderer_for(device, 16, precision).render(scene, 101, 67)
    error = metrics.pixel_error(image, reference.render(scene, 101, 67, truth=truth))
    assert (error > metrics.QUARTER_STEP).sum() <= (20 if truth == "seed" else 0)


@pytest.mark.parametrize("look", LOOKS)
@pytest.mark.parametrize("dtype", [np.float32, np.uint8, np.uint16])
def test_a_region_is_the_crop_with_every_step(device: cl.Device, look: str, dtype) -> None:
    renderer = renderer_for(device, 16)
    for name in ("four-spheres", "sunflower"):
        scene = looking(LOOKS[look], name)
        whole = renderer.render(scene, 101, 67, dtype=dtype)
        assert whole.dtype == dtype
        for x0, y0, x1, y1 in REGIONS:
            part = renderer.render(scene, 101, 67, dtype=dtype, region=(x0, y0, x1, y1))
            assert (part == whole[y0:y1, x0:x1]).all()


def test_steps_show(device: cl.Device) -> None:
    """Outline where the id jumps, the background far away, each pixel else as it was."""
    renderer = renderer_for(device, 16)
    plain, passes = renderer.render(looking(clrt.Film()), 101, 67, passes=("id", "depth"))
    ball, sky = passes["id"] == 2, passes["id"] == -1
    drawn = renderer.render(looking(clrt.Film(outline=1, outline_color=(2, 0, 3))), 101, 67)
    line = (drawn == (2, 0, 3)).all(axis=2)
    assert (drawn[~line] == plain[~line]).all()
    middle = np.flatnonzero(ball.any(axis=1))[ball.any(axis=1).sum() // 2]
    columns = np.flatnonzero(ball[middle])
    assert line[middle, columns[[0, -1]]].all()
    assert not line[middle, columns[1:-1]].any()
    assert not line[:5][sky[:5]].any()
    cued = looking(clrt.Film(background=(0, 0, 1), depth_cue=(1e-3, 2e-3)))
    assert abs(renderer.render(cued, 101, 67) - (0, 0, 1)).max() < 1e-6
    near = looking(clrt.Film(depth_cue=(1e5, 2e5)))
    assert (renderer.render(near, 101, 67) == plain)[passes["depth"] < 1e5].all()


def test_a_sphere_hides_its_share_of_an_edge(device: cl.Device) -> None:
    """One that goes through the middle of a ball: half of it is inside. And the bar is drawn, over
    what is there."""
    along = clrt.Cell(((4, 0, 0), (0, 0, 0), (0, 0, 0)), (-2, 0, 0))
    camera = clrt.Camera((0, 0, 9), (0, 0, 0), projection="orthographic", height=4)
    ball, red = clrt.Sphere((0, 0, 0), 1, "red"), clrt.Material((1, 0, 0), (0, 0, 0))
    look = clrt.Film((0, 1, 0), cells=[along])
    scene = clrt.Scene(camera, (clrt.AmbientLight(),), {"red": red}, (ball,), film=look)
    renderer = renderer_for(device, 16)
    plain = renderer.render(scene, 961, 541)
    row, step = plain[270], 4 / 540  # world units from pixel to pixel
    drawn = (row == (0, 0, 0)).all(axis=1)  # black, for green is bright
    assert drawn.sum() * step == pytest.approx(2, abs=3 * step)
    assert (row[abs((np.arange(961) - 480) * step) < 0.99] == (1, 0, 0)).all()
    look = replace(look, colorbar=" ", colorbar_clim=(0, 1))
    barred = renderer.render(replace(scene, film=look), 961, 541)
    assert (barred[:, :850] == plain[:, :850]).all()
    lowest = color.linear(np.array([68, 1, 84], np.uint8))
    assert (barred[:, 850:] == lowest).all(axis=2).any()


@pytest.mark.parametrize("transfer", ["linear", "srgb"])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_over_white_it_is_what_is_rendered_over_white(device: cl.Device, transfer, dtype) -> None:
    """To the step: colour, alpha and what is over white are rounded each."""
    most = np.iinfo(dtype).max
    scene = looking(clrt.Film((1, 1, 1), transfer=transfer, outline=2, depth_cue=(0.5, 3)))
    renderer = renderer_for(device, 16)
    white = renderer.render(scene, 101, 67, dtype=dtype)
    clear = renderer.render(scene, 101, 67, dtype=dtype, alpha=True) / most
    straight, alpha = clear[..., :3], clear[..., 3:]
    if transfer == "srgb":
        straight = color.to_linear(straight)
    over = straight * alpha + 1 - alpha
    if transfer == "srgb":
        over = color.to_srgb(over)
    assert abs(np.rint(most * over) - white).max() <= 1


def test_sixteen_bits_are_the_film_rounded(device: cl.Device) -> None:
    renderer = renderer_for(device, 16)
    film = renderer.render(looking(clrt.Film()), 101, 67).astype(np.float64)
    image = renderer.render(looking(clrt.Film()), 101, 67, dtype="uint16")
    assert image.dtype == np.uint16
    assert (image == np.rint(65535 * np.clip(film, 0, 1))).all()
    curved = renderer.render(looking(clrt.Film(transfer="srgb")), 101, 67, dtype="uint8")
    assert (curved == np.rint(255 * color.to_srgb(np.clip(film, 0, 1)))).all()


def test_alpha_is_the_scenes_unless_it_is_asked_for(device: cl.Device) -> None:
    renderer = renderer_for(device, 16)
    clear, solid = looking(clrt.Film(transparent=True)), looking(clrt.Film())
    assert renderer.render(clear, 9, 7).shape == (7, 9, 4)
    assert renderer.render(clear, 9, 7, alpha=False).shape == (7, 9, 3)
    assert renderer.render(solid, 9, 7, alpha=True).shape == (7, 9, 4)
    out = np.zeros((7, 9, 4), np.uint8)
    assert renderer.render(solid, 9, 7, out=out) is out
    assert (out == renderer.render(clear, 9, 7, dtype="uint8")).all()
    wide = np.zeros((7, 18, 5), np.uint16)
    renderer.render(solid, 9, 7, out=wide[:, ::2, :4])
    assert (wide[:, ::2, :4] == renderer.render(clear, 9, 7, dtype="uint16")).all()
    assert not wide[:, 1::2].any()
    assert not wide[..., 4].any()
    for scene, channels, alpha in ((clear, 3, None), (solid, 3, True), (solid, 4, False)):
        film = np.zeros((7, 9, channels), np.float32)
        said = r"out: expected a writeable array of \(7, 9, \d\), got"
        with pytest.raises(clrt.RequestError, match=said):
            renderer.render(scene, 9, 7, out=film, alpha=alpha)


def test_kernels_make_what_needs_no_step() -> None:
    plain, white = clrt.Film(), clrt.Film((1, 1, 1), transparent=True)
    floats, byte, word = (np.dtype(kind) for kind in (np.float32, np.uint8, np.uint16))
    srgb = clrt.Film(transfer="srgb")
    for film, dtype, alpha, passes, expected in (
        (plain, floats, False, None, ["float"]),
        (srgb, floats, False, None, ["float"]),
        (plain, byte, False, None, ["bytes"]),
        (plain, byte, False, ["id"], ["bytes", "passes"]),
        (plain, byte, True, None, ["alpha"]),
        (srgb, byte, False, None, ["alpha"]),
        (plain, word, False, None, ["alpha"]),
        (white, floats, True, None, ["alpha"]),
        (white, floats, False, None, ["alpha"]),
        (clrt.Film(outline=1), floats, False, None, ["alpha", "passes"]),
        (LOOKS["legend"], floats, False, None, ["alpha"]),
        (LOOKS["decorated"], byte, False, None, ["alpha", "passes"]),
        (clrt.Film(depth_cue=(1, 2)), byte, True, ["id"], ["alpha", "passes"]),
    ):
        scene = replace(clrt.load_scene("four-spheres"), film=film)
        assert exposures(scene, dtype, alpha, passes) == expected


def test_progress_counts_each_row_once(device: cl.Device) -> None:
    rows: list[int] = []
    renderer = renderer_for(device, 16)
    renderer.render(
        looking(LOOKS["everything"]), 101, 67, region=(9, 5, 50, 45), progress=rows.append
    )
    assert sum(rows) == 40
    assert rows[0] == 0  # of the passes, which can be ended as well


def test_memory_of_every_kind_of_film_is_taken_again() -> None:
    scene = looking(LOOKS["everything"])
    with Renderer() as renderer:
        places = set()
        for _ in range(4):
            image, passes = renderer.render(scene, 64, 36, dtype="uint8", passes=["id"])
            used = renderer._dispatcher._films
            places.add(tuple(sorted((use, films._last.ctypes.data) for use, films in used.items())))
            del image, passes
        assert {use for use, _ in next(iter(places))} == {"picture", "exposed", "passes"}
        assert len(places) == 1


def test_memory_is_taken_again_when_nobody_has_it() -> None:
    with Renderer() as renderer:
        first = renderer.render("four-spheres", 64, 36)
        place, copied = first.ctypes.data, first.copy()
        held = first[3:]  # a part of it is enough
        del first
        assert renderer.render("sunflower", 64, 36).ctypes.data != place
        assert (held == copied[3:]).all()
        del held
        second = renderer.render("four-spheres", 64, 36)
        place = second.ctypes.data
        del second
        assert renderer.render("sunflower", 64, 36).ctypes.data == place


def test_denoise_does_not_show_regions_and_ends_at_16_samples(device: cl.Device) -> None:
    renderer, scene = renderer_for(device, 16), clrt.load_scene("four-spheres")
    dim = clrt.AmbientLight(occlusion=True)
    scene = replace(scene, shadow_bias=0.0, lights=(*scene.lights, dim), samples=2)
    smooth = replace(scene, film=clrt.Film(denoise=True))
    whole = renderer.render(smooth, 96, 54)
    part = renderer.render(smooth, 96, 54, region=(13, 7, 61, 40))
    assert np.array_equal(part, whole[7:40, 13:61])
    enough = replace(smooth, samples=16)
    plain = renderer.render(replace(scene, samples=16), 32, 18)
    assert np.array_equal(renderer.render(enough, 32, 18), plain)
