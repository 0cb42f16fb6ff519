"""Capsules in scenes, their files and the truth."""

import copy
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import LIT
from msgspec.structs import replace

import clrt
from clrt import Capsule, Capsules, Scene, Sphere
from clrt.errors import RequestError, SceneError
from clrt.files.scenefile import parse_scene
from clrt.truth import tracer

START, END = np.arange(12.0).reshape(4, 3), np.arange(12.0).reshape(4, 3) + 1
RED = clrt.Material((0.1, 0, 0), (0.7, 0, 0), (1, 1, 1), shininess=100)
CAMERA = clrt.Camera((0, 0, 3), (0, 0, 0))
LIGHTS = (clrt.Light((3, 4, 5)), clrt.AmbientLight((0.2, 0.2, 0.2)))
FILE = f"""
{LIT}[[capsules]]
start = [0, 0, 0]
end = [1, 0, 0]
radius = 0.1
material = "m"
[[capsules]]
start = [0, 0, 0]
end = [0, 0, 0]
radius = 1
material = "m"
color = [1, 0, 0.5]
"""


def scene(*capsules: Capsule, **more: Any) -> Scene:
    return Scene(CAMERA, LIGHTS, {"red": RED}, capsules=capsules, **more)


def test_a_sequence_of_capsules() -> None:
    capsules = Capsules(START, END, [1, 2, 3, 4], ["a", "b", "a", "c"], np.ones((4, 3)) / 2)
    assert len(capsules) == 4
    assert capsules[1] == Capsule((3, 4, 5), (4, 5, 6), 2, "b", (0.5, 0.5, 0.5))
    assert list(capsules[2:]) == [capsules[2], capsules[-1]]
    assert Capsules.of(list(capsules)) == capsules
    assert pickle.loads(pickle.dumps(capsules)) == copy.deepcopy(capsules) == capsules
    assert Capsules(START, END, 1, "a") != Capsules(START, START, 1, "a")
    assert Capsules(START, END, 1, "a") != Capsules(START, END, 1, "a", np.ones((4, 3)))
    both = Capsules.joined([Capsules(START, END, 1, "a"), capsules])
    assert both[0] == Capsule((0, 1, 2), (1, 2, 3), 1, "a", (1, 1, 1))
    assert list(both[4:]) == list(capsules)


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"end": START[:2]}, "capsules.end: expected 4 points, got float64 of (2, 3)"),
        ({"radius": [1, 2]}, "capsules.radius: expected 4 numbers, got (2,)"),
        ({"radius": [1, 2, 0, 1]}, "capsules.radius[2]: expected a finite number above 0, got 0"),
        ({"start": START + np.inf}, "capsules.start[0]: expected finite numbers"),
        ({"material": ["a"]}, "capsules.material: expected a name, 4 names or 4 indices"),
        ({"color": np.ones((3, 3))}, "capsules.color: expected 4 colours, got (3, 3)"),
    ],
    ids=lambda given: "" if isinstance(given, str) else next(iter(given)),
)
def test_arrays_are_checked(change: dict, error: str) -> None:
    given = {"start": START, "end": END, "radius": 1, "material": "a"} | change
    with pytest.raises(SceneError) as found:
        Capsules(**given)
    assert str(found.value).startswith(error)


def test_in_a_scene_file() -> None:
    read = parse_scene(FILE)
    one, other = read.capsules
    assert one == Capsule((0, 0, 0), (1, 0, 0), 0.1, "m")
    assert other.color == (1, 0, 0.5)
    with pytest.raises(SceneError, match=r"capsules\[1\]\.radius: expected a finite number above"):
        parse_scene(FILE.replace("radius = 1\n", "radius = -1\n"))
    with pytest.raises(SceneError, match=r"capsules\[0\]\.start: expected a value, got none"):
        parse_scene(FILE.replace("start = [0, 0, 0]\nend = [1", "end = [1"))
    with pytest.raises(SceneError, match=r"capsules\[0\]\.material: expected the name of a mat"):
        parse_scene(FILE.replace('material = "m"', 'material = "n"', 1))


