"""Each format read back: frames, size, speed; and nothing half written."""

from pathlib import Path
from typing import Any

import av
import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image

import clrt
from clrt.commands.cli import main
from clrt.errors import RequestError
from clrt.files import image, video
from clrt.storage import folder

SMALL = ["--width", "48", "--height", "27"]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)

    def run(*words: str, command: str = "animate") -> Result:
        return CliRunner().invoke(main, [command, *words], catch_exceptions=False)

    return run


PICTURES = [".webp", ".gif", ".apng"]


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


@pytest.mark.parametrize(
    "color", [(200, 40, 40), (40, 200, 40), (40, 40, 200), (255, 255, 255), (0, 0, 0), (9, 99, 190)]
)
def test_an_mp4s_colours_are_those_of_bt709(tmp_path: Path, color: tuple[int, int, int]) -> None:
    """Recommendation ITU-R BT.709: its matrix, limited range, and the stream says so; a player that
    is told nothing guesses by the size."""
    flat = np.full((36, 64, 3), color, np.uint8)
    video.save(tmp_path / "a.mp4", (flat for _ in range(2)), 30, 18)
    with av.open(str(tmp_path / "a.mp4")) as file:
        told = file.streams.video[0].codec_context
        matrix, range_ = 1, 1  # BT.709 and limited, as ITU-T H.273 and FFmpeg number them
        assert (told.colorspace, told.color_primaries, told.color_trc) == (matrix,) * 3
        assert told.color_range == range_
        frame = next(file.decode(video=0))
    red, green, blue = np.array(color) / 255
    luma = 0.2126 * red + 0.7152 * green + 0.0722 * blue
    expected = (
        16 + 219 * luma,
        128 + 224 * (blue - luma) / 1.8556,
        128 + 224 * (red - luma) / 1.5748,
    )
    for plane, number in zip(frame.planes, expected, strict=True):
        assert np.frombuffer(bytes(plane), np.uint8)[0] == pytest.approx(number, abs=1)


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


@pytest.mark.parametrize("suffix", [".mov", ".mkv"])
def test_other_containers(run, suffix: str) -> None:
    """They have the same stream."""
    for name in (f"a{suffix}", "a.mp4"):
        result = run("-o", name, "--frames", "0-1", *SMALL)
        assert result.exit_code == 0
        # 27 rows are odd.
        assert result.stderr.startswith(f"{name}: 2 frames of 48x28, for 48x27 is odd, in ")
    streams = []
    for name in (f"a{suffix}", "a.mp4"):
        with av.open(name) as file:
            told = file.streams.video[0].codec_context
            assert (told.colorspace, told.color_range) == (1, 1)
            streams.append([frame.to_ndarray() for frame in file.decode(video=0)])
    assert (np.array(streams[0]) == np.array(streams[1])).all()


@pytest.mark.parametrize(
    ("suffix", "fps", "lasts", "said"),
    [
        (".apng", 60, [17, 16, 17], "that last 16 or 17 ms"),
        (".webp", 60, [17, 16, 17], "quality 80, that last 16 or 17 ms"),
        (".gif", 30, [30, 40, 30], "that last 3 or 4 hundredths of a second"),
        (".gif", 25, [40, 40, 40], "3 frames of 8x8"),
        (".apng", 120, [8, 9, 8], "that last 8 or 9 ms, so short (8 ms) that browsers show"),
        (".apng", 50, [20, 20, 20], "3 frames of 8x8"),
    ],
)
def test_frames_last_as_long_as_is_said(
    tmp_path: Path, suffix: str, fps: float, lasts: list[int], said: str
) -> None:
    path = tmp_path / f"a{suffix}"
    video.save(path, (np.full((8, 8, 3), 50 * k, np.uint8) for k in range(3)), fps)
    with Image.open(path) as file:
        found = []
        for k in range(3):
            file.seek(k)
            file.load()
            found.append(file.info["duration"])
    assert found == lasts
    line = video.said(path, 8, 8, 3, fps)
    assert said in line
    assert ("that last" in line) == ("that last" in said)


