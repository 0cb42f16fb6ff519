#!/usr/bin/env bash
# The reader of legacy .vtk files in VTK 9.3.0 to 9.5.0 leaves its process in the locale "C": after
# it Python's open() takes files for ASCII, and a text in UTF-8 that was read before is an error.
# VTK 9.6.0 leaves the locale as it was.
#
# Seen on 2026-11-28 with Python 3.11 in the locale C.UTF-8. This script fails if that changes.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
printf '%s\n' '# vtk DataFile Version 3.0' points ASCII 'DATASET POLYDATA' 'POINTS 1 float' '0 0 0' > points.vtk
export LC_ALL=C.UTF-8
for case in 9.5.0:ANSI_X3.4-1968 9.6.0:UTF-8; do
    version=${case%%:*} expected=${case#*:}
    python3 -m venv "$version"
    "$version/bin/pip" install -q "vtk==$version"
    found=$("$version/bin/python" -c '
import locale
from vtkmodules.vtkIOLegacy import vtkGenericDataObjectReader
reader = vtkGenericDataObjectReader()
reader.SetFileName("points.vtk")
reader.Update()
assert reader.GetOutputDataObject(0).GetNumberOfPoints() == 1
print(locale.nl_langinfo(locale.CODESET))')
    echo "vtk $version: the encoding of files after reading points.vtk: $found"
    test "$found" = "$expected"
done
