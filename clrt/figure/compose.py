"""Compose: the scene that shows particles, as `clrt.plot` and `clrt render PARTICLES` draw them."""

import operator
import re
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

import msgspec
import numpy as np
from msgspec.structs import force_setattr, replace

from clrt.errors import SceneError, SceneWarning, warn
from clrt.figure import framing, styles, surfaces
from clrt.figure.decoration import decorated
from clrt.figure.framing import PROJECTIONS, Projection
from clrt.figure.meaning import Meaning
from clrt.figure.representation import Representation, nothing, represented
from clrt.film import color
from clrt.film.decor import panel, words
from clrt.film.decor.cell import corners_of
from clrt.particles.particlefile import ATOMS, PLAIN, coloring
from clrt.particles.particles import Particles
from clrt.scene.camera import Camera
from clrt.scene.film import Cell, Film
from clrt.scene.mesh import Mesh
from clrt.scene.scene import Scene
from clrt.scene.spheres import Spheres
from clrt.values import Array, did_you_mean, number, require, switches

COLORING = (
    *("select", "hide", "wrap", "replicate", "radius", "scale", "color", "colors", "opacity"),
    *("cmap", "clim", "cell", "labels", "bonds", "bond_radius", "bond_color"),
    *("vectors", "vector_scale", "vector_color"),
)
"""What a Look and a clrt.ParticleFile have alike."""


class Look(msgspec.Struct, frozen=True, kw_only=True):
    """How particles are drawn. Colours are sRGB."""

    select: str | None = None
    hide: str | None = None
    wrap: bool = False
    replicate: tuple[int, int, int] = (1, 1, 1)
    radius: float | Mapping[str, float] | None = None
    scale: float = 1.0
    color: str | None = None
    colors: str | Mapping[str, Any] | None = None
    opacity: float | str | None = None
    cmap: str = "viridis"
    clim: tuple[float, float] | Literal["first", "all"] | None = None
    """These as of a clrt.ParticleFile."""
    colorbar: str | None = None
    """The label of a colour bar or legend; "": there is none. None: there is a legend if text gives
    the colours."""
    cell: bool | Literal["solid"] = False
    """The edges of the particles' box are drawn; "solid": as capsules, which throw shadows."""
    bonds: Any = None
    """As of a clrt.ParticleFile; or True, the file's, or else "auto"; False, none; or (m, 2),
    indices of the particles that each one joins."""
    bond_radius: float | None = None
    bond_color: str | Sequence[float] = ATOMS
    vectors: str | None = None
    vector_scale: float | None = None
    vector_color: str | Sequence[float] = ATOMS
    """As of a clrt.ParticleFile."""
    mesh: surfaces.Surface | None = None
    """Is drawn beside the particles, or alone."""
    labels: str | None = None
    """As of a clrt.ParticleFile."""
    title: str = ""
    label: str = ""
    colorbar_side: Literal["right", "bottom"] = "right"
    axes: Literal["", "xyz", "abc"] = ""
    """These as of a clrt.Film."""
    scalebar: float | tuple[float, str] | Literal["auto"] | None = None
    """A length, and the text at it; "auto": a round one with its unit."""
    font_size: float | str = Film().font_size
    line_width: float | str = Film().line_width
    """As of a clrt.Film; or points on a page of some width, as "8pt/85mm"."""
    view: str | Sequence[float] | None = None
    """Where the camera stands: a name of clrt.figure.framing.VIEWS, or three numbers. None:
    "corner", or "z" if all z are equal."""
    up: str | Sequence[float] | None = None
    """Likewise. None: +z, or +y if the camera looks along z."""
    zoom: float = 1.0
    """1 holds all."""
    center: str | Sequence[float] | None = None
    """What is in the middle; None: the middle of all."""
    projection: Projection = "orthographic"
    margin: float = 0.03
    """The part of the picture that stays free at each of its sides."""
    background: str | Sequence[float] = "white"
    """A colour's name, #rgb or #rrggbb, or three numbers from 0 to 1."""
    transparent: bool = False
    denoise: bool = False
    transfer: Literal["linear", "srgb"] = "srgb"
    style: str = PLAIN
    samples: int = 16
    size: tuple[int, int] = (1920, 1080)
    """Pixels, columns and rows."""

    def __post_init__(self) -> None:
        coloring(self)
        good = self.colorbar is None or isinstance(self.colorbar, str)
        require(good, "colorbar", "a label", self.colorbar)
        switches(self, "transparent", "denoise")
        if isinstance(self.scalebar, tuple | list):
            good = len(self.scalebar) == 2 and isinstance(self.scalebar[1], str)
            require(good, "scalebar", "a length and a text, or 'auto'", self.scalebar)
        for key in ("font_size", "line_width"):
            _part_of_side(self, key)
        _words(self)
        good = self.scalebar is None or self.projection == "orthographic"
        require(good, "scalebar", "an orthographic projection", self.projection)
        number(self, "margin", "a number from 0 to below 0.5", lambda part: 0 <= part < 0.5)
        good = self.projection in PROJECTIONS
        near = did_you_mean(self.projection, PROJECTIONS)
        got = f"{' or '.join(PROJECTIONS)}, got {self.projection!r}{near}"
        if not good:
            raise SceneError(f"projection: expected {got}")
        number(self, "zoom", "a finite number above 0", lambda zoom: zoom > 0)
        for key in ("view", "up"):
            if (given := getattr(self, key)) is not None:
                framing.direction(given, key)
        if self.center is not None:
            framing.point(self.center, "center")
        if isinstance(self.colors, Mapping):
            for one in self.colors.values():
                color.srgb("colors", one)
        elif self.colors is not None:
            color.srgb("colors", self.colors)
        color.srgb("background", self.background)
        for key in ("bond_color", "vector_color"):
            given = getattr(self, key)
            if not (isinstance(given, str) and given == ATOMS):
                color.srgb(key, given)
                if not isinstance(given, str):
                    force_setattr(self, key, tuple(given))  # an array is equal to nothing
        styles.style(self.style)
        try:
            width, height = map(operator.index, self.size)
            good = min(width, height) >= 1
        except (TypeError, ValueError):
            good = False
        require(good, "size", "two whole numbers above 0", self.size)

    @property
    def words(self) -> dict[str, Any]:
        """As a clrt.Film has them."""
        return _words(self)

    @property
    def coloring(self) -> dict[str, Any]:
        """As a clrt.ParticleFile says it, and representation.represented() takes it."""
        balls = styles.style(self.style).balls
        return {"material": self.style, "balls": balls} | {
            name: getattr(self, name) for name in COLORING
        }


