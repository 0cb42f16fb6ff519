"""Frames: files that are cut short, one file a frame, names that people have, packed files."""

import bz2
import gzip
import io
import lzma
import sys
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result
from PIL import Image

import clrt
from clrt.commands.cli import main
from clrt.files.particles import series, suffix
from clrt.files.particles.reader import READERS, Reader

DUMP = (
    "ITEM: TIMESTEP\n{step}\nITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS pp pp pp\n0 9\n0 9\n0 9\n"
    "ITEM: ATOMS id type x y z\n1 1 {step} 0.125 0\n2 1 1.5 1.25 1.125\n"
)
XYZ = "2\nstep={step}\nH {step} 0 0\nO 1.5 1.25 1.125\n"


@pytest.fixture(autouse=True)
def _own_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def warned(call: Callable[[], object]) -> tuple[object, list[str]]:
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = call()
    return found, [str(one.message) for one in caught]


def steps(*names: str) -> list[float]:
    return [
        frame.positions[0, 0] for frame in clrt.read_frames(list(names) if names[1:] else names[0])
    ]


@pytest.mark.parametrize(("name", "form"), [("a.dump", DUMP), ("a.xyz", XYZ)])
def test_a_last_frame_that_is_cut_short_anywhere(name: str, form: str) -> None:
    """All cuts but those that leave a whole frame, or a last number with fewer digits."""
    whole = "".join(form.format(step=k) for k in range(3))
    last = whole.rindex("1.125")
    for end in range(2 * len(whole) // 3 + 1, last):
        Path(name).write_text(whole[:end])

        def frames() -> list[float]:
            return [frame.positions[0, 0] for frame in clrt.read_frames(name)]

        found, said = warned(frames)
        assert found == [0, 1], whole[:end]
        assert said == [f"{name}: frame 2 is cut short: there are 2 whole frames"]
        for _ in range(2):  # found, and recalled
            with Reader(name) as reader:
                found, said = warned(reader.count)
                assert found == 2
                if end > last - 5:  # in the last line
                    assert said == [f"{name}: frame 2 is cut short: there are 2 whole frames"]
    Path(name).write_text(whole[: last + 3])
    assert steps(name) == [0, 1, 2]


def test_a_gzipped_file_that_is_cut_short() -> None:
    random = np.random.default_rng(1)
    one = "2000\n\n" + "".join(
        f"H {row[0]:.9g} {row[1]:.9g} {row[2]:.9g}\n" for row in random.normal(size=(2000, 3))
    )
    packed = gzip.compress((one * 5).encode())
    Path("a.xyz.gz").write_bytes(packed[: len(packed) * 3 // 4])
    found, said = warned(lambda: len(list(clrt.read_frames("a.xyz.gz"))))
    assert found in (2, 3, 4)
    assert said == [f"a.xyz.gz: frame {found} is cut short: there are {found} whole frames"]


def test_a_frame_that_is_wrong_is_named() -> None:
    for wrong in ("1 1 x 0.125 0", "1 1 0.125 0"):
        frames = [DUMP.format(step=k) for k in range(3)]
        frames[1] = frames[1].replace("1 1 1 0.125 0", wrong)
        Path("a.dump").write_text("".join(frames))
        read = []
        with pytest.raises(
            clrt.SceneError, match=r"^a\.dump: frame 1: line 21: expected "
        ) as caught:
            read += list(clrt.read_frames("a.dump"))
        assert caught.value.exit_status == 1
    # A value that is wrong in the last line is no cut.
    Path("a.dump").write_text(DUMP.format(step=0) + DUMP.format(step=1).replace("1.5", "x"))
    with pytest.raises(
        clrt.SceneError, match=r"^a\.dump: frame 1: line 22: expected a number as x"
    ):
        list(clrt.read_frames("a.dump"))


def test_the_last_frame() -> None:
    Path("a.dump").write_text("".join(DUMP.format(step=k) for k in range(3)))
    assert clrt.read("a.dump", -1).positions[0, 0] == 2
    assert clrt.read("a.dump", frame=-3).positions[0, 0] == 0
    for frame in (3, -4):
        said = f"a.dump: expected a frame from 0 to 2, got {frame}"
        with pytest.raises(clrt.RequestError, match=said):
            clrt.read("a.dump", frame)
    assert len(clrt.read(np.zeros((1, 3)), frame=-1)) == 1


def test_one_file_a_frame() -> None:
    """By timestep, whatever their names are, and by the numbers in the names without one."""
    for name, step in (("dump.1", 20), ("dump.2", 3), ("dump.10", 100)):
        Path(name).write_text(DUMP.format(step=step))
    assert steps("dump.*") == [3, 20, 100]
    assert steps("dump.10", "dump.1", "dump.2") == [3, 20, 100]
    assert clrt.read("dump.*", frame=-1).positions[0, 0] == 100
    assert clrt.read(["dump.1", Path("dump.2")], frame=1).positions[0, 0] == 20
    for k in (2, 10, 9):
        Path(f"flow{k}.csv").write_text(f"x,y,z\n{k},0,0\n")
        Path(f"at{k}.xyz").write_text(XYZ.format(step=100 - k))
    assert steps("flow*.csv") == [2, 9, 10]
    assert steps("at*.xyz") == [90, 91, 98]
    Path("dump.3.gz").write_bytes(gzip.compress(DUMP.format(step=7).encode()))
    assert steps("dump.*") == [3, 7, 20, 100]
    Path("dump.2").write_text(DUMP.format(step=3) * 2)
    found, said = warned(lambda: steps("dump.*"))
    assert found == [3, 7, 20, 100]
    assert said == ["dump.2: of several files the first frame each is read"]
    with pytest.raises(clrt.RequestError, match=r"^none\*: no such files"):
        clrt.read("none*")
    with pytest.raises(clrt.SceneError, match=r"^none.dump: no such file"):
        clrt.read(["dump.1", "none.dump"])
    Path("odd[1].csv").write_text("x,y,z\n5,0,0\n")
    assert steps("odd[1].csv") == [5]


@pytest.mark.parametrize(
    ("name", "form"),
    [
        *(("a.ent", "pdb"), ("a.mmcif", "cif"), ("a.lammpsdump", "dump"), ("dump.16000", "dump")),
        *(("dump", "dump"), ("a.dump.100", "dump"), ("a.dump.100.gz", "dump"), ("b.XYZ.xz", "xyz")),
        *(("a.0012.xyz", "xyz"), ("data.lj", "data"), ("a.lmp", "data"), ("dump_007", "dump")),
        *(("a.toml", None), ("dump.toml", None), ("a.txt", None), ("a", None), ("4", None)),
    ],
)
def test_names_that_people_have(name: str, form: str | None) -> None:
    assert suffix.format_of(Path(name)) == form
    assert suffix.is_particles(Path(name)) == (form is not None)


def test_how_a_file_begins_and_what_its_format_is_said_to_be() -> None:
    Path("flow").write_text(DUMP.format(step=4))
    assert clrt.read("flow").positions[0, 0] == 4
    Path("a.txt").write_text("x y z\n1 2 3\n")
    assert clrt.read("a.txt", format="csv").positions.tolist() == [[1, 2, 3]]
    assert clrt.read(["a.txt"], format="csv").positions.tolist() == [[1, 2, 3]]
    with pytest.raises(clrt.RequestError, match=r"^a\.txt: clrt reads \.npz .*--format NAME"):
        clrt.read("a.txt")
    with pytest.raises(clrt.RequestError, match=r"^format: expected one of npz, npy, csv, "):
        clrt.read("a.txt", format="mol")
    assert READERS.keys() == suffix.FORMATS.keys()


def test_what_is_not_read_says_what_does() -> None:
    said = {
        "a.stl": r"\.stl is a mesh: clrt render draws it, clrt.read_mesh reads it",
        "a.mol2": r"clrt does not read \.mol2; MDAnalysis does: clrt.plot\(MDAnalysis.U",
        "a.traj": r"clrt does not read \.traj; ase does: clrt.plot\(ase.io.read\('a.traj'\)\)",
        "a.glb.gz": r"clrt does not read \.glb; trimesh does: clrt.plot\(trimesh.load\(",
    }
    for name, expected in said.items():
        with pytest.raises(clrt.RequestError, match=f"^{name}: {expected}.*clrt reads .npz "):
            clrt.read(name)


@pytest.mark.parametrize("end", [".gz", ".bz2", ".xz", ".zst"])
def test_packed_files(end: str) -> None:
    if end == ".zst":
        compress = pytest.importorskip("zstandard").ZstdCompressor().compress
    else:
        compress = {".gz": gzip.compress, ".bz2": bz2.compress, ".xz": lzma.compress}[end]
    text = "".join(DUMP.format(step=k) for k in range(3)).encode()
    Path(f"a.dump{end}").write_bytes(compress(text))
    assert steps(f"a.dump{end}") == [0, 1, 2]
    with Reader(f"a.dump{end}") as reader:
        assert reader.count() == 3
        assert reader.frame(1).positions[0, 0] == 1  # type: ignore[union-attr]
    file = io.BytesIO()
    np.savez(file, positions=np.eye(3))
    Path(f"a.npz{end}").write_bytes(compress(file.getvalue()))
    assert clrt.read(f"a.npz{end}").positions.tolist() == np.eye(3).tolist()


def test_stdin(monkeypatch: pytest.MonkeyPatch) -> None:
    def given(content: bytes) -> None:
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))

    given((DUMP.format(step=1) + DUMP.format(step=5)).encode())
    assert clrt.read("-", frame=1, format="dump").positions[0, 0] == 5
    given(b"x;y;z\n0,5;1;2\n")
    assert clrt.read("-", format="csv").positions.tolist() == [[0.5, 1, 2]]
    with pytest.raises(clrt.RequestError, match=r"^-: stdin needs --format NAME, one of npz, "):
        clrt.read("-")
    gemmi = pytest.importorskip("gemmi")
    assert gemmi
    given(b"ATOM      1  N   ALA A   1      11.104   6.134  -6.504  1.00  0.00           N\n")
    assert clrt.read("-", format="pdb").positions[0].tolist() == [11.104, 6.134, -6.504]


def test_the_documentation_has_a_row_for_each_format() -> None:
    text = (Path(__file__).parents[1] / "docs" / "particles.md").read_text()
    rows = [line.split("|")[1:3] for line in text.splitlines() if line.startswith("| `.")]
    suffixes = {word.strip("`") for row in rows for word in row[0].split()}
    formats = {word.strip("`") for row in rows for word in row[1].split()}
    assert suffixes == set(suffix.SUFFIXES)
    assert formats == set(suffix.FORMATS)


def test_order_of_files() -> None:
    names = [Path(f"a{k}b{j}.csv") for k in (10, 9) for j in (2, 1)]
    assert series.in_order(names) == [Path(f"a{k}b{j}.csv") for k in (9, 10) for j in (1, 2)]


SMALL = ["--width", "32", "--height", "24", "--samples", "1", "--radius", "0.5", "-q"]


def command(*words: str, given: bytes = b"") -> Result:
    return CliRunner().invoke(main, [*words], input=given, catch_exceptions=False)


def test_a_picture_from_stdin_to_stdout() -> None:
    """The same as from a file to a file."""
    text = "".join(DUMP.format(step=k) for k in range(3))
    Path("a.dump").write_text(text)
    words = [*SMALL, "--frame", "-1"]
    assert command("render", "a.dump", "-o", "a.png", *words).exit_code == 0
    found = command("render", "-", "--format", "dump", "-o", "-", *words, given=text.encode())
    assert found.stdout_bytes == Path("a.png").read_bytes()
    found = command("render", "a.dump", "-o", "-", "--output-format", "ppm", *words)
    assert found.stdout_bytes.startswith(b"P6\n32 24\n")
    for more, said in (
        (["-"], "-: stdin needs --format NAME"),
        (["a.dump", "--output-format", "png"], "--output-format: expected -o -"),
        (["a.dump", "--format", "dump", "--save-scene", "a.toml"], "--save-scene: expected a file"),
        (["a.dump", "-o", "-", "--output-format", "mol"], "stdout.mol: expected a name that ends"),
    ):
        found = command("render", *more, *words)
        assert found.exit_code == 2
        assert said in found.stderr
    assert not list(Path().glob("stdout*"))


def test_a_video_of_several_files() -> None:
    for k in (9, 10):
        Path(f"dump.{k}").write_text(DUMP.format(step=k))
    Path("flow.dump").write_text(DUMP.format(step=9) + DUMP.format(step=10))
    assert command("animate", "flow.dump", "-o", "a#.png", *SMALL).exit_code == 0
    assert command("animate", "dump.*", "-o", "b#.png", *SMALL).exit_code == 0
    assert command("animate", "dump.10", "dump.9", "-o", "c#.png", *SMALL).exit_code == 0
    for k in range(2):
        assert Path(f"a{k}.png").read_bytes() == Path(f"b{k}.png").read_bytes()
        assert Path(f"a{k}.png").read_bytes() == Path(f"c{k}.png").read_bytes()


def test_a_video_up_to_a_frame_that_is_wrong() -> None:
    frames = [DUMP.format(step=k) for k in range(4)]
    frames[2] = frames[2].replace("1 1 2 0.125 0", "1 1 2 here 0")
    Path("a.dump").write_text("".join(frames))
    found = command("animate", "a.dump", "-o", "a.apng", "--clim", "0", "1", *SMALL)
    assert found.exit_code == 1
    said = "clrt: a.dump: frame 2: line 32: expected a number as y, got 'here'; a.apng has the "
    assert said in found.stderr
    with Image.open("a.apng") as video:
        assert video.n_frames == 2  # type: ignore[attr-defined]
    found = command("animate", "a.dump", "-o", "a#.png", *SMALL)
    assert found.exit_code == 1
    assert sorted(path.name for path in Path().glob("a*.png")) == ["a0.png", "a1.png"]
    Path("a.dump").write_text("".join(frames[:2]) + frames[3][:-20])
    found = command("animate", "a.dump", "-o", "b.apng", *SMALL)
    assert found.exit_code == 0
    assert found.stderr == "clrt: a.dump: frame 2 is cut short: there are 2 whole frames\n"


def test_no_word_of_toml_of_what_is_no_scene() -> None:
    Path("a.mol2").write_text("@<TRIPOS>MOLECULE\n")
    Path("a.bin").write_bytes(b"\xff\xfe\x00binary")
    Path("a.xtc").write_bytes(b"x")
    Path("notes").write_text("x y z\n1 2 3\n")
    for name, said in (
        ("a.mol2", "clrt does not read .mol2; MDAnalysis does: clrt.plot(MDAnalysis.Universe("),
        ("a.bin", "clrt does not read .bin; ovito does"),
        ("a.xtc", ".xtc has places and no atoms: clrt animate system.gro a.xtc reads both"),
        ("notes", "clrt reads .npz .npy .csv"),
    ):
        for verb in ("render", "animate"):
            found = command(verb, name)
            assert found.exit_code == 2
            assert f"clrt: {name}: {said}" in found.stderr
            assert "TOML" not in found.stderr
    Path("a.toml").write_text("x y z\n")
    assert "a.toml: not TOML" in command("render", "a.toml").stderr
    Path("a.csv").write_text("x,y,z\n0,0,0\n")
    found = command("check", "a.csv")
    assert (found.exit_code, found.stderr) == (0, "")
    assert "a.csv: 1 particles, 1 frame\n" in found.stdout
