"""ParticleFile: a scene's entry for a file of particles: where it is, and how they are drawn."""

import math
import operator
from collections.abc import Mapping
from typing import Any, Literal

import msgspec
import numpy as np
from msgspec.structs import force_setattr

from clrt.errors import RequestError, SceneError
from clrt.particles import palette
from clrt.values import count, number, require, switches

STYLE_NAMES = ("soft", "matte", "outline", "mirror", "ball-and-stick")
"""Materials that a scene need not have: it gets those of clrt.figure.styles."""
PLAIN = STYLE_NAMES[0]
"""The material of particles, if they are given no other."""
BONDS = ("file", "auto", "none")
ATOMS = "atoms"
"""Bonds have the colours of what they join."""


class ParticleFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A file of particles, each of which is a sphere."""

    file: str
    """In a scene file relative to its folder."""
    frame: int = 0
    material: str = PLAIN
    select: str | None = None
    hide: str | None = None
    """Expressions over columns (clrt.particles.expression): which particles there are, and which of
    them there are not. None: all."""
    wrap: bool = False
    """Particles are moved into their box."""
    replicate: tuple[int, int, int] = (1, 1, 1)
    """How many images there are along each edge of their box."""
    radius: float | dict[str, float] | None = None
    """Of all, world units, or of types, elements and names. None, and for those of which nothing
    is said: the file's, or else the elements' van der Waals radii, or else half the median distance
    between nearest neighbours."""
    balls: bool = False
    """As in the style ball-and-stick: radii that `radius` does not give are smaller, and there are
    bonds."""
    scale: float = 1.0
    """Of all radii."""
    color: str | None = None
    """ "file", "element", "type" or "material", or an expression over columns. None: the first of
    those four that there is; but where the material is a style's, steel blue for "material"."""
    colors: str | dict[str, str | tuple[float, float, float]] | None = None
    """sRGB, of all, or of types, elements, names, or texts of the column that gives the colours."""
    opacity: float | str | None = None
    """Of all, or an expression over columns. None: the file's, or else 1."""
    cmap: str = "viridis"
    """The colour map of a column."""
    clim: tuple[float, float] | Literal["first", "all"] | None = None
    """What the map's ends stand for. None: the least and the largest finite value; of a trajectory
    those of ten frames, of the "first", or of "all"."""
    cell: bool | Literal["solid"] = False
    """The edges of the file's box are drawn; "solid": as capsules, which throw shadows."""
    bonds: str | float | None = None
    """ "file": the file's, and those that names of residues tell; "auto": of atoms nearer than 1.2
    times the sum of their covalent radii, no two of hydrogen; a distance, world units: of all that
    are nearer; "none". None: "none", but of balls the file's, or else "auto" where elements are
    known."""
    bond_radius: float | None = None
    """World units. None: 0.15 angstroms where the file's unit or its elements are known, else 0.3
    of the least radius."""
    bond_color: str = ATOMS
    """ "atoms": each half that of its particle; or sRGB."""
    labels: str | None = None
    """A column, or an expression over columns, that is written at each particle that is seen."""
    vectors: str | None = None
    """Arrows at the particles: "v" stands for the columns vx, vy and vz."""
    vector_scale: float | None = None
    """How long arrows are, in their vectors. None: their mean is twice the median radius."""
    vector_color: str = ATOMS
    """ "atoms": that of its particle; or sRGB."""

    def __post_init__(self) -> None:
        require(isinstance(self.file, str) and self.file != "", "file", "a file's name", self.file)
        count(self, "frame", 0, 2**31 - 1)
        require(isinstance(self.material, str), "material", "a material's name", self.material)
        coloring(self)
        switches(self, "balls")


MOST_IMAGES = 10**6


def _key(key: Any) -> str:
    """A type's number, an element's symbol or a name, as text."""
    return str(key)


def coloring(struct: Any) -> None:
    """Checks which particles are drawn and how: what a ParticleFile and a Look have alike."""
    for key in ("select", "hide", "labels"):
        text = getattr(struct, key)
        require(text is None or isinstance(text, str), key, "an expression", text)
    switches(struct, "wrap")
    try:
        counts = tuple(operator.index(one) for one in struct.replicate)
        good = len(counts) == 3 and min(counts) >= 1 and math.prod(counts) <= MOST_IMAGES
    except TypeError:
        counts, good = (), False
    most = f"three whole numbers from 1, at most {MOST_IMAGES:,} images in all"
    require(good, "replicate", most, struct.replicate)
    force_setattr(struct, "replicate", counts)
    if isinstance(struct.radius, Mapping):
        radii = {_key(key): one for key, one in struct.radius.items()}
        for key, one in radii.items():
            fine = isinstance(one, int | float | np.number) and bool(0 < one < math.inf)
            require(fine, f"radius[{key}]", "a finite number above 0", one)
        force_setattr(struct, "radius", {key: float(one) for key, one in radii.items()})
    elif struct.radius is not None and not isinstance(struct.radius, np.ndarray):
        number(struct, "radius", "a finite number above 0", lambda radius: radius > 0)
    if isinstance(struct.colors, Mapping):
        force_setattr(struct, "colors", {_key(key): one for key, one in struct.colors.items()})
    bonds = struct.bonds
    if not (bonds is None or isinstance(bonds, bool | np.ndarray) or bonds in BONDS):
        expected = "'file', 'auto', 'none' or a distance above 0"
        require(not isinstance(bonds, str), "bonds", expected, bonds)
        number(struct, "bonds", expected, lambda distance: distance > 0)
    if isinstance(struct.opacity, str):
        require(struct.opacity != "", "opacity", "a number or an expression", struct.opacity)
    elif struct.opacity is not None:
        number(struct, "opacity", "a number from 0 to 1", lambda part: 0 <= part <= 1)
    for key in ("bond_radius", "vector_scale"):
        if getattr(struct, key) is not None:
            number(struct, key, "a finite number above 0", lambda given: given > 0)
    good = struct.vectors is None or (isinstance(struct.vectors, str) and struct.vectors != "")
    require(good, "vectors", "the name of three columns, as v of vx, vy and vz", struct.vectors)
    good = isinstance(struct.cell, bool) or struct.cell == "solid"
    require(good, "cell", "true, false or 'solid'", struct.cell)
    number(struct, "scale", "a finite number above 0", lambda scale: scale > 0)
    good = struct.color is None or (isinstance(struct.color, str) and struct.color != "")
    expected = "'file', 'element', 'type', 'material' or an expression over columns"
    require(good, "color", expected, struct.color)
    require(isinstance(struct.cmap, str), "cmap", "a colour map's name", struct.cmap)
    try:
        palette.colormap(struct.cmap)
        if struct.clim not in (None, "first", "all"):
            force_setattr(struct, "clim", palette.check_limits(struct.clim))
    except RequestError as error:
        raise SceneError(str(error)) from None
