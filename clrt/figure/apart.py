"""Apart: a picture without its words, and the words."""

from collections.abc import Callable
from typing import Any

import numpy as np
from msgspec.structs import replace

from clrt.figure.rendering import Renderer
from clrt.film import develop
from clrt.film.decor import decorations
from clrt.film.decor.drawing import Overlay
from clrt.scene.film import Film
from clrt.scene.scene import Scene
from clrt.values import Array

NOTHING = Film()
WORDS = ("colorbar", "title", "label", "labels", "scalebar", "axes")
"""Keys of a film that words and shapes come of."""


def picture_and_words(
    renderer: Renderer,
    scene: Scene,
    width: int,
    height: int,
    progress: Callable[[int], object] | None = None,
) -> tuple[Array, Overlay]:
    """A picture, (height, width, 3 or 4) uint8, and what is to be drawn over it.

    Args:
        scene: with its particles as spheres, and the fields of its label filled.

    Raises:
        as Renderer.render().
    """
    film = scene.film
    decorations.drawings(scene, (width, height), None)  # what is wrong there is said before
    bare = replace(scene, film=replace(film, **{key: getattr(NOTHING, key) for key in WORDS}))
    names = ("depth",) if film.labels else ()
    options: dict[str, Any] = {"dtype": np.uint8, "progress": progress, "passes": names}
    image, found = renderer.render(bare, width, height, **options)
    seen = None
    if film.labels:
        depth = found["depth"]
        seen = develop.Seen(np.zeros(0), depth, np.zeros(0), np.s_[:, :])
    ground = None if image.shape[2] == 4 else film.background
    drawn = decorations.drawings(scene, (width, height), seen)
    return image, Overlay(drawn, decorations.ink(ground), ground)
