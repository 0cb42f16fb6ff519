"""Each format read back: frames, size, speed; and nothing half written."""

from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image

import clrt
from clrt.cli import main
from clrt.data import folder
from clrt.errors import RequestError
from clrt.files import video

SMALL = ["--width", "48", "--height", "27"]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)

    def run(*words: str) -> Result:
        return CliRunner().invoke(main, ["animate", *words], catch_exceptions=False)

    return run


def still(frame: int, width: int = 48, height: int = 27) -> np.ndarray:
    scene = clrt.load_scene("orbit")
    return next(iter(clrt.animate(scene, width, height, frames=[frame], dtype=np.uint8)))


@pytest.mark.parametrize("size", [(48, 26), (47, 27)], ids=["even", "odd"])
def test_mp4(run, tmp_path: Path, size: tuple[int, int]) -> None:
    width, height = size
    result = run("--width", str(width), "--height", str(height), "--frames", "0-19", "--crf", "1")
    assert result.exit_code == 0, result.output
    with av.open("orbit.mp4") as file:
        stream = file.streams.video[0]
        assert stream.average_rate == 30
        assert stream.pix_fmt == "yuv420p"
        frames = [frame.to_ndarray(format="rgb24") for frame in file.decode(video=0)]
    assert len(frames) == 20
    assert frames[0].shape == (height + height % 2, width + width % 2, 3)
    # Half the colour's resolution: compare brightness.
    off = abs(frames[0][:height, :width].mean(axis=2) - still(0, *size).mean(axis=2))
    assert off.mean() < 4
    assert [p.name for p in tmp_path.iterdir()] == ["orbit.mp4"]


@pytest.mark.parametrize("suffix", [".webp", ".apng"])
def test_alpha(run, tmp_path: Path, suffix: str) -> None:
    clear = (folder("scenes") / "orbit.toml").read_text()
    (tmp_path / "clear.toml").write_text(f"{clear}[film]\ntransparent = true\n")
    assert run("clear.toml", "-o", f"a{suffix}", "--frames", "0-1", *SMALL).exit_code == 0
    with Image.open(f"a{suffix}") as file:
        first = np.asarray(file.convert("RGBA"))
    scene = clrt.load_scene("clear.toml")
    expected = next(clrt.animate(scene, 48, 27, frames=[0], dtype="uint8"))
    assert (first[..., 3] == expected[..., 3]).all()
    assert set(np.unique(first[..., 3])) == {0, 255}
    assert run("clear.toml", "-o", "##.png", "--frames", "0-1", *SMALL).exit_code == 0
    with Image.open("00.png") as file:
        assert (np.asarray(file) == expected).all()
        assert "Comment" not in file.info  # whoever makes it makes the same bytes
    with pytest.raises(
        RequestError, match=r"a.gif: .gif has no alpha: use .webp .apng or numbered"
    ):
        video.check_output(tmp_path / "a.gif", 48, 27, 2, 30, alpha=True)


@pytest.mark.parametrize("suffix", [".webp", ".gif", ".apng"])
def test_moving_pictures(run, suffix: str) -> None:
    assert run("-o", f"a{suffix}", "--frames", "0-19", "--step", "2", *SMALL).exit_code == 0
    with Image.open(f"a{suffix}") as file:
        assert file.n_frames == 10  # type: ignore[attr-defined]
        assert file.size == (48, 27)
        first = np.asarray(file.convert("RGB"), int)
        file.seek(1)
        file.load()
        assert file.info["duration"] == pytest.approx(2000 / 30, abs=7)  # GIF: hundredths
    assert abs(first - still(0)).mean() < 6
    if suffix == ".apng":
        assert (first == still(0)).all()


