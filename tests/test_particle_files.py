"""Files of particles: each format read back, and frames found again."""

import gzip
import os
from collections.abc import Callable, Iterable
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from conftest import same

import clrt
from clrt.files.particles import lammps, text, xyz
from clrt.files.particles.reader import READERS, Reader
from clrt.files.particles.suffix import FORMATS, format_of, is_particles
from clrt.film import color

N = 50
RANDOM = np.random.default_rng(1)
POSITIONS = RANDOM.normal(size=(N, 3)) * 10.0 ** RANDOM.integers(-20, 20, (N, 1))
RADII = RANDOM.uniform(0.1, 1, N)
COLORS = RANDOM.integers(0, 256, (N, 3), np.uint8)
SPEED = RANDOM.normal(size=N)
CELL, ORIGIN = np.array([[9.1, 0, 0], [1.2, 8.5, 0], [-0.3, 0.7, 7.25]]), np.array([0.1, -2, 3])
ROWS = [
    (*position, radius, *color, speed)
    for position, radius, color, speed in zip(
        POSITIONS.tolist(), RADII.tolist(), COLORS.tolist(), SPEED.tolist(), strict=True
    )
]


def lines(*row: Iterable[object]) -> str:
    return "".join(" ".join(map(repr, one)) + "\n" for one in row)


def write_npz(path: Path) -> None:
    np.savez(path, positions=POSITIONS, radii=RADII, colors=COLORS, speed=SPEED, cell=CELL,
             origin=ORIGIN)  # fmt: skip


def write_csv(path: Path) -> None:
    head = "x,y,z,radius,red,green,blue,speed\n"
    path.write_text(head + lines(*ROWS).replace(" ", ","))


PLY = """ply
format {form} 1.0
comment made by a test
element vertex 50
property double x
property double y
property double z
property double radius
property uchar red
property uint8 green
property uchar blue
property double speed
element face 1
property list uchar int vertex_indices
end_header
"""


def write_ascii_ply(path: Path) -> None:
    path.write_text(PLY.format(form="ascii") + lines(*ROWS) + "3 0 1 2\n")


def write_binary_ply(path: Path, form: str = "little", order: str = "<") -> None:
    kinds = [f"{order}f8"] * 4 + ["u1"] * 3 + [f"{order}f8"]
    rows = np.array(ROWS, np.dtype([(f"{i}", kind) for i, kind in enumerate(kinds)]))
    head = PLY.format(form=f"binary_{form}_endian")
    path.write_bytes(head.encode() + rows.tobytes() + b"\3" + bytes(12))


def write_big_ply(path: Path) -> None:
    write_binary_ply(path, "big", ">")


def numbers(array: np.ndarray) -> str:
    return " ".join(map(repr, array.ravel().tolist()))


def write_xyz(path: Path) -> None:
    head = (
        f'{N}\nLattice="{numbers(CELL)}" Origin="{numbers(ORIGIN)}" pbc="T F T" time=1.5 '
        "Properties=pos:R:3:radius:R:1:color:R:3:speed:R:1\n"
    )
    rows = [(*row[:4], *(c / 255 for c in row[4:7]), row[7]) for row in ROWS]
    path.write_text(head + lines(*rows))


def write_dump(path: Path) -> None:
    head = f"ITEM: TIMESTEP\n7\nITEM: NUMBER OF ATOMS\n{N}\nITEM: BOX BOUNDS abc origin pp pp pp\n"
    box = lines(*np.column_stack([CELL, ORIGIN]).tolist())
    names = "ITEM: ATOMS x y z radius red green blue speed \n"
    path.write_text(head + box + names + lines(*ROWS))


ROUTES: list[tuple[str, Callable[[Path], None]]] = [
    ("a.npz", write_npz),
    ("a.csv", write_csv),
    ("a.ply", write_ascii_ply),
    ("b.ply", write_binary_ply),
    ("c.ply", write_big_ply),
    ("a.xyz", write_xyz),
    ("a.EXTXYZ", write_xyz),
    ("a.dump", write_dump),
    ("a.lammpstrj", write_dump),
]


