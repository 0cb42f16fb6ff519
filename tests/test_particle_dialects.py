"""Dialects of text files of particles: what programs and people write, and its values."""

import warnings
from pathlib import Path

import numpy as np
import pytest
from conftest import same

import clrt

TWO = [[0.5, 0.1, 0.2], [3.5, 0.1, 0.2]]


def read(path: Path, content: str | bytes) -> tuple[clrt.Particles, list[str]]:
    """Particles of a file with this content, and what is said of them."""
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = clrt.read(path)
    return found, [str(one.message).removeprefix(f"{path}: ") for one in caught]


@pytest.mark.parametrize(
    "text",
    [
        '"Points:0","Points:1","Points:2","radius"\n0.5,0.1,0.2,1\n3.5,0.1,0.2,1\n',
        '"radius","Points_0","Points_1","Points_2"\n1,0.5,0.1,0.2\n1,3.5,0.1,0.2\n',
        "x;y;z;radius\n0,5;0,1;0,2;1,0\n3,5;0,1;0,2;1,0\n",
        "x\ty\tz\tradius\n0,5\t0,1\t0,2\t1\n3,5\t0,1\t0,2\t1\n",
        "0,5;0,1;0,2;1\n3,5;0,1;0,2;1\n",
        "sep=;\nx;y;z;radius\n0.5;0.1;0.2;1\n3.5;0.1;0.2;1\n",
        "x|y|z|radius\n0.5|0.1|0.2|1\n3.5|0.1|0.2|1\n",
        "x,y,z,radius,\n0.5,0.1,0.2,1,\n3.5,0.1,0.2,1,\n",
        "x,y,z,radius\n0.5,0.1,0.2,1,\n3.5,0.1,0.2,1,\n",
        "x,y,z,radius,\n0.5,0.1,0.2,1\n3.5,0.1,0.2,1\n",
        "\ufeffx,y,z,radius\r\n0.5,0.1,0.2,1\r\n3.5,0.1,0.2,1\r\n",
        "\ufeff0.5,0.1,0.2,1\n3.5,0.1,0.2,1\n",
        "x y z radius\n0.5 0.1 0.2 1\n3.5 0.1 0.2 1\n",
        "  x  y  z  r\n 0.05D+01 .1D0 2.D-1 1.0D0\n3.5 0.1 0.2 1\n",
        "x,y,z,radius\n0.05D+01,.1d0,2.D-1,1.0D0\n3.5,0.1,0.2,1\n",
    ],
)
def test_one_table_in_many_dialects(tmp_path: Path, text: str) -> None:
    for content in (text, text.lstrip("\ufeff").encode("utf-16")):
        found, said = read(tmp_path / "a.csv", content)
        assert np.allclose(found.positions, TWO, rtol=1e-15, atol=0)
        assert same(found.radii, [1, 1])
        assert found.values == {}
        assert found.texts == {}
        assert said == []


def test_what_is_in_cells(tmp_path: Path) -> None:
    text = (
        "id,x,y,z,temp,kind,mixed,T\n1,0,0,0,1,sand,1,5\n"
        "2,3,0,0,,clay,b,NA\n# no row\n3,1,1,1,2,,3,n/a\n"
    )
    found, said = read(tmp_path / "a.csv", text)
    assert np.array_equal(found.values["temp"], [1, np.nan, 2], equal_nan=True)
    assert np.array_equal(found.values["T"], [5, np.nan, np.nan], equal_nan=True)
    assert found.texts["kind"].tolist() == ["sand", "clay", ""]
    assert found.texts["mixed"].tolist() == ["1", "b", "3"]
    assert found.values.keys() == {"id", "temp", "T"}
    assert said == []


def test_a_position_that_is_blank_is_left_out(tmp_path: Path) -> None:
    found, said = read(tmp_path / "a.csv", "x,y,z\n0,0,0\n1,,1\n2,2,2\n")
    assert found.positions.tolist() == [[0, 0, 0], [2, 2, 2]]
    assert said == ["1 of 3 particles are left out: no finite position"]


def test_a_delimiter_in_a_header(tmp_path: Path) -> None:
    found, _ = read(tmp_path / "a.csv", "x;y;z;T, K\n0;0;0;1\n3;0;0;2\n")
    assert found.values["T, K"].tolist() == [1, 2]
    found, _ = read(tmp_path / "a.csv", 'x,y,z,"T, K"\n0,0,0,1\n3,0,0,2\n')
    assert found.values["T, K"].tolist() == [1, 2]