PRINTED = re.compile(r"\s*([\d.]+)\s*pt\s*/\s*([\d.]+)\s*(mm|cm|in)\s*")
POINTS = {"mm": 72 / 25.4, "cm": 72 / 2.54, "in": 72.0}
"""In a unit of a page."""


def _part_of_side(look: "Look", key: str) -> float:
    """A size as a part of the picture's smaller side."""
    given = getattr(look, key)
    if not isinstance(given, str):
        return float(given) if isinstance(given, int) else given
    try:
        return float(given)
    except ValueError:
        pass
    expected = "a part of the picture's smaller side, or points on a page as 8pt/85mm"
    found = PRINTED.fullmatch(given)
    if found is None:
        raise SceneError(f"{key}: expected {expected}, got {given!r}")
    try:
        width, height = look.size
        wide = float(found[2]) * POINTS[found[3]]
        return float(found[1]) / wide * width / min(width, height)
    except (ValueError, ZeroDivisionError, TypeError):
        raise SceneError(f"{key}: expected {expected}, got {given!r}") from None


def _words(look: "Look") -> dict[str, Any]:
    """What a film has to say of them.

    Raises:
        SceneError: a film cannot.
    """
    found: dict[str, Any] = {
        key: getattr(look, key) for key in ("title", "label", "axes", "colorbar_side")
    }
    found |= {key: _part_of_side(look, key) for key in ("font_size", "line_width")}
    bar = look.scalebar
    length, text = bar if isinstance(bar, tuple | list) else (bar, "")
    found |= {"scalebar": length, "scalebar_label": text}
    Film(**found)
    return found


def scene(particles: Particles, look: Look, mask: Array | None = None) -> Scene:
    """The scene that shows particles.

    mask: (n,) of bool: only these are there.

    Raises:
        RequestError: naming the key that is wrong, or that the particles do not have the values of.
    """
    made = drawn(particles, look, mask=mask)
    return scene_of(made, look, made.parts, made.cell)


def mesh_scene(look: Look) -> Scene:
    """The scene that shows a look's mesh alone.

    Raises:
        RequestError: as scene().
    """
    return scene_of(no_particles(look), look, [], None)


def no_particles(look: Look) -> Representation:
    """What a mesh alone stands beside.

    Raises:
        RequestError: the look has something of particles.
    """
    usual = Look()
    for key in set(COLORING) - {"cmap", "clim"}:
        given = getattr(look, key)
        if isinstance(given, np.ndarray) or given not in (None, getattr(usual, key)):
            raise SceneError(f"{key}: expected particles, of a mesh alone there are none")
    return nothing(look.style, look.cmap, look.label)