@pytest.mark.parametrize("packed", ["", ".gz"])
@pytest.mark.parametrize(("name", "write"), ROUTES, ids=[name for name, _ in ROUTES])
def test_every_route_gives_the_same_bits(
    tmp_path: Path, name: str, write: Callable[[Path], None], packed: str
) -> None:
    """Text has 17 digits, so that nothing is lost."""
    path = tmp_path / name
    write(path)
    if packed:
        (tmp_path / f"{name}.gz").write_bytes(gzip.compress(path.read_bytes()))
        path = tmp_path / f"{name}.gz"
    assert is_particles(path)
    found = clrt.read(path)
    assert (found.positions == POSITIONS).all()
    assert same(found.radii, RADII)
    assert found.colors is not None
    assert same(color.linear(found.colors), color.linear(COLORS))
    assert found.values.keys() == {"speed"}
    assert (found.values["speed"] == SPEED).all()
    if name[-3:] in ("csv", "ply"):
        assert found.cell is None
        assert (found.origin == 0).all()
    else:
        assert same(found.cell, CELL)
        assert (found.origin == ORIGIN).all()
    (only,) = clrt.read_frames(path)
    assert (only.positions == POSITIONS).all()


def test_npy(tmp_path: Path) -> None:
    np.save(tmp_path / "three.npy", POSITIONS.astype(np.float32))
    np.save(tmp_path / "four.npy", np.column_stack([POSITIONS, RADII]))
    three, four = clrt.read(tmp_path / "three.npy"), clrt.read(str(tmp_path / "four.npy"))
    packed = tmp_path / "three.npy.gz"
    packed.write_bytes(gzip.compress((tmp_path / "three.npy").read_bytes()))
    for one in (three, clrt.read(packed)):
        assert (one.positions == POSITIONS.astype(np.float32)).all()
    assert three.positions.dtype == np.float32
    assert three.radii is None
    assert (four.positions == POSITIONS).all()
    assert same(four.radii, RADII)


def test_npz_keys(tmp_path: Path) -> None:
    path = tmp_path / "a.npz"
    np.savez(path, pos=POSITIONS, r=2.0, elements=["C"] * N, cell=[1, 2, 3], box=np.eye(4))
    with pytest.warns(clrt.ParticleWarning, match="a.npz: box: is not used"):
        found = clrt.read(path)
    assert same(found.radii, 2)
    assert same(found.elements, 6)
    assert same(found.cell, np.diag([1, 2, 3]))


@pytest.mark.parametrize(
    "content",
    [
        "x,y,z,radius,kind\n1,2,3,0.5,7\n4,5,6,0.25,8\n",
        "\ufeffx,y,z,radius,kind\r\n1,2,3,0.5,7\r\n4,5,6,0.25,8",
        "# made by hand\n\n x ; y;z;radius; kind\n1; 2;3;0.5;7\n\n# half way\n4;5;6;0.25;8\n\n",
        '"x","y","z","radius","kind"\n1,2,3,0.5,"7"\n4,5,6,"0.25",8\n',
        "x\ty\tz\tradius\tkind\n1\t2\t3\t0.5\t7\n4\t5\t6\t0.25\t8\n",
        "x y z radius kind\n1 2 3 0.5 7\n4  5 6 .25 8\n",
        "# x y z radius kind\n1.0e+00 2 3 0.5 7\n4 5 6 0.25 8\n",
        ",x,y,z,radius,kind\n0,1,2,3,0.5,7\n1,4,5,6,0.25,8\n",
    ],
)
def test_csv(tmp_path: Path, content: str) -> None:
    path = tmp_path / "a.csv"
    path.write_bytes(content.encode())
    found = clrt.read(path)
    assert (found.positions == [[1, 2, 3], [4, 5, 6]]).all()
    assert same(found.radii, [0.5, 0.25])
    assert found.values.keys() == {"kind"}
    assert (found.values["kind"] == [7, 8]).all()


