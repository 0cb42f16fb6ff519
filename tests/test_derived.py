"""Columns that follow from others: lengths of vectors, and what a particle is by its names."""

from typing import Any

import numpy as np
import pytest

import clrt

THREE = np.eye(3)


def columns_of(*names: str) -> list[str]:
    found = clrt.Particles(THREE, values={name: [3.0, 0, np.nan] for name in names})
    return [name for name in found.columns if name not in ("x", "y", "z", "index", *names)]


@pytest.mark.parametrize(
    ("names", "made"),
    [
        (("vx", "vy", "vz"), ["v", "speed"]),
        (("fx", "fy", "fz"), ["f", "force"]),
        (("velocity_x", "velocity_y", "velocity_z"), ["velocity", "speed"]),
        (("VX", "VY", "VZ"), ["V", "speed"]),
        (("forces_X", "forces_Y", "forces_Z"), ["forces", "force"]),
        (("mux", "muy", "muz", "vx", "vy", "vz"), ["mu", "v", "speed"]),
        (("vx", "vy"), []),
        (("vx", "vy", "Vz"), []),
        (("vx", "vy", "vz", "v"), ["speed"]),
        (("vx", "vy", "vz", "speed"), ["v"]),
        (("_x", "_y", "_z"), []),
    ],
)
def test_lengths(names: tuple[str, ...], made: list[str]) -> None:
    assert sorted(columns_of(*names)) == sorted(made)


def test_a_length_is_one() -> None:
    half = np.array([4, 0, np.nan], np.float32)
    values: dict[str, Any] = {"vx": [3, 0, 1], "vy": half, "vz": [12, 0, 1]}
    found = clrt.Particles(THREE, values=values)
    assert found.column("speed")[:2].tolist() == [13, 0]
    assert np.isnan(found.column("v")[2])


NAMES: dict[str, dict[str, list[str]]] = {
    "water": {"residue": ["HOH", "SOL", "TIP3", "wat", "T4P"], "name": ["OW", "HW1", "MW"]},
    "protein": {"residue": ["ALA", "HSD", "NALA", "CHIE", "MSE", "ACE"]},
    "nucleic": {"residue": ["DA", "DG5", "A", "RU3", "U", "CYT"]},
    "ions": {"residue": ["NA", "CL-", "SOD", "CLA", "ZN2"], "name": ["Na+", "POT"]},
    "": {"residue": ["POPC", "LIG", "", "NAG"], "name": ["CA", "CB", "HG", "CD"]},
}


@pytest.mark.parametrize("of", ["residue", "name"])
def test_what_names_tell(of: str) -> None:
    kinds, names = zip(
        *((kind, name) for kind, by in NAMES.items() for name in by.get(of, ())), strict=True
    )
    found = clrt.Particles(np.zeros((len(names), 3)), texts={of: np.array(names)})
    asked = [kind for kind in ("water", "protein", "nucleic", "ions") if of in NAMES[kind]]
    assert [kind for kind in ("hydrogen", *NAMES) if kind in found.columns] == asked
    for kind in asked:
        assert found.column(kind).tolist() == [kind == one for one in kinds], kind


def test_types_that_are_names_tell_as_well() -> None:
    found = clrt.Particles(THREE, types=[0, 1, 1], type_names=("OW", "Na"))
    assert found.column("water").tolist() == [True, False, False]
    assert found.column("type").tolist() == ["OW", "Na", "Na"]
    assert "water" not in clrt.Particles(THREE, types=[0, 1, 1]).columns


def test_hydrogen_is_an_element() -> None:
    found = clrt.Particles(THREE, elements=[1, 6, 1])
    assert found.column("hydrogen").tolist() == [True, False, True]
    assert found.column("element").tolist() == ["H", "C", "H"]
    assert found.column("index").tolist() == [0, 1, 2]


def test_a_file_s_own_columns_count() -> None:
    own: dict[str, Any] = {"water": [1.0, 2, 3]}
    found = clrt.Particles(THREE, values=own, texts={"residue": np.array(["HOH"] * 3)})
    assert found.column("water").tolist() == own["water"]