@pytest.mark.parametrize("many", [False, True])
def test_written_and_read(many: bool, tmp_path: Path) -> None:
    read = parse_scene(FILE)
    given = replace(read, capsules=Capsules.of(read.capsules)) if many else read
    clrt.save_scene(tmp_path / "a.toml", given)
    found = clrt.load_scene(tmp_path / "a.toml")
    assert Capsules.of(found.capsules) == Capsules.of(read.capsules)
    assert (tmp_path / "a.capsules.npz").exists() == many
    assert many or [one.color for one in found.capsules] == [None, (1, 0, 0.5)]


def test_in_a_file(tmp_path: Path) -> None:
    table = '[[capsules]]\nfile = "b.npz"\n'
    given = Capsules(START, END, [1, 2, 3, 4], ["m", "n", "m", "m"], np.ones((4, 3)) / 2)
    materials = {"m": clrt.Material(), "n": clrt.Material()}
    clrt.save_scene(tmp_path / "a.toml", Scene(CAMERA, materials=materials, capsules=given))
    (tmp_path / "a.capsules.npz").rename(tmp_path / "b.npz")
    text = FILE + "[materials.n]\n" + table
    found = parse_scene(text, tmp_path).capsules
    assert (len(found), list(found[2:])) == (6, list(given))
    with pytest.raises(SceneError, match=r"capsules\[2\]\.radius: expected none beside file"):
        parse_scene(text + "radius = 1\n", tmp_path)
    for wrong in ({"start": START}, {"start": START, "end": END, "radius": 1, "colour": 1}):
        np.savez(tmp_path / "b.npz", **wrong)  # type: ignore[arg-type]
        with pytest.raises(SceneError, match=r"capsules\[2\]\.file: .*: expected an \.npz file of"):
            parse_scene(text, tmp_path)
    for content in (b"", b"PK", b"\x93NUMPY"):
        (tmp_path / "b.npz").write_bytes(content)
        with pytest.raises(SceneError, match=r"capsules\[2\]\.file: "):
            parse_scene(text, tmp_path)
    (tmp_path / "b.npz").unlink()
    with pytest.raises(SceneError, match=r"capsules\[2\]\.file: .*: No such file"):
        parse_scene(text, tmp_path)


GLASS = clrt.Material(transmission=0.5)
ONE = Capsule((0, 0, 0), (1, 0, 0), 0.1, "red")


def test_a_scene_says_what_capsules_cannot_be() -> None:
    with pytest.raises(SceneError, match="shadow_bias: expected 0 where there are capsules"):
        scene(ONE, shadow_bias=1e-3)
    with pytest.raises(SceneError, match=r"materials\.red\.transmission: expected 0 of a material"):
        Scene(CAMERA, materials={"red": GLASS}, capsules=[ONE])
    # Of a material that no capsule has it may be.
    materials = {"glass": GLASS, "red": RED}
    Scene(CAMERA, materials=materials, capsules=Capsules([[0, 0, 0]], [[1, 0, 0]], 1, [1]))
    with pytest.raises(SceneError, match=r"capsules\.material: expected the name of a material"):
        Scene(CAMERA, capsules=Capsules(START, END, 1, "none"))
    with pytest.raises(RequestError, match="'seed' knows no capsules"):
        tracer.trace(scene(ONE), 2, 2, "seed")
    assert not scene(ONE).is_random
    assert Scene(CAMERA, [clrt.Light((0, 2, 0), radius=1)], {"red": RED}, capsules=[ONE]).is_random


# The truth.


