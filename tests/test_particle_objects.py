"""Objects that hold particles, real ones where their library is there and stand-ins elsewhere."""

from types import SimpleNamespace as Object
from typing import Any

import numpy as np
import pytest
from conftest import same

import clrt

POSITIONS = np.random.default_rng(1).normal(size=(3, 3))


def test_arrays_and_dicts() -> None:
    given = POSITIONS.copy()
    found = clrt.read(given)
    given[:] = 0
    assert (found.positions == POSITIONS).all()
    assert (clrt.read(POSITIONS.tolist()).positions == POSITIONS).all()
    assert same(clrt.read(np.column_stack([POSITIONS, [1, 2, 3]])).radii, [1, 2, 3])
    found = clrt.read({"pos": POSITIONS, "radius": 2, "speed": [1, 2, 3], "cell": [1, 1, 2]})
    assert same(found.radii, 2)
    assert same(found.cell, np.diag([1, 1, 2]))
    assert (found.values["speed"] == [1, 2, 3]).all()
    assert clrt.read(found) is found
    assert same(clrt.read({"pos": POSITIONS, "bonds": [[2, 0]]}).bonds, [[2, 0]])


def test_ases_atoms() -> None:
    ase = pytest.importorskip("ase")
    atoms = ase.Atoms("OH2", POSITIONS, cell=[3, 4, 5], pbc=True)
    atoms.set_array("speed", np.array([1.0, 2, 3]))
    found = clrt.read(atoms)
    assert (found.positions == POSITIONS).all()
    assert same(found.elements, [8, 1, 1])
    assert same(found.cell, np.diag([3, 4, 5]))
    assert (found.values["speed"] == [1, 2, 3]).all()
    atoms.positions[:] = 0
    assert (found.positions == POSITIONS).all()
    assert clrt.read(ase.Atoms("H")).cell is None
    assert found.periodic == (True, True, True)
    atoms.pbc = (True, False, True)
    atoms.set_array("bonds", np.array(["1(1),2(3)", "_", "_"]))  # as ase.io.lammpsdata has it
    found = clrt.read(atoms)
    assert same(found.bonds, [[0, 1], [0, 2]])
    assert found.periodic == (True, False, True)


def group(**attributes: Any) -> Object:
    return Object(positions=POSITIONS.astype(np.float32), **attributes)


def test_mdanalysiss_atom_group() -> None:
    """Names are Python's objects there, and an element that nobody knows is empty."""
    names = np.array(["OW", "HW1", "HW2"], object)
    trajectory = Object(ts=Object(triclinic_dimensions=np.diag([3.0, 4, 5])))
    box = {"dimensions": [3, 4, 5, 90, 90, 90], "universe": Object(trajectory=trajectory)}
    found = clrt.read(group(names=names, masses=np.zeros(3), **box))
    assert same(found.elements, [8, 1, 1])
    assert same(found.cell, np.diag([3, 4, 5]))
    assert found.positions.dtype == np.float32
    for elements in (["O", "H", "H"], ["O", "", "H"]):
        found = clrt.read(group(names=names, elements=np.array(elements, object)))
        assert same(found.elements, [8, 1, 1])
    assert clrt.read(group(dimensions=None)).cell is None
    masses = np.array([15.999, 1.008, 1.008])
    assert same(clrt.read(group(masses=masses)).elements, [8, 1, 1])
    assert same(clrt.read(group(radii=np.array([1.5, 1, 1]))).radii, [1.5, 1, 1])
    assert clrt.read(group(radii=np.zeros(3))).radii is None
    bonded = group(bonds=Object(indices=np.array([[9, 7], [2, 9], [5, 9]])), ix=np.array([7, 9, 2]))
    assert same(clrt.read(bonded).bonds, [[1, 0], [2, 1]])


class Properties(dict[str, Any]):
    """OVITO's particles: properties by name, some of which are attributes as well."""

    positions = position = POSITIONS
    bonds: Any = None

    def __init__(self, kinds: list[Object], **more: Any) -> None:
        types = {"Particle Type": np.array([4, 7, 4])}
        super().__init__({"Position": POSITIONS, **types, **more})
        self.particle_types = Object(types=kinds)


KINDS = [Object(id=7, name="Cl", radius=0.5), Object(id=4, name="C", radius=0.25)]


