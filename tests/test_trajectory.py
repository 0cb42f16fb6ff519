"""Trajectories: every frame seen as the first one, read ahead, a few in memory."""

import gc
import weakref
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner, Result

import clrt
from clrt.commands.cli import main
from clrt.figure.compose import Look
from clrt.files.particles import reader
from clrt.film import color
from clrt.motion import animation
from clrt.motion.trajectory import Flow
from clrt.particles import palette

RANDOM = np.random.default_rng(7)
N, FRAMES = 60, 5
AT = RANDOM.uniform(0, 5, (N, 3)) + np.arange(FRAMES)[:, np.newaxis, np.newaxis] * [1.0, 0.0, 0.5]
HEAT = RANDOM.normal(size=(FRAMES, N)) + np.arange(FRAMES)[:, np.newaxis]
WORDS = ["--width", "64", "--height", "48", "--samples", "4", "-q"]
LOOK = Look(color="heat", samples=4, size=(64, 48))
RENDERER = clrt.Renderer()


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    comment = "Properties=pos:R:3:radius:R:1:heat:R:1"
    text = ""
    for at, heat in zip(AT, HEAT, strict=True):
        rows = np.column_stack([at, np.full(N, 0.4), heat])
        lines = [" ".join(f"{x:.17g}" for x in row) for row in rows]
        text += "\n".join([str(N), comment, *lines]) + "\n"
    Path("a.xyz").write_text(text)
    return Path("a.xyz")


def command(*words: str) -> Result:
    return CliRunner().invoke(main, ["animate", *words], catch_exceptions=False)


def test_all_frames_are_seen_as_the_first(path: Path) -> None:
    flow = Flow(path, LOOK)
    first = clrt.plot(clrt.read(path), color="heat", samples=1, size=(64, 48)).scene
    assert flow.frames == range(FRAMES)
    limits = HEAT.min(), HEAT.max()
    for k, scene in enumerate(flow.scenes(flow.frames)):
        assert scene.camera == first.camera
        assert scene.lights == first.lights
        assert isinstance(scene.spheres, clrt.Spheres)
        assert (scene.spheres.center == AT[k]).all()
        expected = color.linear(palette.of_values(HEAT[k], clim=limits))
        assert np.array_equal(scene.spheres.color, expected)  # type: ignore[arg-type]
        assert flow.scene(k) == scene


def test_a_bar_and_a_legend_stay_and_the_box_moves(path: Path) -> None:
    text = path.read_text().splitlines()
    for k in range(FRAMES):
        sides = f"{6 + k} 0 0 0 6 0 0 0 6"
        types = ":".join(["Properties=pos:R:3", "radius:R:1", "type:I:1"])
        text[k * (N + 2) + 1] = f'Lattice="{sides}" {types}'
    for k in range(FRAMES * (N + 2)):
        if k % (N + 2) >= 2:
            text[k] = " ".join([*text[k].split()[:4], str(k % 3 if k < 2 * N else 1)])
    path.write_text("\n".join(text) + "\n")
    look = Look(colorbar="type", cell=True, size=(64, 48))
    scenes = list(Flow(path, look).scenes(range(FRAMES)))
    assert [entry.name for entry in scenes[0].film.legend] == ["0", "1", "2"]
    for k, scene in enumerate(scenes):
        assert scene.film.legend == scenes[0].film.legend
        assert [cell.edges[0] for cell in scene.film.cells] == [(6 + k, 0, 0)]


def test_a_type_keeps_its_colour_where_others_are_not_there(path: Path) -> None:
    """Names are numbered frame by frame: big is the first here, and the second beside aged."""
    frames = ("small big big", "aged big", "small small", "tiny aged")
    text = ""
    for k, names in enumerate(frames):
        rows = [f"{name} {i} {k} 0" for i, name in enumerate(names.split())]
        text += "\n".join([str(len(rows)), "", *rows]) + "\n"
    path.write_text(text)
    scenes = list(Flow(path, Look(colorbar="type", radius=1)).scenes(range(len(frames))))
    colors: dict[str, set[tuple[float, ...]]] = {}
    for names, scene in zip(frames, scenes, strict=True):
        assert [entry.name for entry in scene.film.legend] == ["big", "small", "aged", "tiny"]
        assert isinstance(scene.spheres, clrt.Spheres)
        assert scene.spheres.color is not None
        for name, own in zip(names.split(), scene.spheres.color.tolist(), strict=True):
            colors.setdefault(name, set()).add(tuple(own))
    assert [len(own) for own in colors.values()] == [1, 1, 1, 1]
    assert len(set.union(*colors.values())) == 4


def test_the_box_of_the_first_frame_is_in_view(path: Path) -> None:
    """And with it more than the particles, drawn or not."""
    text = path.read_text().replace("Properties", 'Lattice="90 0 0 0 90 0 0 0 90" Properties')
    path.write_text(text)
    camera = Flow(path, Look(view="x", margin=0, size=(50, 50))).said.camera
    assert camera.height == pytest.approx(90, abs=0.5)  # spheres may stand out


def test_all_frames_in_view(path: Path) -> None:
    camera = Flow(path, Look(view="y", margin=0, size=(500, 50)), view_all=True).said.camera
    both = AT.reshape(-1, 3)
    assert camera.height == pytest.approx(np.ptp(both[:, 2]) + 0.8)
    first = Flow(path, Look(view="y", margin=0, size=(500, 50))).said.camera
    assert first.height == pytest.approx(np.ptp(AT[0, :, 2]) + 0.8)


