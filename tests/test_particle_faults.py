"""Files of particles that are wrong: one line with file, line and what was expected."""

import gzip
import io
import os
import tempfile
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import event, given, settings
from hypothesis import strategies as st

import clrt

XYZ = "2\nProperties=species:S:1:pos:R:3:v:R:1\nH 0 0 0 1\nO 1 1 1 2\n"
DUMP = """\
ITEM: TIMESTEP
0
ITEM: NUMBER OF ATOMS
2
ITEM: BOX BOUNDS pp pp pp
0 1
0 1
0 1
ITEM: ATOMS id type x y z radius
1 1 0 0 0 0.5
2 1 1 1 1 0.5
"""
CSV = "x,y,z,radius\n0,0,0,1\n# in between\n\n1,1,1,2\n"
PLY = """\
ply
format ascii 1.0
element vertex 2
property float x
property float y
property float z
property uchar red
property uchar green
property uchar blue
end_header
0 0 0 1 2 3
1 1 1 4 5 6
"""
GOOD = {".xyz": XYZ, ".dump": DUMP, ".csv": CSV, ".ply": PLY}


def fault(path: Path) -> str:
    """What reading it says, which is one line that begins with its name."""
    with pytest.raises((clrt.SceneError, clrt.RequestError)) as caught:
        for _ in clrt.read_frames(path):
            pass
    said = str(caught.value)
    assert said.startswith(f"{path}: ")
    assert said.isprintable()
    assert len(said) < 300
    return said.removeprefix(f"{path}: ")


