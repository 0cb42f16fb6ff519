"""Programs are kept as binaries, and a spoilt one does no harm."""

import os
from collections import defaultdict
from pathlib import Path

import numpy as np
import pyopencl as cl
import pytest
from msgspec.structs import replace

import clrt
from clrt import storage
from clrt.errors import DeviceError
from clrt.figure.rendering import Renderer
from clrt.opencl import pocl, program

KEPT = "?" * storage.KEY_LENGTH  # and not the folders of processes that compile


def picture(device: cl.Device) -> np.ndarray:
    with Renderer(device=device) as renderer:
        return renderer.render(clrt.load_scene("four-spheres"), 40, 23)


def test_kept_cut_short_and_refused(
    device: cl.Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    first = picture(device)
    (kept,) = (tmp_path / "clrt").glob(KEPT)
    whole = kept.read_bytes()
    assert (picture(device) == first).all()
    assert kept.read_bytes() == whole
    for spoilt in (b"", whole[:-100], b"x" * len(whole)):
        kept.write_bytes(spoilt)
        assert (picture(device) == first).all()
        assert list((tmp_path / "clrt").glob(KEPT)) == [kept]
    kept.unlink()
    os.mkfifo(kept)
    assert (picture(device) == first).all()
    assert kept.is_file()


def test_a_cache_that_cannot_be_written(
    device: cl.Device, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "clrt").write_text("a file where the folder would be")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert picture(device).any()


def test_what_does_not_compile_says_why(device: cl.Device) -> None:
    with pytest.raises(DeviceError, match=r"it cannot compile the kernel: .*error: "):
        program.compiled(cl.Context([device]), device, program.kernel_source(), ["-DLANES=5"])


def test_a_pipe_in_the_cache_is_nothing_to_wait_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    assert storage.kept(tmp_path / "pipe") is None


def test_the_cache_forgets_what_was_not_used_for_longest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("clrt.storage.KEPT_ROOM", 350)
    paths = [tmp_path / (f"{i}" * storage.KEY_LENGTH) for i in range(4)]
    (tmp_path / "run-x").mkdir()
    for i, path in enumerate(paths[:3]):
        storage.keep(path, bytes(50))
        os.utime(path, (i, i))
    assert storage.kept(paths[0]) == bytes(50)  # now it is the youngest
    storage.keep(paths[3], bytes(100))
    assert [path.exists() for path in paths] == [True, False, True, True]
    storage.keep(paths[1], bytes(400))  # larger than all of it
    assert [path.name for path in tmp_path.iterdir()] == ["run-x"]


def test_what_is_run_lies_in_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Unless the user says where, or there is no such folder."""
    (tmp_path / "home").mkdir()
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    monkeypatch.delenv("XDG_CACHE_HOME", raising=False)
    monkeypatch.setattr("clrt.storage.IN_MEMORY", str(tmp_path))
    of_user = tmp_path / "home" / ".cache" / "clrt"
    assert storage.cache_folder() == of_user
    assert storage.cache_folder(runs=True) == tmp_path / f"clrt-{os.getuid()}"
    monkeypatch.setattr("clrt.storage.IN_MEMORY", str(tmp_path / "none"))
    assert storage.cache_folder(runs=True) == of_user
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert storage.cache_folder(runs=True) == tmp_path / "clrt"


def test_a_program_belongs_to_cpu_and_width(
    device: cl.Device, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two machines can have a home and a model's name in common."""

    def path() -> Path:
        return program.cache_path(device, "", [])

    before = path()
    assert path() == before
    monkeypatch.setattr("clrt.opencl.pocl.name_given", lambda device: "another")
    assert path() != before


CLOUD = replace(
    clrt.load_scene("four-spheres"),
    spheres=clrt.Spheres(
        np.random.default_rng(1).uniform((-1, -0.5, -2), (1, 0.5, 0), (2000, 3)), 0.02, "red"
    ),
    shadow_bias=0.0,
    materials={"red": clrt.Material((0.1, 0, 0), (0.7, 0, 0), (1, 1, 1), 100)},
    lights=(clrt.Light((5, 5, 5), radius=0.5), clrt.AmbientLight((0.2, 0.2, 0.2), occlusion=True)),
)


@pytest.mark.parametrize("of", ["list", "tree", "sky"])
@pytest.mark.parametrize("samples", [1, 4])
def test_nothing_is_compiled_after_the_trial(of: str, samples: int) -> None:
    """PoCL compiles a kernel again for each size of work-group and kind of grid: no launch, of a
    small picture or a large one, needs a library that the trial did not make."""
    scene = clrt.load_scene("four-spheres") if of == "list" else CLOUD
    if of == "tree":
        scene = replace(scene, lights=scene.lights[:1])
    scene = replace(scene, samples=samples)
    renderer, before = Renderer(), set(pocl.run_folder().rglob("*.so"))
    sizes = [(64, 36), (3840, 2160)] if of == "list" else [(64, 36), (1920, 1080)]
    for width, height in sizes if of != "sky" or samples == 1 else sizes[:1]:
        renderer.render(scene, width, height, dtype="uint8")
    renderer.render(scene, 640, 360, dtype="uint8", region=(10, 20, 300, 90))
    renderer.render(scene, 640, 360, dtype="uint8", passes=("depth", "id"))
    renderer.render(scene, 3, 70_000, dtype="uint8")
    moved = replace(scene, camera=replace(scene.camera, position=(0.1, 0.1, 1.5)))
    renderer.render(moved, 640, 360, dtype="uint8")
    found = defaultdict(list)
    for library in set(pocl.run_folder().rglob("*.so")) - before:
        found[library.parent.parent].append(library.parent.name)
    for of_kernel in found.values():  # both are of the binary: unpacked, not compiled
        assert min(of_kernel) == "0-0-0"
        assert len(of_kernel) == 2
