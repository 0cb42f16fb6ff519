"""What a scene says of a file of particles: where it is, and how its particles are drawn."""

from typing import Any

import msgspec
from msgspec.structs import force_setattr

from clrt.errors import RequestError, SceneError
from clrt.particles import palette
from clrt.values import count, number, require, switches

MATTE = "matte"
"""The material of particles, if they are given no other: a scene that has none gets that of
clrt.figure.styles."""


class ParticleFile(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """A file of particles, each of which is a sphere."""

    file: str
    """In a scene file relative to its folder."""
    frame: int = 0
    material: str = MATTE
    radius: float | None = None
    """Of all, world units. None: the file's, or else the elements' van der Waals radii."""
    scale: float = 1.0
    """Of all radii."""
    color: str | None = None
    """ "file", "element", "type" or "material", or a column's name. None: the first of those four
    that there is."""
    cmap: str = "viridis"
    """The colour map of a column."""
    clim: tuple[float, float] | None = None
    """What the map's ends stand for. None: the least and the largest finite value."""
    cell: bool = False
    """The edges of the file's box are drawn."""

    def __post_init__(self) -> None:
        require(isinstance(self.file, str) and self.file != "", "file", "a file's name", self.file)
        count(self, "frame", 0, 2**31 - 1)
        require(isinstance(self.material, str), "material", "a material's name", self.material)
        coloring(self)
        switches(self, "cell")


def coloring(struct: Any) -> None:
    """Checks how particles are drawn: radius, scale, color, cmap and clim."""
    if struct.radius is not None:
        number(struct, "radius", "a finite number above 0", lambda radius: radius > 0)
    number(struct, "scale", "a finite number above 0", lambda scale: scale > 0)
    good = struct.color is None or (isinstance(struct.color, str) and struct.color != "")
    expected = "'file', 'element', 'type', 'material' or a column's name"
    require(good, "color", expected, struct.color)
    require(isinstance(struct.cmap, str), "cmap", "a colour map's name", struct.cmap)
    try:
        palette.colormap(struct.cmap)
        if struct.clim is not None:
            force_setattr(struct, "clim", palette.check_limits(struct.clim))
    except RequestError as error:
        raise SceneError(str(error)) from None
