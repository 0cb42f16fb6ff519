"""Meshes in scenes and their files: what is checked, dropped, closed and turned."""

import copy
import pickle
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import LIT

import clrt
from clrt import Mesh, Scene
from clrt.errors import RequestError, SceneError, SceneWarning
from clrt.files.scenefile import parse_scene
from clrt.truth import tracer

TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])
OUTWARD = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])
CAMERA = clrt.Camera((0, 0, 3), (0, 0, 0))
FILE = f"""
{LIT}[[meshes]]
vertices = [[0, 0, 0], [1, 0, 0], [0.5, 1, 0]]
faces = [[0, 1, 2]]
normals = [[0, 0, 1], [0, 1, 0], [1, 0, 0]]
material = "m"
"""


@pytest.mark.parametrize(
    ("change", "error"),
    [
        ({"vertices": TETRAHEDRON[:, :2]}, "vertices: expected numbers of shape (n, 3)"),
        (
            {"vertices": np.where(TETRAHEDRON == 1, np.nan, TETRAHEDRON)},
            "vertices[1]: expected finite numbers, got [nan, 0.0, 0.0]",
        ),
        ({"faces": OUTWARD + 1}, "faces[1]: expected indices from 0 to 3, got [1, 2, 4]"),
        ({"faces": [[0, 1, -1]]}, "faces[0]: expected indices from 0 to 3, got [0, 1, -1]"),
        ({"faces": OUTWARD + 2**40}, "faces[0]: expected indices from 0 to 3"),
        ({"faces": OUTWARD * 1.0}, "faces: expected whole numbers of shape (m, 3)"),
        ({"faces": [[0, 1, 2, 3]]}, "faces: expected whole numbers of shape (m, 3)"),
        ({"faces": [[0, 1, 2], [0, 1]]}, "faces: expected whole numbers of shape (m, 3)"),
        ({"normals": TETRAHEDRON[:3]}, "normals: expected one a vertex, got float64 of (3, 3)"),
        ({"colors": np.ones((5, 3))}, "colors: expected one a vertex or one a face, got float64"),
        ({"colors": np.full((4, 3), np.inf)}, "colors[0]: expected finite numbers"),
        ({"material": 3}, "material: expected a material's name, got 3"),
        ({"shading": "smooth"}, "shading: expected 'flat', 'gouraud' or 'phong', got 'smooth'"),
    ],
)
def test_arrays_are_checked(change: dict[str, Any], error: str) -> None:
    given: dict[str, Any] = {"vertices": TETRAHEDRON, "faces": OUTWARD, "material": "m"} | change
    with pytest.raises(SceneError) as found:
        Mesh(**given)
    assert str(found.value).startswith(error)
    assert "\n" not in str(found.value)


def test_values() -> None:
    mesh = Mesh(TETRAHEDRON, OUTWARD, material="m")
    assert (len(mesh), mesh.shading, mesh.closed) == (4, "flat", True)
    assert Mesh(TETRAHEDRON, OUTWARD, TETRAHEDRON + 1).shading == "phong"
    assert Mesh(TETRAHEDRON, OUTWARD, TETRAHEDRON + 1, shading="flat").shading == "flat"
    assert pickle.loads(pickle.dumps(mesh)) == copy.deepcopy(mesh) == mesh
    assert hash(mesh) == hash(copy.deepcopy(mesh))
    assert mesh != Mesh(TETRAHEDRON, OUTWARD, material="n")
    assert mesh != Mesh(TETRAHEDRON, OUTWARD, colors=TETRAHEDRON, material="m")
    assert repr(mesh) == "Mesh(4 vertices, 4 faces, flat, closed)"
    assert len(Mesh(np.zeros((0, 3)), [])) == 0
    single = Mesh(TETRAHEDRON.astype(np.float32), OUTWARD.astype(np.uint8))
    assert single.vertices.dtype == np.float32
    assert single.faces.dtype == np.int32


def test_nobody_changes_it_later() -> None:
    vertices, faces = TETRAHEDRON.copy(), OUTWARD.astype(np.int32)
    mesh = Mesh(vertices, faces)
    vertices[:], faces[:] = 7, 0
    assert mesh == Mesh(TETRAHEDRON, OUTWARD)
    assert not mesh.vertices.flags.writeable
    assert not mesh.faces.flags.writeable


