"""Files of real programs: every field that was written is found, with its values, or named."""

import ast
import tomllib
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from corpus import make

import clrt

FOLDER = Path(__file__).parent / "corpus"
EXPECTED = tomllib.loads((FOLDER / "expected.toml").read_text())
CELL = np.array([[4.0, 0, 0], [1, 5, 0], [0, 0, 6]])


def values_of(field: str) -> np.ndarray:
    """By a name of make.py, or as they are written."""
    if field in ("AT", "RADII", "COLORS", "SPEED", "VELOCITY"):
        return np.asarray(getattr(make, field))
    return CELL if field == "CELL" else np.array(ast.literal_eval(field))


def found_at(particles: clrt.Particles, place: str) -> Any:
    kind, _, name = place.partition(" ")
    found = getattr(particles, kind)
    if kind == "colors" and found.dtype != np.uint8:
        return np.rint(found * 255)
    if kind not in ("values", "texts"):
        return found
    if name in found:
        return found[name]
    for join in ("_", ""):
        parts = [f"{name}{join}{axis}" for axis in "xyz"]
        if all(part in found for part in parts):
            return np.stack([found[part] for part in parts], axis=1)
    return None


def test_the_table_has_all_files() -> None:
    files = {path.name for path in FOLDER.iterdir() if path.suffix not in (".py", ".toml")}
    assert files - {"__pycache__"} == EXPECTED.keys()


@pytest.mark.parametrize("name", EXPECTED)
def test_no_field_is_lost_in_silence(name: str) -> None:
    if name.rpartition(".")[2] in ("vtp", "vtu", "vtk"):
        pytest.importorskip("vtkmodules")
    expected, path = EXPECTED[name], FOLDER / name
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        frames = list(clrt.read_frames(path))
    said = [str(one.message).removeprefix(f"{path}: ") for one in caught]
    assert said == expected["said"] * len(frames)
    assert len(frames) == expected.get("frames", 1)
    silent = []
    for field, place in expected["fields"].items():
        if place.startswith("said "):
            if not any(place.removeprefix("said ") in line for line in said):
                silent.append(field)
            continue
        found = found_at(frames[0], place)
        if found is None:
            silent.append(field)
        elif found.dtype.kind in "SU":
            assert found.tolist() == values_of(field).tolist()
        else:
            assert np.allclose(found, values_of(field), rtol=1e-6, atol=1e-7), place
    assert silent == []
