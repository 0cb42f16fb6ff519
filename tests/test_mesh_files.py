"""Meshes of files and objects: what is read, what is named, and what is wrong."""

import gzip
import struct
import warnings
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from conftest import LIT
from mesh_cases import sphere

import clrt
from clrt import Mesh, read_mesh
from clrt.errors import ParticleWarning, RequestError, SceneError
from clrt.files.meshes.reader import is_mesh
from clrt.files.meshes.surface import merged, triangles
from clrt.film import color

VERTICES, FACES = sphere(3)
SINGLE = VERTICES.astype(np.float32)
MESH = Mesh(SINGLE, FACES)
QUAD = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n"


def stl_bytes(begin: bytes = b"made by hand") -> bytes:
    rows = np.zeros(len(FACES), np.dtype([("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")]))
    rows["v"] = SINGLE[FACES]
    return begin.ljust(80) + struct.pack("<I", len(rows)) + rows.tobytes()


def stl_text() -> bytes:
    corner = "   vertex {0:.9e} {1:.9E} {2:.9g}\n"
    facets = "".join(
        " facet normal 0 0 0\n  outer loop\n"
        + "".join(corner.format(*point) for point in SINGLE[face].tolist())
        + "  endloop\n endfacet\n"
        for face in FACES
    )
    return f"solid a name\n{facets}endsolid a name\n".encode()


def ply_bytes(form: str, more: str = "", polygons: bool = False) -> bytes:
    order = ">" if form == "binary_big_endian" else "<"
    faces: list[Any] = FACES.tolist()
    if polygons:
        faces = [[*FACES[0], FACES[0][2]], *faces[1:]]  # the first has a corner twice
    header = (
        f"ply\nformat {form} 1.0\ncomment by hand\nelement vertex {len(SINGLE)}\n"
        + "".join(f"property float {axis}\n" for axis in "xyz")
        + f"element face {len(faces)}\nproperty list uchar int vertex_indices\n{more}end_header\n"
    )
    if form == "ascii":
        rows = [" ".join(map(repr, map(float, row))) for row in SINGLE]
        rows += [" ".join(map(str, [len(face), *face])) for face in faces]
        return (header + "\n".join(rows) + "\n").encode()
    lists = b"".join(struct.pack(f"{order}B{len(face)}i", len(face), *face) for face in faces)
    return header.encode() + SINGLE.astype(f"{order}f4").tobytes() + lists


def obj_text(corner: str) -> bytes:
    """The corners' forms: {0} the vertex, {1} that of the normals, from the end."""
    n = len(VERTICES)
    rows = ["# by hand", "o ball", "g one two", "s 1"]
    rows += [f"v {x!r} {y!r} {z!r}" for x, y, z in map(tuple, SINGLE.astype(float).tolist())]
    rows += ["vn {} {} {}".format(*row) for row in VERTICES.tolist()]
    rows += ["f " + " ".join(corner.format(k + 1, k - n) for k in face) for face in FACES.tolist()]
    return "\n".join(rows).encode()


FILES: dict[str, tuple[str, Callable[[], bytes]]] = {
    "stl": ("a.stl", stl_bytes),
    "stl that begins like text": ("a.STL", lambda: stl_bytes(b"solid lies")),
    "stl of text": ("a.stl", stl_text),
    "stl of text with \\r": ("a.stl", lambda: stl_text().replace(b"\n", b"\r\n")),
    "ply": ("a.ply", lambda: ply_bytes("binary_little_endian")),
    "ply big": ("a.ply", lambda: ply_bytes("binary_big_endian")),
    "ply of text": ("a.ply", lambda: ply_bytes("ascii")),
    "ply packed": ("a.ply.gz", lambda: gzip.compress(ply_bytes("binary_little_endian"))),
    "obj": ("a.obj", lambda: obj_text("{0}")),
    "obj from the end": ("a.obj", lambda: obj_text("{1}")),
    "obj with \\r": ("a.obj", lambda: obj_text("{0}").replace(b"\n", b"\r\n")),
    "obj with tabs": ("a.obj", lambda: obj_text("{0}").replace(b" ", b"\t")),
    "obj with blanks before": ("a.obj", lambda: b"  " + obj_text("{0}").replace(b"\n", b"\n ")),
}


def written(tmp_path: Path, name: str, content: bytes) -> Path:
    path = tmp_path / name
    path.write_bytes(content)
    return path