@pytest.mark.parametrize("scale", [1e-200, 1e-6, 1.0, 1e6, 1e200])
def test_faces_without_area_are_dropped_and_counted(scale: float) -> None:
    vertices = scale * np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [2, 0, 0], [1, 0, 0]])
    faces = [[0, 1, 2], [0, 0, 1], [0, 1, 3], [1, 2, 4], [1, 3, 2]]
    colors = np.arange(15.0).reshape(5, 3)
    with pytest.warns(SceneWarning, match=r"faces: 3 of 5 have no area and are left out"):
        mesh = Mesh(vertices, faces, colors=colors[:5])
    assert mesh.faces.tolist() == [[0, 1, 2], [1, 3, 2]]
    assert mesh.colors is not None
    assert (mesh.colors == colors).all()  # one a vertex
    with pytest.warns(SceneWarning):
        mesh = Mesh(np.concatenate([vertices, vertices]), faces, colors=colors)
    assert not mesh.has_vertex_colors
    assert mesh.colors is not None
    assert mesh.colors.tolist() == colors[[0, 4]].tolist()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        sliver = vertices[:3] * [1, 1e-6, 1]
        assert len(Mesh(sliver, [[0, 1, 2]])) == 1
        assert len(Mesh(sliver * 1e-3, [[0, 1, 2]])) == 1


def box(split: bool) -> tuple[np.ndarray, np.ndarray]:
    """A cube of 12 faces; split: each side has corners of its own."""
    corners = np.array([[x, y, z] for x in (0.0, 1) for y in (0, 1) for z in (0, 1)])
    sides = np.array(
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    )
    if split:
        corners, sides = corners[sides.ravel()], np.arange(24).reshape(6, 4)
    return corners, np.concatenate([sides[:, [0, 1, 2]], sides[:, [0, 2, 3]]])


@pytest.mark.parametrize("split", [False, True])
def test_closed(split: bool) -> None:
    vertices, faces = box(split)
    whole = Mesh(vertices, faces)
    assert whole.closed
    assert not Mesh(vertices, faces[:-1]).closed  # an edge of one face
    turned = faces.copy()
    turned[3] = turned[3, ::-1]
    assert not Mesh(vertices, turned).closed  # two faces in one direction
    assert not Mesh(vertices, np.concatenate([faces, faces])).closed  # of four
    back_to_back = np.concatenate([faces[:2], faces[:2, ::-1]])
    assert not Mesh(vertices, back_to_back).closed  # it holds nothing
    apart = np.concatenate([vertices, vertices + 3])
    assert Mesh(apart, np.concatenate([faces, faces + len(vertices)])).closed


@pytest.mark.parametrize("split", [False, True])
@pytest.mark.parametrize("where", [0, 1e6])
def test_what_is_closed_and_inside_out_is_turned(split: bool, where: float) -> None:
    vertices, faces = box(split)
    vertices = vertices + where
    out = vertices - vertices.mean(axis=0)
    right, wrong = Mesh(vertices, faces, out), Mesh(vertices, faces[:, ::-1], -out)
    for mesh in (right, wrong):
        middle = mesh.corners.mean(axis=1) - vertices.mean(axis=0)
        assert np.einsum("ij,ij->i", mesh.face_normals, middle) == pytest.approx(0.5)
        assert (np.einsum("ijk,ijk->ij", mesh.corner_normals, mesh.corners - where - 0.5) > 0).all()
    # Normals that are against the faces are turned, be these open or closed.
    for some in (faces, faces[:, ::-1], faces[:-1]):
        assert (Mesh(vertices, some, -out).normals == out).all()
    # One that is open stays as it is.
    assert (Mesh(vertices, faces[:-1, ::-1]).faces == faces[:-1, ::-1]).all()


def test_normals_weighed_by_area() -> None:
    vertices, faces = box(split=False)
    mesh = Mesh(vertices * [1, 2, 3], faces, shading="phong")
    areas = np.cross(
        mesh.corners[:, 1] - mesh.corners[:, 0], mesh.corners[:, 2] - mesh.corners[:, 0]
    )
    for vertex in range(8):
        expected = areas[(faces == vertex).any(axis=1)].sum(axis=0)
        expected /= np.linalg.norm(expected)
        assert mesh.vertex_normals[vertex] == pytest.approx(expected, abs=1e-15)
    given = np.zeros((8, 3))
    given[3] = [0, 3e-200, 4e-200]
    some = Mesh(vertices * [1, 2, 3], faces, given)
    assert some.vertex_normals[3] == pytest.approx([0, 0.6, 0.8], abs=1e-15)
    rest = np.arange(8) != 3
    assert (some.vertex_normals[rest] == mesh.vertex_normals[rest]).all()
    # Where the sum is 0 each face has its own.
    double = Mesh(TETRAHEDRON, [[0, 1, 2], [0, 2, 1]], shading="phong")
    assert double.vertex_normals.any() == 0
    assert double.corner_normals.tolist() == [[[0, 0, 1]] * 3, [[0, 0, -1]] * 3]