def test_numbered_pictures_split_and_resumed(run, tmp_path: Path) -> None:
    (tmp_path / "whole").mkdir()
    (tmp_path / "parts").mkdir()
    assert run("-o", "whole/####.png", "--frames", "0-11", *SMALL).exit_code == 0
    assert run("-o", "parts/####.png", "--frames", "0-5", *SMALL).exit_code == 0
    kept = (tmp_path / "parts/0003.png").stat().st_mtime_ns
    cut = tmp_path / "parts/0001.png"
    cut.write_bytes(cut.read_bytes()[:-9])
    other_size = ("--width", "20", "--height", "20")
    assert run("-o", "parts/####.png", "--frames", "5-5", *other_size).exit_code == 0
    result = run("-o", "parts/####.png", "--frames", "0-11", "--resume", *SMALL)
    assert "8 frames" in result.stderr
    assert result.stderr.strip().endswith("4 were there")
    assert (tmp_path / "parts/0003.png").stat().st_mtime_ns == kept
    for k in range(12):
        name = f"{k:04d}.png"
        assert (tmp_path / "whole" / name).read_bytes() == (tmp_path / "parts" / name).read_bytes()


def test_an_interrupt_leaves_no_video_and_whole_pictures(
    run, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from clrt import animation

    def interrupted(*words: Any, **options: Any):
        yield from list(real(*words, **options))[:3]
        raise KeyboardInterrupt

    real = animation.animate
    monkeypatch.setattr(animation, "animate", interrupted)
    for output in ("a.mp4", "a.webp"):
        assert run("-o", output, "--frames", "0-9", *SMALL).exit_code != 0
        assert not list(tmp_path.iterdir())
    assert run("-o", "##.png", "--frames", "0-9", *SMALL).exit_code != 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["00.png", "01.png", "02.png"]
    monkeypatch.setattr(animation, "animate", real)
    assert run("-o", "##.png", "--frames", "0-9", "--resume", *SMALL).exit_code == 0
    assert len(list(tmp_path.iterdir())) == 10


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["-o", "a.avi"], "ends in .mp4"),
        (["-o", "no/a.mp4"], "does not exist"),
        (["-o", "##.avi"], "ends in one of .png"),
        (["-o", "#-#.png"], "all # in one place"),
        (["--frames", "5-"], "--frames"),
        (["--frames", "9-3"], "--frames: expected frames from 0 to 119"),
        (["--fps", "inf"], "--fps"),
        (["--fps", "nan"], "--fps"),
        (["--frames", "100-130"], "--frames: expected frames from 0 to 119"),
        (["-o", "a.gif", "--fps", "60"], "a.gif: .gif has from 1/655 to 50 frames a second"),
        (["--resume"], "--resume: expected an output with ####"),
        (["--width", "20000"], "orbit.mp4: .mp4 has no more than 16384 pixels each way"),
        (["-o", "a.webp", "--width", "16384"], "a.webp: .webp has no more than 16383 pixels"),
        (["four-spheres"], "animation: expected a table, got none"),
    ],
)
def test_wrong_requests_end_with_2(run, tmp_path: Path, words: list[str], said: str) -> None:
    result = run(*SMALL, *words)
    assert result.exit_code == 2
    assert said in result.stderr
    assert not list(tmp_path.iterdir())


def test_without_pyav_one_line_says_how_to_get_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "av", None)
    with pytest.raises(RequestError, match=r"pip install av"):
        video.check_output(Path("a.mp4"), 8, 8, 1, 30)


def test_a_gif_plays_as_fast_as_it_says(tmp_path: Path) -> None:
    """It counts in hundredths of a second."""
    shades = np.arange(48, dtype=np.uint8)
    video.save(tmp_path / "a.gif", (np.full((8, 8, 3), 5 * k, np.uint8) for k in shades), 24, 18)
    with Image.open(tmp_path / "a.gif") as gif:
        durations = []
        for k in range(gif.n_frames):  # type: ignore[attr-defined]
            gif.seek(k)
            durations.append(gif.info["duration"])
    assert sum(durations) == 2000
    assert set(durations) == {40, 50}