def test_what_is_clear_has_the_colour_beside_it(tmp_path: Path) -> None:
    """Lossy .webp mixes colours of neighbours: black under alpha 0 would tint what is seen."""
    frame = np.zeros((64, 96, 4), np.uint8)
    row, column = np.indices(frame.shape[:2])
    frame[np.hypot(row - 31, column - 40) < 20] = (255, 120, 30, 255)
    frame[np.hypot(row - 31, column - 80) < 9] = (40, 60, 255, 255)
    seen = frame[..., 3] > 0
    for quality, most in ((80, 12), (100, 0)):
        video.save(tmp_path / "a.webp", [frame] * 2, 30, quality=quality)
        with Image.open(tmp_path / "a.webp") as file:
            found = np.asarray(file.convert("RGBA"))
        assert (found[..., 3] == frame[..., 3]).all()
        assert abs(found[seen].astype(int) - frame[seen])[:, :3].max() <= most
    filled = video._filled(frame)
    assert (filled[seen] == frame[seen]).all()
    assert filled[31, 62, :3].tolist() == [255, 120, 30]
    assert filled[31, 69, :3].tolist() == [40, 60, 255]
    assert filled[9, 40, :3].tolist() == [255, 120, 30]
    assert filled[1, 1, 0] > 100  # neither its row nor its column has one: about a mean
    clear = np.zeros((4, 4, 4), np.uint8)
    assert (video._filled(clear) == clear).all()


@pytest.mark.parametrize("suffix", PICTURES)
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
    image.save(tmp_path / "parts/0005.png", np.zeros((20, 20, 3), np.uint8))
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
    from clrt.motion import animation

    def interrupted(*words: Any, **options: Any):
        yield from list(real(*words, **options))[:3]
        raise KeyboardInterrupt

    real = animation.animate
    monkeypatch.setattr(animation, "animate", interrupted)
    for output in ("a.mp4", "a.webp"):
        assert run("-o", output, "--frames", "0-9", *SMALL).exit_code != 0
        assert not list(tmp_path.iterdir())
    assert run("-o", "##.png", "--frames", "0-9", *SMALL).exit_code != 0
    assert sorted(p.name for p in tmp_path.glob("*.png")) == ["00.png", "01.png", "02.png"]
    assert len(list(tmp_path.iterdir())) == 3 + 1  # and what says how they are made
    monkeypatch.setattr(animation, "animate", real)
    assert run("-o", "##.png", "--frames", "0-9", "--resume", *SMALL).exit_code == 0
    assert len(list(tmp_path.iterdir())) == 10 + 1


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
        (["--shard", "0/2"], "--shard: expected an output with ####"),
        (["--shard", "2/2"], "expected I/N with 0 <= I < N, as 0/50, got '2/2'"),
        (["--shard", "0/0"], "expected I/N"),
        (["--shard", "1"], "expected I/N"),
        (["--shard", "-1/2"], "expected I/N"),
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


def test_shards_are_all_frames_and_none_twice(run, tmp_path: Path) -> None:
    """Every Nth of those that --frames and --step leave, from the Ith; more shards than frames."""
    made = []
    for i in range(7):
        folder = tmp_path / str(i)
        folder.mkdir()
        words = ("--frames", "3-20", "--step", "4", "--shard", f"{i}/7", *SMALL)
        result = run("-o", f"{i}/####.png", *words)
        assert result.exit_code == 0
        made.append(sorted(p.name for p in folder.glob("*.png")))
        assert f"{len(made[-1])} frames" in result.stderr
    assert made == [["0003.png"], ["0007.png"], ["0011.png"], ["0015.png"], ["0019.png"], [], []]
    (tmp_path / "two").mkdir()
    for i in range(2):
        run("-o", "two/##.png", "--frames", "0-8", "--step", "2", "--shard", f"{i}/2", *SMALL)
        names = sorted(p.name for p in (tmp_path / "two").glob("*.png"))
        assert names == (["00.png", "04.png", "08.png"] if i == 0 else
                         ["00.png", "02.png", "04.png", "06.png", "08.png"])  # fmt: skip


@pytest.mark.parametrize("words", [(), ("--step", "3"), ("--frames", "5-19"), ("--fps", "12")])
def test_encoded_it_is_the_same_video(run, tmp_path: Path, words: tuple[str, ...]) -> None:
    words = ("--frames", "0-19", *words)
    assert run("-o", "direct.apng", *words, *SMALL).exit_code == 0
    for i in range(2):
        assert run("-o", "##.png", *words, "--shard", f"{i}/2", *SMALL).exit_code == 0
    fps = words[-2:] if "--fps" in words else ()
    result = run("##.png", "-o", "encoded.apng", *fps, command="encode")
    assert result.exit_code == 0, result.output
    direct, encoded = (Path(f"{name}.apng").read_bytes() for name in ("direct", "encoded"))
    assert encoded == direct


