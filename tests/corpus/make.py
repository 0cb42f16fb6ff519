# mypy: ignore-errors
"""Writes the files of this folder, each by the program that users have it from.

    python -m venv /tmp/corpus
    /tmp/corpus/bin/pip install ase==3.29.0 gemmi==0.7.5 gsd==5.0.1 MDAnalysis==2.11.0 \\
        ovito==3.17.2 pyvista==0.49.1 trimesh==5.2.0 vtk==9.7.2
    /tmp/corpus/bin/python tests/corpus/make.py

expected.toml says what each must give; tests/test_corpus.py reads both. A function here writes the
files that its name begins.
"""

import sys
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
AT = np.array([[0.0, 0, 0], [0.75, 0.5, 0.25], [1.5, 1, 2], [2.25, 0.25, 1]])
RADII = np.array([0.25, 0.5, 0.25, 0.375])
COLORS = np.array([[255, 0, 0], [0, 128, 255], [10, 20, 30], [255, 255, 255]], np.uint8)
SPEED = np.array([1.0, -2.5, 3.25, 0.5])
VELOCITY = np.array([[1.0, 0, 0], [0, 2, 0], [0, 0, 3], [1, 1, 1]])


def ase(folder: Path) -> None:
    from ase import Atoms
    from ase.io import write

    atoms = Atoms("OHHC", AT, cell=[[4, 0, 0], [1, 5, 0], [0, 0, 6]], pbc=[True, True, False])
    atoms.set_momenta(VELOCITY)
    atoms.set_tags([0, 1, 1, 2])
    atoms.set_array("label", np.array(["a", "b", "c", "d"]))
    atoms.set_array("fixed", np.array([True, False, True, False]))
    atoms.info["energy"] = -1.5
    write(folder / "ase.extxyz", [atoms, atoms])
    write(folder / "ase.xyz", atoms, format="xyz")
    write(folder / "ase.pdb", atoms)
    write(folder / "ase.vasp", atoms, format="vasp")
    write(folder / "ase.data", atoms, format="lammps-data", atom_style="charge", masses=True)


def gemmi(folder: Path) -> None:
    import gemmi

    structure, model = gemmi.Structure(), gemmi.Model(1)
    structure.name, structure.cell = "corpus", gemmi.UnitCell(40, 50, 60, 90, 90, 90)
    for name, residue, number, chain, element, at, speed in zip(
        ("N", "CA", "ZN", "O"), ("GLY", "GLY", "ZN", "HOH"), (1, 1, 2, 3), "AABB",
        ("N", "C", "Zn", "O"), AT, SPEED, strict=True,
    ):  # fmt: skip
        if chain not in [one.name for one in model]:
            model.add_chain(chain)
        if not model[chain] or model[chain][-1].seqid.num != number:
            new = gemmi.Residue()
            new.name, new.seqid = residue, gemmi.SeqId(number, " ")
            new.het_flag = "A" if residue == "GLY" else "H"
            model[chain].add_residue(new)
        atom = gemmi.Atom()
        atom.name, atom.element, atom.b_iso = name, gemmi.Element(element), abs(speed)
        atom.pos = gemmi.Position(*at)
        model[chain][-1].add_atom(atom)
    structure.add_model(model)
    structure.setup_entities()
    structure.assign_label_seq_id()
    structure.make_mmcif_document().write_file(str(folder / "gemmi.cif"))
    structure.write_pdb(str(folder / "gemmi.pdb"))


def mdanalysis(folder: Path) -> None:
    import MDAnalysis

    names, residues = ["OW", "HW1", "HW2", "CA"], ["SOL", "GLY"]
    universe = MDAnalysis.Universe.empty(4, 2, atom_resindex=[0, 0, 0, 1], trajectory=True)
    for key, given in (("name", names), ("resname", residues), ("resid", [1, 2])):
        universe.add_TopologyAttr(key, given)
    universe.atoms.positions = AT
    universe.dimensions = [40, 50, 60, 90, 90, 90]
    for suffix in ("gro", "pdb"):
        universe.atoms.write(folder / f"mdanalysis.{suffix}")


