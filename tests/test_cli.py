"""The command line, inside this process and as a real one."""

import math
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result
from msgspec.structs import replace
from PIL import Image

import clrt
from clrt.commands.cli import main
from clrt.commands.terminal import Progress
from clrt.files import image
from clrt.storage import folder

SMALL = ["--width", "40", "--height", "23"]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> Result:
        return CliRunner().invoke(main, words, catch_exceptions=False)

    return run


def clrt_process(*words: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "clrt", *words],
        cwd=cwd,
        capture_output=True,
        text=True,
        timeout=120,
    )


def test_render_defaults_to_the_papers_scene(run, tmp_path: Path) -> None:
    result = run("render", *SMALL)
    assert result.exit_code == 0
    assert result.stdout == ""
    assert "four-spheres.png: 40x23, rendered in" in result.stderr.splitlines()[-1]
    assert Image.open("four-spheres.png").size == (40, 23)
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("lanes", ["1", "16"])
def test_render_npy_is_the_renderers_film(run, lanes: str) -> None:
    assert run("render", "-o", "a.npy", "--lanes", lanes, "-q", *SMALL).exit_code == 0
    expected = clrt.render(clrt.load_scene("four-spheres"), 40, 23, lanes=int(lanes))
    assert (np.load("a.npy") == expected).all()


def test_options_reach_the_scene(run) -> None:
    run("render", "-o", "deep.npy", *SMALL)
    run("render", "-o", "flat.npy", "--max-depth", "1", *SMALL)
    run("render", "-o", "exact.npy", "--shadow-bias", "0", "--precision", "double", *SMALL)
    deep, flat, exact = map(np.load, ("deep.npy", "flat.npy", "exact.npy"))
    truth = clrt.reference.render(clrt.load_scene("four-spheres"), 40, 23, truth="exact")
    assert (deep != flat).any()
    assert abs(exact - truth).max() < 1e-7


@pytest.mark.parametrize("command", ["render", "animate"])
def test_samples_reach_the_scene(run, monkeypatch: pytest.MonkeyPatch, command: str) -> None:
    seen: list[int] = []

    def prepare(self: clrt.Renderer, scene: clrt.Scene, *more: Any, **options: Any) -> None:
        seen.append(scene.samples)

    monkeypatch.setattr(clrt.Renderer, "prepare", prepare)
    words = (command, "orbit", "-o", "####.png", *SMALL)
    frames = ("--frames", "0") if command == "animate" else ()
    for samples in ((), ("--samples", "4")):
        assert run(*words, *frames, *samples).exit_code == 0
    assert seen == [1, 4]


def test_a_region(run) -> None:
    run("render", "-o", "whole.png", *SMALL)
    result = run("render", "-o", "part.png", "--region", "5", "3", "40", "20", *SMALL)
    assert "part.png: 35x17, rendered in" in result.stderr
    whole, part = map(Image.open, ("whole.png", "part.png"))
    assert (np.asarray(part) == np.asarray(whole)[3:20, 5:40]).all()


def test_looks(run) -> None:
    """Options of the film, against the renderer's pictures of such scenes."""
    scene = clrt.load_scene("four-spheres")

    def expected(dtype: str, **film: Any) -> np.ndarray:
        return clrt.render(replace(scene, film=clrt.Film(**film)), 40, 23, dtype=dtype)

    run("render", "-o", "a.png", "--transparent", "--transfer", "srgb", *SMALL)
    picture = Image.open("a.png")
    assert (picture.mode, picture.info["srgb"]) == ("RGBA", 0)
    assert (np.asarray(picture) == expected("uint8", transparent=True, transfer="srgb")).all()
    said = "clrt render --transparent --transfer srgb --width 40 --height 23"
    assert picture.info["Comment"] == said
    run("render", "-o", "b.png", "--background", "#808000", *SMALL)
    half = 0.21586050
    assert (np.asarray(Image.open("b.png")) == expected("uint8", background=(half, half, 0))).all()
    assert "srgb" not in Image.open("b.png").info
    run("render", "-o", "c.tif", "--bits", "16", *SMALL)
    assert (np.rint(65535.0 * image.load(Path("c.tif"))) == expected("uint16")).all()