@pytest.mark.parametrize(
    ("suffix", "old", "new", "said"),
    [
        # Cut files.
        (".xyz", "O 1 1 1 2\n", "", "expected 2 particles from line 3 on, the file ends after lin"),
        (".xyz", XYZ[2:], "", "line 1: expected a number of particles that the file has room for,"),
        (".xyz", XYZ, "", "expected a number of particles, the file ends at once"),
        (".xyz", XYZ, "\n\n", "expected a number of particles, the file ends after line 2"),
        (".xyz", "1 1 1 2\n", "1 1 1", "line 4: expected 5 columns ('species', 'pos', 'pos', 'pos"),
        (".dump", "2 1 1 1 1 0.5\n", "", "expected 2 particles from line 10 on, the file ends aft"),
        (".dump", DUMP[60:], "", "expected 2 numbers of the box, the file ends after line 5"),
        (".dump", "0 1\nITEM: ATOMS", "ITEM: ATOMS", "line 8: expected 2 numbers of the box, got "),
        (".dump", DUMP, "", "expected 'ITEM: ...', the file ends at once"),
        (".csv", CSV, "", "expected a header that names x, y and z, the file ends at once"),
        (".csv", CSV, "\n\n", "expected a header that names x, y and z, the file ends after line "),
        (".csv", "1,1,1,2", "1,1", "line 5: expected 4 columns ('x', 'y', 'z', 'radius'), got '1,"),
        (".ply", "1 1 1 4 5 6\n", "", "expected 2 particles from line 11 on, the file ends after "),
        (".ply", "end_header\n0 0 0 1 2 3\n1 1 1 4 5 6\n", "", "expected a line of a PLY header, "),
        (".ply", PLY, "", "expected 'ply', the file ends at once"),
        # Wrong counts.
        (".xyz", "2\n", "1\n", "frame 1: line 4: expected a number of particles, got 'O 1 1 1 2'"),
        (".xyz", "2\n", "3\n", "expected 3 particles from line 3 on, the file ends after line 4"),
        (".xyz", "2\n", "99999999999\n", "line 1: expected a number of particles, got '9999999999"),
        (".xyz", "2\n", "2000000000\n", "line 1: expected a number of particles that the file has"),
        (".xyz", "2\n", "-2\n", "line 1: expected a number of particles, got '-2'"),
        (".xyz", "2\n", "2.0\n", "line 1: expected a number of particles, got '2.0'"),
        (".dump", "ATOMS\n2", "ATOMS\n1", "frame 1: line 11: expected 'ITEM: ...', got '2 1 1 1 1"),
        (".dump", "ATOMS\n2", "ATOMS\nmany", "line 4: expected a number of particles, got 'many'"),
        (".ply", "vertex 2", "vertex 3", "expected 3 particles from line 11 on, the file ends aft"),
        (".ply", "vertex 2", "vertex 1e3", "line 3: expected a number of particles, got '1e3'"),
        # Columns.
        (".xyz", "H 0 0 0 1", "H 0 0 0", "line 3: expected 5 columns ('species', 'pos', 'pos', 'p"),
        (".xyz", "H 0 0 0 1", "H 0 0 0 1 2", "line 3: expected 5 columns ('species', 'pos', 'pos'"),
        (".xyz", "H 0 0 0 1\n", "H 0 0 0 1\n\n", "line 4: expected 5 columns ('species', 'pos', '"),
        (".xyz", "pos:R:3", "pos:R:0", "line 2: expected Properties=name:kind:width:..., kinds R "),
        (".xyz", "pos:R:3", "pos:Q:3", "line 2: expected Properties=name:kind:width:..., kinds R "),
        (".xyz", "v:R:1", "v:R", "line 2: expected Properties=name:kind:width:..., kinds R I S L,"),
        (".xyz", "pos:R:3", "pos:R:999999999999", "line 2: expected Properties=name:kind:width:.."),
        (".xyz", "pos:R:3", "where:R:3", "expected columns x, y and z or positions (n, 3), got 's"),
        (".xyz", "v:R:1", "v:R:1 Lattice='1 2'", "line 2: expected Lattice of 9 numbers, got '1 2"),
        (".xyz", "v:R:1", 'v:R:1 Origin="0 0 x"', "line 2: expected Origin of 3 numbers, got '0 0"),
        (".dump", "x y z radius", "x y", "line 10: expected 4 columns ('id', 'type', 'x', 'y'), g"),
        (".dump", "x y z", "a b c", "expected columns x, y and z or positions (n, 3), got 'id', '"),
        (".dump", "ITEM: NUMBER OF ATOMS\n2\n", "", "line 7: expected ITEM: NUMBER OF ATOMS"),
        (".dump", "ITEM: TIMESTEP", "ITEM: STEP", "line 1: expected ITEM: TIMESTEP, NUMBER OF ATO"),
        (".dump", "0 1\nITEM: ATOMS", "0\nITEM: ATOMS", "line 8: expected 2 numbers of the box, g"),
        (".dump", "BOUNDS pp", "BOUNDS xy xz yz pp", "line 6: expected 3 numbers of the box, got "),
        (".csv", "x,y,z,radius", "x,a,radius,v", "expected columns x, y and z or positions (n, 3)"),
        (".csv", "x,y,z,radius\n", "1,2\n", "line 1: expected a header that names x, y and z, got"),
        (".csv", "0,0,0,1", "0,0,0", "line 2: expected 4 columns ('x', 'y', 'z', 'radius'), got '"),
        (".ply", "float z", "list uchar int z", "line 10: expected vertices without lists before,"),
        (".ply", "float z", "third z", "line 6: expected one of the types char uchar short ushort"),
        (".ply", "float y", "float w", "expected columns x, y and z or positions (n, 3), got 'x',"),
        (".ply", "vertex", "corner", "line 10: expected an element vertex before, got 'end_header"),
        (".ply", "format ascii 1.0\n", "", "line 9: expected a format before, got 'end_header'"),
        (".ply", "ascii 1.0", "ascii 2.0", "line 2: expected a line of a PLY header, got 'format "),
        (".ply", "ply\n", "PLY\n", "line 1: expected 'ply', got 'PLY'"),
        # Values.
        (".xyz", "O 1 1 1 2", "O 1 1,5 1 2", "line 4: expected a number as pos, got '1,5'"),
        (".xyz", "O 1 1 1 2", f"{'O' * 80} 1 1 1 2", "line 4: expected names of less than 64 byte"),
        (".dump", "2 1 1 1 1 0.5", "2 1 1 1 1 -1", "line 11: radii: expected a finite number a"),
        (".dump", "2 1 1 1 1 0.5", "2 1 1 1 1 x", "line 11: expected a number as radius, got 'x'"),
        (".dump", "2 1 1 1 1 0.5", "2 1.5 1 1 1 1", "line 11: expected a whole number as type, go"),
        (".dump", "0 1\nITEM: ATOMS", "0 x\nITEM: ATOMS", "line 8: expected 2 numbers of the box,"),
        (".dump", "0 1\nITEM: ATOMS", "0 inf\nITEM: ATOMS", "cell: expected finite numbers of sha"),
        (".csv", "1,1,1,2", "1,1,1,-2", "line 5: radii: expected a finite number above 0, got -2."),
        (".csv", "0,0,0,1", "0,0,0,-0.5", "line 2: radii: expected a finite number above 0, got -"),
        (".ply", "4 5 6", "4 5 256", "line 12: expected blue from 0 to 255, got 256"),
        (".ply", "4 5 6", "4 5 -1", "line 12: expected blue from 0 to 255, got -1"),
        (".ply", "4 5 6", "4 5 6.5", "line 12: expected a whole number as blue, got '6.5'"),
    ],
)  # fmt: skip
def test_says_where_and_what(tmp_path: Path, suffix: str, old: str, new: str, said: str) -> None:
    path = tmp_path / f"a{suffix}"
    assert old in GOOD[suffix]
    for ends in ("\n", "\r\n"):
        path.write_text(GOOD[suffix].replace(old, new, 1), newline=ends)
        assert fault(path).startswith(said)


