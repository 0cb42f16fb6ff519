"""Meshes by a file's name or of an object: which of the readers reads it."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from clrt.errors import RequestError, SceneError, named
from clrt.files.meshes import obj, objects, ply, stl
from clrt.files.meshes.surface import Surface
from clrt.files.particles import opened, rules, suffix
from clrt.files.particles.text import Lines
from clrt.film import color as colors
from clrt.particles import palette
from clrt.scene.mesh import Mesh, Shading
from clrt.values import Array, some

READERS: dict[str, Callable[[Lines], Surface]] = {
    ".ply": ply.read,
    ".stl": stl.read,
    ".obj": obj.read,
}
"""By suffix, in small letters."""


def is_mesh(path: Path) -> bool:
    """Whether a file is a mesh by its name, or, a .ply, by the faces that it says to have."""
    end = suffix.split(path)[0]
    return end in READERS and (end != ".ply" or ply.has_faces(path))


def read_mesh(
    source: Any,
    material: str = "",
    shading: Shading | None = None,
    *,
    color: str | None = None,
    cmap: str = "viridis",
    clim: tuple[float, float] | None = None,
) -> Mesh:
    """A mesh of a file or of an object.

    Args:
        source: the name of a .ply, .stl or .obj file, packed or not. Or trimesh's Trimesh,
            PyVista's PolyData, Open3D's TriangleMesh, (vertices, faces), scikit-image's (vertices,
            faces, normals, values), or a dict of these names.
        material: the name of the scene's material that it has.
        shading: "flat", "gouraud" or "phong"; None: "phong" where there are normals, else "flat".
        color: the name of numbers of its vertices or faces, which give colours; of scikit-image's
            "values". None: the file's colours, or white.
        cmap: the colour map of those numbers.
        clim: what its ends stand for; None: the least and the largest finite number.

    Returns:
        it in the file's units. Colours of files are sRGB; those of the mesh are linear.

    Raises:
        SceneError: it cannot be read; the message names file, line and what was expected.
        RequestError: the suffix is of no format, or an extra is missing.
    """
    made, _ = read_with_limits(source, color, cmap, clim)
    return made.made_of(material or made.material, shading)


def read_with_limits(
    source: Any,
    color: str | None = None,
    cmap: str = "viridis",
    clim: tuple[float, float] | None = None,
) -> tuple[Mesh, tuple[float, float] | None]:
    """As read_mesh(), and what the ends of the colour map stand for; None: no numbers give the
    colours."""
    if isinstance(source, Mesh):
        if color is not None:
            raise SceneError(f"color: expected none, for a Mesh has its colours, got {color!r}")
        return source, None
    is_file = isinstance(source, str | os.PathLike)
    name = str(source) if is_file else type(source).__name__
    found = _of_file(Path(source)) if is_file else objects.read(source)
    with named(name, SceneError):
        chosen = _colors(found, color, cmap, clim)
        made = Mesh(found.vertices, found.faces, found.normals, chosen)
    return made, None if color is None else palette.limits(found.columns[color], clim)


def is_mesh_like(source: Any) -> bool:
    """Whether an object, which is no file's name, is a mesh by its shape."""
    if isinstance(source, Mesh):
        return True
    names = ("points", "faces"), ("vertices", "faces"), ("vertices", "triangles")
    return any(all(hasattr(source, name) for name in pair) for pair in names)


def _of_file(path: Path) -> Surface:
    read = READERS.get(suffix.split(path)[0])
    if read is None:
        known = f"expected a mesh in a file that ends in {', '.join(READERS)}"
        raise RequestError(f"{path}: {known}; trimesh.load reads others, clrt takes what it gives")
    try:
        lines = opened.lines(path)
    except OSError as error:
        raise SceneError(f"{path}: cannot be read: {error.strerror or error}") from None
    with lines.file:
        try:
            return read(lines)
        except (OSError, EOFError) as error:
            raise SceneError(f"{path}: cannot be read: {error}") from None


def _colors(
    found: Surface, color: str | None, cmap: str, clim: tuple[float, float] | None
) -> Array | None:
    """Linear RGB of vertices or faces."""
    if color is not None:
        if color not in found.columns:
            known = some(found.columns)
            raise SceneError(f"color: expected the name of numbers ({known}), got {color!r}")
        return colors.linear(palette.of_values(found.columns[color], cmap, clim))
    if found.colors is None:
        return None
    given = rules.bytes_of(np.asarray(found.colors))
    if given.dtype.kind in "iu" and given.dtype != np.uint8:
        given = given.astype(np.uint8)
    return colors.linear(given)