def drawn(
    particles: Particles,
    look: Look,
    meaning: Meaning | None = None,
    mask: Array | None = None,
) -> Representation:
    """Particles as spheres.

    meaning: of another frame.

    Raises:
        RequestError: as scene().
    """
    return represented(particles, **look.coloring, label=look.label, meaning=meaning, mask=mask)


def scene_of(made: Representation, look: Look, parts: Iterable[Spheres], box: Cell | None) -> Scene:
    """The scene that shows particles as spheres.

    Args:
        parts: what is in view.
        box: is in view as well.

    Raises:
        RequestError: as scene().
    """
    style = styles.style(look.style)
    ground = color.to_linear(color.srgb("background", look.background))
    label = look.colorbar
    if label is None:
        label = " " if made.source.by == "text" else ""
    film = Film(
        background=tuple(ground.tolist()),
        transparent=look.transparent,
        denoise=look.denoise,
        transfer=look.transfer,
        outline=style.outline,
        colorbar=label,
        colorbar_room=label != "",
        **look.words,
    )
    alone = len(made.spheres) == 0
    if look.mesh is not None and alone and label:
        if look.mesh.clim is None:
            raise SceneError("colorbar: expected a mesh that is coloured by numbers")
        film = replace(film, colorbar_clim=look.mesh.clim, colorbar_cmap=look.cmap)
    film = decorated(film, [made])
    if isinstance(look.scalebar, float | int):
        text = f"{look.scalebar:g} {made.unit}".strip()
        film = replace(film, scalebar_label=text)
    camera = framed(made, look, parts, box, film)
    corners = _corners(box, look)
    moved = [key for key in ("center", "zoom") if getattr(look, key) != getattr(Look(), key)]
    balls, sticks = made.spheres, made.capsules
    if moved and not framing.is_seen(camera, balls, sticks, corners, look.size):
        said = "what is drawn is outside the picture, or smaller than a pixel"
        warn(moved[0], said, SceneWarning)
    materials, meshes = {look.style: style.material}, list[Mesh]()
    if look.mesh is not None:
        mesh, material = surfaces.shown(look.mesh, style.material, alone)
        materials |= {surfaces.MATERIAL: material}
        meshes.append(mesh)
    extent = framing.extent(made.spheres, corners) if style.reach > 0 else 0.0
    return Scene(
        camera=camera,
        lights=styles.lights(style, camera, extent),
        materials=materials,
        spheres=made.spheres,
        meshes=meshes,
        capsules=() if made.capsules is None else made.capsules,
        film=film,
        samples=look.samples,
    )


def framed(
    made: Representation, look: Look, parts: Iterable[Spheres], box: Cell | None, film: Film
) -> Camera:
    """The camera that sees all that is in view, beside the colour bar or legend of a film and below
    its title.

    Raises:
        RequestError: as scene().
    """
    aside, below = panel.room(film, look.size) if film.colorbar else (0, 0)
    (width, height), most = look.size, (1 - 2 * look.margin) / 2
    above = words.title_rows(film, look.size)
    room = min(aside / width, most), min(below / height, most / 2), min(above / height, most / 2)
    view = look.view
    if view is None:
        flat = framing.is_flat(made.spheres, _corners(box, look))
        view = "z" if flat else "corner"
    return framing.holding(
        parts,
        _corners(box, look),
        framing.direction(view),
        look.size,
        look.projection,
        look.margin,
        room,
        None if look.up is None else framing.direction(look.up, "up"),
        look.zoom,
        None if look.center is None else framing.point(look.center, "center"),
    )


def _corners(box: Cell | None, look: Look) -> Array:
    """What is in view beside spheres."""
    parts = [] if box is None else [corners_of(box)]
    if look.mesh is not None:
        parts.append(look.mesh.mesh.trimmed().vertices)
    return np.concatenate([np.zeros((0, 3)), *parts])


def seen_in(
    made: Representation,
    look: Look,
    parts: Iterable[Spheres],
    box: Cell | None,
    film: Film,
    size: tuple[int, int],
    view: str | None,
) -> Camera:
    """What framed() finds, in a picture of another size, and from elsewhere if `view` is given."""
    if view is not None:
        look = msgspec.structs.replace(look, view=view, up=None)
    return framed(made, msgspec.structs.replace(look, size=size), parts, box, film)