def test_a_camera(run) -> None:
    run("render", "-o", "a.npy", "--camera", "position = [0, 1, 2], look_at = [0, 0, 0]", *SMALL)
    scene = replace(clrt.load_scene("four-spheres"), camera=clrt.Camera((0, 1, 2), (0, 0, 0)))
    assert (np.load("a.npy") == clrt.render(scene, 40, 23)).all()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("position = [0, 1, 2]", "camera.look_at: expected a value, got none"),
        ("position = [0, 1, 2], look_at = [0, 0, 0], fov = 180", "camera.fov: expected degrees"),
        ("position = [0, 1, 2], look_at = [0, 0, 0], f = 1", "camera.f: unknown key"),
        ("fov", "not TOML"),
    ],
)
def test_a_camera_that_is_none(run, text: str, said: str) -> None:
    result = run("render", "--camera", text, *SMALL)
    assert result.exit_code == 2
    assert said in " ".join(result.stderr.split())
    assert not list(Path().iterdir())


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["nothing"], "clrt: nothing: no such file"),
        (["four-spheres", "--style", "soft"], "clrt: --style: expected a file of particles"),
        (["four-spheres", "--port", "70000"], "'--port'"),
        (["four-spheres", "--samples", "70000"], "clrt: samples: expected a whole number"),
    ],
)
def test_what_cannot_be_viewed(run, words: list[str], said: str) -> None:
    result = run("view", *words)
    assert (result.exit_code, result.stdout) == (2, "")
    assert said in result.stderr


def test_passes(run) -> None:
    names = ("depth", "normal", "id")
    film, passes = clrt.Renderer().render("four-spheres", 40, 23, passes=names)
    run("render", "-o", "a.npz", "--passes", "depth,normal,id", *SMALL)
    with np.load("a.npz") as found:
        assert list(found) == ["image", *names]
        assert (found["image"] == film).all()
        for name in names:
            assert (found[name] == passes[name]).all()
    run("render", "-o", "part.npz", "--passes", "id", "--region", "5", "3", "40", "20", *SMALL)
    with np.load("part.npz") as found:
        assert list(found) == ["image", "id"]
        assert (found["id"] == passes["id"][3:20, 5:40]).all()
    run("render", "-o", "a.exr", "--passes", "id", "--transparent", *SMALL)
    assert image.load(Path("a.exr")).shape == (23, 40, 4)


def test_where_to_is_not_in_the_file(run, tmp_path: Path) -> None:
    for words in (["-o", "a.png"], ["--output", "b.png"], ["-oc.png"], ["--output=d.png"]):
        assert run("render", *words, *SMALL).exit_code == 0
    files = [path.read_bytes() for path in tmp_path.iterdir()]
    assert files == files[:1] * 4
    assert Image.open("a.png").info["Comment"] == "clrt render --width 40 --height 23"


def test_the_pictures_of_the_docs_are_made_as_they_say(run, tmp_path: Path) -> None:
    docs = Path(__file__).parents[1] / "docs"
    commands = re.findall(r"`clrt (render -o docs/(\S+\.png) .*?)`", (docs / "film.md").read_text())
    assert len(commands) == 2
    (tmp_path / "docs").mkdir()
    for words, name in commands:
        assert run(*words.split()).exit_code == 0
        made, shown = (np.asarray(Image.open(at / name), int) for at in (tmp_path / "docs", docs))
        assert (abs(made - shown).max(axis=2) > 1).sum() <= 2  # another CPU rounds otherwise


def test_quiet_says_nothing(run) -> None:
    result = run("render", "-q", *SMALL)
    assert result.stdout == result.stderr == ""


def test_verbose_says_where_and_how_long(run) -> None:
    assert "kernel alone" in run("render", "-v", *SMALL).stderr


