"""What is looked at: scenes, animations and files of particles."""

import shlex
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from PIL import Image

import clrt
from clrt.commands.cli import main
from clrt.errors import RequestError
from clrt.figure import styles
from clrt.film import color
from clrt.motion.animation import camera_at
from clrt.particles import palette
from clrt.viewer import orbit
from clrt.viewer.session import Frame, Look, Reset, Resize, Sample, Session, Turn
from clrt.viewer.subject import Subject, of, of_figure, of_file, of_particles

SPEEDS = ((1.0, 4.0, 2.0), (8.0, 3.0, 5.0))
PLACES = ((0, 0, 0), (1.5, 0, 0), (0, 1, 1))


@pytest.fixture
def flow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Two frames of three atoms, each of its own speed."""
    monkeypatch.chdir(tmp_path)
    lines = []
    for k, speeds in enumerate(SPEEDS):
        lines += ["3", "Properties=species:S:1:pos:R:3:speed:R:1"]
        lines += [
            f"{name} {x + k / 2} {y} {z} {speed}"
            for name, (x, y, z), speed in zip("OCH", PLACES, speeds, strict=True)
        ]
    path = Path("a flow.extxyz")
    path.write_text("\n".join(lines) + "\n")
    return path


def test_a_scene_has_one_frame() -> None:
    scene = clrt.load_scene("four-spheres")
    assert of("four-spheres").at(0) == scene
    assert of(scene).words == ()
    assert of("four-spheres", ["--lanes", "1"]).words == ("four-spheres", "--lanes", "1")


def test_an_animation_moves_the_camera() -> None:
    subject, scene = of("orbit"), clrt.load_scene("orbit")
    assert (subject.frames, subject.fps) == (120, 30)
    assert subject.at(30).camera == camera_at(scene, 30)
    assert subject.at(30).spheres is subject.at(0).spheres  # the renderer knows them by that


def test_a_trajectory(flow: Path) -> None:
    subject = of_file(flow, {"color": "speed", "style": "soft", "cell": False, "view": None})
    assert subject.frames == 2
    options = ["--color", "speed", "--style", "soft", "--clim", "1.0", "8.0"]
    assert list(subject.words) == [str(flow), *options]
    first, second = subject.at(0), subject.at(1)
    assert (first.camera, first.lights) == (second.camera, second.lights)
    assert np.array_equal(second.spheres[1].center, (2, 0, 0))
    # Yellow, the colour of the largest of both frames.
    assert second.spheres[0].color == tuple(color.linear(palette.colormap("viridis")[-1]).tolist())
    found = subject.described(second, 1, 0)
    assert found is not None
    assert (found["index"], found["speed"]) == (0, 8.0)
    assert subject.at(0) is first  # it is not read again for each picture


def test_lights_go_with_the_camera_of_a_figure(flow: Path) -> None:
    subject = of_file(flow, {"style": "soft"})
    before = subject.at(0)
    behind = orbit.turned(before.camera, 180, 0)
    after = subject.seen_by(before, behind)
    way = np.array([light.direction for light in (before.lights[0], after.lights[0])])  # type: ignore
    # In the cameras' own axes it is the same.
    axes = [np.array(camera.basis()) for camera in (before.camera, behind)]
    for axis, direction in zip(axes, way, strict=True):
        assert axis @ direction == pytest.approx(styles.KEY)
    assert after.lights[1] == before.lights[1]


def says(subject: Subject, *messages: Any) -> Session:
    found = Session(subject)
    for message in messages:
        found.change(message)
    return found


def test_the_command_of_a_trajectory(flow: Path) -> None:
    """The camera stays from frame to frame, and the command makes the picture."""
    subject = of_file(flow, {"color": "speed", "style": "outline"})
    session = says(subject, Resize(60, 40), Turn(25, 10), Frame(1))
    assert session.scene.camera == says(subject, Resize(60, 40), Turn(25, 10)).scene.camera
    shot = session.shot
    assert shot is not None
    words = shlex.split(shot.command)[1:]
    assert CliRunner().invoke(main, [*words, "-o", "a.png"]).exit_code == 0
    expected = clrt.render(shot.scene, 60, 40, dtype="uint8")
    assert len(np.unique(expected.reshape(-1, 3), axis=0)) > 10
    assert (np.asarray(Image.open("a.png")) == expected).all()


def test_another_style(flow: Path) -> None:
    """Camera, frame and samples stay, and Reset leaves it."""
    subject = of_file(flow, {"color": "speed"})
    session = says(subject, Resize(60, 40), Turn(25, 10), Frame(1), Sample(4))
    before = session.scene
    session.change(Look("style", "soft"))
    assert (session.scene.camera, session.scene.samples) == (before.camera, 4)
    assert session.scene.spheres[1].center == before.spheres[1].center
    assert session.state["look"]["style"] == "soft"
    assert len(session.scene.materials) == 1
    assert session.scene.lights[1].occlusion  # type: ignore[union-attr]
    assert session.shot is not None
    assert "--style soft" in session.shot.command
    session.change(Reset())
    assert session.scene.lights[1].occlusion  # type: ignore[union-attr]
    with pytest.raises(RequestError, match="style: expected one of soft"):
        session.change(Look("style", "oil"))
    assert session.state["look"]["style"] == "soft"


def test_particles_without_a_file() -> None:
    particles = clrt.Particles(PLACES, radii=1, values={"speed": SPEEDS[0]})
    subject = of_particles(particles)
    assert subject.words == ()
    found = subject.described(subject.at(0), 0, 1)
    assert found is not None
    assert found["speed"] == 4.0
    assert subject.drawn is not None
    assert subject.drawn("style", "outline").at(0).film.outline == styles.STYLES["outline"].outline


def test_bonds(flow: Path) -> None:
    """They are words of the command, and can be picked; a style may have them."""
    subject = of_file(flow, {"bonds": 1.6, "bond_color": "red", "cell": False})
    assert subject.words[1:5] == ("--bonds", "1.6", "--bond-color", "red")
    scene = subject.at(1)
    assert len(scene.capsules) == 2
    found = subject.described(scene, 1, 3)
    assert found == {
        "index": 3, "start": (0.5, 0, 0), "end": (2, 0, 0), "radius": 0.15, "material": "soft"
    }  # fmt: skip
    assert subject.drawn is not None
    bare = of_file(flow, {"style": "soft"})
    assert bare.drawn is not None
    assert (
        len(bare.at(0).capsules),
        len(bare.drawn("style", "ball-and-stick").at(0).capsules),
    ) == (0, 2)


def test_lights_go_with_the_camera_of_a_plot(flow: Path) -> None:
    scene = clrt.plot(flow, size=(40, 30), samples=1).scene
    subject = of_figure(scene, (40, 30))
    after = subject.seen_by(scene, orbit.turned(scene.camera, 90, 0))
    assert after.lights[0] != scene.lights[0]


def test_a_scene_has_no_style() -> None:
    session = says(of("four-spheres"), Look("style", "soft"))
    assert session.about["styles"] == []
    assert session.scene == clrt.load_scene("four-spheres")


def test_what_cannot_be_drawn(flow: Path) -> None:
    with pytest.raises(RequestError, match=r"a flow.extxyz: .*velocity"):
        of_file(flow, {"color": "velocity"}).at(0)
    with pytest.raises(clrt.SceneError, match="no such file"):
        of_file(Path("nothing.xyz"), {})
