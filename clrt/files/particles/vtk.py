"""VTK's files of points, read by the vtk wheel (https://vtk.org), the extra clrt[vtk]."""

import importlib
from pathlib import Path
from typing import Any

import numpy as np

from clrt.errors import RequestError, SceneError
from clrt.files.particles import rules
from clrt.files.particles.columns import particles
from clrt.files.particles.suffix import split
from clrt.particles.particles import Particles
from clrt.values import Array

READERS = {
    ".vtp": ("vtkmodules.vtkIOXML", "vtkXMLPolyDataReader"),
    ".vtu": ("vtkmodules.vtkIOXML", "vtkXMLUnstructuredGridReader"),
    ".vtk": ("vtkmodules.vtkIOLegacy", "vtkGenericDataObjectReader"),
}


def read(path: Path) -> Particles:
    """The points of a file, with the arrays that have a value for each.

    Raises:
        RequestError: vtk is not installed.
        SceneError: it cannot be read, or has no points.
    """
    module, name = READERS[split(path)[0]]
    try:
        reader = getattr(importlib.import_module(module), name)()
        to_numpy = importlib.import_module("vtkmodules.util.numpy_support").vtk_to_numpy
    except ImportError:
        raise RequestError(f"{path}: needs vtk: pip install 'clrt[vtk]'") from None
    faults: list[str] = []

    def note(sender: Any, event: str) -> None:
        faults.append(event)

    reader.AddObserver("ErrorEvent", note)
    if hasattr(reader, "GetXMLParser"):
        for event in ("ErrorEvent", "WarningEvent"):
            reader.AddObserver(event, note)
    reader.SetFileName(str(path))
    reader.Update()
    data = (
        reader.GetOutput() if not name.startswith("vtkGeneric") else reader.GetOutputDataObject(0)
    )
    points = data.GetPoints() if hasattr(data, "GetPoints") else None
    if faults or points is None:
        raise SceneError(f"{path}: expected a VTK file of points, which vtk can read")
    columns: dict[str, Array] = {}
    arrays = data.GetPointData()
    for i in range(arrays.GetNumberOfArrays()):
        found, called = arrays.GetArray(i), arrays.GetArrayName(i) or f"array{i}"
        if found is None:  # of text
            texts = arrays.GetAbstractArray(i)
            columns[called] = np.array(
                [texts.GetValue(k) for k in range(texts.GetNumberOfValues())]
            )
        else:
            columns[called] = to_numpy(found)
    for taken in ("positions", "position", "pos", "xyz", "x", "y", "z", "points"):
        # What a file says beside its points is no second position.
        if taken in (lower := {one.lower(): one for one in columns}):
            columns[f"{lower[taken]} (array)"] = columns.pop(lower[taken])
    columns = {"positions": to_numpy(points.GetData()), **columns}
    _say_unused(data, str(path))
    return particles(columns, str(path))


def _say_unused(data: Any, source: str) -> None:
    """Names cells that are no points, and what they have."""
    surfaces = 0
    for kind in ("Polys", "Lines", "Strips"):
        surfaces += getattr(data, f"GetNumberOf{kind}", int)()
    if not hasattr(data, "GetNumberOfPolys"):
        surfaces = sum(
            data.GetCell(i).GetCellDimension() > 0
            for i in range(min(data.GetNumberOfCells(), 1000))
        )
    if surfaces:
        rules.say(source, f"{data.GetNumberOfCells()} cells are not used: their points are drawn")
    cells = data.GetCellData()
    if names := [cells.GetArrayName(i) or "" for i in range(cells.GetNumberOfArrays())]:
        rules.say(source, f"arrays of cells are not used: {', '.join(names)}")