def gsd(folder: Path) -> None:
    import gsd.hoomd

    frame = gsd.hoomd.Frame()
    frame.particles.N = 4
    frame.particles.position, frame.particles.diameter = AT, 2 * RADII
    frame.particles.velocity = VELOCITY
    frame.particles.types, frame.particles.typeid = ["a", "b"], [0, 1, 0, 1]
    frame.particles.type_shapes = [{"type": "Ellipsoid", "a": 0.25, "b": 0.1, "c": 0.1}, {}]
    frame.bonds.N, frame.bonds.group = 1, [[0, 1]]
    frame.configuration.box = [4, 5, 6, 0.2, 0, 0]
    with gsd.hoomd.open(folder / "gsd.gsd", "w") as file:
        file.append(frame)


def trimesh(folder: Path) -> None:
    import trimesh

    colors = np.column_stack([COLORS, [255, 128, 255, 0]]).astype(np.uint8)
    trimesh.PointCloud(AT, colors=colors).export(folder / "trimesh.ply")
    trimesh.Trimesh(AT, [[0, 1, 2], [0, 2, 3]], process=False).export(folder / "trimesh-mesh.ply")


def pyvista(folder: Path) -> None:
    import pyvista

    cloud = pyvista.PolyData(AT)
    cloud["radius"], cloud["speed"], cloud["velocity"] = RADII, SPEED, VELOCITY
    cloud["RGB"] = COLORS
    cloud.save(folder / "pyvista.vtp")
    cloud.save(folder / "pyvista.vtk")
    cloud.cast_to_unstructured_grid().save(folder / "pyvista.vtu")


def vtk(folder: Path) -> None:
    """What a DEM code writes: lines between grains as well, and arrays of those."""
    import pyvista

    net = pyvista.PolyData(AT, lines=[2, 0, 1, 2, 1, 2])
    net["radius"] = RADII
    net.cell_data["force"] = [1.0, 2.0]
    net.save(folder / "vtk-contacts.vtp", binary=False)


def ovito(folder: Path) -> None:
    from ovito.data import DataCollection, Particles, SimulationCell
    from ovito.io import export_file
    from ovito.pipeline import Pipeline, StaticSource

    data = DataCollection()
    particles = Particles()
    particles.create_property("Position", data=AT)
    particles.create_property("Particle Type", data=[1, 2, 1, 2])
    particles.create_property("Radius", data=RADII)
    particles.create_property("Color", data=COLORS / 255)
    particles.create_property("Transparency", data=[0, 0.5, 0, 0])
    particles.create_property("Velocity", data=VELOCITY)
    data.objects.append(particles)
    cell = SimulationCell(pbc=(True, True, True))
    cell[...] = [[4, 1, 0, -1], [0, 5, 0, -2], [0, 0, 6, -3]]
    data.objects.append(cell)
    pipeline = Pipeline(source=StaticSource(data=data))
    columns = [
        *("Particle Type", "Position.X", "Position.Y", "Position.Z", "Radius"),
        *("Color.R", "Color.G", "Color.B", "Transparency"),
        *("Velocity.X", "Velocity.Y", "Velocity.Z"),
    ]
    export_file(pipeline, str(folder / "ovito.dump"), "lammps/dump", columns=columns)
    export_file(pipeline, str(folder / "ovito.xyz"), "xyz", columns=columns)
    export_file(pipeline, str(folder / "ovito.data"), "lammps/data", atom_style="sphere")


def numpy(folder: Path) -> None:
    table = np.column_stack([AT, RADII, SPEED])
    np.savetxt(folder / "numpy.csv", table, "%.6g", ",", header="x,y,z,radius,speed")
    np.savez(folder / "numpy.npz", positions=AT, radii=RADII, colors=COLORS, speed=SPEED)


def main() -> None:
    for make in (ase, gemmi, mdanalysis, gsd, trimesh, pyvista, vtk, ovito, numpy):
        if len(sys.argv) == 1 or make.__name__ in sys.argv[1:]:
            make(HERE)


if __name__ == "__main__":
    main()