def same_shape(found: Mesh, expected: Mesh = MESH) -> bool:
    return np.array_equal(found.corners.astype(np.float32), expected.corners.astype(np.float32))


@pytest.mark.parametrize("case", FILES)
def test_files(case: str, tmp_path: Path) -> None:
    name, content = FILES[case]
    path = written(tmp_path, name, content())
    assert is_mesh(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = read_mesh(path, "skin", "gouraud")
    assert same_shape(found)
    assert found.closed
    assert len(found.vertices) == len(VERTICES)
    assert (found.material, found.shading, found.colors) == ("skin", "gouraud", None)


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian", "binary_big_endian"])
def test_polygons_of_ply(form: str, tmp_path: Path) -> None:
    path = written(tmp_path, "a.ply", ply_bytes(form, polygons=True))
    with pytest.warns(clrt.SceneWarning, match="1 of 181 have no area"):
        assert same_shape(read_mesh(path))


@pytest.mark.parametrize(
    ("corner", "width"),
    [("{0}//{0}", 3), ("{0}/7/{0}", 3), ("{1}//{1}", 3), ("{0}/7", 1), ("{0}/", 1)],
)
def test_corners_of_obj(corner: str, width: int, tmp_path: Path) -> None:
    text = obj_text(corner)
    if "7" in corner:
        text = b"vt 0 0\n" * 9 + text
        with pytest.warns(ParticleWarning, match="textures and materials are not read: vt"):
            found = read_mesh(written(tmp_path, "a.obj", text))
    else:
        found = read_mesh(written(tmp_path, "a.obj", text))
    assert same_shape(found)
    assert found.shading == ("phong" if width == 3 else "flat")
    if width == 3:
        assert abs(found.vertex_normals[found.faces] - VERTICES[FACES]).max() < 1e-15


def test_obj_of_hard_edges_mixed_corners_and_polygons(tmp_path: Path) -> None:
    text = QUAD + "v 0.5 0.5 1 1 0 0\n"
    with pytest.raises(
        SceneError, match=r"a\.obj: line 5: expected v and 3 or 4 or 6 or 7 numbers"
    ):
        read_mesh(written(tmp_path, "a.obj", (text + "f 1 2 3\n").encode()))
    text = (
        QUAD + "v .5 .5 1\nvn 0 0 -1\nvn 0 -1 1\nf 4//1 3//1 2//1 1//1\nf 1//2 2//2 5//2 # side\n"
    )
    found = read_mesh(written(tmp_path, "a.obj", text.encode()))
    assert len(found) == 3
    assert len(found.vertices) == 7  # two of them twice, for they have two normals
    assert abs(found.corner_normals[2] - np.array([0, -1, 1]) / 2**0.5).max() < 1e-15
    text = QUAD + "f 1 2 3\\\n 4\nf 1/2/ 2 4\n"
    assert len(read_mesh(written(tmp_path, "a.obj", text.encode()))) == 3
    colored = "v 0 0 0 1 0 0\nv 1 0 0 0 .5 0\nv 1 1 0 0 0 1\nf 1 2 3\n"
    found = read_mesh(written(tmp_path, "a.obj", colored.encode()))
    assert found.colors is not None
    assert found.colors[1].tolist() == color.linear([0, 0.5, 0]).tolist()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (QUAD, r"expected lines f, of faces, the file ends"),
        (QUAD + "f 1 2\n", r"line 5: expected f and three or more corners.*got '1 2'"),
        (QUAD + "f 1 2 5\n", r"line 5: expected v from 1 to 4, got '5'"),
        (QUAD + "f 1 2 0\n", r"line 5: expected v from 1 to 4, got '0'"),
        (QUAD + "f 1 2 3\nf 1 2 -5\n", r"line 6: expected v from 1 to 4, got '-5'"),
        (QUAD + "f 1 2 x\n", r"line 5: expected f and three"),
        (QUAD + "f 1/2/3 4/5 6\n", r"line 5: expected v from 1 to 4, got '6'"),
        (QUAD + "f 1/1/1/1 2 3\n", r"line 5: expected f and three"),
        (QUAD + "f 1//1 2//1 3//1\n", r"expected normals vn, which faces name, got 'none'"),
        ("v 0 0\nf 1 1 1\n", r"line 1: expected v and 3 or 4 or 6 or 7 numbers in each line"),
        (QUAD + "v 1 2 x\nf 1 2 3\n", r"line 5: expected v and 3"),
        (QUAD + "v nan 2 3\nf 1 2 3\n", r"line 5: expected v and 3.*got 'nan 2 3'"),
        ("v 1e999 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", r"vertices\[0\]: expected finite numbers"),
        ("", "expected lines f"),
    ],
)
def test_faults_of_obj(text: str, said: str, tmp_path: Path) -> None:
    with pytest.raises(SceneError, match=rf"a\.obj: .*{said}") as found:
        read_mesh(written(tmp_path, "a.obj", text.encode()))
    assert "\n" not in str(found.value)