@pytest.mark.parametrize("suffix", GOOD)
def test_what_is_spoilt_here_is_good(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_text(GOOD[suffix])
    assert (clrt.read(path).positions == [[0, 0, 0], [1, 1, 1]]).all()


def saved(**arrays: Any) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


def saved_one(array: object, version: tuple[int, int] = (1, 0)) -> bytes:
    file = io.BytesIO()
    np.lib.format.write_array(file, np.asarray(array), version)
    return file.getvalue()


BINARY = PLY.replace("ascii", "binary_little_endian").partition("0 0 0")[0].encode()
FOUR = np.zeros((4, 3))


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.npz", saved(positions=FOUR, radii=[1, 2]), "radii: expected 4 of them, as positions, "),
        ("a.npz", saved(positions=FOUR, radii=[1, 2, -3, 4]), "radii[2]: expected a finite number"),
        ("a.npz", saved(where=FOUR), "expected columns x, y and z or positions (n, 3), got 'whe"),
        ("a.npz", saved(positions=FOUR[:, :1]), "positions: expected numbers of shape (n, 3), got"),
        ("a.npz", saved(positions=FOUR, cell=np.eye(4)), "cell: expected finite numbers of shape "),
        ("a.npz", saved(positions=FOUR, numbers=[1, 2, 3, 200]), "elements[3]: expected an atomic"),
        ("a.npz", saved(positions=FOUR, colors=FOUR + 0.5 + np.eye(4, 3)), "colors[0]: expected s"),
        ("a.npz", saved(positions=np.array([None] * 4)), "cannot be read: Object arrays cannot be"),
        ("a.npz", saved(positions=FOUR)[:-30], "cannot be read: File is not a zip file"),
        ("a.npz", b"", "expected NumPy's file, which begins b'PK', got b''"),
        ("a.npz", b"rubbish", "expected NumPy's file, which begins b'PK', got b'ru'"),
        ("a.npz", saved_one(FOUR), "expected NumPy's file, which begins b'PK', got b'\\x93N'"),
        ("a.npy", saved(positions=FOUR), "expected NumPy's file, which begins b'\\x93NUMPY', got"),
        ("a.npy", saved_one(FOUR)[:-5], "cannot be read: "),
        ("a.npy", saved_one(FOUR)[:40], "cannot be read: "),
        ("a.npy", saved_one(FOUR[:, 0]), "expected numbers of shape (n, 3), or (n, 4) with the ra"),
        ("a.npy", saved_one(FOUR * 1j), "expected numbers of shape (n, 3), or (n, 4) with the rad"),
        ("a.npy", saved_one(np.ones((2, 4)) * [1, 1, 1, -1]), "radii[0]: expected a finite number"),
        ("a.npy.gz", gzip.compress(saved_one(FOUR), mtime=0)[:-20], "cannot be read: "),
        ("a.xyz.gz", XYZ.encode(), "cannot be read: Not a gzipped file"),
        ("a.xyz.gz", gzip.compress(XYZ.encode() * 99, mtime=0)[:-50], "line 2: expected "),
        ("a.xyz.gz", gzip.compress(b"20000000000\n\n0 0 0\n", mtime=0), "line 1: expected a num"),
        ("a.xyz.gz", gzip.compress(b"20000\n\n0 0 0\n", mtime=0), "expected 20000 particles fr"),
        ("a.xyz.gz", b"", "expected a number of particles, the file ends at once"),
        ("a.ply", BINARY + bytes(29), "expected 2 vertices, the file ends after 1"),
        ("a.ply", BINARY, "expected 2 vertices, the file ends after 0"),
        ("a.ply", BINARY.replace(b"2\n", b"2000\n", 1), "line 3: expected a number of particles t"),
        (
            "a.ply",
            BINARY.replace(b"element", b"element face 1\nproperty list int int i\nelement"),
            "line 12: expected no lists before the vertices, got 'end_header'",
        ),
        ("a.pdb", b"", "expected atoms, got none"),
        ("a.pdb", b"rubbish\0\xff\n", "expected atoms, got none"),
        ("a.pdb", b"ATOM      1  N   ALA A   1      11.104   6.1", "line 1: expected coordi"),
        ("a.cif", b"", "expected atoms, got none"),
        ("a.cif", b"data_\nloop_\n_atom_site.x\n1 2 3 oops", "expected atoms, got none"),
        ("a.gsd", b"", "cannot be read: Not a GSD file"),
        ("a.gsd", b"rubbish" * 100, "cannot be read: Not a GSD file"),
        ("a.gsd.gz", b"", "cannot be read: "),
        ("a.txt", b"0 0 0", "clrt reads .npz .npy .csv .tsv .ply .xyz .extxyz .dump .lammpstrj "),
        ("xyz", b"0 0 0", "clrt reads .npz .npy .csv .tsv .ply .xyz .extxyz .dump .lammpstrj "),
        ("a.csv", b"x,y,z\n0,0,\xff\n", "line 2: expected a number as z, got '\ufffd'"),
        ],
)  # fmt: skip
def test_bytes_that_are_wrong(tmp_path: Path, name: str, content: bytes, said: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    assert fault(path).startswith(said)


@pytest.mark.parametrize("suffix", [".xyz", ".dump", ".csv", ".ply"])
def test_what_never_ends(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    path.write_bytes(b"9" * (3 << 20))
    assert fault(path) == "line 1: expected a line of at most 1 MB, got 'a longer one'"
    path.write_bytes(bytes(50_000))
    assert fault(path).startswith(("line 1: expected ", "expected columns x, y and z"))


@pytest.mark.parametrize("suffix", [".xyz", ".dump", ".csv", ".ply"])
def test_columns_without_end(tmp_path: Path, suffix: str) -> None:
    many = [f"c{i}" for i in range(100_000)]
    path = tmp_path / f"a{suffix}"
    head, _, rows = DUMP.partition(" x y z")
    path.write_text(
        {
            ".xyz": f"1\n\nH 0 0 0{' 1' * 100_000}\n",
            ".dump": f"{head} {' '.join(many)} x y z{rows}",
            ".csv": f"{','.join(many)}\n{','.join('1' for _ in many)}\n",
            ".ply": PLY.replace("property", "".join(f"property int {c}\n" for c in many), 1),
        }[suffix]
    )  # fmt: skip
    assert "at most 1000" in fault(path)
    path.write_text({".xyz": f"1\nProperties={':R:1:'.join(many)}:R:1\n1 2\n"}.get(suffix, "x"))
    fault(path)


def test_what_is_no_file(tmp_path: Path) -> None:
    (tmp_path / "folder.xyz").mkdir()
    (tmp_path / "null.xyz").symlink_to("/dev/null")
    (tmp_path / "zero.npz").symlink_to("/dev/zero")
    os.mkfifo(tmp_path / "fifo.csv")
    for name in ("folder.xyz", "null.xyz", "zero.npz", "fifo.csv"):
        assert fault(tmp_path / name) == "is a folder or a device, expected a file"
    (tmp_path / "lost.xyz").symlink_to("nowhere")
    for name in ("none.xyz", "none.gsd", "none.pdb", "none/a.csv", "lost.xyz"):
        assert fault(tmp_path / name) == "no such file"
    with pytest.raises(clrt.SceneError, match="no such file"):
        clrt.read("a\0b.xyz")


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read everything")
def test_not_allowed(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text(XYZ)
    path.chmod(0)
    assert fault(path) == "cannot be read: Permission denied"


@pytest.mark.parametrize(
    ("name", "module", "said"),
    [
        ("a.pdb", "gemmi", "needs gemmi: pip install 'clrt[mol]'"),
        ("a.gsd", "gsd.hoomd", "needs gsd: pip install 'clrt[gsd]'"),
    ],
)
def test_an_extra_that_is_missing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, module: str, said: str
) -> None:
    monkeypatch.setitem(__import__("sys").modules, module, None)
    (tmp_path / name).touch()
    assert fault(tmp_path / name) == said


def test_without_extxyz_all_is_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "extxyz", None)
    monkeypatch.setattr("clrt.files.particles.xyz.FAST_FROM", 1)
    (tmp_path / "a.xyz").write_text(XYZ)
    assert len(clrt.read(tmp_path / "a.xyz")) == 2


def test_a_trajectory_is_good_up_to_where_it_is_cut(tmp_path: Path) -> None:
    path = tmp_path / "a.xyz"
    path.write_text(XYZ * 3 + XYZ[:-10])
    found: list[clrt.Particles] = []
    with pytest.warns(clrt.ParticleWarning, match="frame 3 is cut short: there are 3 whole frames"):
        found.extend(clrt.read_frames(path))
    assert len(found) == 3
    with pytest.raises(clrt.RequestError, match=r"expected a frame from 0 to 2, got 4"):
        clrt.read(path, frame=4)
    path.write_text(XYZ[:-10])
    with pytest.raises(
        clrt.SceneError, match=r"expected 2 particles from line 3 on, the file ends"
    ):
        clrt.read(path)


def test_too_many_for_the_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("clrt.memory.UNASKED_BYTES", 1)
    monkeypatch.setattr("clrt.memory.available", lambda: 100)
    for suffix in (".xyz", ".dump", ".ply"):
        path = tmp_path / f"a{suffix}"
        path.write_text(GOOD[suffix])
        with pytest.raises(clrt.OutputError, match=f"a{suffix}: 2 particles needs .*: take fewer"):
            clrt.read(path)


PLACES = st.integers(0, 10**6)
ODD = ["nan", "inf", "-1", "0", "1e999", "9" * 30, "\0", "\n", "\r", "\n\n", " ", ",", '"', "#",
       "é", "ITEM:", "x", "2", ":"]  # fmt: skip


@st.composite
def mutated(draw: st.DrawFn) -> tuple[str, bytes]:
    """A good file with some bytes gone, doubled, changed, or replaced by what is odd."""
    good = [(suffix, text.encode() * n) for suffix, text in GOOD.items() for n in (1, 2)]
    good += [(".ply", BINARY + bytes(range(30))), (".npz", saved(pos=FOUR))]
    suffix, whole = draw(st.sampled_from(good))
    content = bytearray(whole)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(PLACES) % (len(content) + 1)
        end = at + draw(st.sampled_from([0, 0, 1, 1, 2, 5, 40]))
        new = draw(st.one_of(st.just(b""), st.binary(max_size=3),
                             st.sampled_from(ODD).map(str.encode)))  # fmt: skip
        content[at:end] = new
    if draw(st.booleans()) and draw(st.booleans()):
        return f"{suffix}.gz", gzip.compress(bytes(content), mtime=0)[
            : draw(st.sampled_from([None, -9]))
        ]
    return suffix, bytes(content)


@settings(max_examples=600, deadline=None)
@given(file=mutated())
def test_a_mutated_file_is_particles_or_one_line(file: tuple[str, bytes]) -> None:
    suffix, content = file
    with tempfile.NamedTemporaryFile(suffix=suffix) as here, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        here.write(content)
        here.flush()
        try:
            for found in clrt.read_frames(here.name):
                assert np.isfinite(found.positions).all()
        except (clrt.SceneError, clrt.RequestError) as error:
            said = str(error)
            assert said.startswith(here.name)
            assert "\n" not in said
            event(said.removeprefix(here.name)[:25])
        else:
            event("particles")