def test_units(tmp_path: Path) -> None:
    found, _ = read(tmp_path / "a.csv", "X (nm),Y (nm),Z (nm),Radius (nm)\n0,0,0,1\n3,0,0,2\n")
    assert found.unit == "nm"
    assert same(found.radii, [1, 2])


def test_many_rows_of_a_slow_dialect(tmp_path: Path) -> None:
    """More than one chunk of them, the last with text where others have numbers."""
    rows = [f"{i},5;0;{i};{i}" for i in range(70_000)]
    text = "x;y;z;label\n" + "\n".join(rows) + "\n1,5;2;3;last\n"
    found, _ = read(tmp_path / "a.csv", text)
    assert same(found.positions[:-1, 0], np.arange(70_000) + 0.5)
    assert found.texts["label"][[0, 69_999, 70_000]].tolist() == ["0", "69999", "last"]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("x;y;z\n0,5;0;0\n0,5;a;0\n", "line 3: expected a number as y, got 'a'"),
        ("x;y;z\n0,5;0;0\n0,5;0\n", "line 3: expected 3 columns ('x', 'y', 'z'), got '0,5;0'"),
        ("x,y,z,radius\n0,0,0,1\n1,1,1,big\n", "line 3: expected a number as radius, got 'big'"),
        ("x;y;z;r\n0,5;0;0;1\n\n0,5;0;0;-1\n", "line 4: radii: expected a finite number above 0"),
    ],
)
def test_wrong_cells_are_named(tmp_path: Path, text: str, said: str) -> None:
    path = tmp_path / "a.csv"
    path.write_text(text)
    with pytest.raises(clrt.SceneError) as caught:
        clrt.read(path)
    assert str(caught.value).startswith(f"{path}: {said}")


def test_a_column_named_twice(tmp_path: Path) -> None:
    said = "v: two columns have this name: the first is used"
    found, lines = read(tmp_path / "a.csv", "x,y,z,v,v\n0,0,0,1,2\n1,0,0,3,4\n")
    assert found.values["v"].tolist() == [1, 3]
    assert lines == [said]
    box = "ITEM: BOX BOUNDS pp pp pp\n0 9\n0 9\n0 9\n"
    dump = f"ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n1\n{box}ITEM: ATOMS x y z v v\n1 2 3 4 5\n"
    found, lines = read(tmp_path / "a.dump", dump)
    assert found.values["v"].tolist() == [4]
    assert lines == [said]
    text = "1\nProperties=pos:R:3:v:R:1:v:R:2\n1 2 3 4 5 6\n"
    found, lines = read(tmp_path / "a.xyz", text)
    assert found.values["v"].tolist() == [4]
    assert list(found.values) == ["v"]
    assert lines == [said]


def test_dumps_of_other_programs(tmp_path: Path) -> None:
    head = "ITEM: UNITS\nreal\nITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\n"
    head += "ITEM: BOX BOUNDS pp pp pp\n0 10\n0 20\n-0.5 0.5\n"
    rows = (
        "ITEM: ATOMS type x y z radius ColorR ColorG ColorB\n2 3 0 0 .5 1 0 0\n1 1 2 3 .6 0 .5 1\n"
    )
    found, said = read(tmp_path / "a.dump", head + rows)
    assert same(found.colors, np.array([[1, 0, 0], [0, 0.5, 1]]))
    assert found.unit == "angstrom"
    assert (found.values, said) == ({}, [])
    for names, row in (("x y", "1 5"), ("xs ys", "0.1 0.25")):
        text = head + f"ITEM: ATOMS id {names}\n1 {row}\n2 {row}\n"
        assert read(tmp_path / "a.dump", text)[0].positions[0].tolist() == [1, 5, 0]
    text = head + "ITEM: ATOMS id x y z\n1 -nan nan nan\n2 0.37D-02 1.D+1 3\n"
    found, said = read(tmp_path / "a.dump", text)
    assert found.positions.tolist() == [[0.0037, 10, 3]]
    assert said == ["1 of 2 particles are left out: no finite position"]