def random_scene(orthographic: bool) -> Scene:
    random = np.random.default_rng(3)
    start = random.uniform(-1, 1, (30, 3))
    end = start + random.normal(size=(30, 3)) * random.choice([0.01, 0.3, 1.5], (30, 1))
    capsules = Capsules(start, end, random.uniform(0.02, 0.3, 30), "red")
    camera = clrt.Camera((0, 0, 9), (0, 0, 0), projection="orthographic", height=3)
    return replace(scene(), capsules=capsules, camera=camera if orthographic else CAMERA)


def from_axes(capsules: Capsules, points: np.ndarray) -> np.ndarray:
    """How far points (n, 3) lie outside of each capsule, (n, capsules)."""
    axis = capsules.end - capsules.start
    aside = points[:, np.newaxis] - capsules.start
    part = np.clip((aside * axis).sum(2) / (axis**2).sum(1), 0, 1)
    return np.linalg.norm(aside - part[..., np.newaxis] * axis, axis=2) - capsules.radius


@pytest.mark.parametrize("orthographic", [False, True])
def test_the_truth_is_on_the_surface_and_nothing_is_before_it(orthographic: bool) -> None:
    given = random_scene(orthographic)
    capsules = Capsules.of(given.capsules)
    found = tracer.trace(given, 40, 40)
    assert len(np.unique(found.id)) > 15
    assert found.id.min() == -1
    x, y = np.meshgrid(np.linspace(-1, 1, 40), np.linspace(1, -1, 40))
    if orthographic:
        origin = np.stack([1.5 * x, 1.5 * y, 9 + 0 * x], axis=-1)
        way = np.broadcast_to([0.0, 0, -1], origin.shape)
    else:
        way = np.stack([x, y, -1 + 0 * x], axis=-1)
        way = way / np.linalg.norm(way, axis=-1, keepdims=True)
        origin = np.broadcast_to([0.0, 0, 3], way.shape)
    seen = found.id >= 0
    point = (origin + np.where(seen, found.depth, 0)[..., np.newaxis] * way)[seen]
    outside = from_axes(capsules, point)
    own = np.take_along_axis(outside, found.id[seen][:, np.newaxis], 1)[:, 0]
    assert abs(own).max() < 1e-13
    assert outside.min() > -1e-13
    # The normal is the slope of that distance.
    for axis in range(3):
        step = np.eye(3)[axis] * 1e-6
        there = [from_axes(capsules, point + way * step) for way in (-1, 1)]
        slope = np.take_along_axis(there[1] - there[0], found.id[seen][:, np.newaxis], 1) / 2e-6
        assert abs(slope[:, 0] - found.normal[seen][:, axis]).max() < 1e-5
    # Nothing is before it, and where nothing is seen there is nothing.
    until = np.where(seen, found.depth, 20)[..., np.newaxis]
    for part in np.linspace(0, 0.9999, 100):
        places = (origin + part * until * way).reshape(-1, 3)
        assert from_axes(capsules, places).min() > 0


def test_of_no_length_it_is_a_sphere() -> None:
    capsule = Capsule((0.2, 0.1, -0.4), (0.2, 0.1, -0.4), 0.7, "red", (1, 0.5, 0.5))
    sphere = Sphere((0.2, 0.1, -0.4), 0.7, "red", (1, 0.5, 0.5))
    ground = Sphere((0, -101, 0), 100, "red")
    one = tracer.trace(replace(scene(capsule), spheres=(ground,)), 50, 30)
    other = tracer.trace(replace(scene(), spheres=(ground, sphere)), 50, 30)
    assert (one.id == other.id).all()
    assert set(one.id.ravel().tolist()) == {-1, 0, 1}
    assert abs(one.image - other.image).max() < 1e-12
    assert (one.paths == other.paths).mean() > 0.999


def test_from_inside_it_is_not_seen() -> None:
    inside = Capsule((0, 0, 9), (0, 0, 2), 0.5, "red")
    behind = Capsule((-1, 0, 0), (1, 0, 0), 0.1, "red")
    assert set(tracer.trace(scene(inside, behind), 21, 21).id.ravel().tolist()) == {-1, 1}