def test_colors_of_corners() -> None:
    colors = np.arange(12.0).reshape(4, 3)
    of_vertices = Mesh(TETRAHEDRON, OUTWARD, colors=colors)  # four faces as well
    assert of_vertices.corner_colors is not None
    assert of_vertices.corner_colors[3].tolist() == colors[[1, 2, 3]].tolist()
    of_faces = Mesh(TETRAHEDRON, OUTWARD[:2], colors=colors[:2])
    assert of_faces.corner_colors is not None
    assert of_faces.corner_colors[1].tolist() == [colors[1].tolist()] * 3
    assert Mesh(TETRAHEDRON, OUTWARD).corner_colors is None


def test_without_the_vertices_of_no_face() -> None:
    places = np.concatenate([[[9.0, 9, 9]], TETRAHEDRON, [[8, 8, 8]]])
    colors = np.arange(18.0).reshape(6, 3)
    mesh = Mesh(places, np.array(OUTWARD) + 1, colors=colors, material="m", shading="phong")
    assert mesh.vertex_normals.shape == (6, 3)
    expected = Mesh(TETRAHEDRON, OUTWARD, colors=colors[1:5], material="m", shading="phong")
    assert mesh.trimmed() == expected
    assert (mesh.trimmed().vertex_normals == expected.vertex_normals).all()
    assert expected.trimmed() is expected
    # As many faces as vertices are left, and colours are still the faces'.
    of_faces = Mesh(places, np.array(OUTWARD) + 1, colors=colors[:4]).trimmed()
    assert (of_faces.has_vertex_colors, len(of_faces.vertices)) == (False, 4)


def test_in_a_scene_file() -> None:
    (mesh,) = parse_scene(FILE).meshes
    assert mesh.shading == "phong"
    assert mesh.vertex_normals[1].tolist() == [0, 1, 0]
    for old, new, error in [
        ("[[0, 1, 2]]", "[[0, 1, 3]]", r"meshes\[0\]\.faces\[0\]: expected indices from 0 to 2"),
        ("[[0, 1, 2]]", "[[0, 1]]", r"meshes\[0\]\.faces\[0\]: "),
        ('rial = "m"', 'rial = "n"', r"meshes\[0\]\.material: expected the name of a mat"),
        ('material = "m"', "", r"meshes\[0\]\.material: expected a value, got none"),
        ("normals", "normal", r"meshes\[0\]\.normal: unknown key; did you mean 'normals'"),
        ("normals = [", "colors = [[1, 1, 1], ", r"meshes\[0\]\.colors: expected one a vertex or"),
        ("normals =", 'shading = "soft"\nnormals =', r"meshes\[0\]\.shading: "),
    ]:
        with pytest.raises(SceneError, match=error):
            parse_scene(FILE.replace(old, new))


def test_written_and_read(tmp_path: Path) -> None:
    read = parse_scene(FILE)
    clrt.save_scene(tmp_path / "a.toml", read)
    assert clrt.load_scene(tmp_path / "a.toml") == read


def test_a_scene_says_what_meshes_cannot_be() -> None:
    mesh = Mesh(TETRAHEDRON, OUTWARD, material="m")
    materials = {"m": clrt.Material(), "glass": clrt.Material(transmission=0.5)}
    with pytest.raises(SceneError, match="shadow_bias: expected 0 where there are meshes"):
        Scene(CAMERA, materials=materials, meshes=[mesh], shadow_bias=1e-3)
    glass = Mesh(TETRAHEDRON, OUTWARD, material="glass")
    with pytest.raises(
        SceneError, match=r"materials\.glass\.transmission: expected 0 of a material"
    ):
        Scene(CAMERA, materials=materials, meshes=[glass])
    with pytest.raises(SceneError, match=r"meshes\[0\]\.material: expected the name of a material"):
        Scene(CAMERA, meshes=[mesh])
    wrong: Any = TETRAHEDRON
    with pytest.raises(SceneError, match=r"meshes\[0\]: expected a Mesh"):
        Scene(CAMERA, meshes=[wrong])
    given = Scene(CAMERA, [clrt.Light((0, 2, 0), radius=1)], materials, meshes=[mesh])
    assert given.is_random
    with pytest.raises(RequestError, match="'seed' knows no"):
        tracer.trace(given, 2, 2, "seed")