def test_csv_without_a_header(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("1,2,3\n4,5,6\n")
    assert (clrt.read(path).positions == [[1, 2, 3], [4, 5, 6]]).all()
    path.write_text("1 2 3 0.5\n")
    assert same(clrt.read(path).radii, [0.5])
    for empty in ("x,y,z\n", "# x,y,z\n", "x,y,z\n\n# nothing\n"):
        path.write_text(empty)
        assert len(clrt.read(path)) == 0


def test_csv_with_names(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("name,x,y,z,element\nleft,0,0,0,C\nright,1,0,0,Cl\n")
    found = clrt.read(path)
    assert same(found.elements, [6, 17])
    long = "a name that is much longer than eight bytes"
    path.write_text(f"type,x,y,z\n{long},0,0,0\n{long[:8]},0,0,0\n")
    found = clrt.read(path)
    assert found.type_names == (long[:8], long)
    assert same(found.types, [1, 0])


@pytest.mark.parametrize("ends", ["\n", "\r\n"])
def test_plain_xyz(tmp_path: Path, ends: str) -> None:
    path = tmp_path / "a.xyz"
    content = (
        "3\nwater = H2O\nO 0 0 0\nH 1 0 0\nH 0 1e0 0\n"
        "\n2\n\n1 0 0 0\n2 0 0 1\n\n\n1\n\n.5 .5 .5\n\n"
    )
    path.write_bytes(content.replace("\n", ends).encode())
    first, second, third = clrt.read_frames(path)
    assert same(first.elements, [8, 1, 1])
    assert (first.positions == [[0, 0, 0], [1, 0, 0], [0, 1, 0]]).all()
    assert same(second.types, [1, 2])
    assert second.elements is None
    assert (third.positions == 0.5).all()
    assert third.types is None


def test_xyz_columns(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text(
        "2\nProperties=species:S:1:pos:R:3:Z:I:1:forces:R:3:tags:I:2:fixed:L:1 "
        "Lattice='5 0 0 0 6 0 0 0 7'\n"
        "Bead 1 2 3 6 7 8 9 10 11 T\nBead 1 2 3 8 7 8 9 10 11 F\n"
    )
    found = clrt.read(path)
    assert same(found.elements, [6, 8])
    names = ["forces_x", "forces_y", "forces_z", "tags_1", "tags_2"]
    assert list(found.values) == [*names, "fixed"]
    assert found.values["fixed"].tolist() == [True, False]
    assert [found.values[name][1] for name in names] == [7, 8, 9, 10, 11]
    assert same(found.cell, np.diag([5, 6, 7]))
    path.write_text("1\nplain\nH 1 2 3 4.5 free\n")
    found = clrt.read(path)
    assert found.values["column5"] == [4.5]
    assert found.texts["column6"].tolist() == ["free"]


BOX = "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS {}\nITEM: ATOMS id type {}\n"
ORTHOGONAL = "pp pp pp\n-1 3\n0 6\n2 4"
TILTED = "xy xz yz pp pp pp\n-1 13 2\n0 12 1\n0 10 0.5"


@pytest.mark.parametrize("name", ["a.xyz", "a.dump"])
def test_no_particles(tmp_path: Path, name: str) -> None:
    path = tmp_path / name
    dump = BOX.replace("\n2\n", "\n0\n").format(ORTHOGONAL, "x y z")
    path.write_text("0\n\n" * 2 if name == "a.xyz" else dump * 2)
    assert [len(found) for found in clrt.read_frames(path)] == [0, 0]


@pytest.mark.parametrize(
    ("box", "names", "cell", "origin", "second"),
    [
        (ORTHOGONAL, "x y z", np.diag([4, 6, 2]), [-1, 0, 2], [0.5, 0.25, 1]),
        (ORTHOGONAL, "xu yu zu", np.diag([4, 6, 2]), [-1, 0, 2], [0.5, 0.25, 1]),
        (ORTHOGONAL, "xs ys zs", np.diag([4, 6, 2]), [-1, 0, 2], [1, 1.5, 4]),
        (ORTHOGONAL, "xsu ysu zsu", np.diag([4, 6, 2]), [-1, 0, 2], [1, 1.5, 4]),
        # The bounds hold the tilted box: x from -1 to 13 - (2 + 1), y to 12 - 0.5.
        (
            TILTED,
            "xs ys zs",
            [[11, 0, 0], [2, 11.5, 0], [1, 0.5, 10]],
            [-1, 0, 0],
            [-1 + 5.5 + 0.5 + 1, 2.875 + 0.5, 10],
        ),
    ],
)
def test_boxes_and_coordinates(
    tmp_path: Path, box: str, names: str, cell: list, origin: list, second: list
) -> None:
    path = tmp_path / "a.dump"
    path.write_text(BOX.format(box, names) + "1 1 0 0 0\n2 2 0.5 0.25 1\n")
    found = clrt.read(path)
    assert same(found.cell, cell)
    assert (found.origin == origin).all()
    assert found.positions[1] == pytest.approx(second, abs=1e-14)
    assert same(found.types, [1, 2])
    assert (found.values["id"] == [1, 2]).all()


def test_a_box_tilted_to_the_left(tmp_path: Path) -> None:
    """Corners of the cell, from LAMMPS's own formula, lie on its bounds."""
    path = tmp_path / "a.dump"
    path.write_text(BOX.format("xy xz yz\n-4 9 -2\n-1 7 -1\n0 5 -1", "x y z") + "1 1 0 0 0\n" * 2)
    found = clrt.read(path)
    assert found.cell is not None
    places = np.array([(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)])
    corners = found.origin + places @ found.cell
    assert (corners.min(axis=0) == [-4, -1, 0]).all()
    assert (corners.max(axis=0) == [9, 7, 5]).all()


def test_dump_columns(tmp_path: Path) -> None:
    path = tmp_path / "a.dump"
    path.write_text(
        "ITEM: UNITS\nmetal\nITEM: TIME\n0.5\n"
        + BOX.format(ORTHOGONAL, "element x y z xs ys zs diameter c_pe[1]")
        + "1 1 C 0 0 0 0 0 0 3 -1e-3\n2 1 Cl 1 1 1 0 0 0 4 nan\n"
    )
    found = clrt.read(path)
    assert same(found.elements, [6, 17])
    assert same(found.radii, [1.5, 2])
    assert list(found.values) == ["id", "xs", "ys", "zs", "c_pe[1]"]
    assert np.isnan(found.values["c_pe[1]"][1])


def test_ase_reads_the_same(tmp_path: Path) -> None:
    io = pytest.importorskip("ase.io")
    path = tmp_path / "a.dump"
    rows = "".join(f"{i + 1} {1 + i % 3} {x!r} {y!r} {z!r}\n" for i, (x, y, z) in
                   enumerate(RANDOM.uniform(size=(20, 3)).tolist()))  # fmt: skip
    path.write_text(BOX.replace("\n2\n", "\n20\n").format(TILTED, "xs ys zs") + rows)
    theirs, ours = io.read(path, format="lammps-dump-text"), clrt.read(path)
    assert abs(theirs.cell - ours.cell).max() < 1e-12
    moved = theirs.positions + theirs.get_celldisp().T  # they begin at the cell's corner
    assert abs(moved - ours.positions).max() < 1e-12
    theirs.numbers[:] = RANDOM.integers(1, 90, 20)
    theirs.set_array("speed", RANDOM.normal(size=20))
    io.write(tmp_path / "a.extxyz", [theirs, theirs], format="extxyz")
    again, ours = io.read(tmp_path / "a.extxyz"), clrt.read(tmp_path / "a.extxyz", frame=1)
    assert (again.positions == ours.positions).all()
    assert (again.numbers == ours.elements).all()
    assert (again.arrays["speed"] == ours.values["speed"]).all()
    assert (again.cell == ours.cell).all()


PDB = """\
CRYST1   10.000   11.000   12.000  90.00  90.00 120.00 P 1           1
MODEL        1
ATOM      1  N   ALA A   1      11.104   6.134  -6.504  1.00 10.00           N
ATOM      2  CA  ALA A   1      11.639   6.071  -5.147  1.00 20.00           C
HETATM    3 NA    NA A   2      12.639   6.071  -5.147  0.50 30.00          NA
HETATM    4  D1  DOD A   3      12.639   7.071  -5.147  1.00 30.00           D
ENDMDL
MODEL        2
ATOM      1  N   ALA A   1       1.500   6.134  -6.504  1.00 10.00           N
ENDMDL
END
"""


def test_pdb(tmp_path: Path) -> None:
    for path in (tmp_path / "a.pdb", tmp_path / "a.pdb.gz"):
        packed = gzip.compress(PDB.encode())
        path.write_bytes(packed if path.suffix == ".gz" else PDB.encode())
        first, second = clrt.read_frames(path)
        assert same(first.elements, [7, 6, 11, 1])
        assert (first.positions[1] == [11.639, 6.071, -5.147]).all()
        assert (first.values["b_factor"] == [10, 20, 30, 30]).all()
        assert first.values["occupancy"][2] == 0.5
        expected = [[10, 0, 0], [-5.5, 11 * 0.75**0.5, 0], [0, 0, 12]]
        assert first.cell == pytest.approx(np.array(expected), abs=1e-12)
        assert (second.positions == [[1.5, 6.134, -6.504]]).all()
        assert (clrt.read(path, frame=1).positions == second.positions).all()


SALT = """\
data_salt
_cell_length_a 5.6
_cell_length_b 5.6
_cell_length_c 5.6
_cell_angle_alpha 90
_cell_angle_beta 90
_cell_angle_gamma 90
_space_group_name_H-M_alt "F m -3 m"
loop_
_atom_site_label
_atom_site_type_symbol
_atom_site_fract_x
_atom_site_fract_y
_atom_site_fract_z
Na1 Na 0 0 0
Cl1 Cl 0.5 0.5 0.5
"""


def test_cif_of_a_crystal_is_its_unit_cell(tmp_path: Path) -> None:
    path = tmp_path / "salt.cif"
    path.write_text(SALT)
    found = clrt.read(path)
    assert sorted(np.asarray(found.elements)) == [11] * 4 + [17] * 4
    places = {tuple(place) for place in np.rint(found.positions / 2.8).astype(int).tolist()}
    assert places == {(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)}
    sums = np.rint(found.positions / 2.8).sum(axis=1)
    assert ((sums % 2 == 0) == (found.elements == 11)).all()
    assert same(found.cell, np.diag([5.6] * 3))


def test_gsd(tmp_path: Path) -> None:
    hoomd = pytest.importorskip("gsd.hoomd")
    frame = hoomd.Frame()
    frame.particles.N = 3
    frame.particles.position = POSITIONS[:3]
    frame.particles.diameter = [1, 2, 3]
    frame.particles.types = ["colloid", "A"]
    frame.particles.typeid = [0, 1, 0]
    frame.particles.velocity = [[1, 0, 0], [0, 2, 0], [0, 0, 3]]
    frame.configuration.box = [4, 5, 6, 0.5, 0.25, -0.5]
    frame.log["particles/energy"] = [7, 8, 9]
    path = tmp_path / "a.gsd"
    with hoomd.open(path, "w") as file:
        file.append(frame)
        frame.particles.position = 2 * POSITIONS[:3]
        file.append(frame)
    found, second = clrt.read_frames(path)
    for one in (found, clrt.read(frame)):
        assert same(one.radii, [0.5, 1, 1.5])
        assert one.type_names == ("colloid", "A")
        assert same(one.types, [0, 1, 0])
        assert one.elements is None
        assert same(one.cell, np.array([[4, 0, 0], [2.5, 5, 0], [1.5, -3, 6]]))
        assert (one.origin == [-4, -1, -3]).all()
        assert (one.values["energy"] == [7, 8, 9]).all()
        assert (one.values["vy"] == [0, 2, 0]).all()
    assert (found.positions == POSITIONS[:3].astype(np.float32)).all()
    assert (second.positions == 2 * found.positions).all()
    assert (clrt.read(path, frame=1).positions == second.positions).all()


def test_extxyz_reads_the_same_bits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The extra clrt[fast], on frames that our own reader would have read."""
    pytest.importorskip("extxyz")
    monkeypatch.setattr(xyz, "FAST_FROM", 1)
    path = tmp_path / "a.xyz"
    write_xyz(path)
    head = 'odd = "comment\n'
    rows = [f"{name} {x!r} {y!r} {z!r} {i * 10**10}\n" for i, (name, (x, y, z)) in
            enumerate(zip(["H", "Cl"] * 25, POSITIONS.tolist(), strict=True))]  # fmt: skip
    with path.open("a", newline="\r\n") as file:
        file.write(f"\n\n{N}\n{head}{''.join(rows)}{N}\n\n{''.join(rows)}")
    calls = []
    monkeypatch.setattr(xyz, "table", lambda *_: calls.append(1))
    fast = list(clrt.read_frames(path))
    assert not calls
    monkeypatch.setattr(xyz, "table", text.table)
    monkeypatch.setattr(xyz, "FAST_FROM", 10**9)
    for mine, theirs in zip(clrt.read_frames(path), fast, strict=True):
        assert (mine.positions == theirs.positions).all()
        assert mine.values.keys() == theirs.values.keys()
        for name, column in mine.values.items():
            assert (column == theirs.values[name]).all()
        for key in ("elements", "radii", "colors"):
            first, second = getattr(mine, key), getattr(theirs, key)
            assert (first is None and second is None) or (first == second).all()
    assert (fast[1].values["column5"] == np.arange(N) * 10.0**10).all()


def test_what_extxyz_refuses_is_read_or_refused_by_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("extxyz")
    monkeypatch.setattr(xyz, "FAST_FROM", 1)
    path = tmp_path / "a.xyz"
    path.write_text("2\nProperties=pos:R:3:v:R:1\n0 0 0 nan\n1 1 1 inf\n")
    assert np.isnan(clrt.read(path).values["v"][0])
    for rows, said in [
        ("0 0 0\n1 1 1 2\n", "line 3: expected 4 columns"),
        ("0 0 0 1\n1 1 1 x\n", "line 4: expected a number as v, got 'x'"),
        ("0 0 0 1\n", "expected 2 particles from line 3 on, the file ends after line 3"),
    ]:
        path.write_text("2\nProperties=pos:R:3:v:R:1\n" + rows)
        with pytest.raises(clrt.SceneError, match=said):
            clrt.read(path)
    path.write_text("1\n\nH 0 0 0\n\n1\n\nH 0 0 x\n")
    with pytest.raises(clrt.SceneError, match="line 7: expected a number as z, got 'x'"):
        list(clrt.read_frames(path))


@pytest.fixture
def flow(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, list[int]]:
    """A dump of six frames, and a list of the lines where frames were skipped."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    path = tmp_path / "flow.dump"
    frame = BOX.format(ORTHOGONAL, "x y z") + "1 1 {k} 0 0\n2 2 1 1 1\n"
    path.write_text("".join(frame.format(k=k) for k in range(6)))
    skipped: list[int] = []
    skip = lammps.skip

    def counted(lines: text.Lines) -> None:
        skipped.append(lines.number)
        skip(lines)

    monkeypatch.setattr(lammps, "skip", counted)
    return path, skipped


def at(path: Path, k: int) -> float:
    return float(clrt.read(path, frame=k).positions[0, 0])


def test_a_frame_is_found_and_found_again(flow: tuple[Path, list[int]]) -> None:
    path, skipped = flow
    assert at(path, 0) == 0
    assert not (path.parent / "cache").exists()  # one frame costs nothing
    assert at(path, 3) == 3
    assert skipped == [0, 11, 22]
    assert [at(path, k) for k in (3, 2, 4, 1)] == [3, 2, 4, 1]  # where 4 begins was seen after 3
    assert skipped == [0, 11, 22]
    assert [at(path, k) for k in (5, 5)] == [5, 5]
    assert skipped == [0, 11, 22]
    with Reader(path) as file:
        assert file.count() == 6
        last = file.frame(5)
        assert last is not None
        assert last.positions[0, 0] == 5
        assert file.frame(6) is None
    assert len(skipped) == 3


def test_frames_in_turn_skip_nothing(flow: tuple[Path, list[int]]) -> None:
    path, skipped = flow
    assert [found.positions[0, 0] for found in clrt.read_frames(path)] == list(range(6))
    assert at(path, 5) == 5
    assert not skipped


def test_what_was_found_is_not_forgotten(flow: tuple[Path, list[int]]) -> None:
    path, skipped = flow
    assert at(path, 5) == 5
    assert len(list(islice(clrt.read_frames(path), 3))) == 3
    assert len(skipped) == 5
    assert at(path, 5) == 5
    assert len(skipped) == 5


def test_more_is_kept_than_was_known(flow: tuple[Path, list[int]]) -> None:
    path, skipped = flow
    assert at(path, 2) == 2
    assert len(list(islice(clrt.read_frames(path), 5))) == 5
    assert at(path, 5) == 5
    assert len(skipped) == 2


def test_a_file_that_changed_is_read_anew(flow: tuple[Path, list[int]]) -> None:
    path, skipped = flow
    assert at(path, 3) == 3
    path.write_text(path.read_text().replace("1 1 3 0 0", "1 1 33.5 0 0"))
    assert at(path, 3) == 33.5
    assert len(skipped) == 6


@pytest.mark.parametrize("spoilt", [b"", b"x" * 100])
def test_a_spoilt_cache_does_no_harm(flow: tuple[Path, list[int]], spoilt: bytes) -> None:
    path, skipped = flow
    assert at(path, 3) == 3
    for kept in (path.parent / "cache" / "clrt").iterdir():
        kept.write_bytes(spoilt)
    assert at(path, 3) == 3
    assert len(skipped) == 6


def test_no_cache_does_no_harm(flow: tuple[Path, list[int]], monkeypatch) -> None:
    path, skipped = flow
    monkeypatch.setenv("XDG_CACHE_HOME", "/proc/none")
    monkeypatch.setattr("tempfile.gettempdir", lambda: "/proc/none")
    assert [at(path, 3), at(path, 3)] == [3, 3]
    assert len(skipped) == 6


def test_blank_lines_are_the_same_to_reading_and_skipping(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text("\n1\n\n0 0 0\n\n \n1\n\n1 1 1\n\n")
    assert [at(path, k) for k in (1, 0)] == [1, 0]
    path.write_text("1\n\n\n0 0 0\n1\n\n1 1 1\n")
    for k in (0, 1):
        with pytest.raises(clrt.SceneError):
            clrt.read(path, frame=k)


def test_frames_that_are_not_there(flow: tuple[Path, list[int]]) -> None:
    path, _ = flow
    with pytest.raises(clrt.RequestError, match=r"flow.dump: expected a frame from 0 to 5, got 6"):
        clrt.read(path, frame=6)
    for wrong in (1.0, "0", None):
        with pytest.raises(clrt.RequestError, match="frame: expected a whole number, got"):
            clrt.read(path, frame=wrong)  # type: ignore[arg-type]


def test_a_packed_trajectory(flow: tuple[Path, list[int]]) -> None:
    path, _ = flow
    packed = path.with_name("flow.dump.gz")
    packed.write_bytes(gzip.compress(path.read_bytes()))
    assert [at(packed, k) for k in (4, 5, 1, 4)] == [4, 5, 1, 4]


def test_a_file_is_closed(flow: tuple[Path, list[int]]) -> None:
    path, _ = flow
    before = len(os.listdir("/proc/self/fd"))
    clrt.read(path)
    next(clrt.read_frames(path)).positions.sum()
    with pytest.raises(clrt.RequestError):
        clrt.read(path, frame=9)
    assert len(os.listdir("/proc/self/fd")) == before


def test_every_suffix_is_tried() -> None:
    tried = {format_of(Path(name)) for name, _ in ROUTES}
    elsewhere = {"npy", "pdb", "cif", "gsd", "data", "vtk", "gro", "poscar"}
    assert tried | elsewhere == set(READERS) == set(FORMATS)


@pytest.mark.parametrize(
    ("shape", "radius", "said"),
    [
        ({"type": "Sphere", "diameter": 3.0}, 1.5, None),
        ({"type": "Ellipsoid", "a": 1.0, "b": 2.0, "c": 0.5}, 2, "Ellipsoid: are drawn as the"),
        ({"type": "ConvexPolyhedron", "rounding_radius": 0.5,
          "vertices": [[3, 4, 0], [0, 0, 1]]}, 5.5, "ConvexPolyhedron: are drawn as the spheres"),
        ({"type": "SphereUnion", "diameters": [2, 1], "centers": [[2, 0, 0], [0, 0, 0]]}, 3,
         "SphereUnion: are drawn as the spheres"),
        ({"type": "Blob"}, 0.5, "Blob (unknown: spheres of the diameters)"),
    ],
)  # fmt: skip
def test_shapes_of_gsd(shape: dict[str, object], radius: float, said: str | None) -> None:
    hoomd = pytest.importorskip("gsd.hoomd")
    frame = hoomd.Frame()
    frame.particles.N = 2
    frame.particles.position = POSITIONS[:2]
    frame.particles.types = ["a", "b"]
    frame.particles.typeid = [0, 1]
    frame.particles.type_shapes = [shape, {}]
    frame.validate()
    if said is None:
        found = clrt.read(frame)
    else:
        with pytest.warns(clrt.ParticleWarning) as caught:
            found = clrt.read(frame)
        assert said in str(caught[0].message)
    assert same(found.radii, [radius, 0.5])


DUMP = """ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
1
ITEM: BOX BOUNDS {}
0 9
0 9
0 9
ITEM: ATOMS x y z
1 2 3
"""


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("a.xyz", '1\nLattice="1 0 0 0 1 0 0 0 1" pbc="T F T"\nH 0 0 0\n'),
        ("a.dump", DUMP.format("pp fs pp")),
        ("a.lammpstrj", DUMP.format("xy xz yz pp mm pp").replace("0 9", "0 9 0")),
    ],
)
def test_boxes_that_are_not_periodic(name: str, text: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text)
    assert clrt.read(tmp_path / name).periodic == (True, False, True)
