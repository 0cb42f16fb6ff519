"""Naming: what the name of a column says that it holds."""

import re
from collections.abc import Iterable
from typing import NamedTuple

# In small letters; the first that there is counts.
POSITIONS = ("positions", "position", "pos", "xyz", "points", "coordinates", "coords", "coord")
CENTERS = ("center", "centre", "centers", "centres", "location", "locations")
COLORS = ("colors", "color", "rgb")
COLOR_TRIPLES = (
    ("red", "green", "blue"),
    ("r", "g", "b"),
    ("diffuse_red", "diffuse_green", "diffuse_blue"),
)
RADII = ("radii", "radius", "r")
DIAMETERS = ("diameters", "diameter")
ELEMENTS = ("numbers", "elements", "element", "species", "symbols", "symbol")
TYPES = ("types", "type", "typeid")
NAMES = ("names", "name")
RESIDUES = ("residue", "resnames", "resname", "residues")
MASSES = ("masses", "mass")
ANGLES = ("theta", "phi", "angle", "azimuth", "polar", "zenith", "elevation", "inclination")
"""Beside one of these r is no radius."""
OPACITIES = ("opacity", "alpha", "transparency")
SHAPES = (("shapex", "shapey", "shapez"), ("c_shape[1]", "c_shape[2]", "c_shape[3]"))
"""Of ellipsoids: their diameters, or beside "blockiness1" the halves."""
SEMI_AXES = (
    ("asphericalshapex", "asphericalshapey", "asphericalshapez"),
    ("aspherical shape.x", "aspherical shape.y", "aspherical shape.z"),
    ("aspherical_shape_x", "aspherical_shape_y", "aspherical_shape_z"),
)
"""Of ellipsoids: the halves of their diameters."""
COORDINATES = {"x", "y", "z", "xu", "yu", "zu", "xs", "ys", "zs", "xsu", "ysu", "zsu"}

AXES = (("x", "y", "z"), ("0", "1", "2"), ("1", "2", "3"), ("r", "g", "b"))
PART = re.compile(r"^(.*?)[ :._\[]?([0123xyzrgb])\]?$")
"""A name and the axis behind it: Points:0, Points_0, position.x, pos[1], ColorR."""
UNIT = re.compile(r"^(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]$")
"""A name and its unit: X (nm), radius [m]."""
LENGTHS = {
    "m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6, "nm": 1e-9, "angstrom": 1e-10, "pm": 1e-12,
    "km": 1e3,
}  # fmt: skip
"""Metres."""
SPELT = {
    "µm": "um", "μm": "um", "micron": "um", "microns": "um", "micrometer": "um", "å": "angstrom",
    "a": "angstrom", "ang": "angstrom", "angstroms": "angstrom", "ångström": "angstrom",
    "nanometer": "nm", "nanometers": "nm", "meter": "m", "meters": "m", "metre": "m",
}  # fmt: skip


class Title(NamedTuple):
    """A column's name and the unit of length that stands behind it."""

    name: str
    unit: str | None


def title(text: str) -> Title:
    """The name that a header gives a column, and its unit: X (nm) is x in nm.

    What stands in brackets stays in a name that has no unit of length: pos[1], v (m/s).
    """
    if found := UNIT.match(text):
        unit = found[2].lower()
        unit = SPELT.get(unit, unit)
        if unit in LENGTHS:
            return Title(found[1], unit)
    return Title(text, None)


def triple(names: Iterable[str], bases: Iterable[str]) -> list[tuple[str, ...]]:
    """The names of columns that are the parts of one of these, with three parts or with two.

    Args:
        names: in small letters.
    """
    parts: dict[tuple[str, str], str] = {}
    for name in names:
        if found := PART.match(name):
            parts.setdefault((found[1], found[2]), name)
    found_all = list[tuple[str, ...]]()
    for base in bases:
        for axes in AXES:
            there = tuple(parts[base, axis] for axis in axes if (base, axis) in parts)
            if len(there) == 3 or (len(there) == 2 and there[0] == parts.get((base, axes[0]))):
                found_all.append(there)
    return found_all
