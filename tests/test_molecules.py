"""PDB and CIF files that real programs write: order, frames, locations, elements, symmetry."""

import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner
from conftest import same

import clrt
from clrt.commands.cli import main
from clrt.files.particles import pdb
from clrt.particles import elements


def atom(
    serial: object, name: str, residue: str = "ALA", number: object = 1, x: float = 0.0,
    alt: str = " ", occupancy: float = 1.0, symbol: str = "", head: str = "ATOM", chain: str = "A",
) -> str:  # fmt: skip
    """A line of a PDB file."""
    return (
        f"{head:6}{serial:>5} {name:4}{alt}{residue:<4}{chain}{number:>4}    "
        f"{x:8.3f}{1:8.3f}{2:8.3f}{occupancy:6.2f}{10:6.2f}          {symbol:>2}\n"
    )


def read(path: Path, content: str, *said: str) -> list[clrt.Particles]:
    """All frames; the warnings are those that are said."""
    path.write_text(content)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = list(clrt.read_frames(path))
    texts = [str(one.message) for one in caught]
    assert len(texts) == len(said), texts
    assert all(part in text for part, text in zip(said, texts, strict=True)), texts
    return found


def symbols(found: clrt.Particles) -> str:
    assert found.elements is not None
    return " ".join(elements.SYMBOLS[z] for z in found.elements)


@pytest.mark.parametrize(
    ("names", "residues", "right"),
    [
        ("N CA C O CB CD HA 1HB", "LEU " * 8, "N C C O C C H H"),
        ("CA CD HG CO", "CA CD HG CO", "Ca Cd Hg Co"),
        ("SOD CLA POT CAL CES", "SOD CLA POT CAL CES", "Na Cl K Ca Cs"),
        ("SOD CLA NA+ ZN2", "ION ION NA+ ZN2", "Na Cl Na Zn"),
        ("OH2 H1 HW2 MW", "TIP3 TIP3 SOL SOL", "O H H X"),
        ("SE CG P OP1 N9 FE NA", "MSE MSE DA DA ADE HEM HEM", "Se C P O N Fe Na"),
    ],
)
def test_elements_by_names_and_residues(
    tmp_path: Path, names: str, residues: str, right: str
) -> None:
    known = elements.each_of_names(names.split(), residues.split())
    if "P OP1" not in names:
        assert " ".join(elements.SYMBOLS[z] for z in known if z is not None) == right
    rows = zip(names.split(), residues.split(), strict=True)
    content = "".join(atom(i, f"{n:<4}", r, i, i) for i, (n, r) in enumerate(rows))
    (found,) = read(tmp_path / "a.pdb", content)
    assert symbols(found) == right


def test_beads_are_types(tmp_path: Path) -> None:
    names = [("BB", "ALA"), ("SC1", "ALA"), ("W", "W"), ("P4", "W"), ("W", "PW")]
    content = "".join(atom(i, n, r, i, i) for i, (n, r) in enumerate(names))
    (found,) = read(tmp_path / "a.pdb", content, "are taken for types, not for elements")
    assert found.elements is None
    assert found.type_names == ("BB", "P4", "SC1", "W")
    assert same(found.types, [0, 2, 3, 1, 3])
    assert None in elements.each_of_names(["W", "BB", "P4"])
    with pytest.warns(clrt.ParticleWarning, match="taken for types"):
        found = clrt.read({"positions": np.eye(3), "names": ["W", "BB", "P4"]})
    assert found.elements is None
    assert found.type_names == ("BB", "P4", "W")


def test_a_rare_element_among_many_atoms_is_one(tmp_path: Path) -> None:
    content = "".join(atom(i, "CA", "ALA", i, i) for i in range(30)) + atom(30, "HG", "HG", 30, 30)
    (found,) = read(tmp_path / "a.pdb", content)
    assert symbols(found).split()[29:] == ["C", "Hg"]
    content = "".join(atom(i, "W", "W", i, i, symbol="W") for i in range(3))
    (found,) = read(tmp_path / "a.pdb", content)  # an element column counts
    assert symbols(found) == "W W W"


