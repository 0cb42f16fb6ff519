"""Words of a figure: fields of its label, labels at particles, and all of them kept in a scene."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

import clrt
from clrt.commands.cli import main
from clrt.errors import ParticleWarning, RequestError
from clrt.figure import captions, compose
from clrt.figure.compose import Look
from clrt.figure.sources import look as looking
from clrt.motion.trajectory import Flow

PARTICLES = clrt.Particles(
    np.array([[0.0, 0, 0], [3, 0, 0]]),
    radii=1.0,
    values={"heat": [7.5, 7.5], "speed": [1.0, 100.0], "none": [np.nan, np.nan]},
    texts={"name": ["Å1", ""], "chain": ["A", "A"]},
    cell=np.diag([4.0, 2, 2]),
    unit="angstrom",
    facts={"frame": 3, "time": 0.25},
)
FRAMES = "".join(
    f"2\nLattice='4 0 0 0 2 0 0 0 2' time={k / 4} step={k * 10} energy=-{k}.5\nC 0 0 {k}\nO 2 0 0\n"
    for k in range(3)
)


def film(**how: Any) -> clrt.Film:
    return compose.scene(PARTICLES, Look(size=(320, 180), **how)).film


@pytest.mark.parametrize(
    ("template", "expected"),
    [
        ("{frame:03d}, t = {time:.2f}", "003, t = 0.25"),
        ("{heat} {chain!r:>5}", "7.5   'A'"),
        ("{{}} {frame}", "{{}} 3"),  # is filled once more, by who draws it
        ("Φ = 1", "Φ = 1"),
    ],
)
def test_fields(template: str, expected: str) -> None:
    found = film(label=template).label
    assert found == expected
    assert captions.filled(found, {}) == found


@pytest.mark.parametrize(
    ("template", "said"),
    [
        ("{tim}", r"label: expected one of 'frame', 'time', .*, got 'tim'; did you mean 'time'"),
        ("{step}", "label: expected one of .* got 'step'"),
        ("{speed}", "label: expected a column of one value, 'speed' has several"),
        ("{frame:q}", "label: {frame:q} of 3: Unknown format code 'q'"),
        ("{frame", "label: expected '}' before end of string; a brace alone is written twice"),
    ],
)
def test_fields_that_are_none(template: str, said: str) -> None:
    with pytest.raises(RequestError, match=said):
        film(label=template)


def test_labels_are_where_particles_are() -> None:
    (one,) = film(labels="name").labels  # the other's is empty
    assert (one.text, one.position, one.radius) == ("Å1", (0, 0, 0), 1)
    assert [label.text for label in film(labels="speed / 8").labels] == ["0.125", "12.5"]
    assert [label.text for label in film(labels="index", select="speed > 1").labels] == ["1"]
    assert len(film(labels="name", replicate=(2, 1, 1)).labels) == 2
    with pytest.raises(RequestError, match=r"labels: expected one of .* got 'namee'; did you mean"):
        film(labels="namee")
    many = clrt.Particles(np.zeros((10_001, 3)) + np.arange(10_001)[:, np.newaxis], radii=1.0)
    with pytest.raises(RequestError, match="labels: expected at most 10,000 particles, got 10,001"):
        compose.scene(many, Look(labels="index"))


def test_sizes_on_a_page() -> None:
    """8 points are 8 / 72 inches: where 85 mm are 320 pixels, 10.6 of 180."""
    assert film(font_size="8pt/85mm").font_size == pytest.approx(8 / 72 * 25.4 / 85 * 320 / 180)
    assert film(line_width="1pt / 8.5 cm").line_width == pytest.approx(25.4 / 72 / 85 * 320 / 180)
    assert film(font_size="0.1").font_size == 0.1
    for wrong in ("8pt", "8pt/0mm", "x", "..pt/1mm"):
        with pytest.raises(RequestError, match="font_size: expected a part of the picture's"):
            film(font_size=wrong)


def test_bars_and_axes_of_particles() -> None:
    bar = film(color="log10(speed)", colorbar="log10(speed)", clim=(0.5, 2))
    assert (bar.colorbar, bar.colorbar_log, bar.colorbar_ends) == ("speed", "log10", (True, False))
    assert film(color="speed", colorbar="v").colorbar_log == ""
    assert film(color="log10(speed)+(2)", colorbar="v").colorbar_log == ""
    with pytest.warns(ParticleWarning, match="color: no value of none is finite"):
        assert film(color="none", colorbar="none").colorbar == ""
    assert film(axes="abc").axes_edges == ((4, 0, 0), (0, 2, 0), (0, 0, 2))
    assert film(scalebar=2.0).scalebar_label == "2 Å"
    assert film(scalebar="auto").scalebar_label == "Å"
    with pytest.raises(RequestError, match="scalebar: expected an orthographic projection"):
        film(scalebar=2.0, projection="perspective")
    with pytest.raises(RequestError, match="axes: expected particles in a box"):
        compose.scene(clrt.Particles([[0.0, 0, 0]], radii=1.0), Look(axes="abc"))


def test_there_is_room_for_title_and_bar() -> None:
    """What is drawn is lower where there is a title, and higher above a bar."""
    options: dict[str, Any] = {"size": (200, 160), "samples": 1, "view": "y", "color": "heat"}

    def rows(**how: Any) -> tuple[int, int]:
        picture = compose.scene(PARTICLES, Look(**options, **how))
        _, passes = clrt.Renderer().render(picture, 200, 160, passes=("id",))
        there = np.flatnonzero((passes["id"] >= 0).any(axis=1))
        return int(there[0]), int(there[-1])

    top, bottom = rows(zoom=2)
    lower, _ = rows(zoom=2, title="T")
    _, higher = rows(zoom=2, colorbar="heat", colorbar_side="bottom")
    assert lower > top + 5
    assert higher < bottom - 5


@pytest.fixture
def path(tmp_path: Path) -> Path:
    (tmp_path / "a.xyz").write_text(FRAMES)
    return tmp_path / "a.xyz"


def test_each_frame_has_its_words(path: Path) -> None:
    how = {"label": "{frame} {time} {step} {energy:.1f}", "labels": "element", "cell": True}
    flow = Flow(path, looking(size=(64, 48), **how))
    for k, scene in enumerate(flow.scenes(range(3))):
        assert scene.film.label == f"{k} {k / 4} {k * 10} -{k}.5"
        assert [label.text for label in scene.film.labels] == ["C", "O"]
        assert scene.film.labels[0].position == (0, 0, k)
    assert flow.said.film.label == how["label"]


WORDS = (
    *("--title", "Φ = 0.25", "--label", "t = {time:.2f}", "--labels", "element"),
    *("--scalebar", "1", "1 Å", "--axes", "abc", "--line-width", "0.01", "--font-size", "0.06"),
    *("--color", "log10(x + 1)", "--colorbar", "log10(x + 1)", "--colorbar-side", "bottom"),
)


def test_a_scene_file_keeps_them(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(path.parent)
    size = ("--width", "160", "--height", "120")

    def run(*words: str) -> None:
        result = CliRunner().invoke(main, ["render", *words], catch_exceptions=False)
        assert result.exit_code == 0, result.output

    run("a.xyz", "--frame", "1", *WORDS, *size, "-o", "a.ppm", "--save-scene", "a.toml")
    assert "{time" in (path.parent / "a.toml").read_text()
    run("a.toml", *size, "-o", "b.ppm")
    assert Path("a.ppm").read_bytes() == Path("b.ppm").read_bytes()
    run("a.toml", *size, "-o", "part.ppm", "--region", "20", "30", "140", "110")
    whole, part = (Path(name).read_bytes() for name in ("a.ppm", "part.ppm"))
    pixels = np.frombuffer(whole[-160 * 120 * 3 :], np.uint8).reshape(120, 160, 3)
    region = np.frombuffer(part[-120 * 80 * 3 :], np.uint8).reshape(80, 120, 3)
    assert (pixels[30:110, 20:140] == region).all()


def test_a_scene_with_an_animation_has_frames_and_times() -> None:
    scene = clrt.load_scene("orbit")
    film = clrt.Film(label="{frame} {time:.1f}")
    from msgspec.structs import replace

    from clrt.motion.animation import Way

    way = Way(replace(scene, film=film))
    assert way.scene(45).film.label == "45 1.5"
    wrong = replace(scene, film=clrt.Film(label="{speed}"))
    with pytest.raises(clrt.SceneError, match=r"film.label: expected one of 'frame', 'time', got"):
        clrt.render(wrong, 8, 8)