def test_what_obj_has_that_is_not_read_is_named(tmp_path: Path) -> None:
    text = "mtllib a.mtl\nusemtl skin\nl 1 2\n" + QUAD + "f 1 2 3\n"
    with pytest.warns(ParticleWarning) as said:
        read_mesh(written(tmp_path, "a.obj", text.encode()))
    texts = [str(one.message) for one in said]
    assert any("are not read: mtllib usemtl" in text for text in texts)
    assert any("lines that are not read begin with 'l': 1" in text for text in texts)


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.stl", stl_bytes()[:-1], "expected 180 facets, the file ends after 179"),
        ("a.stl", b"not one", "expected 'solid' or a binary STL, got b'not one'"),
        (
            "a.stl",
            stl_text()[: stl_text().rindex(b"   vertex")],
            r"expected a loop of three vertices",
        ),
        (
            "a.stl",
            stl_text().replace(b"vertex", b"vertex x", 1),
            "line 4: expected vertex and three",
        ),
        ("a.ply", ply_bytes("ascii")[:-9], "expected 180 rows of vertex_indices from line"),
        ("a.ply", ply_bytes("binary_little_endian")[:-1], "the file ends before"),
        (
            "a.ply",
            ply_bytes("binary_little_endian", polygons=True)[:-1],
            "expected 180 rows of element face, the file ends before",
        ),
        (
            "a.ply",
            ply_bytes("ascii").replace(b"int vertex_ind", b"int other_ind"),
            "vertex_indices",
        ),
        (
            "a.ply",
            ply_bytes("ascii").replace(b"float z", b"float w"),
            "expected vertices with x, y",
        ),
        ("a.ply", ply_bytes("ascii").replace(b"uchar int", b"uchar text"), "lists of the types"),
        ("none.stl", None, "cannot be read: No such file"),
    ],
)
def test_faults(name: str, content: bytes | None, said: str, tmp_path: Path) -> None:
    path = tmp_path / name if content is None else written(tmp_path, name, content)
    with pytest.raises(SceneError, match=said) as found:
        read_mesh(path)
    assert str(found.value).startswith(str(path))
    assert "\n" not in str(found.value)


def test_other_suffixes() -> None:
    with pytest.raises(RequestError, match=r"a\.glb: expected a mesh in a file that ends in \.ply"):
        read_mesh("a.glb")


