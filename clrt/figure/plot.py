"""Plot: particles to a picture, in one call."""

from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, DTypeLike

from clrt.errors import RequestError, called
from clrt.figure import compose, surfaces
from clrt.figure.compose import Look
from clrt.figure.framing import Projection
from clrt.figure.rendering import Renderer
from clrt.files import image, vector
from clrt.files.meshes.reader import is_mesh, is_mesh_like
from clrt.files.particles.reader import read
from clrt.film.color import srgb
from clrt.particles.particles import Particles
from clrt.particles.texts import distinct
from clrt.scene.scene import Scene
from clrt.values import Array, require

VECTORS = "vectors"
"""The name of the columns that plot() makes of `vectors`."""
VALUES = "values"
"""The name of the column that plot() makes of `values`."""


class Picture:
    """A picture of particles. np.asarray() makes an array of it, and notebooks show it.

    Args:
        pixels: (height, width, 3), or 4 with alpha, uint8: sRGB, straight.
        scene: the scene that it shows.
    """

    def __init__(self, pixels: Array, scene: Scene) -> None:
        self.pixels, self.scene = pixels, scene

    def save(self, path: str | Path) -> None:
        """Writes it to a file of 8 bits a channel, whole or not at all. For .svg and .pdf, whose
        words are words, it is rendered again.

        Raises:
            as clrt.save().
        """
        pixels, overlay = self.pixels, None
        if Path(path).suffix.lower() in vector.SUFFIXES:
            from clrt.figure.apart import picture_and_words

            height, width = pixels.shape[:2]
            image.check_output(Path(path), width, height)
            with Renderer() as renderer:
                pixels, overlay = picture_and_words(renderer, self.scene, width, height)
        image.save(path, pixels, transfer=self.scene.film.transfer, overlay=overlay)

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
    altloc: str = "most",
    assembly: str | int | None = None,
    select: str | None = None,
    hide: str | None = None,
    mask: ArrayLike | None = None,
    radii: ArrayLike | Mapping[Any, float] | None = None,
    scale: float = 1.0,
    color: str | None = None,
    colors: ArrayLike | Mapping[Any, Any] | None = None,
    values: ArrayLike | None = None,
    opacity: str | ArrayLike | None = None,
    cmap: str = "viridis",
    clim: tuple[float, float] | Literal["first", "all"] | None = None,
    colorbar: str | None = None,
    cell: bool | Literal["solid"] | ArrayLike | None = None,
    bonds: bool | str | float | ArrayLike | None = None,
    bond_radius: float | None = None,
    bond_color: str | Sequence[float] = "atoms",
    title: str = "",
    label: str = "",
    labels: str | None = None,
    scalebar: float | tuple[float, str] | Literal["auto"] | None = None,
    axes: bool | Literal["", "xyz", "abc"] = False,
    colorbar_side: Literal["right", "bottom"] = "right",
    font_size: float | str = 1 / 36,
    line_width: float | str = 1 / 540,
    vectors: str | ArrayLike | None = None,
    vector_scale: float | None = None,
    vector_color: str | Sequence[float] = "atoms",
    wrap: bool = False,
    replicate: Sequence[int] = (1, 1, 1),
    mesh: Any = None,
    mesh_color: str | Sequence[float] | None = None,
    mesh_opacity: float | None = None,
    view: str | Sequence[float] | None = None,
    up: str | Sequence[float] | None = None,
    zoom: float = 1.0,
    center: Sequence[float] | None = None,
    projection: Projection = "orthographic",
    margin: float = 0.03,
    background: str | Sequence[float] = "white",
    transparent: bool = False,
    denoise: bool = False,
    style: str = "soft",
    samples: int = 16,
    size: tuple[int, int] = (1920, 1080),
    renderer: Renderer | None = None,
) -> Picture:
    """Draws particles so that all are in view. `clrt render PARTICLES` draws the same picture.

    Colours are sRGB: names, #rgb, #rrggbb, uint8, or floats from 0 to 1.

    Args:
        positions_or_particles: positions (n, 3), or whatever clrt.read() takes. Or a mesh alone: a
            Mesh, an object that clrt.read_mesh() takes, or the name of a file of faces.
        altloc, assembly: of a file's name, as of clrt.read().
        select: which particles there are: an expression over columns in Python's syntax, as
            'x > 0 and chain == "A"' (docs/particles.md).
        hide: which of them there are not, likewise.
        mask: (n,) of bool: only these are there.
        radii: in the unit of the positions: one for all, (n,), or by type, element or name, as
            {"Na": 1.0}. Default, and for those that are not named: the particles', or else the van
            der Waals radii of their elements, or else half the median distance between nearest
            neighbours.
        scale: of all radii.
        color: what gives the colours: "file", "element", "type" or "material", or an expression
            over columns. Default: the first of file, element and type that there is, or else steel
            blue.
        colors: (n, 3), n names, one for all, or by type, element, name, or text of the column that
            gives the colours, as {"A": "red"}.
        values: (n,) numbers that give the colours.
        opacity: from 0 to 1: one for all, (n,), or an expression over columns. Default: the
            particles', or else 1.
        cmap: the colour map of numbers, see clrt.palette.
        clim: what the map's ends stand for; default: the least and the largest finite value.
        colorbar: the label of a colour bar, or of a legend of elements, types or text; "": none.
            Default: none, but a legend where text gives the colours.
        cell: True draws the particles' box, "solid" with edges that throw shadows; (3, 3), a row
            for each edge, draws that one.
        bonds: True, the particles', or else "auto": of atoms nearer than 1.2 times the sum of their
            covalent radii, but no two of hydrogen; a distance: of all that are nearer; (m, 2):
            indices of the particles that each one joins; "file"; False. Default: True with the
            style "ball-and-stick" as far as elements are known, else none. Bonds across the box are
            drawn as two halves.
        bond_radius: default: 0.15 angstroms, or 0.3 of the least radius where neither the unit nor
            elements are known.
        bond_color: "atoms": each half that of its particle; or of all.
        title: a text above.
        label: a text in the upper left corner; fields in braces, as of str.format(): "frame",
            "time", "step" and columns that have one value.
        labels: a column, or an expression, that is written at each particle that is seen.
        scalebar: a length that is drawn, or (length, text), or "auto" for a round one. The
            projection must be orthographic.
        axes: True or "xyz" draws which way the axes go, "abc" the box's edges.
        colorbar_side: where the bar is, "right" or "bottom".
        font_size: an em, as a part of the picture's smaller side, or points on a page, as
            "8pt/85mm" where the picture is printed 85 mm wide.
        line_width: of the box's edges, likewise.
        vectors: arrows at the particles, (n, 3), or the name of three columns, as "v" of vx, vy and
            vz. They begin at the particles' surfaces.
        vector_scale: how long arrows are, in their vectors; default: so that their mean is twice
            the median radius.
        vector_color: "atoms": that of its particle; or of all.
        wrap: particles are moved into their box.
        replicate: how many images there are along each edge of their box.
        mesh: is drawn beside the particles: whatever clrt.read_mesh() takes.
        mesh_color: a colour, or the name of numbers of its vertices or faces. Default: its own, or
            else light gray, of a mesh alone steel blue.
        mesh_opacity: from 0 to 1.
        view: where the camera stands: "corner", "iso", "x", "-x", "y", "-y", "z", "-z", or
            (dx, dy, dz). Default: "corner", or "z" if all z are equal.
        up: likewise; default: +z, or +y if the camera looks along z.
        zoom: 1 holds all.
        center: (x, y, z), what is in the middle; default: the middle of all.
        projection: "orthographic" or "perspective".
        margin: the part of the picture that stays free at each of its sides.
        transparent: alpha in place of the background.
        denoise: filters the noise of occlusion and soft shadows; for fewer than 16 samples.
        style: "soft", "matte", "outline", "mirror" or "ball-and-stick": docs/styles.md.
        samples: the most that a pixel gets; 1 is the fastest.
        size: of the picture, columns and rows.
        renderer: default: one for the default device.

    Raises:
        RequestError: naming the argument that is wrong, and what was expected.
        OutputError: the picture does not fit into memory.
        DeviceError: the device fails.
    """
    given = positions_or_particles
    if alone := is_mesh(Path(given)) if isinstance(given, str | Path) else is_mesh_like(given):
        if mesh is not None:
            raise RequestError("mesh: expected one mesh, got two")
        mesh, given = given, np.zeros((0, 3))
    particles = read(given, altloc=altloc, assembly=assembly)
    if colors is not None and values is not None:
        raise RequestError("values: expected none beside colors")
    by_kind = isinstance(radii, Mapping)
    many = _many(colors)
    if many is not None:
        color = "file"
    if values is not None:
        color = VALUES
    particles = _changed(particles, None if by_kind else radii, many, values, vectors, cell)
    if opacity is not None and not isinstance(opacity, str):
        with called({"opacities": "opacity"}):
            particles, opacity = particles.replaced(opacities=opacity), None
    with called({"radius": "radii"}):
        surface = None
        if mesh is not None:
            surface = surfaces.read(mesh, mesh_color, mesh_opacity, cmap, clim)
        look = Look(
            mesh=surface,
            select=select,
            hide=hide,
            wrap=wrap,
            replicate=tuple(replicate),  # type: ignore[arg-type]
            radius=radii if by_kind or radii is None else particles.radii,  # type: ignore[arg-type]
            scale=scale,
            color=color,
            colors=colors if many is None else None,  # type: ignore[arg-type]
            opacity=opacity,
            cmap=cmap,
            clim=clim,
            colorbar=colorbar,
            cell=(
                cell  # type: ignore[arg-type]
                if isinstance(cell, str)
                else cell is not None and cell is not False
            ),
            bonds=_bonds(bonds),
            bond_radius=bond_radius,
            bond_color=bond_color,
            title=title,
            label=label,
            labels=labels,
            scalebar=scalebar,
            axes="xyz" if axes is True else axes or "",
            colorbar_side=colorbar_side,
            font_size=font_size,
            line_width=line_width,
            vectors=vectors if vectors is None or isinstance(vectors, str) else VECTORS,
            vector_scale=vector_scale,
            vector_color=vector_color,
            view=view,
            up=up,
            zoom=zoom,
            center=center,
            projection=projection,
            margin=margin,
            background=background,
            transparent=transparent,
            denoise=denoise,
            style=style,
            samples=samples,
            size=size,
        )
        chosen = None if mask is None else particles.checked_mask(mask)
        scene = compose.mesh_scene(look) if alone else compose.scene(particles, look, chosen)
    with Renderer() if renderer is None else nullcontext(renderer) as used:
        return Picture(used.render(scene, *look.size, dtype=np.uint8), scene)