def test_points_without_a_count(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    found, _ = read(path, "0.5 1 2\n3 4 5\n")
    assert found.positions.tolist() == [[0.5, 1, 2], [3, 4, 5]]
    found, _ = read(path, "\nC 0 1 2 7\nO 3 4 5 8\n")
    assert same(found.elements, [6, 8])
    assert found.values["column5"].tolist() == [7, 8]
    found, _ = read(path, "0 1 2 10 20 255\n3 4 5 0 1 2\n")
    assert same(found.colors, [[10, 20, 255], [0, 1, 2]])
    found, _ = read(path, "0 1 2 0.5 0.5 0.7\n3 4 5 0 1 2\n")
    assert found.colors is None
    assert list(found.values) == ["column4", "column5", "column6"]
    assert len(list(clrt.read_frames(path))) == 1
    # A count alone is none.
    assert len(read(path, "2\n\n0 1 2\n3 4 5\n")[0]) == 2


def test_xyz_of_fortran_and_truths(tmp_path: Path) -> None:
    text = "2\nProperties=species:S:1:pos:R:3:fixed:L:1:label:S:1\n"
    text += "H 0.37D-02 1 2 T a1\nO 3 -4.D+01 5 F 1.D2\n"
    found, said = read(tmp_path / "a.xyz", text)
    assert found.positions.tolist() == [[0.0037, 1, 2], [3, -40, 5]]
    assert found.values["fixed"].tolist() == [True, False]
    assert found.texts["label"][0] == "a1"
    assert said == []


def ply(rows: int, properties: str, content: str, form: str = "ascii", more: str = "") -> str:
    lines = "".join(f"property {one}\n" for one in properties.split(", "))
    return f"ply\nformat {form} 1.0\nelement vertex {rows}\n{lines}{more}end_header\n{content}"


XYZ = "float x, float y, float z"


def test_ply_colours_and_types(tmp_path: Path) -> None:
    path = tmp_path / "a.ply"
    for kind, row, expected in (
        ("ushort", "65535 0 32768", [1, 0, 32768 / 65535]),
        ("float", "255 0 127.5", [1, 0, 0.5]),
        ("float", "1 0 0.5", [1, 0, 0.5]),
        ("uchar", "255 0 127", [255, 0, 127]),
    ):
        columns = f"{XYZ}, {kind} red, {kind} green, {kind} blue, bool kept"
        found, said = read(path, ply(1, columns, f"1 2 3 {row} 1\n"))
        assert np.allclose(np.asarray(found.colors)[0], expected, rtol=1e-6)
        assert found.values["kept"].tolist() == [1]
        assert said == []
    with pytest.raises(clrt.SceneError, match="line 9: expected red from 0 to 255, got 256"):
        read(path, ply(1, f"{XYZ}, uchar red", "1 2 3 256\n"))
    with pytest.raises(
        clrt.SceneError, match=r"line 7: expected one of the types char .*, got 'rat"
    ):
        read(path, ply(1, f"{XYZ}, rational q", "1 2 3 1\n"))
    found, lines = read(path, ply(1, f"{XYZ}, float v, float v", "1 2 3 4 5\n"))
    assert found.values["v"].tolist() == [4]
    assert lines == ["v: two properties have this name: the first is used"]
    faces = "element face 1\nproperty list uchar int vertex_indices\n"
    lines = read(path, ply(3, XYZ, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", more=faces))[1]
    assert lines == ["element face: is not used: its vertices are drawn"]
    lines = read(path, ply(1, XYZ, "0 0 0\n", more=faces.replace("face 1", "face 0")))[1]
    assert lines == ["element face: has no rows: the vertices are drawn"]


def test_splats(tmp_path: Path) -> None:
    """Positions, radii of 2 exp of the mean scale, colours of the zeroth harmonic, 0.28209."""
    names = [*"xyz", "nx", "ny", "nz", *(f"f_dc_{i}" for i in range(3)), "f_rest_0", "f_rest_1"]
    names.append("opacity")
    names += [f"scale_{i}" for i in range(3)] + [f"rot_{i}" for i in range(4)]
    row = [1, 2, 3, 0, 0, 0, 0, 1, -9, 5, 5, 0, -1, -2, -3, 1, 0, 0, 0]
    rows = np.array([row, row], "<f4")
    rows[1, 0] = 8
    head = ply(2, ", ".join(f"float {name}" for name in names), "", "binary_little_endian")
    found, said = read(tmp_path / "a.ply", head.encode() + rows.tobytes())
    assert found.positions.tolist() == [[1, 2, 3], [8, 2, 3]]
    assert np.allclose(found.radii, 2 * np.exp(-2), rtol=1e-7)  # type: ignore[arg-type]
    expected = [0.5, 0.5 + 0.28209479177387814, 0]
    assert np.allclose(np.asarray(found.colors)[0], expected, rtol=1e-6)
    assert found.values["opacity"].tolist() == [0.5, 0.5]
    assert "f_rest nx ny nz rot" in said[0]
    assert np.asarray(found.opacities).tolist() == [0.5, 0.5]
    assert len(said) == 1
