"""LAMMPS's data files: atom styles, masses, bonds and boxes."""

from pathlib import Path

import numpy as np
import pytest
from conftest import same

import clrt

WATER = """\
LAMMPS data file via write_data, version 2 Aug 2023, timestep = 0, units = real

3 atoms
2 bonds
1 angles
2 atom types
1 bond types

-1.0 9.0 xlo xhi
0.0 20.0 ylo yhi
0.0 30.0 zlo zhi
1.0 2.0 3.0 xy xz yz

Masses

1 15.9994 # O
2 1.008 # H

Bond Coeffs # harmonic

1 450 0.9572

Atoms # full

3 1 2 0.41 1.5 2.5 3.5 0 0 1
1 1 1 -0.82 1 2 3 0 0 0 # the first
2 1 2 0.41 1.25 2.5 3.5 0 0 0

Velocities

1 1 2 3
2 4 5 6
3 7 8 9

Bonds

1 1 1 2
2 1 1 3

Angles

1 1 2 1 3
"""


def test_full(tmp_path: Path) -> None:
    path = tmp_path / "water.data"
    path.write_text(WATER)
    found = clrt.read(path)
    assert found.positions.tolist() == [[1.5, 2.5, 3.5], [1, 2, 3], [1.25, 2.5, 3.5]]
    assert found.values["id"].tolist() == [3, 1, 2]
    assert same(found.bonds, [[1, 2], [1, 0]])
    assert found.type_names == ("O", "H")
    assert same(found.types, [1, 0, 1])
    assert same(found.elements, [1, 8, 1])
    assert found.values["vy"].tolist() == [8, 2, 5]
    assert found.values["q"].tolist() == [0.41, -0.82, 0.41]
    assert same(found.cell, [[10, 0, 0], [1, 20, 0], [2, 3, 30]])
    assert found.origin.tolist() == [-1, 0, 0]
    assert found.unit == "angstrom"


HEAD = "LAMMPS\n\n2 atoms\n2 atom types\n\n0 1 xlo xhi\n0 1 ylo yhi\n0 1 zlo zhi\n\n"


@pytest.mark.parametrize(
    ("section", "rows", "radii", "more"),
    [
        ("Atoms # atomic", ["1 1 {}", "2 2 {}"], None, {}),
        ("Atoms", ["1 1 {}", "2 2 {}"], None, {}),
        ("Atoms", ["1 5 1 {} 0 0 0", "2 5 2 {} 0 0 1"], None, {"mol": 5}),
        ("Atoms", ["1 1 0.5 {}", "2 2 0.5 {}"], None, {"q": 0.5}),
        ("Atoms  # sphere", ["1 1 2.0 2.5 {}", "2 2 4.0 2.5 {}"], [1, 2], {"density": 2.5}),
        ("Atoms # molecular", ["1 5 1 {}", "2 5 2 {}"], None, {"mol": 5}),
        ("Atoms # hybrid", ["1 1 {} 7", "2 2 {} 7"], None, {"column6": 7}),
    ],
)
def test_styles(tmp_path: Path, section: str, rows: list[str], radii: object, more: dict) -> None:
    path = tmp_path / "data.lj"
    text = "\n".join(rows).replace("{}", "0.25 0.5 0.75", 1).replace("{}", "0.5 0.5 0.5")
    path.write_text(f"{HEAD}{section}\n\n{text}\n")
    found = clrt.read(path)
    assert found.positions.tolist() == [[0.25, 0.5, 0.75], [0.5, 0.5, 0.5]]
    assert same(found.types, [1, 2])
    assert (found.radii is None) == (radii is None)
    assert radii is None or same(found.radii, radii)  # type: ignore[arg-type]
    for name, value in more.items():
        assert (found.values[name] == value).all()


def test_ellipsoids_and_general_boxes(tmp_path: Path) -> None:
    path = tmp_path / "a.data"
    head = "x\n\n2 atoms\n1 ellipsoids\n1 atom types\n2 0 0 avec\n1 3 0 bvec\n0 0 4 cvec\n"
    text = f"{head}-1 -2 -3 abc origin\n\nAtoms # ellipsoid\n\n1 1 1 2.5 0 0 0\n2 1 0 2.5 1 1 1\n"
    path.write_text(f"{text}\nEllipsoids\n\n1 1 4 2 1 0 0 0\n\nBodies\n\n1 1 2\n")
    with pytest.warns(clrt.ParticleWarning) as caught:
        found = clrt.read(path)
    said = [str(one.message).removeprefix(f"{path}: ") for one in caught]
    assert said[0] == "section Bodies: is not used: spheres are drawn"
    assert said[1] == "shapex shapey shapez: are drawn as the spheres around them"
    assert same(found.cell, [[2, 0, 0], [1, 3, 0], [0, 0, 4]])
    assert found.origin.tolist() == [-1, -2, -3]
    assert found.radii is not None
    assert found.radii[0] == 2


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("Atoms # full", "Atoms # fill", None),
        (WATER, "", "expected a section Atoms, the file ends at once"),
        ("3 atoms\n", "", "expected an atom of id 1, got none"),
        ("1.25 2.5 3.5 0 0 0\n", "1.25 2.5 3.5 0 0\n", "line 27: expected 10 columns ('id', 'mol'"),
        ("1 1 1 2\n", "1 1 1 4\n", "expected an atom of id 4, got none"),
        ("-1.0 9.0 xlo", "-1.0 9.0 lo", "line 9: expected a line of the header of a LAMMPS data f"),
        ("1 15.9994", "1 heavy", "line 16: expected a type and its mass, got '1 heavy"),
    ],
)
def test_faults(tmp_path: Path, old: str, new: str, said: str | None) -> None:
    path = tmp_path / "a.data"
    assert old in WATER
    path.write_text(WATER.replace(old, new))
    if said is None:
        assert len(clrt.read(path)) == 3
        return
    with pytest.raises(clrt.SceneError) as caught:
        clrt.read(path)
    assert str(caught.value).startswith(f"{path}: {said}")


def test_numbers_of_atoms_that_are_none(tmp_path: Path) -> None:
    path = tmp_path / "a.data"
    path.write_text(HEAD.replace("2 atoms", "0 atoms") + "Atoms # atomic\n\n")
    assert clrt.read(path).positions.shape == (0, 3)
    assert np.isfinite(clrt.read(path).cell).all()  # type: ignore[arg-type]


def test_a_style_that_is_not_named_is_said(tmp_path: Path) -> None:
    path = tmp_path / "a.data"
    for title, said in (
        ("Atoms", "Atoms names no style: its columns are read as id mol type x y z (molecular)"),
        ("Atoms # fill", "Atoms # fill is of no known style: its columns are read as id mol type"),
    ):
        path.write_text(HEAD + f"{title}\n\n1 5 1 0 0 0\n2 5 1 0 0 1\n")
        with pytest.warns(clrt.ParticleWarning) as caught:
            clrt.read(path)
        assert [said in str(one.message) for one in caught] == [True]
