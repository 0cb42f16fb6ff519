"""Spheres as arrays: what is kept, what is copied, what is refused."""

import copy
import pickle

import numpy as np
import pytest

import clrt
from clrt.scene.spheres import Sphere, Spheres

CENTER = np.arange(12.0).reshape(4, 3)
RED = clrt.Material((0.1, 0, 0), (0.7, 0, 0), (1, 1, 1), shininess=100)
CAMERA = clrt.Camera((0, 0, 1), (0, 0, 0))


def frozen(array: np.ndarray) -> np.ndarray:
    array = array.copy()
    array.flags.writeable = False
    return array


def test_a_sequence_of_spheres() -> None:
    spheres = Spheres(CENTER, [1, 2, 3, 4], ["a", "b", "a", "c"], np.ones((4, 3)) / 2)
    assert len(spheres) == 4
    assert spheres[1] == Sphere((3, 4, 5), 2, "b", (0.5, 0.5, 0.5))
    assert list(spheres[2:]) == [spheres[2], spheres[-1]]
    assert [sphere.material for sphere in spheres] == ["a", "b", "a", "c"]
    assert spheres[0] in spheres
    assert Spheres.of(list(spheres)) == spheres
    assert not len(Spheres(np.zeros((0, 3)), 1, "a"))


def test_compared_by_value() -> None:
    spheres = Spheres(CENTER, 1, "a")
    assert spheres == Spheres(CENTER.tolist(), np.ones(4), "a")
    assert hash(spheres) == hash(Spheres(CENTER, np.ones(4), "a"))
    for other in (
        Spheres(CENTER, 2, "a"), Spheres(CENTER, 1, "b"), Spheres(CENTER[:3], 1, "a"),
        Spheres(CENTER, 1, "a", np.ones((4, 3))), Spheres(CENTER, 1, [0, 0, 0, 0]),
    ):  # fmt: skip
        assert spheres != other
    assert pickle.loads(pickle.dumps(spheres)) == copy.deepcopy(spheres) == spheres


def test_an_array_is_kept_if_nobody_else_can_write_to_it() -> None:
    owned = frozen(CENTER)
    assert Spheres(owned, 1, "a").center is owned
    single = frozen(CENTER.astype(np.float32))
    assert Spheres(single, 1, "a").center is single
    assert np.shares_memory(Spheres(owned[1:], 1, "a").center, owned)


def test_else_it_is_copied() -> None:
    writeable = CENTER.copy()
    looks_frozen = writeable[:]
    looks_frozen.flags.writeable = False
    for given in (writeable, looks_frozen):
        spheres = Spheres(given, 1, "a")
        before = spheres.center.copy()
        writeable += 1
        assert (spheres.center == before).all()
        with pytest.raises(ValueError, match="read-only"):
            spheres.center[0] = 0


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: Spheres(np.zeros((3, 2)), 1, "a"), r"spheres.center: expected numbers of shape"),
        (lambda: Spheres("abc", 1, "a"), r"spheres.center: expected numbers of shape \(n, 3\)"),
        (
            lambda: Spheres([[0.0, 0.0, 0.0], [0.0, float("inf"), 0.0]], 1, "a"),
            r"spheres.center\[1\]: expected",
        ),
        (lambda: Spheres(CENTER, [1, 2, 0, 4], "a"), r"spheres.radius\[2\]: expected a finite num"),
        (lambda: Spheres(CENTER, [1, 2, np.nan, 4], "a"), r"spheres.radius\[2\]: expected a finit"),
        (lambda: Spheres(CENTER, -1, "a"), r"spheres.radius: expected a finite number above 0, go"),
        (lambda: Spheres(CENTER, [1, 2], "a"), r"spheres.radius: expected 4 numbers"),
        (lambda: Spheres(CENTER, 1, ["a"]), r"spheres.material: expected a name, 4 names or 4 ind"),
        (lambda: Spheres(CENTER, 1, [0, 1, -1, 0]), r"spheres.material\[2\]: expected an index"),
        (lambda: Spheres(CENTER, 1, 5), r"spheres.material: expected a name"),  # type: ignore
        (lambda: Spheres(CENTER, 1, "a", CENTER[:2]), r"spheres.color: expected 4 colours"),
    ],
)
def test_refuses(make, said: str) -> None:
    with pytest.raises(clrt.SceneError, match=said):
        make()


def test_a_scene_of_arrays() -> None:
    materials = {"red": RED, "blue": RED}
    spheres = Spheres(CENTER, 1, [0, 1, 0, 1])
    scene = clrt.Scene(CAMERA, materials=materials, spheres=spheres)
    assert scene.spheres[1].material == "blue"
    with pytest.raises(clrt.SceneError, match=r"spheres.material\[1\]: expected an index below 1"):
        clrt.Scene(CAMERA, materials={"red": RED}, spheres=spheres)
    named = Spheres(CENTER, 1, "green")
    with pytest.raises(clrt.SceneError, match=r"spheres.material: expected the name of a material"):
        clrt.Scene(CAMERA, materials=materials, spheres=named)


def test_arrays_give_the_picture_of_the_list() -> None:
    scene = clrt.load_scene("four-spheres")
    arrays = Spheres.of(scene.spheres)
    same = clrt.Scene(scene.camera, scene.lights, scene.materials, arrays, shadow_bias=1e-5)
    with clrt.Renderer() as renderer:
        assert (renderer.render(same, 101, 67) == renderer.render(scene, 101, 67)).all()
