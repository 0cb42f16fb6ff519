"""GSD, read by gsd (https://gsd.readthedocs.io), the extra clrt[gsd]."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from clrt.errors import RequestError
from clrt.files.particles import rules
from clrt.files.particles.columns import particles
from clrt.particles.particles import Particles
from clrt.values import Array


class Frames:
    """The frames of a GSD file, one in memory at a time.

    Raises:
        RequestError: gsd is not installed.
    """

    def __init__(self, path: Path) -> None:
        try:
            import gsd.hoomd
        except ImportError:
            raise RequestError(f"{path}: needs gsd: pip install 'clrt[gsd]'") from None
        self.source = str(path)
        self.file = gsd.hoomd.open(self.source, "r")

    def frame(self, k: int) -> Particles | None:
        """Frame k, or None after the last one."""
        return of_frame(self.file[k], f"{self.source}: frame {k}") if k < self.count() else None

    def count(self) -> int:
        return len(self.file)

    def close(self) -> None:
        self.file.close()


def of_frame(frame: Any, source: str) -> Particles:
    """A frame of gsd's, whose box is centred on 0."""
    part = frame.particles
    columns = {
        "positions": part.position,
        "diameter": part.diameter,
        "typeid": part.typeid,
        "mass": part.mass,
        "charge": part.charge,
    }
    columns = {name: np.asarray(given) for name, given in columns.items() if given is not None}
    for i, axis in enumerate("xyz" if part.velocity is not None else ""):
        columns[f"v{axis}"] = np.asarray(part.velocity)[:, i]
    for name, given in frame.log.items():
        if name.startswith("particles/"):
            columns[name.removeprefix("particles/")] = np.asarray(given)
    cell = None
    if frame.configuration.box is not None:
        cell = cell_of(frame.configuration.box)
    origin = np.zeros(3) if cell is None else -cell.sum(axis=0) / 2
    names = tuple(part.types) if part.types else None
    if (radii := _by_shape(part, source)) is not None:
        columns["diameter"] = 2 * radii
    bonds = getattr(getattr(frame, "bonds", None), "group", None)
    if bonds is not None and len(bonds) == 0:
        bonds = None
    step = getattr(frame.configuration, "step", None)
    facts = {} if step is None else {"step": int(step)}
    return particles(columns, source, cell, origin, names, bonds=bonds, facts=facts)


def cell_of(box: Any) -> Array:
    """(3, 3), a row for each edge, of HOOMD's box: lengths, and tilts that are parts of them."""
    x, y, z, xy, xz, yz = np.asarray(box, np.float64)
    return np.array([[x, 0, 0], [xy * y, y, 0], [xz * z, yz * z, z]])


def _by_shape(part: Any, source: str) -> Array | None:
    """(n,) radii of spheres around the types' shapes, or None: there are no shapes. A particle of
    a type without one keeps its diameter; a diameter other than 1, gsd's default, counts for a
    sphere.

    https://gsd.readthedocs.io/en/stable/shapes.html
    """
    shapes = list(getattr(part, "type_shapes", None) or [])
    if not any(shapes) or part.typeid is None:
        return None
    n = len(part.position)
    typeid = np.asarray(part.typeid)
    own = np.ones(n) if part.diameter is None else np.asarray(part.diameter, np.float64)
    radii, said = own / 2, list[str]()
    for k, shape in enumerate(shapes):
        if not (of := np.flatnonzero(typeid == k)).size or not shape:
            continue
        kind, radius = str(shape.get("type")), _around(shape)
        if radius is None:
            said.append(f"{kind} (unknown: spheres of the diameters)")
            continue
        if kind != "Sphere":
            said.append(kind)
            radii[of] = radius
        else:
            radii[of] = np.where(own[of] == 1, radius, own[of] / 2)
    if said:
        names = ", ".join(dict.fromkeys(said))
        rules.say(source, f"type_shapes: {names}: are drawn as the spheres around them")
    return radii


def _around(shape: Mapping[str, Any]) -> float | None:
    """The radius around the origin that holds a shape, or None: nobody knows."""
    kind = shape.get("type")
    if kind == "Sphere":
        return float(shape["diameter"]) / 2
    if kind == "Ellipsoid":
        return float(max(shape[axis] for axis in "abc" if axis in shape))
    if kind == "SphereUnion":
        centers = np.linalg.norm(np.asarray(shape["centers"], np.float64), axis=1)
        return float((centers + np.asarray(shape["diameters"], np.float64) / 2).max())
    if "vertices" in shape:
        corners = np.asarray(shape["vertices"], np.float64)
        return float(np.linalg.norm(corners, axis=1).max()) + float(
            shape.get("rounding_radius") or 0.0
        )
    return None
