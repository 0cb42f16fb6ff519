"""Frames by themselves: the bytes of those in a row, whoever renders them, and of one kind."""

import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from PIL import Image

import clrt
from clrt.motion import cluster

ORBIT = clrt.load_scene("orbit")
SMALL: dict[str, Any] = {"width": 48, "height": 27}
ROOT = Path(__file__).parents[1]
# Here `clrt` and `python` are those of the tests.
ENVIRONMENT = {**os.environ, "PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}


def animate(pattern: str, *words: str, cwd: Path, **environment: str) -> str:
    """By the command, in a process of its own; returns what it says."""
    size = ("--width", "48", "--height", "27")
    done = subprocess.run(
        [sys.executable, "-m", "clrt", "animate", *words, "-o", pattern, *size],
        cwd=cwd,
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stderr


def content(folder: Path, glob: str = "*.png") -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.glob(glob)}


@pytest.fixture
def folders(tmp_path: Path) -> tuple[Path, Path]:
    for name in "ab":
        (tmp_path / name).mkdir()
    return tmp_path / "a", tmp_path / "b"


@pytest.mark.parametrize("suffix", [".png", ".npy"])
def test_a_frame_is_that_of_the_command(folders: tuple[Path, Path], suffix: str) -> None:
    one, other = folders
    animate(f"###{suffix}", "orbit", "--frames", "0-119", "--step", "40", cwd=one)
    for k in (80, 0, 40):
        path = clrt.render_frame("orbit", k, other / f"###{suffix}", **SMALL)
        assert path == other / f"{k:03d}{suffix}"
    assert len(content(one, "*")) == 4
    assert content(other, f"*{suffix}") == content(one, f"*{suffix}")
    # They are of one kind: each can go on with the other's.
    assert "0 frames of 48x27" in animate(
        f"###{suffix}", "orbit", "--step", "40", "--resume", cwd=other
    )
    clrt.render_frame("orbit", 1, one / f"###{suffix}", **SMALL)


def test_a_frame_has_the_film_of_its_scene(folders: tuple[Path, Path]) -> None:
    """Alpha, and the curve that a PNG names."""
    one, other = folders
    text = (ROOT / "scenes" / "orbit.toml").read_text()
    scene = one.parent / "clear.toml"
    scene.write_text(text + '\n[film]\ntransparent = true\ntransfer = "srgb"\n')
    animate("#.png", str(scene), "--frames", "0", cwd=one)
    path = clrt.render_frame(scene, 0, other / "#.png", **SMALL)
    assert content(other) == content(one)
    with Image.open(path) as file:
        assert file.mode == "RGBA"
        assert "srgb" in file.info
    with pytest.raises(clrt.RequestError, match=r"\.jpg has no alpha"):
        clrt.render_frame(scene, 0, other / "#.jpg", **SMALL)


def test_what_it_takes_gives_and_raises_can_be_pickled(tmp_path: Path) -> None:
    call = pickle.loads(pickle.dumps((clrt.render_frame, (ORBIT, 3, tmp_path / "#.png"), SMALL)))
    function, words, options = call
    assert pickle.loads(pickle.dumps(function(*words, **options))) == tmp_path / "3.png"
    with pytest.raises(clrt.RequestError) as raised:
        clrt.render_frame("orbit", 120, tmp_path / "#.png", **SMALL)
    assert str(pickle.loads(pickle.dumps(raised.value))) == str(raised.value)


def test_scene_and_file_say_the_same(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A name, a path and a Scene; and a file that has changed is read again."""
    shutil.copy(ROOT / "scenes" / "orbit.toml", tmp_path / "mine.toml")
    monkeypatch.chdir(tmp_path)
    names = ("orbit", "mine.toml", Path("mine.toml"), ORBIT)
    pictures = {clrt.render_frame(name, 7, "#.npy", **SMALL).read_bytes() for name in names}
    assert len(pictures) == 1
    text = Path("mine.toml").read_text()
    Path("mine.toml").write_text(text + "# a comment is nothing new\n")
    clrt.render_frame("mine.toml", 8, "#.npy", **SMALL)
    Path("mine.toml").write_text(text.replace("frames = 120", "frames = 160"))
    with pytest.raises(clrt.RequestError, match=r"scene [0-9a-f]{16}, not [0-9a-f]{16}"):
        clrt.render_frame("mine.toml", 9, "#.npy", **SMALL)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"width": 64, "height": 36}, r"size \(48, 27\), not \(64, 36\)"),
        ({"lanes": 4}, r"lanes \d+, not 4"),
        ({"precision": "double"}, "precision robust, not double"),
    ],
)
def test_a_mix_is_refused_by_call_and_command(tmp_path: Path, options: dict, said: str) -> None:
    clrt.render_frame("orbit", 0, tmp_path / "#.png", **SMALL)
    before = content(tmp_path, "*")
    with pytest.raises(clrt.RequestError, match=said):
        clrt.render_frame("orbit", 1, tmp_path / "#.png", **SMALL | options)
    words = [f"--{name}={value}" for name, value in (SMALL | options).items()]
    done = subprocess.run(
        [sys.executable, "-m", "clrt", "animate", "-o", "#.png", "--shard", "0/9", *words],
        cwd=tmp_path,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 2
    assert re.fullmatch(f"clrt: #.png: the pictures there have {said} .*\n", done.stderr)
    assert content(tmp_path, "*") == before


def test_another_target_is_another_kind(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    clrt.render_frame("orbit", 0, tmp_path / "#.png", **SMALL)
    monkeypatch.setattr(cluster, "target", lambda device: "i386 (PoCL)")
    with pytest.raises(clrt.RequestError, match=r"target .*, not i386 \(PoCL\)"):
        clrt.render_frame("orbit", 1, tmp_path / "#.png", **SMALL)


def test_resumed_only_what_is_missing_is_made(tmp_path: Path) -> None:
    pattern = tmp_path / "#.png"
    paths = [clrt.render_frame("orbit", k, pattern, **SMALL) for k in range(3)]
    whole = content(tmp_path)
    paths[1].write_bytes(paths[1].read_bytes()[:-9])
    paths[2].unlink()
    os.utime(paths[0], ns=(7, 7))
    for k in range(3):
        clrt.render_frame("orbit", k, pattern, **SMALL, resume=True)
    assert content(tmp_path) == whole
    assert paths[0].stat().st_mtime_ns == 7
    clrt.render_frame("orbit", 0, pattern, **SMALL)
    assert paths[0].stat().st_mtime_ns != 7


def test_a_killed_shard_loses_nothing(folders: tuple[Path, Path]) -> None:
    """It is ended in the middle, by a signal that nobody can answer, and started again."""
    one, other = folders
    animate("###.png", "orbit", cwd=one)
    words = ("animate", "orbit", "-o", "###.png", "--shard", "1/2", "--width", "48")
    shard = subprocess.Popen([sys.executable, "-m", "clrt", *words, "--height", "27"], cwd=other)
    while len(list(other.glob("*.png"))) < 5:
        time.sleep(0.001)
    shard.kill()
    shard.wait()
    assert 5 <= len(content(other)) < 60
    for part in ("0/2", "1/2"):
        animate("###.png", "orbit", "--shard", part, "--resume", cwd=other)
    assert content(other) == content(one)


@pytest.mark.parametrize(
    ("source", "frame", "pattern", "said"),
    [
        ("orbit", 120, "#.png", "frames: expected whole numbers from 0 to 119, got 120"),
        ("orbit", 1.5, "#.png", "frames: expected whole numbers"),
        ("four-spheres", 0, "#.png", "animation: expected a table, got none"),
        ("none.toml", 0, "#.png", "none.toml: no such file"),
        ("orbit", 0, "a.png", "a.png: expected a name with #### where the number goes"),
        ("orbit", 0, "#.avi", "ends in one of .png"),
        ("orbit", 0, "none/#.png", "does not exist"),
    ],
)
def test_refuses(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, source, frame, pattern: str, said: str
) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(clrt.RequestError, match=re.escape(said)):
        clrt.render_frame(source, frame, pattern, **SMALL)
    assert not list(tmp_path.iterdir())


def test_a_scene_has_one_hash_in_every_process() -> None:
    center = np.arange(300.0).reshape(-1, 3)
    material = {"a": clrt.Material((0, 0, 0), (1, 1, 1), (0, 0, 0), 1)}
    many = replace(ORBIT, materials=material, spheres=clrt.Spheres(center, 0.5, "a", center))
    other = replace(many, spheres=clrt.Spheres(center, 0.5, "a", center + 1))
    smooth = replace(ORBIT, samples=16)
    assert len({cluster.fingerprint(scene) for scene in (ORBIT, smooth, many, other)}) == 4
    code = (
        "import clrt; from clrt.motion.cluster import fingerprint\n"
        "print(fingerprint(clrt.load_scene('orbit')))"
    )
    for seed in ("1", "2"):
        done = subprocess.run(
            [sys.executable, "-c", code],
            env={**os.environ, "PYTHONHASHSEED": seed},
            capture_output=True,
            text=True,
        )
        assert done.stdout.strip() == cluster.fingerprint(ORBIT)


def test_a_kernel_cache_can_be_carried(tmp_path: Path) -> None:
    """Warmed by a small picture, copied elsewhere, it has all that the frames need."""
    warm, carried = tmp_path / "warm", tmp_path / "carried"
    animate("#.png", "--frames", "0", cwd=tmp_path, XDG_CACHE_HOME=str(warm))
    shutil.copytree(warm, carried)
    programs = sorted((carried / "clrt").iterdir())
    assert len(programs) == 1
    os.utime(programs[0], (7, 7))
    animate("##.npy", "--frames", "5-6", cwd=tmp_path, XDG_CACHE_HOME=str(carried))
    animate("##.png", "--frames", "5-6", cwd=tmp_path, XDG_CACHE_HOME=str(carried))
    found = sorted((carried / "clrt").iterdir())
    assert len(found) == 2  # floats are another program
    assert programs[0].stat().st_mtime > 7  # used


def named_blocks(page: str) -> list[tuple[str, str, str]]:
    """Of each block of code: its file's name, if the line before ends in one, kind and text."""
    block = r"(?:`(\S+)`:\n\n)?^```(sh|python)\n(.*?)^```"
    return re.findall(block, page, re.DOTALL | re.MULTILINE)


@pytest.mark.slow
def test_what_the_page_says_runs(tmp_path: Path) -> None:
    """Its programs are written to files, and what has no name is typed, one after the other."""
    for name, kind, text in named_blocks((ROOT / "docs" / "cluster.md").read_text()):
        if name:
            (tmp_path / name).write_text(text)
            continue
        assert kind == "sh"
        done = subprocess.run(
            ["bash", "-euc", text], cwd=tmp_path, env=ENVIRONMENT, capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
    frames = content(tmp_path / "frames")
    assert len(frames) == 120
    assert content(tmp_path / "shared") == content(tmp_path / "dask") == frames
    assert (tmp_path / "orbit.mp4").exists()
    huge = np.asarray(Image.open(tmp_path / "huge.png"))
    assert (huge == clrt.render("four-spheres", 3840, 2160, dtype="uint8")).all()


@pytest.mark.slow
def test_a_killed_worker_loses_nothing(folders: tuple[Path, Path], tmp_path: Path) -> None:
    """200 frames by Dask on two processes, of which one is killed as it renders."""
    distributed: Any = pytest.importorskip("distributed")
    one, other = folders
    text = (ROOT / "scenes" / "orbit.toml").read_text()
    assert "frames = 120" in text
    scene = tmp_path / "longer.toml"
    scene.write_text(text.replace("frames = 120", "frames = 200"))
    animate("###.png", str(scene), cwd=one)
    cluster = distributed.LocalCluster(n_workers=2, threads_per_worker=1, dashboard_address=None)
    with cluster, distributed.Client(cluster) as client:
        before = set(client.run(os.getpid).values())
        count, pattern = 200, str(other / "###.png")
        futures = client.map(
            clrt.render_frame, [str(scene)] * count, range(count), [pattern] * count, **SMALL
        )
        while len(list(other.glob("*.png"))) < 20:
            time.sleep(0.001)
        os.kill(min(before), signal.SIGKILL)
        assert client.gather(futures) == [other / f"{k:03d}.png" for k in range(count)]
        assert min(before) not in client.run(os.getpid).values()
    assert len(content(other)) == count
    assert content(other) == content(one)