def test_frames(tmp_path: Path) -> None:
    one, two = atom(1, "N", x=1), atom(1, "N", x=2)
    for content in (
        f"{one}END\n{two}END\n",
        f"MODEL 1\n{one}ENDMDL\nMODEL 2\n{two}ENDMDL\nEND\n",
        f"MODEL 1\n{one}TER\nMODEL 2\n{two}END\n",
        f"REMARK\r\n{one}END\r\nREMARK\r\n{two}",
    ):
        found = read(tmp_path / "a.pdb", content)
        assert [frame.positions[0, 0] for frame in found] == [1, 2]
    cells = [f"CRYST1{side:9.3f}{20:9.3f}{30:9.3f}{90:7.2f}{90:7.2f}{90:7.2f} P 1\n" for side in
             (10, 11)]  # fmt: skip
    found = read(tmp_path / "a.pdb", f"{cells[0]}{one}END\n{cells[1]}{two}END\n")
    assert [frame.cell[0, 0] for frame in found if frame.cell is not None] == [10, 11]


def test_the_files_order(tmp_path: Path) -> None:
    content = "".join(atom(i + 1, "O", "HOH", (9998 + i) % 10000, i) for i in range(6))
    content += "".join(atom(i + 7, "H1", "HOH", (9998 + i) % 10000, i + 6) for i in range(6))
    (found,) = read(tmp_path / "a.pdb", content)
    assert same(found.positions[:, 0], np.arange(12))
    (found,) = read(tmp_path / "a.pdb", atom("A0001", "O", "HOH", "A000"))
    assert found.values["residue_id"][0] == 10000


def test_shifted_columns(tmp_path: Path) -> None:
    far = atom(1, "N", symbol="N").replace("   0.000   1.000", "-1000.500   1.000")
    long = atom(100000, "CA", x=3.5, symbol="C")
    (found,) = read(tmp_path / "a.pdb", far + long)
    assert same(found.positions, [[-1000.5, 1, 2], [3.5, 1, 2]])
    assert symbols(found) == "N C"
    assert list(found.texts["name"]) == ["N", "CA"]
    assert same(found.values["occupancy"], [1, 1])
    for wrong in ("********", "        ", "  oops  "):
        (tmp_path / "a.pdb").write_text(atom(1, "N") + atom(2, "C").replace("   0.000", wrong))
        with pytest.raises(clrt.SceneError, match=r"a.pdb: line 2: expected coordinates x, y and"):
            clrt.read(tmp_path / "a.pdb")
    (found,) = read(tmp_path / "a.pdb", atom(1, "N").replace("   0.000", "   12.50"))
    assert found.positions[0, 0] == 12.5


def test_alternate_locations(tmp_path: Path) -> None:
    content = atom(1, "N") + "".join(
        atom(i + 2, "CB", x=1 + i, alt=alt, occupancy=part)
        for i, (alt, part) in enumerate([("A", 0.3), ("B", 0.4), ("C", 0.3)])
    )
    (found,) = read(tmp_path / "a.pdb", content, "2 of 4 particles are left out: another location")
    assert same(found.positions[:, 0], [0, 2])
    assert list(found.texts["altloc"]) == ["", "B"]
    two = "".join(
        atom(i, name, residue, x=i, alt=alt, occupancy=part)
        for i, (name, residue, alt, part) in enumerate(
            [("CB", "SER", "A", 0.6), ("OG", "SER", "A", 0.6), ("CB", "THR", "B", 0.4),
             ("OG1", "THR", "B", 0.4)])
    )  # fmt: skip
    (found,) = read(tmp_path / "a.pdb", two, "2 of 4 particles are left out")
    assert list(found.texts["residue"]) == ["SER", "SER"]


def test_two_atoms_on_one_site(tmp_path: Path) -> None:
    content = (
        HEAD
        + """\
Mg1 Mg 0 0 0 0.5
Fe1 Fe 0 0 0 0.5
O1 O 0.5 0.5 0.5 1
"""
    )
    (found,) = read(tmp_path / "a.cif", content, "1 of 3 particles are left out: a larger atom is")
    radii = elements.VAN_DER_WAALS
    larger = "Mg" if radii[12] >= radii[26] else "Fe"
    assert symbols(found) == f"{larger} O"


HEAD = """\
data_a
_cell_length_a 5
_cell_length_b 5
_cell_length_c 5
_cell_angle_alpha 90
_cell_angle_beta 90
_cell_angle_gamma 90
loop_
_atom_site_label
_atom_site_type_symbol
_atom_site_fract_x
_atom_site_fract_y
_atom_site_fract_z
_atom_site_occupancy
"""


