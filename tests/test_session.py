"""What a page says, and what it sees then."""

import json
import math
import shlex
import tomllib
from typing import Any

import msgspec
import numpy as np
import pytest
from msgspec.structs import replace

import clrt
from clrt.files.scenefile import parse_camera
from clrt.motion.animation import camera_at
from clrt.scene import lens
from clrt.viewer import orbit
from clrt.viewer.session import FOV, MESSAGES, Change, Pick, Session, Shown
from clrt.viewer.subject import Subject, of, of_figure, of_particles

FOUR = of("four-spheres")
START = clrt.load_scene("four-spheres").camera


def said(**message: Any) -> Change:
    found = MESSAGES.decode(json.dumps(message))
    assert not isinstance(found, Pick | Shown)
    return found


def session(*messages: dict, subject: Subject = FOUR, samples: int | None = None) -> Session:
    found = Session(subject, samples)
    for message in ({"do": "resize", "width": 80, "height": 45}, *messages):
        found.change(said(**message))
    return found


def camera(*messages: dict) -> clrt.Camera:
    return session(*messages).scene.camera


def test_nothing_is_due_before_the_size_is_known() -> None:
    assert Session(FOUR).shot is None
    shot = session().shot
    assert shot is not None
    assert (shot.size, shot.scene) == ((80, 45), clrt.load_scene("four-spheres"))


def test_a_scale_bar_is_there_as_long_as_the_camera_has_one() -> None:
    flat = replace(START, projection="orthographic", fov=None, height=2.0)
    film = clrt.Film(scalebar=0.5)
    subject = of(replace(clrt.load_scene("four-spheres"), camera=flat, film=film))
    there, back = ({"do": "project", "projection": p} for p in ("perspective", "orthographic"))
    assert session(there, subject=subject).scene.camera.projection == "perspective"
    assert session(there, subject=subject).scene.film.scalebar is None
    assert session(there, back, subject=subject).scene.film == film


def test_a_drag_to_the_right_shows_the_left_side() -> None:
    """Half the height is a quarter turn."""
    x, y, z = camera({"do": "turn", "x": 22.5, "y": 0}).position
    assert (x, y, z) == pytest.approx((-1, 0, 0), abs=1e-12)
    x, y, z = camera({"do": "turn", "x": 0, "y": 45 / 6}).position
    assert (x, y, z) == pytest.approx((0, 0.5, math.sqrt(0.75)), abs=1e-12)


def test_moves_are_those_of_the_camera() -> None:
    size = 80, 45
    assert camera({"do": "pan", "x": 3, "y": -4.5}) == orbit.panned(START, 3, -4.5, size)
    zoom = {"do": "zoom", "factor": 2, "x": 70, "y": 1}
    assert camera(zoom) == orbit.zoomed(START, 2, (70, 1), size)
    straight = camera({"do": "project", "projection": "orthographic"})
    assert straight == orbit.orthographic(START, size)
    both = [{"do": "project", "projection": p} for p in ("orthographic", "perspective")]
    assert camera(*both).fov == START.fov == 90
    assert camera(zoom, {"do": "reset"}) == START


def test_a_scene_that_is_orthographic_gets_a_field_of_view() -> None:
    scene = replace(clrt.load_scene("four-spheres"), camera=orbit.orthographic(START, (80, 45)))
    subject = Subject(("x",), lambda frame: scene)
    message = {"do": "project", "projection": "perspective"}
    assert session(message, subject=subject).scene.camera.fov == FOV


def test_a_camera_that_cannot_be_leaves_that_which_is() -> None:
    closer = [{"do": "zoom", "factor": 100, "x": 70, "y": 1}] * 200
    found = camera(*closer)
    assert math.dist(found.position, found.look_at) > 0
    assert camera(*closer, {"do": "reset"}) == START
    farther = [{"do": "zoom", "factor": 0.01, "x": 70, "y": 1}] * 200
    assert all(map(math.isfinite, camera(*farther).position))


def test_samples() -> None:
    assert session(samples=9).scene.samples == 9
    assert session({"do": "sample", "samples": 64}).scene.samples == 64
    reset = session({"do": "sample", "samples": 64}, {"do": "reset"}, samples=9)
    assert reset.scene.samples == 9


def test_frames() -> None:
    subject = of("orbit")
    assert (subject.frames, subject.fps) == (120, 30)
    found = session({"do": "sample", "samples": 4}, {"do": "frame", "frame": 30}, subject=subject)
    expected = camera_at(clrt.load_scene("orbit"), 30)
    assert found.scene.camera == expected
    assert (found.scene.samples, found.state["frame"]) == (4, 30)
    found.change(said(do="frame", frame=1000))
    assert found.state["frame"] == 119
    # Its keys have a fov, which an orthographic camera has not.
    found.change(said(do="project", projection="orthographic"))
    assert found.scene.camera.orthographic


