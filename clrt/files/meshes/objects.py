"""Other libraries' objects that hold meshes, known by their shape: none is imported."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from clrt.errors import SceneError
from clrt.files.meshes.surface import Surface, triangles
from clrt.values import Array


def read(source: Any) -> Surface:
    """What trimesh's Trimesh, PyVista's PolyData, Open3D's TriangleMesh, a tuple (vertices, faces)
    or scikit-image's (vertices, faces, normals, values), or a dict of those names holds.

    Raises:
        SceneError: it is nothing of the kind.
    """
    if isinstance(source, Mapping):
        return _of_mapping(source)
    if isinstance(source, tuple | list):
        return _of_tuple(source)
    if hasattr(source, "point_data") and hasattr(source, "faces"):
        return _of_pyvista(source)
    if hasattr(source, "triangles") and hasattr(source, "vertices"):
        return _of_open3d(source)
    if hasattr(source, "vertices") and hasattr(source, "faces"):
        return _of_trimesh(source)
    expected = "a file's name, a Mesh, (vertices, faces), or an object with vertices and faces"
    raise SceneError(f"mesh: expected {expected}, got {type(source).__name__}")


def _of_mapping(source: Mapping[str, Any]) -> Surface:
    given = dict(source)
    known = ("vertices", "faces", "normals", "colors")
    if "vertices" not in given or "faces" not in given:
        names = ", ".join(map(str, given)) or "none"
        raise SceneError(f"mesh: expected the keys vertices and faces, got {names}")
    parts = [None if given.get(key) is None else np.asarray(given[key]) for key in known]
    columns = {str(key): np.asarray(one) for key, one in given.items() if key not in known}
    return Surface(parts[0], parts[1], parts[2], parts[3], columns)  # type: ignore[arg-type]


def _of_tuple(source: Any) -> Surface:
    if not 2 <= len(source) <= 4:
        expected = "(vertices, faces), with normals and values or without"
        raise SceneError(f"mesh: expected {expected}, got {len(source)} of them")
    vertices, faces, *more = (None if one is None else np.asarray(one) for one in source)
    columns = {"values": more[1]} if len(more) > 1 and more[1] is not None else {}
    return Surface(vertices, faces, more[0] if more else None, None, columns)  # type: ignore[arg-type]


def _of_trimesh(mesh: Any) -> Surface:
    """Without its normals: it does not tell those that were given from those it has worked out."""
    visual = getattr(mesh, "visual", None)
    colors = None
    if getattr(visual, "defined", False):
        kind = getattr(visual, "kind", None)
        if kind in ("vertex", "face"):
            colors = np.asarray(getattr(visual, f"{kind}_colors"))[:, :3]
    columns = {
        str(name): array
        for given in (getattr(mesh, "vertex_attributes", {}), getattr(mesh, "face_attributes", {}))
        for name, one in dict(given).items()
        if (array := np.asarray(one)).ndim == 1
    }
    return Surface(np.asarray(mesh.vertices), np.asarray(mesh.faces), None, colors, columns)


def _of_open3d(mesh: Any) -> Surface:
    def there(name: str) -> Array | None:
        found = np.asarray(getattr(mesh, name, ()))
        return found if len(found) else None

    vertices, faces = np.asarray(mesh.vertices), np.asarray(mesh.triangles)
    return Surface(vertices, faces, there("vertex_normals"), there("vertex_colors"))


def _of_pyvista(mesh: Any) -> Surface:
    """Polygons are cut into triangles; its lines and points are none of a surface."""
    flat = np.asarray(mesh.faces)
    counts, starts, at = [], [], 0
    if flat.size and flat.size % 4 == 0 and (flat[::4] == 3).all():
        corners = flat.reshape(-1, 4)[:, 1:]
        polygon = np.arange(len(corners))
    else:
        while at < len(flat):
            counts.append(int(flat[at]))
            starts.append(at + 1)
            at += 1 + counts[-1]
        corners, polygon = triangles(flat, np.array(starts, np.int64), np.array(counts, np.int64))
    columns: dict[str, Array] = {}
    normals = colors = None
    for given, where in ((mesh.cell_data, polygon), (mesh.point_data, slice(None))):
        for name in given.keys():  # noqa: SIM118
            array = np.asarray(given[name])
            if len(array) == 0 or (where is polygon and len(array) <= int(polygon.max(initial=-1))):
                continue
            array = array[where]
            if name in ("RGB", "RGBA", "colors") and array.ndim == 2 and array.shape[1] in (3, 4):
                colors = array[:, :3]
            elif name == "Normals" and where is not polygon and array.shape[1:] == (3,):
                normals = array
            elif array.ndim == 1 and array.dtype.kind in "biuf":
                columns[str(name)] = array
    return Surface(np.asarray(mesh.points), corners, normals, colors, columns)