@pytest.mark.parametrize(
    ("group", "count", "said"),
    [
        ("_space_group_IT_number 225", 4, []),
        ("_symmetry_Int_Tables_number 225", 4, []),
        ("_symmetry_space_group_name_H-M 'F m -3 m'", 4, []),
        ("loop_\n_symmetry_equiv_pos_as_xyz\nx,y,z\nx+1/2,y+1/2,z\nx+1/3,y,z", 3, ["is no space"]),
        ("loop_\n_space_group_symop_operation_xyz\nx,y,z\n-x,y,-z", 1, []),
        ("_symmetry_space_group_name_H-M 'P what'", 1, ["'P what': is no space group"]),
        ("", 1, []),
    ],
)
def test_symmetry(tmp_path: Path, group: str, count: int, said: list[str]) -> None:
    content = HEAD.replace("loop_", f"{group}\nloop_") + "Na1 Na+ 0 0 0 1\n"
    (found,) = read(tmp_path / "a.cif", content, *said)
    assert symbols(found) == " ".join(["Na"] * count)


def test_cif_without_a_cell_and_with_places_that_nobody_knows(tmp_path: Path) -> None:
    content = HEAD.replace("fract", "Cartn").replace("_cell_length_a 5\n", "")
    (found,) = read(tmp_path / "a.cif", content + "O1 O 0 0.8(1) 0.1 1\nH1 H 1 0 0 1\n")
    assert same(found.positions, [[0.0, 0.8, 0.1], [1.0, 0.0, 0.0]])
    assert found.cell is None
    assert found.unit == "angstrom"
    (found,) = read(tmp_path / "a.cif", HEAD + "O1 O 0 0 0 1\nH1 H ? ? ? 1\n", "1 of 2 particles")
    assert symbols(found) == "O"


def test_blocks_with_atoms_are_frames(tmp_path: Path) -> None:
    block = HEAD + "O1 O 0 0 0 1\n"
    content = f"data_global\n_publ_contact_author_name x\n{block}{block.replace('a', 'b', 0)}"
    content = (
        content[: content.rindex("data_a")] + "data_b" + content[content.rindex("data_a") + 6 :]
    )
    assert len(read(tmp_path / "a.cif", content)) == 2


LIGAND = """\
data_LIG
loop_
_chem_comp_atom.comp_id
_chem_comp_atom.atom_id
_chem_comp_atom.type_symbol
_chem_comp_atom.model_Cartn_x
_chem_comp_atom.model_Cartn_y
_chem_comp_atom.model_Cartn_z
_chem_comp_atom.pdbx_model_Cartn_x_ideal
_chem_comp_atom.pdbx_model_Cartn_y_ideal
_chem_comp_atom.pdbx_model_Cartn_z_ideal
LIG C1 C 0 0 0 1 2 3
LIG "O1'" O 1.2 0 0 4 5 6
loop_
_chem_comp_bond.comp_id
_chem_comp_bond.atom_id_1
_chem_comp_bond.atom_id_2
LIG C1 "O1'"
"""


def test_ligands(tmp_path: Path) -> None:
    (found,) = read(tmp_path / "a.cif", LIGAND)
    assert same(found.positions, [[0.0, 0.0, 0.0], [1.2, 0.0, 0.0]])
    assert symbols(found) == "C O"
    assert same(found.bonds, [[0, 1]])
    (found,) = read(tmp_path / "a.cif", LIGAND.replace("1.2 0 0", "? 0 0"))
    assert same(found.positions, [[1, 2, 3], [4, 5, 6]])


def test_bonds_of_a_pdb_file(tmp_path: Path) -> None:
    content = atom(1, "N") + atom(2, "CA", x=1) + atom(3, "C", x=2) + "CONECT    1    2    9\n"
    (found,) = read(tmp_path / "a.pdb", content + "CONECT    2    1    3\n")
    assert same(found.bonds, [[0, 1], [1, 2]])