def test_the_peak_memory_is_the_commands_own(tmp_path: Path) -> None:
    held = np.ones(2**29, np.uint8)  # as a test before may have had
    done = clrt_process("render", "-v", *SMALL, cwd=tmp_path)
    assert len(held) == 2**29
    (peak,) = re.findall(r"peak memory (\d+) MB", done.stderr)
    assert int(peak) < 400


@pytest.mark.slow
def test_a_large_picture_takes_three_bytes_a_pixel(tmp_path: Path) -> None:
    """Those of the film: none of floats, and few of the PNG."""
    done = clrt_process("render", "-v", "--width", "16384", "--height", "16384", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    peak = re.search(r"peak memory (\d+) MB", done.stderr)
    assert peak is not None
    assert int(peak[1]) * 2**20 < 3 * 16384**2 + 150e6
    (tmp_path / "four-spheres.png").unlink()


def test_devices(run) -> None:
    assert run("devices").stdout.splitlines()
    said = run("devices", "-v").stdout
    for what in ("platform", "threads", "lanes", "cache", "versions    clrt", "machine"):
        assert what in said


def test_check(run) -> None:
    assert "4 spheres, 4 materials, 1 light," in run("check", "four-spheres").stdout


def test_compare(run) -> None:
    run("render", "-o", "a.png", *SMALL)
    run("render", "-o", "b.png", "--max-depth", "1", *SMALL)
    result = run("compare", "a.png", "b.png", "--heatmap", "where.png")
    assert result.exit_code == 0
    assert "pixels   920" in result.stdout
    assert Image.open("where.png").size == (40, 23)
    assert "PSNR     inf dB" in run("compare", "a.png", "a.png").stdout


def test_compare_alpha_and_curves(run) -> None:
    film = np.zeros((4, 5, 4), np.uint8)
    film[..., 0], film[..., 3] = 200, np.arange(5) * 60
    hidden = film.copy()
    hidden[:, 0, :3] = 99  # where alpha is 0
    clrt.save("a.png", film)
    clrt.save("b.png", hidden)
    assert "max      0.000e+00" in run("compare", "a.png", "b.png").stdout
    clrt.save("rgb.png", film[..., :3])
    result = run("compare", "a.png", "rgb.png")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr == "clrt: one of the pictures has alpha, the other has not\n"
    clrt.save("srgb.png", film, transfer="srgb")
    for pair in (("srgb.png", "a.png"), ("a.png", "srgb.png")):
        said = run("compare", *pair).stderr
        assert said == "clrt: srgb.png is sRGB and a.png is not: compared as they are\n"
    clrt.save("deep.png", film.astype(np.uint16) * 257)
    result = run("compare", "a.png", "deep.png", "--heatmap", "map.png")
    assert "max      0.000e+00" in result.stdout


def test_what_is_read_is_not_overwritten(run, tmp_path: Path) -> None:
    run("render", "-o", "a.png", *SMALL)
    run("render", "-o", "b.png", *SMALL)
    before = (tmp_path / "b.png").read_bytes()
    for heatmap in ("a.png", "./b.png"):
        result = run("compare", "a.png", "b.png", "--heatmap", heatmap)
        assert result.exit_code == 2
        assert "is read as well: expected another name" in result.stderr
    assert (tmp_path / "b.png").read_bytes() == before


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["render", "-o", "a" * 300 + ".png"], "File name too long"),
        (["render", "--threads", "100000"], "--threads"),
        (["render", "--region", "0", "0", "9", "2161"], "region: expected X0 Y0 X1 Y1 with 0 <="),
        (["render", "-o", "a.jpg", "--width", "65501"], "a.jpg: .jpg has no more than 65500"),
        (["render", "--max-depth", "99999999999"], "max_depth: expected a whole number"),
        (["render", "--samples", "65537"], "samples: expected a whole number from 1 to 65536"),
        (["animate", "--samples", "0"], "--samples"),
        (["render", "--lanes", "3"], "--lanes"),
        (["render", "-o", "a.jpg", "--transparent"], "a.jpg: .jpg has no alpha: use one of .png"),
        (["render", "--background", "whiter"], "expected a colour's name, #rgb or #rrggbb"),
        (["render", "--transfer", "gamma"], "--transfer"),
        (["render", "--passes", "id"], "four-spheres.png: .png has no passes: use one of .npz"),
        (["render", "-o", "a.npz", "--passes", "id,uv"], "expected some of depth, normal, id, got"),
        (["render", "-o", "a.npy", "--bits", "16"], "a.npy: .npy has no 16 bits a channel: use"),
        (["render", "-o", "a.hdr"], "a.hdr: expected a name that ends in one of .png"),
        (["animate", "clear.toml"], "clear.mp4: .mp4 has no alpha: use .webp .apng or numbered"),
        (["render", "--shadow-bias", "inf"], "shadow_bias: expected"),
        (["render", "--precision", "half"], "--precision"),
        (["check", "none.toml"], "none.toml: no such file"),
        (["compare", "a.png", "b.png"], "a.png: cannot be read: No such file"),
    ],
)
def test_wrong_requests_end_with_2(run, tmp_path: Path, words: list[str], said: str) -> None:
    clear = (folder("scenes") / "orbit.toml").read_text() + "[film]\ntransparent = true\n"
    (tmp_path / "clear.toml").write_text(clear)
    result = run(*words)
    assert result.exit_code == 2
    assert said in result.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["clear.toml"]


