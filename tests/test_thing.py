"""What has an index: a sphere, a capsule, a face."""

import shlex
from pathlib import Path

import numpy as np
import pytest

import clrt
from clrt.viewer import orbit
from clrt.viewer.session import Center, Resize, Session
from clrt.viewer.subject import of, of_mesh, of_particles
from clrt.viewer.thing import thing

SQUARE = np.array([[0.0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3]])
MESHES = (
    clrt.Mesh(SQUARE, [[0, 1, 2]], material="red"),
    clrt.Mesh(SQUARE, [[0, 1, 3], [0, 2, 3]], material="red"),
)
SCENE = clrt.Scene(
    clrt.Camera((0, 0, 9), (0, 0, 0), fov=40),
    materials={"red": clrt.Material((0, 0, 0), (1, 0, 0), (0, 0, 0), 1)},
    spheres=[clrt.Sphere((0, 0, 0), 0.5, "red")],
    capsules=[clrt.Capsule((1, 0, 0), (1, 2, 0), 0.25, "red")] * 2,
    meshes=MESHES,
)


@pytest.mark.parametrize(
    ("index", "kind", "number", "middle"),
    [
        (0, "sphere", 0, (0, 0, 0)),
        (2, "capsule", 1, (1, 1, 0)),
        (3, "face", 0, (1, 1, 0)),
        (4, "face", 0, (1, 0, 1)),
        (5, "face", 1, (0, 1, 1)),
    ],
)
def test_each_has_its_index(
    index: int, kind: str, number: int, middle: tuple[float, float, float]
) -> None:
    found = thing(SCENE, index)
    assert found is not None
    assert (found.kind, found.number) == (kind, number)
    assert found.middle == pytest.approx(middle)
    assert found.about["index"] == index
    assert found.about["material"] == "red"
    rings = found.rings(SCENE.camera, (60, 60))
    assert rings is not None
    assert len(rings) == {"sphere": 1, "capsule": 2, "face": 3}[kind]
    middles = [orbit.circle(SCENE.camera, tuple(c), found.radius, (60, 60)) for c in found.corners]
    assert rings == middles


def test_faces_are_those_of_a_mesh() -> None:
    """Of several meshes it is told which."""
    told = thing(SCENE, 5)
    assert told is not None
    assert (told.about["mesh"], told.about["face"]) == (1, 1)


@pytest.mark.parametrize("index", [-1, 6, 1000])
def test_there_is_nothing(index: int) -> None:
    assert thing(SCENE, index) is None


def test_behind_the_camera_there_is_no_ring() -> None:
    found = thing(SCENE, 2)
    assert found is not None
    assert found.rings(clrt.Camera((0, 0, -9), (0, 0, -10), fov=40), (60, 60)) is None


def test_capsules_of_particles_are_bonds() -> None:
    particles = clrt.Particles(SQUARE, radii=0.3, bonds=np.array([[0, 1]]))
    assert of_particles(particles, {"bonds": True}).capsules == "bond"
    assert of(SCENE).capsules == "capsule"


def test_a_face_goes_into_the_command(tmp_path: Path) -> None:
    """Of a file of a mesh."""
    path = tmp_path / "a.obj"
    path.write_text("v 0 0 0\nv 3 0 0\nv 0 3 0\nf 1 2 3\n")
    session = Session(of_mesh(path, {}))
    session.change(Resize(60, 40))
    session.marked = 0
    assert session.shot is not None
    assert session.shot.name == "face 0"
    words = shlex.split(session.shot.command)
    assert words[words.index("--center") + 1] == "1.0,1.0,0.0"
    session.change(Center())
    assert session.scene.camera.look_at == pytest.approx((1, 1, 0))