def test_all_locations_and_assemblies(tmp_path: Path) -> None:
    two = atom(1, "CB", alt="A", occupancy=0.6) + atom(2, "CB", x=1, alt="B", occupancy=0.4)
    (tmp_path / "a.pdb").write_text(two)
    assert len(clrt.read(tmp_path / "a.pdb", altloc="all")) == 2
    with pytest.raises(clrt.RequestError, match="altloc: expected one of most, all, got 'A'"):
        clrt.read(tmp_path / "a.pdb", altloc="A")
    remark = """\
REMARK 350 BIOMOLECULE: 1
REMARK 350 APPLY THE FOLLOWING TO CHAINS: A
REMARK 350   BIOMT1   1  1.000000  0.000000  0.000000        0.00000
REMARK 350   BIOMT2   1  0.000000  1.000000  0.000000        0.00000
REMARK 350   BIOMT3   1  0.000000  0.000000  1.000000        0.00000
REMARK 350   BIOMT1   2 -1.000000  0.000000  0.000000       10.00000
REMARK 350   BIOMT2   2  0.000000 -1.000000  0.000000        0.00000
REMARK 350   BIOMT3   2  0.000000  0.000000  1.000000        0.00000
"""
    (tmp_path / "a.pdb").write_text(remark + atom(1, "N", x=3) + atom(2, "N", x=4, chain="B"))
    found = clrt.read(tmp_path / "a.pdb", assembly=1)
    assert same(found.positions, [[3, 1, 2], [7, -1, 2]])
    assert found.bonds is None
    with pytest.raises(clrt.RequestError, match="assembly: expected one of '1', got '2'"):
        clrt.read(tmp_path / "a.pdb", assembly="2")


MMCIF = """\
data_a
loop_
_atom_site.group_PDB
_atom_site.id
_atom_site.type_symbol
_atom_site.label_atom_id
_atom_site.label_comp_id
_atom_site.label_asym_id
_atom_site.label_seq_id
_atom_site.Cartn_x
_atom_site.Cartn_y
_atom_site.Cartn_z
ATOM 1 N N ALA A 1 3 1 2
ATOM 2 C CA ALA A 1 4 1 2
ATOM 3 N N ALA B 1 5 1 2
loop_
_struct_conn.id
_struct_conn.conn_type_id
_struct_conn.ptnr1_label_asym_id
_struct_conn.ptnr1_label_comp_id
_struct_conn.ptnr1_label_seq_id
_struct_conn.ptnr1_label_atom_id
_struct_conn.ptnr2_label_asym_id
_struct_conn.ptnr2_label_comp_id
_struct_conn.ptnr2_label_seq_id
_struct_conn.ptnr2_label_atom_id
1 covale A ALA 1 N A ALA 1 CA
2 covale A ALA 1 CA B ALA 1 N
loop_
_pdbx_struct_assembly.id
_pdbx_struct_assembly.details
1 whatever
2 whatever
loop_
_pdbx_struct_assembly_gen.assembly_id
_pdbx_struct_assembly_gen.oper_expression
_pdbx_struct_assembly_gen.asym_id_list
1 1,2 A
1 2 B
2 1 A
2 2 B
loop_
_pdbx_struct_oper_list.id
_pdbx_struct_oper_list.matrix[1][1]
_pdbx_struct_oper_list.matrix[1][2]
_pdbx_struct_oper_list.matrix[1][3]
_pdbx_struct_oper_list.vector[1]
_pdbx_struct_oper_list.matrix[2][1]
_pdbx_struct_oper_list.matrix[2][2]
_pdbx_struct_oper_list.matrix[2][3]
_pdbx_struct_oper_list.vector[2]
_pdbx_struct_oper_list.matrix[3][1]
_pdbx_struct_oper_list.matrix[3][2]
_pdbx_struct_oper_list.matrix[3][3]
_pdbx_struct_oper_list.vector[3]
1 1 0 0 0 0 1 0 0 0 0 1 0
2 -1 0 0 10 0 -1 0 0 0 0 1 0
"""


def test_assemblies_keep_bonds_between_what_is_moved_alike(tmp_path: Path) -> None:
    (tmp_path / "a.cif").write_text(MMCIF)
    whole = clrt.read(tmp_path / "a.cif")
    assert same(whole.bonds, [[0, 1], [1, 2]])
    found = clrt.read(tmp_path / "a.cif", assembly=1)
    expected = [[3, 1, 2], [4, 1, 2], [7, -1, 2], [6, -1, 2], [5, -1, 2]]
    assert same(found.positions, expected)
    assert same(found.bonds, [[0, 1], [2, 3], [3, 4]])
    with pytest.warns(clrt.ParticleWarning, match="a.cif: 1 of 2 bonds are left out: their ends"):
        found = clrt.read(tmp_path / "a.cif", assembly="2")
    assert same(found.positions, [[3, 1, 2], [4, 1, 2], [5, -1, 2]])
    assert same(found.bonds, [[0, 1]])