def test_a_frame_is_the_same_whoever_renders_it(path: Path) -> None:
    words = ["--color", "heat", "--colorbar", "heat", *WORDS]
    assert command("a.xyz", "-o", "a#.png", *words).exit_code == 0
    for part in ("0/2", "1/2"):
        assert command("a.xyz", "-o", "b#.png", "--shard", part, *words).exit_code == 0
    size: dict[str, Any] = {"width": 64, "height": 48}
    for k in (3, 1):
        clrt.render_frame("a.xyz", k, "c#.png", color="heat", colorbar="heat", samples=4, **size)
    for k in range(FRAMES):
        assert Path(f"a{k}.png").read_bytes() == Path(f"b{k}.png").read_bytes()
    for k in (1, 3):
        assert Path(f"a{k}.png").read_bytes() == Path(f"c{k}.png").read_bytes()
    heat: dict[str, Any] = {"color": "heat", "colorbar": "heat", "clim": (HEAT.min(), HEAT.max())}
    still = clrt.plot(clrt.read(path), **heat, samples=4, size=(64, 48))
    assert Path("a0.png").read_bytes() == still._repr_png_()


def test_what_is_missing_is_made_again(path: Path) -> None:
    assert command("a.xyz", "-o", "a#.png", *WORDS).exit_code == 0
    before = Path("a2.png").read_bytes()
    Path("a2.png").unlink()
    result = command("a.xyz", "-o", "a#.png", "--resume", *WORDS[:-1])
    assert "1 frames" in result.stderr
    assert "4 were there" in result.stderr
    assert Path("a2.png").read_bytes() == before
    result = command("a.xyz", "-o", "a#.png", "--resume", "--view", "z", *WORDS)
    assert result.exit_code == 2  # they show something else


def test_a_video(path: Path) -> None:
    words = ["--frames", "1-4", "--step", "2", "--transparent", *WORDS[:-1]]
    result = command("a.xyz", "-o", "a.webp", *words)
    assert result.exit_code == 0, result.stderr
    assert "2 frames of 64x48" in result.stderr


def test_few_frames_are_in_memory(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One with the caller, and one or two each that are read and rendered."""
    path.write_text(path.read_text() * 8)
    known: list[weakref.ref[Any]] = []
    read = reader.Reader.frame

    def counted(self: reader.Reader, k: int) -> clrt.Particles | None:
        found = read(self, k)
        assert found is not None
        known.append(weakref.ref(found.positions))
        return found

    monkeypatch.setattr(reader.Reader, "frame", counted)
    flow, most = Flow(path, LOOK), 0
    gc.freeze()  # what other tests have left is not looked through each time
    for _ in animation.animate(flow, 64, 48, renderer=RENDERER):
        gc.collect()
        most = max(most, sum(one() is not None for one in known))
    gc.unfreeze()
    # The first one was read for its view, ten say what colours mean, and the first is drawn so.
    assert len(known) == 8 * FRAMES + 1 + 9 + 1
    assert 2 <= most <= 5


def test_a_file_that_ends_is_told_when_it_is_read(path: Path) -> None:
    """Whole frames before it are rendered."""
    lines = path.read_text().splitlines()
    lines[-2] = "1 2 three"
    path.write_text("\n".join(lines) + "\n")
    result = command("a.xyz", "-o", "a#.png", *WORDS)
    assert result.exit_code == 1
    assert result.stderr.startswith(f"clrt: a.xyz: frame 4: line {len(lines) - 1}: ")
    assert result.stderr.endswith("; a#.png has the frames before it\n")
    assert len(result.stderr.splitlines()) == 1
    names = sorted(file.name for file in path.parent.glob("*.png"))
    assert names == [f"a{k}.png" for k in range(4)]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["orbit", "--color", "x"], "--color: expected a file of particles, orbit is a scene"),
        (["orbit", "--view-all"], "--view-all: expected a file of particles, orbit is a scene"),
        (
            ["a.xyz", "--color", "v"],
            "a.xyz: --color: expected one of 'material', 'heat', 'x', 'y',",
        ),
        (["a.xyz", "--frames", "3-5"], "--frames: expected frames from 0 to 4"),
        (["a.xyz", "-o", "a.xyz"], "a.xyz: is read as well: expected another name"),
        (["b.xyz"], "b.xyz: no such file"),
    ],
    ids=str,
)
def test_a_wrong_word_is_one_line(path: Path, words: list[str], message: str) -> None:
    output = [] if "-o" in words else ["-o", "a.webp"]
    result = command(*words, *output, *WORDS)
    assert result.exit_code == 2
    assert result.stderr.startswith(f"clrt: {message}")
    assert len(result.stderr.splitlines()) == 1


def test_render_frame_says_what_is_wrong(path: Path) -> None:
    with pytest.raises(clrt.RequestError, match="style: expected a trajectory of particles, orb"):
        clrt.render_frame("orbit", 0, "a#.png", style="soft")
    with pytest.raises(
        clrt.RequestError, match="frames: expected whole numbers from 0 to 4, got 5"
    ):
        clrt.render_frame(path, 5, "a#.png")
