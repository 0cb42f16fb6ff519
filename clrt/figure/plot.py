"""Plot: particles to a picture, in one call."""

from collections.abc import Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from clrt.errors import RequestError
from clrt.figure import compose
from clrt.figure.compose import Look
from clrt.figure.framing import Projection
from clrt.figure.rendering import Renderer
from clrt.files import image
from clrt.files.particles.reader import read
from clrt.film.color import srgb
from clrt.particles.particles import Particles
from clrt.scene.scene import Scene
from clrt.values import Array

VALUES = "values"
"""What the column is called that plot() is given."""


class Picture:
    """A picture of particles. np.asarray() makes an array of it, and notebooks show it.

    Args:
        pixels: (height, width, 3), or 4 with alpha, uint8: sRGB, straight.
        scene: what it was rendered of.
    """

    def __init__(self, pixels: Array, scene: Scene) -> None:
        self.pixels, self.scene = pixels, scene

    def save(self, path: str | Path) -> None:
        """Writes it to a file of 8 bits a channel, whole or not at all.

        Raises:
            as clrt.save().
        """
        image.save(path, self.pixels, transfer=self.scene.film.transfer)

    def _repr_png_(self) -> bytes:
        return image.as_png(self.pixels, transfer=self.scene.film.transfer)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> Array:
        wanted = self.pixels.dtype if dtype is None else np.dtype(dtype)
        if copy is False and wanted != self.pixels.dtype:
            raise ValueError(f"a picture of {self.pixels.dtype} is one of {wanted} by a copy only")
        return self.pixels.astype(wanted, copy=bool(copy))

    def __repr__(self) -> str:
        return f"Picture({self.pixels.shape[1]}x{self.pixels.shape[0]}, {self.scene.spheres!r})"


def plot(
    positions_or_particles: Any,
    *,
    radii: ArrayLike | None = None,
    colors: ArrayLike | None = None,
    values: ArrayLike | None = None,
    color: str | None = None,
    scale: float = 1.0,
    cmap: str = "viridis",
    clim: tuple[float, float] | None = None,
    colorbar: str | None = None,
    cell: bool | ArrayLike | None = None,
    mask: ArrayLike | None = None,
    view: str | Sequence[float] = "iso",
    projection: Projection = "orthographic",
    margin: float = 0.03,
    background: str | Sequence[float] = "white",
    transparent: bool = False,
    style: str = "matte",
    samples: int = 16,
    size: tuple[int, int] = (1920, 1080),
    renderer: Renderer | None = None,
) -> Picture:
    """Draws particles so that all are in view. `clrt render PARTICLES` draws the same picture.

    Colours are sRGB: names, #rgb, #rrggbb, uint8, or floats from 0 to 1.

    Args:
        positions_or_particles: positions (n, 3), or whatever clrt.read() takes.
        radii: (n,) or one for all, in the unit of the positions; default: the particles', or else
            the van der Waals radii of their elements.
        colors: (n, 3), or one for all.
        values: (n,) numbers that give the colours.
        color: what gives the colours if neither of these does: "file", "element", "type" or
            "material", or the name of a column; default: the first of those four that there is.
        scale: of all radii.
        cmap: the colour map of values and columns, see clrt.palette.
        clim: what the map's ends stand for; default: the least and the largest finite value.
        colorbar: the label of a colour bar, or of a legend of elements or types; None: none.
        cell: True draws the particles' box; (3, 3), a row for each edge, draws that one.
        mask: (n,) of bool: only these are there.
        view: where the camera stands: "iso", "x", "-x", "y", "-y", "z", "-z", or (dx, dy, dz). Up
            is +z, or +y if the camera looks along z.
        projection: "orthographic" or "perspective".
        margin: the part of the picture that stays free at each of its sides.
        transparent: alpha in place of the background.
        style: "matte", "soft", "outline" or "mirror": docs/styles.md.
        samples: the most that a pixel gets; 1 is the fastest.
        size: of the picture, columns and rows.
        renderer: default: one for the default device.

    Raises:
        RequestError: naming the argument that is wrong, and what was expected.
        OutputError: the picture does not fit into memory.
        DeviceError: the device fails.
    """
    particles = read(positions_or_particles)
    if colors is not None and values is not None:
        raise RequestError("values: expected none beside colors")
    if colors is not None:
        color = "file"
    if values is not None:
        color = VALUES
    particles = _changed(particles, radii, colors, values, cell)
    if mask is not None:
        particles = particles.where(mask)
    look = Look(
        scale=scale,
        color=color,
        cmap=cmap,
        clim=clim,
        colorbar=colorbar,
        cell=cell is not None and cell is not False,
        view=view,
        projection=projection,
        margin=margin,
        background=background,
        transparent=transparent,
        style=style,
        samples=samples,
        size=size,
    )
    scene = compose.scene(particles, look)
    with Renderer() if renderer is None else nullcontext(renderer) as used:
        return Picture(used.render(scene, *look.size, dtype=np.uint8), scene)


def _changed(
    particles: Particles,
    radii: ArrayLike | None,
    colors: ArrayLike | None,
    values: ArrayLike | None,
    cell: bool | ArrayLike | None,
) -> Particles:
    """The particles with what plot() was given in place of their own."""
    if colors is not None and (isinstance(colors, str) or np.ndim(colors) == 1):
        colors = np.broadcast_to(srgb("colors", colors), (len(particles), 3))
    more = {} if values is None else {VALUES: values}
    own_box = cell is not None and not isinstance(cell, bool)
    if radii is None and colors is None and values is None and not own_box:
        return particles
    return particles.replaced(
        radii=particles.radii if radii is None else radii,
        colors=particles.colors if colors is None else colors,
        values={**particles.values, **more},
        cell=cell if own_box else particles.cell,
    )
