"""The table of elements, held against ase's and gemmi's, and elements by names and masses."""

import gemmi
import numpy as np
import pytest

from clrt.particles import elements
from clrt.particles.particles import HEAVIEST

ALL = range(1, 119)


def test_every_element_has_a_row() -> None:
    assert len(elements.SYMBOLS) == HEAVIEST + 1
    arrays = elements.COLORS, elements.VAN_DER_WAALS, elements.COVALENT, elements.MASSES
    assert all(len(array) == HEAVIEST + 1 for array in arrays)
    assert (elements.VAN_DER_WAALS >= 1).all()
    assert (elements.COVALENT > 0).all()


def test_symbols_and_masses_are_gemmis() -> None:
    for z in ALL:
        assert elements.SYMBOLS[z] == gemmi.Element(z).name
        if z < 100:  # of heavier ones there are but isotopes, and each names another
            assert elements.MASSES[z] == pytest.approx(gemmi.Element(z).weight, abs=0.1)


def test_radii_are_gemmis_where_it_has_bondis() -> None:
    """Its other van der Waals radii are ionic ones; its C is sp2, its Lu and Hf are swapped."""
    bondi = "H He Li C N O F Ne Na Mg Si P S Cl Ar K Ni Cu Zn Ga As Se Br Kr Pd Ag Cd In Sn Te I Xe"
    for symbol in bondi.split():
        z = elements.NUMBERS[symbol]
        assert elements.VAN_DER_WAALS[z] == pytest.approx(gemmi.Element(z).vdw_r, abs=5e-3)
    for z in {*range(1, 97)} - {6, 71, 72}:
        assert elements.COVALENT[z] == pytest.approx(gemmi.Element(z).covalent_r, abs=5e-3)
    for z in range(98, 113):
        assert elements.COVALENT[z] == pytest.approx(gemmi.Element(z).covalent_r, abs=5e-3)


def test_the_table_is_ases() -> None:
    data = pytest.importorskip("ase.data")
    jmol = pytest.importorskip("ase.data.colors").jmol_colors
    alvarez = pytest.importorskip("ase.data.vdw_alvarez").vdw_radii
    assert tuple(data.chemical_symbols) == elements.SYMBOLS
    assert abs(elements.COLORS[1:110] - 255 * jmol[1:]).max() <= 0.5
    assert abs(elements.MASSES[1:] - data.atomic_masses[1:]).max() <= 1e-3
    assert (elements.COVALENT[1:97] == data.covalent_radii[1:97]).all()
    for z in range(1, 104):
        known = [r for r in (data.vdw_radii[z], alvarez[z]) if np.isfinite(r)]
        if known:
            assert elements.VAN_DER_WAALS[z] == known[0]
        else:
            assert elements.SYMBOLS[z] in ("Pm", "Fm", "Md", "No", "Lr")


@pytest.mark.parametrize(
    ("symbols", "numbers"),
    [
        (["H", "He", "og"], [1, 2, 118]),
        (["CL", "cl", "Cl"], [17, 17, 17]),
        (["D", "T", "X"], [1, 1, 0]),
        (["A", "B"], None),
        (["C1"], None),
        ([""], None),
        ([], []),
    ],
)
def test_of_symbols(symbols: list[str], numbers: list[int] | None) -> None:
    assert elements.of_symbols(symbols) == numbers


@pytest.mark.parametrize(
    ("names", "symbols"),
    [
        ("N CA C O CB CG1 CD2 CE3 OXT OD1 NE2", "N C C O C C C C O O N"),
        ("SG HG21 1HB 2HH1 HA", "S H H H H"),
        ("OW HW1 HW2 MG CL NA ZN SOD CLA POT CAL", "O H H Mg Cl Na Zn Na Cl K Ca"),
        ("Fe2+ Cl- C12 H_a Ca Si4", "Fe Cl C H Ca Si"),
        ("P31 C210 H2R O11", "P C H O"),
    ],
)
def test_of_names(names: str, symbols: str) -> None:
    found = elements.each_of_names(names.split())
    assert [elements.SYMBOLS[z or 0] for z in found] == symbols.split()


@pytest.mark.parametrize("name", ["A", "GL1", "", "12", "+", "QD", "Zz"])
def test_what_is_no_atoms_name(name: str) -> None:
    assert elements.each_of_names(["C", name]) == [6, None]


@pytest.mark.parametrize(
    ("masses", "symbols"),
    [
        ([1.008, 12.011, 15.9994, 14.007, 30.974, 22.99], "H C O N P Na"),
        ([12.0, 1.008, 16.0], "C H O"),
        ([2.014, 12.01], "H C"),
        ([39.948, 40.078, 39.0983], "Ar Ca K"),
        ([35.5, 55.85, 63.5], "Cl Fe Cu"),
    ],
)
def test_of_masses(masses: list[float], symbols: str) -> None:
    found = elements.of_masses(np.array(masses))
    assert found is not None
    assert found.dtype == np.uint8
    assert [elements.SYMBOLS[z] for z in found] == symbols.split()


@pytest.mark.parametrize(
    "masses",
    [
        [],
        [1.0, 1.0],
        [12.011, 15.035],
        [0.5],
        [np.nan],
        [72.0],
        [0],
        [12.0, 1.0, 16.0],
        [1.0, 4.0],
        [1.008, 4.003],
    ],
)
def test_masses_that_are_no_atoms(masses: list[float]) -> None:
    assert elements.of_masses(np.array(masses, float)) is None