@pytest.mark.parametrize(
    "messages",
    [
        [],
        [{"do": "turn", "x": 1.7, "y": 3.1}, {"do": "sample", "samples": 4}],
        [{"do": "project", "projection": "orthographic"}, {"do": "pan", "x": 1e-9, "y": 3e4}],
    ],
)
def test_the_command_and_toml_say_what_is_seen(messages: list[dict]) -> None:
    subject = of("four-spheres", ["--precision", "double"])
    shot = session(*messages, subject=subject).shot
    assert shot is not None
    words = shlex.split(shot.command)
    samples = str(shot.scene.samples)
    expected = "clrt render four-spheres --precision double --width 80 --height 45 --samples"
    assert words[:-1] == [*expected.split(), samples, "--camera"]
    assert parse_camera(words[-1]) == shot.scene.camera
    tables = tomllib.loads(shot.toml)
    assert msgspec.convert(tables.pop("camera"), clrt.Camera) == shot.scene.camera
    assert tables == {"samples": shot.scene.samples}


@pytest.mark.parametrize(
    "text",
    [
        "nonsense",
        "[]",
        "{}",
        '{"do": "fly"}',
        '{"do": "turn", "x": 1}',
        '{"do": "turn", "x": 1e999, "y": 0}',
        '{"do": "turn", "x": NaN, "y": 0}',
        '{"do": "turn", "x": 1e9, "y": 0}',
        '{"do": "turn", "x": "1", "y": 0}',
        '{"do": "turn", "x": 1, "y": 0, "z": 0}',
        '{"do": "resize", "width": 0, "height": 5}',
        '{"do": "resize", "width": 100000, "height": 5}',
        '{"do": "zoom", "factor": 0, "x": 0, "y": 0}',
        '{"do": "pick", "x": -1, "y": 0}',
        '{"do": "sample", "samples": 100000}',
        '{"do": "frame", "frame": -1}',
        '{"do": "project", "projection": "fisheye"}',
        "[" * 100_000,
    ],
    ids=lambda text: text[:50],
)
def test_nonsense(text: str) -> None:
    with pytest.raises((msgspec.DecodeError, RecursionError)):
        MESSAGES.decode(text)


def test_what_is_known_of_a_sphere() -> None:
    scene = clrt.load_scene("four-spheres")
    first = scene.spheres[0]
    expected = {"index": 0, "position": first.center, "radius": first.radius, "material": "red"}
    assert FOUR.described(scene, 0, 0) == expected
    assert FOUR.described(scene, 0, -1) is None


def test_the_camera_holds_all_in_any_window() -> None:
    """Anew when it changes, as long as nobody has moved."""
    ends = np.array([[0.0, 0, 0], [9, 0, 0]])
    figure = of_figure(clrt.plot(ends, radii=1.0, size=(8, 6), samples=1).scene, (8, 6))
    for subject in (of_particles(clrt.Particles(ends, radii=1.0)), figure):
        for size in ((90, 45), (45, 90), (60, 60)):
            resize = {"do": "resize", "width": size[0], "height": size[1]}
            found = session(resize, subject=subject)
            right, _, _ = found.scene.camera.basis()
            half = lens.half_screen(found.scene.camera, *size)[0]
            aside = (ends - found.scene.camera.look_at) @ right
            assert abs(aside).max() + 1 <= half
            found.change(said(do="turn", x=1, y=0))
            moved = found.scene.camera
            found.change(said(do="resize", width=20, height=90))
            assert found.scene.camera == moved
            found.change(said(do="reset"))
            found.change(said(**resize))
            assert found.scene.camera == session(resize, subject=subject).scene.camera


@pytest.mark.parametrize("projection", ["perspective", "orthographic"])
@pytest.mark.parametrize("size", [(45, 90), (90, 10), (16, 9)])
def test_the_frame_of_a_scene_is_held(projection: str, size: orbit.Size) -> None:
    """All that `clrt render` shows of it, and the same camera where that has this shape."""
    camera = START if projection == "perspective" else orbit.orthographic(START, (16, 9))
    scene = replace(clrt.load_scene("four-spheres"), camera=camera)
    width, height = size
    found = session({"do": "resize", "width": width, "height": height}, subject=of(scene))
    here, there = found.scene.camera, camera
    low, high = orbit.point(here, (0, 0), size), orbit.point(here, (width - 1, height - 1), size)
    least = orbit.point(there, (0, 0), (1600, 900)), orbit.point(there, (1599, 899), (1600, 900))
    assert low[0] <= least[0][0] + 1e-9
    assert high[1] <= least[1][1] + 1e-9
    assert any(np.isclose([low[0], high[1]], [least[0][0], least[1][1]]))
    fits = 16 * height >= 9 * width if projection == "perspective" else 16 * height <= 9 * width
    assert (here == there) == fits