def test_locations_and_assemblies_by_a_command_and_a_call(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    words = ["--width", "48", "--height", "32", "--samples", "1", "-q"]
    size: dict[str, Any] = {"size": (48, 32), "samples": 1}
    Path("a.cif").write_text(MMCIF)
    found = CliRunner().invoke(main, ["render", "a.cif", "--assembly", "1", "-o", "a.png", *words])
    assert found.exit_code == 0, found.stderr
    picture = clrt.plot("a.cif", assembly=1, **size)
    assert len(picture.scene.spheres) == 5
    assert Path("a.png").read_bytes() == picture._repr_png_()
    two = atom(1, "CB", alt="A", occupancy=0.6) + atom(2, "CB", x=9, alt="B", occupancy=0.4)
    Path("b.pdb").write_text(two)
    words = ["animate", "b.pdb", "-o", "b#.png", *words]
    assert CliRunner().invoke(main, [*words, "--altloc", "all"]).exit_code == 0
    picture = clrt.plot("b.pdb", altloc="all", **size)
    assert len(picture.scene.spheres) == 2
    assert Path("b0.png").read_bytes() == picture._repr_png_()
    found = CliRunner().invoke(main, [*words, "--resume"])
    assert found.exit_code == 2  # they show something else
    for more, said in (
        (["a.xyz", "--assembly", "1"], "a.xyz: --assembly: expected a file of pdb or cif"),
        (["a.cif", "--assembly", "3"], "--assembly: expected one of '1', '2', got '3'"),
        (["b.pdb", "--altloc", "B"], "--altloc: expected one of most, all, got 'B'"),
        (["orbit", "--assembly", "1"], "--assembly: expected a file of particles, orbit is"),
        (["a.cif", "--assembly", "1", "--save-scene", "a.toml"], "--save-scene: expected no"),
    ):
        Path("a.xyz").write_text("1\n\nC 0 0 0\n")
        found = CliRunner().invoke(main, ["render", *more])
        assert found.exit_code == 2
        assert said in found.stderr
    with pytest.raises(clrt.RequestError, match="ndarray: assembly: expected a file of pdb or cif"):
        clrt.plot(np.zeros((1, 3)), assembly=1)


def test_gro_and_poscar_are_ases(tmp_path: Path) -> None:
    io, build = pytest.importorskip("ase.io"), pytest.importorskip("ase.build")
    atoms = build.bulk("NaCl", "rocksalt", 5.64, cubic=True)
    atoms.rattle(0.1)
    for name, form, scale in (
        ("POSCAR", "vasp", 1), ("a.vasp", "vasp", 1), ("XDATCAR", "vasp-xdatcar", 1),
        ("a.gro", "gromacs", 10),
    ):  # fmt: skip
        io.write(tmp_path / name, [atoms, atoms] if name == "XDATCAR" else atoms, format=form)
        theirs, ours = io.read(tmp_path / name, format=form), clrt.read(tmp_path / name, frame=-1)
        assert abs(scale * ours.positions - theirs.positions).max() < 1e-12
        assert ours.cell is not None
        assert abs(scale * ours.cell - theirs.cell).max() < 1e-12
        assert same(ours.elements, theirs.numbers)
        assert ours.unit == ("nm" if scale == 10 else "angstrom")
        assert len(list(clrt.read_frames(tmp_path / name))) == 1 + (name == "XDATCAR")


def test_gro_with_velocities_and_faults(tmp_path: Path) -> None:
    row = "    1SOL     OW    1   0.126   1.624   1.679  0.1227 -0.0580  0.0434\n"
    (found,) = read(tmp_path / "a.gro", f"title\n1\n{row}   1.0   2.0   3.0\n")
    assert same(found.positions, [[0.126, 1.624, 1.679]])
    assert found.values["vy"][0] == -0.058
    assert symbols(found) == "O"
    assert same(found.cell, np.diag([1, 2, 3]))
    (tmp_path / "a.gro").write_text(
        f"title\n1\n{row.replace('1.624', 'oops!')}   1.0   2.0   3.0\n"
    )
    with pytest.raises(clrt.SceneError, match=r"a.gro: line 3: expected numbers in columns"):
        clrt.read(tmp_path / "a.gro")


def test_a_topology_and_a_trajectory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    row = "    1SOL     OW    1   0.126   1.624   1.679\n"
    (tmp_path / "a.gro").write_text(f"title\n1\n{row}   1.0   2.0   3.0\n")
    (tmp_path / "a.xtc").write_bytes(b"")
    monkeypatch.setitem(sys.modules, "MDAnalysis", None)
    with pytest.raises(
        clrt.RequestError, match=r"a.xtc: needs MDAnalysis: pip install 'clrt\[traj"
    ):
        clrt.read([tmp_path / "a.gro", tmp_path / "a.xtc"])
    monkeypatch.undo()
    mda = pytest.importorskip("MDAnalysis")
    universe = mda.Universe(str(tmp_path / "a.gro"))
    with mda.Writer(str(tmp_path / "a.xtc"), 1) as writer:
        for step in range(3):
            universe.atoms.positions = [[step, 2.0, 3.0]]
            writer.write(universe.atoms)
    found = list(clrt.read_frames([tmp_path / "a.gro", tmp_path / "a.xtc"]))
    assert [frame.positions[0, 0] for frame in found] == pytest.approx([0, 1, 2])
    assert [symbols(frame) for frame in found] == ["O"] * 3
    assert found[0].unit == "angstrom"
    assert found[0].cell is not None
    assert same(np.rint(found[0].cell), np.diag([10, 20, 30]))


@pytest.mark.parametrize("atoms", [3, 30])
def test_a_trajectory_of_gromacs_that_is_cut_short(tmp_path: Path, atoms: int) -> None:
    mda = pytest.importorskip("MDAnalysis")
    row = "{0:5}SOL     OW{0:5}   1.000   1.000   1.000\n"
    rows = "".join(row.format(i + 1) for i in range(atoms))
    (tmp_path / "a.gro").write_text(f"title\n{atoms}\n{rows}   4.0   4.0   4.0\n")
    universe = mda.Universe(str(tmp_path / "a.gro"))
    with mda.Writer(str(tmp_path / "a.xtc"), atoms) as writer:
        for _ in range(3):
            universe.atoms.positions = np.random.default_rng(1).uniform(0, 40, (atoms, 3))
            writer.write(universe.atoms)
    whole = (tmp_path / "a.xtc").read_bytes()
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", clrt.ParticleWarning)
        assert len(list(clrt.read_frames([tmp_path / "a.gro", tmp_path / "a.xtc"]))) == 3
    assert not [one for one in caught if "cut" in str(one.message)]
    (tmp_path / "b.xtc").write_bytes(whole[:-9])
    with pytest.warns(clrt.ParticleWarning, match="b.xtc: frame 2 is cut short: there are 2 whole"):
        found = list(clrt.read_frames([tmp_path / "a.gro", tmp_path / "b.xtc"]))
    assert len(found) == 2


@pytest.mark.parametrize(
    ("field", "decimals", "is_exact"),
    [
        ("  -0.000", 3, True),
        ("-999.999", 3, True),
        ("9999.999", 3, True),
        ("   -.456", 3, True),
        ("    .456", 3, True),
        ("   1.50 ", 3, False),
        ("  1.5e+1", 3, False),
        ("1 23.456", 3, False),
        ("  --.456", 3, False),
        ("  12.3-4", 3, False),
        ("     nan", 3, False),
        ("  1.00", 2, True),
        ("      ", 2, False),
        ("   1", 0, True),
        ("-  1", 0, False),
        ("A000", 0, False),
        ("12  ", 0, False),
    ],
)
def test_numbers_of_fixed_width_are_those_of_float(
    field: str, decimals: int, is_exact: bool
) -> None:
    found = pdb._fixed(np.frombuffer(field.encode(), np.uint8).reshape(1, -1), decimals)
    assert (found is not None) == is_exact
    if found is not None:
        assert found.tobytes() == np.float64(field).tobytes()  # and the sign of 0


def test_lines_may_be_short_and_end_in_several_ways(tmp_path: Path) -> None:
    lines = [
        atom(1, "N", x=-1.5),
        atom(2, "CA", symbol="C")[:54] + "\n",
        "TER\n",
        atom(3, "O", x=9),
    ]
    for end in ("\n", "\r\n", "\r"):
        for last in ("", end):
            text = "".join(lines).replace("\n", end).removesuffix(end) + last
            (tmp_path / "a.pdb").write_bytes(text.encode())
            found = clrt.read(tmp_path / "a.pdb")
            assert same(found.positions[:, 0], [-1.5, 0, 9])
            assert symbols(found) == "N C O"
            assert same(found.values["occupancy"], [1, 1, 1])
            assert same(found.values["b_factor"], [10, 0, 10])