def full_ply(tmp_path: Path, form: str) -> Path:
    """With normals, colours of faces, numbers, and elements that are none of a mesh."""
    vertices = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
    header = "".join(
        [
            f"ply\nformat {form} 1.0\nelement camera 1\nproperty list uchar float cam\n",
            "element vertex 4\n",
            *(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz", "quality")),
            "element face 2\nproperty uchar red\nproperty list uchar uint vertex_index\n",
            "property uchar green\nproperty uchar blue\nproperty list uchar float texcoord\n",
            "element edge 1\nproperty int a\nend_header\n",
        ]
    )
    faces = [(255, (0, 1, 2), 0, 128), (0, (2, 1, 3), 255, 0)]
    if form == "ascii":
        rows = ["2 0.5 0.5", *(f"{x} {y} {z} 0 0 2 {k}.5" for k, (x, y, z) in enumerate(vertices))]
        rows += [f"{r} 3 {' '.join(map(str, f))} {g} {b} 2 0 0" for r, f, g, b in faces]
        return written(tmp_path, "full.ply", (header + "\n".join([*rows, "7"]) + "\n").encode())
    body = struct.pack("<B2f", 2, 0.5, 0.5)
    body += b"".join(
        struct.pack("<7f", x, y, z, 0, 0, 2, k + 0.5) for k, (x, y, z) in enumerate(vertices)
    )
    body += b"".join(struct.pack("<BB3I2BB2f", r, 3, *f, g, b, 2, 0, 0) for r, f, g, b in faces)
    return written(tmp_path, "full.ply", header.encode() + body + struct.pack("<i", 7))


@pytest.mark.parametrize("form", ["ascii", "binary_little_endian"])
def test_all_that_ply_can_have(form: str, tmp_path: Path) -> None:
    path = full_ply(tmp_path, form)
    with pytest.warns(ParticleWarning) as said:
        found = read_mesh(path)
    texts = [str(one.message) for one in said]
    assert any("element edge: is not used" in text for text in texts)
    assert any("textures are not read: texcoord" in text for text in texts)
    assert found.faces.tolist() == [[0, 1, 2], [2, 1, 3]]
    assert found.shading == "phong"
    assert found.vertex_normals[3].tolist() == [0, 0, 1]
    assert found.colors is not None
    assert not found.has_vertex_colors
    expected = color.linear(np.array([[255, 0, 128], [0, 255, 0]], np.uint8))
    assert np.array_equal(found.colors, expected)
    with pytest.warns(ParticleWarning):
        by_value = read_mesh(path, color="quality", cmap="gray", clim=(0.5, 3.5))
    assert by_value.colors is not None
    assert by_value.has_vertex_colors
    assert by_value.colors[[0, 3]].tolist() == [[0, 0, 0], [1, 1, 1]]
    with (
        pytest.warns(ParticleWarning),
        pytest.raises(
            SceneError, match=r"color: expected the name of numbers \('quality'\), got 'x'"
        ),
    ):
        read_mesh(path, color="x")


def pyvista_like() -> SimpleNamespace:
    faces = np.concatenate([np.full((len(FACES), 1), 3), FACES], axis=1).ravel()
    values = np.arange(len(VERTICES))
    return SimpleNamespace(
        points=SINGLE, faces=faces, point_data={"Normals": SINGLE, "height": values}, cell_data={}
    )


OBJECTS: dict[str, Callable[[], Any]] = {
    "a pair": lambda: (SINGLE, FACES),
    "lists": lambda: [SINGLE.tolist(), FACES.tolist()],
    "as of scikit-image": lambda: (SINGLE, FACES, VERTICES, np.arange(len(SINGLE))),
    "a dict": lambda: {"vertices": SINGLE, "faces": FACES},
    "as of trimesh": lambda: SimpleNamespace(
        vertices=SINGLE,
        faces=FACES,
        visual=SimpleNamespace(defined=True, kind="face", face_colors=np.full((180, 4), 255)),
    ),
    "as of open3d": lambda: SimpleNamespace(
        vertices=SINGLE, triangles=FACES, vertex_normals=np.zeros((0, 3)), vertex_colors=[]
    ),
    "as of pyvista": pyvista_like,
    "a Mesh": lambda: MESH,
}


@pytest.mark.parametrize("case", OBJECTS)
def test_objects(case: str) -> None:
    found = read_mesh(OBJECTS[case](), "skin")
    assert same_shape(found)
    assert found.closed
    assert found.material == "skin"
    assert (found.shading == "phong") == (case in ("as of scikit-image", "as of pyvista"))
    assert (found.colors is None) == (case != "as of trimesh")


def test_values_of_objects() -> None:
    four = OBJECTS["as of scikit-image"]()
    found = read_mesh(four, color="values", cmap="gray")
    assert found.colors is not None
    assert found.colors[[0, -1]].tolist() == [[0, 0, 0], [1, 1, 1]]
    assert read_mesh(pyvista_like(), color="height").has_vertex_colors
    with pytest.raises(SceneError, match="mesh: expected a file's name, a Mesh"):
        read_mesh(7)
    with pytest.raises(SceneError, match="mesh: expected the keys vertices and faces, got points"):
        read_mesh({"points": SINGLE})
    with pytest.raises(SceneError, match=r"mesh: expected \(vertices, faces\)"):
        read_mesh((SINGLE,))
    with pytest.raises(SceneError, match=r"tuple: faces\[0\]: expected indices from 0 to 2"):
        read_mesh((SINGLE[:3], [[0, 1, 3]]))


def test_polygons_of_pyvista() -> None:
    flat = [4, 0, 1, 2, 3, 3, 0, 1, 2, 5, 0, 1, 2, 3, 0]
    quads = SimpleNamespace(
        points=np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]),
        faces=np.array(flat),
        point_data={},
        cell_data={"RGB": np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255]], np.uint8)},
    )
    with pytest.warns(clrt.SceneWarning, match="1 of 6 have no area"):
        found = read_mesh(quads)
    assert found.faces.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 1, 2], [0, 2, 3]]
    assert found.colors is not None
    assert found.colors.argmax(axis=1).tolist() == [0, 0, 1, 2, 2]


