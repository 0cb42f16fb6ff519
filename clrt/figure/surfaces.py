"""Surfaces: a mesh in a figure, alone or beside particles."""

import os
from collections.abc import Sequence
from typing import Any, NamedTuple

from msgspec.structs import replace

from clrt.errors import RequestError, SceneError, called
from clrt.files.meshes.reader import read_mesh, read_with_limits
from clrt.film.color import linear, srgb
from clrt.scene.material import Material
from clrt.scene.mesh import Mesh
from clrt.values import Array, Color

MATERIAL = "mesh"
"""The name of its material in the figure's scene."""
ALONE, BESIDE = (70, 130, 180), (200, 200, 200)
"""sRGB, where it has no colours: as particles have, or beside them."""


class Surface(NamedTuple):
    """A mesh, and how it is drawn."""

    mesh: Mesh
    color: Array | None
    """(3,): linear, of all; None: its own, or that of a mesh alone or beside particles."""
    opacity: float
    by: str = ""
    """The numbers that give its colours."""
    clim: tuple[float, float] | None = None
    """What the map's ends stand for, if there are any."""


def read(
    source: Any,
    color: str | Sequence[float] | None = None,
    opacity: float | None = None,
    cmap: str | None = None,
    clim: Any = None,
) -> Surface:
    """A mesh of a file or of an object.

    Args:
        source: see clrt.read_mesh().
        color: a colour, or the name of numbers of its vertices or faces.
        opacity: from 0 to 1; None: 1.
        cmap, clim: of those numbers; words of trajectories' are as None.

    Raises:
        RequestError: it cannot be read, is without faces, or has no such numbers.
    """
    found = _read(source, color, opacity, cmap, clim)
    if not len(found.mesh):
        name = source if isinstance(source, str | os.PathLike) else "mesh"
        raise SceneError(f"{name}: expected faces that have an area, got none")
    return found


def _read(
    source: Any,
    color: str | Sequence[float] | None,
    opacity: float | None,
    cmap: str | None,
    clim: Any,
) -> Surface:
    opacity = 1.0 if opacity is None else opacity
    if not isinstance(opacity, int | float) or not 0 <= opacity <= 1:
        raise SceneError(f"mesh_opacity: expected a number from 0 to 1, got {opacity!r}")
    if color is None:
        return Surface(read_mesh(source), None, opacity)
    try:
        tint = linear(srgb("mesh_color", color))
        return Surface(read_mesh(source).without_colors(), tint, opacity)
    except RequestError as error:
        if not isinstance(color, str) or not str(error).startswith("mesh_color"):
            raise
    ends = None if isinstance(clim, str) else clim
    with called({"color": "mesh_color"}):
        mesh, limits = read_with_limits(source, color=color, cmap=cmap or "viridis", clim=ends)
    return Surface(mesh, None, opacity, color, limits)


def shown(surface: Surface, style: Material, alone: bool) -> tuple[Mesh, Material]:
    """The mesh and its material, by that of a figure's style.

    Raises:
        SceneError: a style whose surfaces mirror has no opacity.
    """
    if style.reflection > 0 and surface.opacity < 1:
        raise SceneError(
            f"mesh_opacity: expected 1 beside a style that mirrors, got {surface.opacity:g}"
        )
    tint = surface.color
    if tint is None and surface.mesh.colors is None:
        tint = linear([part / 255 for part in (ALONE if alone else BESIDE)])
    changes: dict[str, Any] = {"opacity": surface.opacity}
    if tint is not None:
        changes |= {key: _times(getattr(style, key), tint) for key in ("ambient", "diffuse")}
    return surface.mesh.made_of(MATERIAL), replace(style, **changes)


def _times(color: Color, tint: Array) -> Color:
    red, green, blue = (part * float(by) for part, by in zip(color, tint, strict=True))
    return red, green, blue