def test_a_wrong_scene_ends_with_one_line(run, tmp_path: Path) -> None:
    (tmp_path / "wrong.toml").write_text("[camera]\nposition = [0, 0, 0]\nlook_at = [0, 0, nan]")
    result = run("render", "wrong.toml")
    assert result.exit_code == 2
    assert result.stderr == (
        "clrt: wrong.toml: camera.look_at: expected three finite numbers, got (0.0, 0.0, nan)\n"
    )


def test_what_a_scene_says_stays_on_one_line(run, tmp_path: Path) -> None:
    (tmp_path / "wrong.toml").write_text('"a\\nb\\u001b[31m" = 1')
    result = run("check", "wrong.toml")
    assert result.exit_code == 2
    assert result.stderr == "clrt: wrong.toml: a\\nb\\x1b[31m: unknown key\n"


def test_every_process_makes_the_same_bytes(tmp_path: Path) -> None:
    """In every run, with one thread and two, of a region as of the whole."""
    for name, words in {"a": (), "b": (), "c": ("--threads", "1"), "d": ("--threads", "2")}.items():
        done = clrt_process(
            "render", "sunflower", "-o", f"{name}.npy", *words, *SMALL, cwd=tmp_path
        )
        assert done.returncode == 0, done.stderr
    expected = clrt.render(clrt.load_scene("sunflower"), 40, 23)
    files = [path.read_bytes() for path in sorted(tmp_path.iterdir())]
    assert files[1:] == files[:1] * 3
    assert (np.load(tmp_path / "a.npy") == expected).all()
    region = ("--region", "11", "2", "40", "23", "--threads", "1")
    clrt_process("render", "sunflower", "-o", "e.npy", *region, *SMALL, cwd=tmp_path)
    assert (np.load(tmp_path / "e.npy") == expected[2:23, 11:40]).all()


def test_help_has_examples(run) -> None:
    for words in ([], ["render"], ["compare"]):
        assert "Examples:" in run(*words, "--help").stdout


@pytest.mark.parametrize("on_a_terminal", [True, False])
def test_bars_are_for_terminals(monkeypatch: pytest.MonkeyPatch, on_a_terminal: bool) -> None:
    monkeypatch.setattr(sys.stderr, "isatty", lambda: on_a_terminal, raising=False)
    assert (Progress(9, quiet=False).due < math.inf) == on_a_terminal
    assert Progress(9, quiet=True).due == math.inf