def test_encoded_pictures_can_be_linear_and_of_others(run, tmp_path: Path) -> None:
    """Floats are clipped; without the file beside them there are 30 a second."""
    shades = [-0.5, 0.1, 0.3, 0.5, 0.7, 0.9, 1.5]
    for k, shade in enumerate(shades):
        image.save(tmp_path / f"a{k + 7}b.npy", np.full((8, 10, 3), shade, np.float32))
    assert run("a#b.npy", "-o", "a.apng", command="encode").exit_code == 0
    expected = np.rint(255 * np.clip(np.array(shades, np.float32).astype(float), 0, 1))
    with Image.open("a.apng") as file:
        assert file.n_frames == 7  # type: ignore[attr-defined]
        # Pillow 11.0 tells whole milliseconds only.
        assert file.info["duration"] == pytest.approx(1000 / 30, abs=0.5)
        for k, byte in enumerate(expected):
            file.seek(k)
            assert (np.asarray(file.convert("RGB")) == byte).all()


@pytest.mark.parametrize("suffix", [".png", ".npy"])
def test_encoded_pictures_keep_alpha(run, tmp_path: Path, suffix: str) -> None:
    """Straight in whole numbers, premultiplied in floats."""
    straight = np.array([200, 100, 0, 51], np.uint8)
    film: np.ndarray = np.tile(straight, (8, 10, 1))
    if suffix == ".npy":
        film = (film / np.float32(255)) * np.array([0.2, 0.2, 0.2, 1], np.float32)
    for k in range(2):
        image.save(tmp_path / f"{k}{suffix}", film)
    assert run(f"#{suffix}", "-o", "a.apng", command="encode").exit_code == 0
    with Image.open("a.apng") as file:
        assert (np.asarray(file.convert("RGBA")) == straight).all()
    result = run(f"#{suffix}", "-o", "a.mp4", command="encode")
    assert result.exit_code == 2
    assert "a.mp4: .mp4 has no alpha" in result.stderr


def test_encoded_pictures_can_have_16_bits(run, tmp_path: Path) -> None:
    film = np.tile(np.array([0, 257 * 90 + 128, 65535], np.uint16), (8, 10, 1))
    for k in range(2):
        image.save(tmp_path / f"{k}.png", film)
    assert run("#.png", "-o", "a.apng", command="encode").exit_code == 0
    with Image.open("a.apng") as file:
        assert (np.asarray(file.convert("RGB")) == [0, 90, 255]).all()


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["none/#.png", "-o", "a.gif"], "none/#.png: No such file or directory"),
        (["b#.png", "-o", "a.gif"], "b#.png: no such pictures: render them first (clrt animate)"),
        (["1.png", "-o", "a.gif"], "1.png: expected a name with #### where the number goes"),
        (["#-#.png", "-o", "a.gif"], "#-#.png: expected all # in one place"),
        (["#.png", "-o", "a.gif"], "1 of 5 pictures are missing, the first is 4.png: render them"),
        (["#.png", "-o", "a.gif", "--frames", "1-3", "--fps", "0"], "--fps: expected a number"),
        (["#.png", "-o", "a.gif", "--frames", "3-1"], "--frames: expected A-B with A <= B"),
        (["#.png", "-o", "a.gif", "--frames", "1-6"], "2 of 6 pictures are missing"),
        (["#.png", "-o", "##.gif"], "##.gif: expected the name of a video, without ####"),
        (["#.png", "-o", "a.avi", "--frames", "1-3"], "ends in .mp4"),
        (["#.webp", "-o", "1.webp"], "1.webp: is read as well: expected another name"),
        (["c#.png", "-o", "a.gif"], "c2.png: expected 8x8 as the first, got 10x8"),
        (["e#.png", "-o", "a.apng"], "e2.png: expected 8x8 as the first, got 8x8 with alpha"),
        (["d#.png", "-o", "a.gif"], "d1.png: cannot be read"),
    ],
)
def test_encode_refuses(run, tmp_path: Path, words: list[str], said: str) -> None:
    for name in ("1.png", "2.png", "3.png", "5.png", "1.webp", "2.webp", "c1.png", "e1.png"):
        image.save(Path(name), np.zeros((8, 8, 3), np.uint8))
    image.save(Path("c2.png"), np.zeros((8, 10, 3), np.uint8))
    image.save(Path("e2.png"), np.zeros((8, 8, 4), np.uint8))
    Path("d1.png").touch()
    before = set(tmp_path.iterdir())
    result = run("-q", *words, command="encode")
    assert result.exit_code == 2
    assert result.stderr.startswith("clrt: ")
    assert said in result.stderr
    assert len(result.stderr.splitlines()) == 1
    assert set(tmp_path.iterdir()) == before
