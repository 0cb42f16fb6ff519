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
from conftest import kept, renderer_for
from msgspec.structs import replace

import clrt
from clrt import metrics, reference
from clrt.renderer import Renderer

TRUTHS: list[tuple[reference.Truth, float]] = [("seed", 1e-5), ("exact", 0.0)]
SIZES = [(240, 135), (101, 67), (1, 1), (1, 7), (7, 1), (17, 2)]


@pytest.fixture(scope="session")
def truths() -> dict:
    """(scene, size, truth) -> (scene to render, its trace)."""
    found = {}
    for name in clrt.builtin_scenes():
        for size in SIZES:
            for truth, bias in TRUTHS:
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


@pytest.mark.parametrize("truth", ["seed", "exact"])
@pytest.mark.parametrize("size", SIZES, ids=lambda s: f"{s[0]}x{s[1]}")
@pytest.mark.parametrize("name", clrt.builtin_scenes())
def test_robust_against_truth(renderer: Renderer, truths, name, size, truth) -> None:
    scene, trace = truths[name, size, truth]
    image = renderer.render(scene, *size)
    assert image.shape == (size[1], size[0], 3)
    assert image.dtype == np.float32
    # In sunflower each of six bounces off a small mirror magnifies a rounding, most at its edge.
    check(image, trace, flips=3 if name == "sunflower" else 1)


@pytest.mark.parametrize("truth", ["seed", "exact"])
def test_paths_are_those_of_the_truth(renderer: Renderer, truths, truth) -> None:
    scene, trace = truths["four-spheres", SIZES[0], truth]
    flips = renderer.paths(scene, *SIZES[0]) != trace.paths
    assert flips.sum() <= 1
    assert len(np.unique(trace.paths)) > 20


@pytest.mark.parametrize("truth", ["seed", "exact"])
@pytest.mark.parametrize("name", clrt.builtin_scenes())
def test_double_against_truth(double_renderer: Renderer, truths, name, truth) -> None:
    scene, trace = truths[name, SIZES[0], truth]
    image = double_renderer.render(scene, *SIZES[0])
    # The film is float32: half a unit in the last place of 1.
    check(image, trace, flips=0, bound=6.1e-8)


@pytest.mark.parametrize("name", clrt.builtin_scenes())
def test_8_bit_is_the_film_rounded(renderer: Renderer, name) -> None:
    scene = clrt.load_scene(name)
    film = renderer.render(scene, 101, 67)
    image = renderer.render(scene, 101, 67, dtype=np.uint8)
    assert image.dtype == np.uint8
    assert (image == np.rint(255 * np.clip(film.astype(np.float64), 0, 1))).all()


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


REGIONS = [(0, 0, 101, 67), (0, 0, 1, 1), (17, 3, 50, 64), (50, 30, 51, 67), (99, 66, 101, 67)]


@pytest.mark.parametrize("dtype", [np.float32, np.uint8])
@pytest.mark.parametrize("name", clrt.builtin_scenes())
def test_a_region_is_the_crop_of_the_whole(renderer: Renderer, name: str, dtype) -> None:
    scene = clrt.load_scene(name)
    whole = renderer.render(scene, 101, 67, dtype=dtype)
    for x0, y0, x1, y1 in REGIONS:
        part = renderer.render(scene, 101, 67, dtype=dtype, region=(x0, y0, x1, y1))
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
    with pytest.raises(clrt.RequestError, match="dtype: expected float32 or uint8"):
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
from clrt.data import cache_folder
before, scene = dict(os.environ), clrt.load_scene("four-spheres")
with ThreadPoolExecutor(8) as threads:
    pictures = list(threads.map(lambda i: clrt.render(scene, 20, 10), range(8)))
assert all((picture == pictures[0]).all() for picture in pictures)
assert dict(os.environ) == before
assert len(list(cache_folder().glob("run-*"))) == 1
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
    scenes = [clrt.load_scene(name) for name in clrt.builtin_scenes()]
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
        (np.zeros((9, 8, 3)), {}, "dtype: expected float32 or uint8, got float64"),
        (np.zeros((9, 8, 3), np.float32), {"dtype": "uint8"}, "dtype: expected that of out, float"),
        (np.zeros((8, 9, 3), np.float32), {}, r"out: expected a writeable array of \(9, 8, 3\)"),
        (np.broadcast_to(np.float32(0), (9, 8, 3)), {}, "out: expected a writeable array"),
        ([[0.0]], {}, "out: expected an array, got list"),
    ],
)
def test_refuses_an_out(out, options: dict, said: str) -> None:
    with pytest.raises(clrt.RequestError, match=said):
        Renderer().render("four-spheres", 8, 9, out=out, **options)


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
