"""Compose: the scene that shows particles, as `clrt.plot` and `clrt render PARTICLES` draw them."""

import operator
from collections.abc import Iterable, Sequence
from typing import Any, Literal

import msgspec
import numpy as np

from clrt.figure import framing, styles
from clrt.figure.coloring import Colored, colored, decorated
from clrt.figure.framing import PROJECTIONS, Projection
from clrt.film import color
from clrt.film.decor import panel
from clrt.film.decor.cell import corners_of
from clrt.particles.particlefile import coloring
from clrt.particles.particles import Particles
from clrt.scene.film import Cell, Film
from clrt.scene.scene import Scene
from clrt.scene.spheres import Spheres
from clrt.values import number, require, switches


class Look(msgspec.Struct, frozen=True, kw_only=True):
    """How particles are drawn. Colours are sRGB."""

    radius: float | None = None
    scale: float = 1.0
    color: str | None = None
    cmap: str = "viridis"
    clim: tuple[float, float] | None = None
    """These five as of a clrt.ParticleFile."""
    colorbar: str | None = None
    """The label of a colour bar or legend; None: there is none."""
    cell: bool = False
    """The edges of the particles' box are drawn."""
    view: str | Sequence[float] = "iso"
    """Where the camera stands: a name of clrt.figure.framing.VIEWS, or three numbers."""
    projection: Projection = "orthographic"
    margin: float = 0.03
    """The part of the picture that stays free at each of its sides."""
    background: str | Sequence[float] = "white"
    """A colour's name, #rgb or #rrggbb, or three numbers from 0 to 1."""
    transparent: bool = False
    transfer: Literal["linear", "srgb"] = "srgb"
    style: str = "matte"
    samples: int = 16
    size: tuple[int, int] = (1920, 1080)
    """Pixels, columns and rows."""

    def __post_init__(self) -> None:
        coloring(self)
        good = self.colorbar is None or isinstance(self.colorbar, str)
        require(good, "colorbar", "a label", self.colorbar)
        switches(self, "cell", "transparent")
        number(self, "margin", "a number from 0 to below 0.5", lambda part: 0 <= part < 0.5)
        good = self.projection in PROJECTIONS
        require(good, "projection", " or ".join(PROJECTIONS), self.projection)
        framing.direction(self.view)
        color.srgb("background", self.background)
        styles.style(self.style)
        try:
            width, height = map(operator.index, self.size)
            good = min(width, height) >= 1
        except (TypeError, ValueError):
            good = False
        require(good, "size", "two whole numbers above 0", self.size)

    @property
    def coloring(self) -> dict[str, Any]:
        """As a clrt.ParticleFile says it, and coloring.colored() takes it."""
        names = ("radius", "scale", "color", "cmap", "clim", "cell")
        return {"material": self.style} | {name: getattr(self, name) for name in names}


def scene(particles: Particles, look: Look) -> Scene:
    """The scene that shows particles.

    Raises:
        RequestError: naming the key that is wrong, or that the particles do not have the values of.
    """
    made = drawn(particles, look)
    return scene_of(made, look, [made.spheres], made.cell)


def drawn(particles: Particles, look: Look) -> Colored:
    """Particles as spheres.

    Raises:
        RequestError: as scene().
    """
    return colored(particles, **look.coloring)


def scene_of(made: Colored, look: Look, parts: Iterable[Spheres], box: Cell | None) -> Scene:
    """The scene that shows particles as spheres.

    Args:
        parts: what is in view.
        box: is in view as well.

    Raises:
        RequestError: as scene().
    """
    style = styles.style(look.style)
    ground = color.to_linear(color.srgb("background", look.background))
    film = Film(
        background=tuple(ground.tolist()),
        transparent=look.transparent,
        transfer=look.transfer,
        outline=style.outline,
        colorbar=look.colorbar or "",
    )
    film = decorated(film, [made])
    room = panel.room(film, look.size) / look.size[0] if film.colorbar else 0.0
    corners = np.zeros((0, 3)) if box is None else corners_of(box)
    camera = framing.holding(
        parts,
        corners,
        framing.direction(look.view),
        look.size,
        look.projection,
        look.margin,
        min(room, (1 - 2 * look.margin) / 2),
    )
    extent = framing.extent(made.spheres, corners) if style.reach > 0 else 0.0
    return Scene(
        camera=camera,
        lights=styles.lights(style, camera, extent),
        materials={look.style: style.material},
        spheres=made.spheres,
        film=film,
        samples=look.samples,
    )