def test_ovitos_data_collection() -> None:
    matrix = np.array([[3, 1, 0, -1], [0, 4, 2, -2], [0, 0, 5, -3.0]])
    velocity = {"Velocity": np.arange(9.0).reshape(3, 3)}
    found = clrt.read(Object(particles=Properties(KINDS, **velocity), cell=matrix))
    assert (found.positions == POSITIONS).all()
    assert same(found.elements, [6, 17, 6])
    assert same(found.radii, [0.25, 0.5, 0.25])
    assert found.type_names == ("C", "Cl")
    assert (found.values["Velocity.Z"] == [2, 5, 8]).all()
    assert same(found.cell, [[3, 0, 0], [1, 4, 0], [0, 2, 5]])
    assert (found.origin == [-1, -2, -3]).all()
    nameless = [Object(id=kind.id, name="", radius=0.0) for kind in KINDS]
    own = {"Radius": np.array([1.0, 2, 3]), "Color": np.full((3, 3), 0.5)}
    found = clrt.read(Object(particles=Properties(nameless, **own), cell=None))
    assert same(found.types, [4, 7, 4])
    assert found.type_names is None
    assert same(found.radii, [1, 2, 3])
    assert same(found.colors, 0.5)
    assert found.cell is None


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (3, "particles: expected a file's name, arrays, or an object with positions, got int"),
        (None, "particles: expected a file's name, arrays, or an object with positions, got No"),
        (object, "particles: expected a file's name, arrays, or an object with positions, got t"),
        (np.zeros(3), "ndarray: expected numbers of shape (n, 3), or (n, 4) with the radius last"),
        ([[1, 2], [3]], "list: expected an array, got rows of several lengths"),
        ({"pos": [[1, 2], [3]]}, "dict: pos: expected an array, got rows of several lengths"),
        (["a.xyz"], "a.xyz: no such file"),
        (
            ["a.xyz", 1],
            "list: expected numbers of shape (n, 3), or (n, 4) with the radius last, got",
        ),
        ({}, "dict: expected columns x, y and z or positions (n, 3), got none"),
        ({"pos": POSITIONS, "r": "big"}, "dict: radii: expected numbers of shape (n,) or one num"),
        (group(), None),
    ],
)
def test_what_holds_no_particles(given: object, said: str | None) -> None:
    if said is None:
        assert len(clrt.read(given)) == 3
        return
    with pytest.raises(clrt.SceneError) as caught:
        clrt.read(given)
    assert str(caught.value).startswith(said)


def test_an_object_has_one_frame() -> None:
    with pytest.raises(clrt.RequestError, match="frame: expected 0 for what is no file, got 1"):
        clrt.read(POSITIONS, frame=1)


def test_a_universe_is_its_atoms() -> None:
    types = np.array(["2", "1", "1"], object)
    universe = Object(atoms=group(types=types), trajectory=None)
    found = clrt.read(universe)
    assert found.type_names == ("1", "2")
    assert same(found.types, [1, 0, 0])
    assert found.elements is None
    names = np.array(["CA", "CD", "HG"], object)
    guessed = group(names=names, types=names, resnames=np.array(["CA", "GLU", "ALA"], object))
    assert same(clrt.read(guessed).elements, [20, 6, 1])


def test_ases_origin() -> None:
    ase = pytest.importorskip("ase")
    atoms = ase.Atoms("OH2", POSITIONS, cell=[10, 10, 10], celldisp=[-5, -5, -5])
    assert same(clrt.read(atoms).origin, [-5, -5, -5])
    atoms.info["Origin"] = [1, 2, 3]
    atoms.set_momenta(POSITIONS)
    found = clrt.read(atoms)
    assert same(found.origin, [1, 2, 3])
    assert (found.values["momenta_y"] == POSITIONS[:, 1]).all()


def test_ovitos_text_and_radii_of_0() -> None:
    own = {"Radius": np.zeros(3), "Residue": np.array(["A", "B", "C"], object)}
    found = clrt.read(Object(particles=Properties(KINDS, **own), cell=None))
    assert list(found.texts["Residue"]) == ["A", "B", "C"]
    assert same(found.radii, [0.25, 0.5, 0.25])


class Listed:
    """A property of OVITO that is text: a slice of it is a list, and it is no array."""

    def __init__(self, *words: str) -> None:
        self.words = list(words)

    def __getitem__(self, key: slice) -> list[str]:
        return self.words[key]

    def __array__(self, *args: Any, **options: Any) -> Any:
        raise RuntimeError("OVITO property arrays of data type 'str' cannot be directly exposed")


def test_ovitos_molecules() -> None:
    """As it reads a PDB file: names are text, residues are types, and there are bonds."""
    residues = np.array([2, 2, 1]).view(Typed)
    residues.types = [Object(id=1, name="GLY"), Object(id=2, name="ALA")]
    properties = Properties(
        KINDS, **{"Atom Name": Listed("CA", "Cl", "CA"), "Residue Type": residues}
    )
    properties.bonds = Object(topology=np.array([[0, 2], [1, 2]]))
    found = clrt.read(Object(particles=properties, cell=None))
    assert list(found.texts["name"]) == ["CA", "Cl", "CA"]
    assert list(found.texts["residue"]) == ["ALA", "ALA", "GLY"]
    assert same(found.elements, [6, 17, 6])
    assert same(found.bonds, [[0, 2], [1, 2]])


class Typed(np.ndarray):  # type: ignore[type-arg]
    """An array with types."""

    types: list[Any]