def test_merged() -> None:
    random = np.random.default_rng(3)
    for dtype in (np.float32, np.float64, np.int64):
        rows = random.integers(-3, 3, (5000, 3)).astype(dtype)
        kept, which = merged(rows)
        assert (kept[which] == rows).all()
        assert len(np.unique(kept, axis=0)) == len(kept)
        first = [int(np.argmax((rows == one).all(axis=1))) for one in kept]
        assert first == sorted(first)
    zeros = np.array([[0.0, -0.0, 1], [-0.0, 0.0, 1]])
    assert merged(zeros)[1].tolist() == [0, 0]
    assert len(merged(np.zeros((0, 3)))[0]) == 0


def test_merged_where_hashes_are_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "clrt.files.meshes.surface._hashes", lambda words: np.zeros(len(words), np.uint64)
    )
    rows = np.random.default_rng(3).integers(0, 3, (500, 3)).astype(np.float32)
    kept, which = merged(rows)
    assert (kept[which] == rows).all()
    assert len(kept) == 27


def test_triangles() -> None:
    corners = np.array([7, 8, 9, 1, 2, 3, 4, 5, 6])
    found, polygon = triangles(corners, np.array([0, 3, 7]), np.array([3, 4, 2]))
    assert found.tolist() == [[7, 8, 9], [1, 2, 3], [1, 3, 4]]
    assert polygon.tolist() == [0, 1, 1]


SCENE = f"""
{LIT}[[meshes]]
file = "a.stl"
material = "m"
"""


def test_in_a_scene_file(tmp_path: Path) -> None:
    written(tmp_path, "a.stl", stl_bytes())
    path = written(tmp_path, "scene.toml", SCENE.encode())
    (mesh,) = clrt.load_scene(path).meshes
    assert same_shape(mesh)
    for old, new, said in [
        ("a.stl", "b.stl", r"scene\.toml: meshes\[0\]\.file: .*b\.stl: cannot be read"),
        ("a.stl", "b.glb", r"meshes\[0\]\.file: .*expected a mesh in a file that ends"),
        ('file = "a.stl"\n', "", r"meshes\[0\]: expected file, or vertices and faces"),
        ("material =", "faces = []\nmaterial =", r"meshes\[0\]\.faces: expected none beside file"),
    ]:
        written(tmp_path, "scene.toml", SCENE.replace(old, new).encode())
        with pytest.raises(SceneError, match=said):
            clrt.load_scene(path)


@pytest.mark.parametrize("kind", ["plain", "vertices", "faces", "odd"])
def test_a_large_mesh_is_written_beside_its_scene(kind: str, tmp_path: Path) -> None:
    random = np.random.default_rng(1)
    count = {"plain": 0, "vertices": len(VERTICES), "faces": len(FACES), "odd": len(FACES)}[kind]
    colors = None if kind == "plain" else color.linear(random.uniform(0, 1, (count, 3)))
    if kind == "odd" and colors is not None:
        colors = colors * 3
    normals = VERTICES if kind == "vertices" else None
    vertices = VERTICES if kind == "faces" else SINGLE
    mesh = Mesh(vertices, FACES, normals, colors, "m", "gouraud")
    scene = clrt.Scene(
        clrt.Camera((0, 0, 3), (0, 0, 0)), [clrt.Light((1, 2, 3))], {"m": clrt.Material()},
        meshes=[mesh],
    )  # fmt: skip
    clrt.save_scene(tmp_path / "a.toml", scene)
    names = sorted(path.name for path in tmp_path.iterdir())
    assert names == (["a.toml"] if kind == "odd" else ["a.0.ply", "a.toml"])
    (found,) = clrt.load_scene(tmp_path / "a.toml").meshes
    assert found == mesh
    if kind != "odd":
        assert found.vertices.dtype == vertices.dtype
