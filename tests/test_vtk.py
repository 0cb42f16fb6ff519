"""VTK's files of points, written by vtk."""

import importlib
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from conftest import same

import clrt

POINTS = np.array([[0, 0, 0], [1, 2, 3], [4, 5, 6.5]])


def written(path: Path, lines: bool = False) -> Any:
    """A file of three points, as VTK writes it."""
    pytest.importorskip("vtkmodules")
    numpy_to_vtk = importlib.import_module("vtkmodules.util.numpy_support").numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData, vtkUnstructuredGrid

    points = vtkPoints()
    points.SetDataTypeToDouble()
    points.SetData(numpy_to_vtk(POINTS, deep=True))
    data: Any = vtkUnstructuredGrid() if path.suffix == ".vtu" else vtkPolyData()
    data.SetPoints(points)
    if path.suffix == ".vtu":
        for i in range(3):
            data.InsertNextCell(1, 1, [i])
    else:
        cells = vtkCellArray()
        for i in range(3):
            cells.InsertNextCell(1, [i])
        data.SetVerts(cells)
    if lines:
        cells = vtkCellArray()
        cells.InsertNextCell(2, [0, 1])
        data.SetLines(cells)
    for name, column in (("radius", [1.0, 2, 3]), ("v", POINTS), ("type", np.array([1, 2, 1]))):
        array = numpy_to_vtk(np.asarray(column), deep=True)
        array.SetName(name)
        data.GetPointData().AddArray(array)
    module, name = {
        ".vtk": ("vtkIOLegacy", "vtkPolyDataWriter"),
        ".vtu": ("vtkIOXML", "vtkXMLUnstructuredGridWriter"),
        ".vtp": ("vtkIOXML", "vtkXMLPolyDataWriter"),
    }[path.suffix]
    writer = getattr(importlib.import_module(f"vtkmodules.{module}"), name)()
    writer.SetFileName(str(path))
    writer.SetInputData(data)
    writer.Write()


@pytest.mark.parametrize("suffix", [".vtp", ".vtu", ".vtk"])
def test_points_and_their_arrays(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"a{suffix}"
    written(path)
    # Only these: objects of other tests that are freed meanwhile may warn as well.
    with warnings.catch_warnings(action="error", category=clrt.ParticleWarning):
        found = clrt.read(path)
    assert (found.positions == POINTS).all()
    assert same(found.radii, [1, 2, 3])
    assert same(found.types, [1, 2, 1])
    assert found.values["v_z"].tolist() == [0, 3, 6.5]


def test_cells_that_are_not_used(tmp_path: Path) -> None:
    written(tmp_path / "a.vtp", lines=True)
    with pytest.warns(clrt.ParticleWarning, match="a.vtp: 4 cells are not used: their points are"):
        assert len(clrt.read(tmp_path / "a.vtp")) == 3


def test_faults(tmp_path: Path) -> None:
    pytest.importorskip("vtkmodules")
    for name, content in (("a.vtp", "rubbish"), ("a.vtk", "rubbish"), ("a.vtu", "<VTKFile/>")):
        (tmp_path / name).write_text(content)
        with pytest.raises(clrt.SceneError, match=f"{name}: expected a VTK file of points"):
            clrt.read(tmp_path / name)