def _bonds(given: Any) -> Any:
    """One word for all bonds, a distance, or an array of them."""
    return given if given is None or np.ndim(given) == 0 else np.asarray(given)


def _many(colors: Any) -> Any:
    """Colours of all particles one by one, (n, 3); None: they are not so given."""
    if colors is None or isinstance(colors, str | Mapping):
        return None
    if np.ndim(colors) == 1 and all(isinstance(one, str) for one in colors):
        text = distinct(np.asarray(colors))
        return np.array([srgb("colors", kind) for kind in text.kinds]).reshape(-1, 3)[text.which]
    return colors


def _changed(
    particles: Particles,
    radii: Any,
    colors: Any,
    values: ArrayLike | None,
    vectors: str | ArrayLike | None,
    cell: bool | str | ArrayLike | None,
) -> Particles:
    """The particles with what plot() was given in place of their own."""
    if colors is not None and np.ndim(colors) == 1:
        colors = np.broadcast_to(srgb("colors", colors), (len(particles), 3))
    more = {} if values is None else {VALUES: values}
    if vectors is not None and not isinstance(vectors, str):
        ways = np.asarray(vectors)
        expected = f"numbers of shape ({len(particles)}, 3), or a name"
        require(ways.shape == (len(particles), 3), "vectors", expected, ways)
        more |= {f"{VECTORS}_{axis}": ways[:, i] for i, axis in enumerate("xyz")}
    own_box = cell is not None and not isinstance(cell, bool | str)
    if radii is None and colors is None and not more and not own_box:
        return particles
    return particles.replaced(
        radii=particles.radii if radii is None else radii,
        colors=particles.colors if colors is None else colors,
        values={**particles.values, **more},
        cell=cell if own_box else particles.cell,
    )
