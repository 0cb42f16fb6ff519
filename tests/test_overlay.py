"""What lies over a picture, beside the picture that has it in it."""

import io
from typing import Any

import numpy as np
import pytest
from msgspec.structs import replace
from PIL import Image

import clrt
from clrt.film import develop
from clrt.viewer.overlay import MOVING, STILL, Overlay, bare, needs_depth

RENDERER = clrt.Renderer()
SIZE = (240, 160)
LOOKS: dict[str, dict[str, Any]] = {
    "bar": {"colorbar": "speed", "color": "speed"},
    "lines": {"cell": True},
    "words": {"title": "A title", "label": "here", "axes": "xyz", "scalebar": "auto"},
}


def figure(**look: Any) -> clrt.Scene:
    places = np.array([[1.0, 1, 1], [3, 2, 1], [2, 3, 3]])
    particles = clrt.Particles(
        places, radii=0.8, values={"speed": np.array([1.0, 2, 4])}, cell=4 * np.eye(3)
    )
    return clrt.plot(
        particles, style="matte", samples=1, size=SIZE, renderer=RENDERER, **look
    ).scene


def drawn(scene: clrt.Scene, small: tuple[int, int] = SIZE) -> np.ndarray:
    """A picture with its layers over it, as a page draws them."""
    picture = RENDERER.render(bare(scene), *SIZE, dtype="uint8")
    depth = None
    if needs_depth(scene.film):
        depth = RENDERER.render(bare(scene), *small, dtype="uint8", passes=("depth",))[1]["depth"]
    whole = Image.fromarray(picture).convert("RGBA")
    for x, y, file in Overlay().layers(scene, SIZE, depth):
        whole.alpha_composite(Image.open(io.BytesIO(file)).convert("RGBA"), (x, y))
    return np.asarray(whole)[..., :3]


@pytest.mark.parametrize("look", LOOKS.values(), ids=LOOKS)
def test_layers_make_the_picture(look: dict[str, Any]) -> None:
    """But for the edges of thin ink over spheres: pages mix in sRGB, and clrt in linear light."""
    scene = figure(**look)
    expected = RENDERER.render(scene, *SIZE, dtype="uint8").astype(int)
    off = abs(drawn(scene) - expected).max(axis=2)
    without = abs(RENDERER.render(bare(scene), *SIZE, dtype="uint8") - expected).max(axis=2)
    assert (off > 2).sum() < 0.5 * (without > 2).sum()
    assert (off > 2).mean() < 0.01


def test_lines_are_as_sharp_over_a_small_picture() -> None:
    scene = figure(cell=True)
    sharp, small = drawn(scene), drawn(scene, (80, 54))
    assert (abs(sharp.astype(int) - small).max(axis=2) > 0).mean() < 0.01


def test_what_no_camera_changes_is_drawn_once() -> None:
    overlay, scene = Overlay(), figure(colorbar="speed", color="speed")
    first, second = (overlay.layers(scene, SIZE, None)[0].file for _ in range(2))
    assert first is second
    assert overlay.layers(scene, (120, 80), None)[0].file != first


def test_nothing_is_left_of_a_film_with_every_mark() -> None:
    film = figure(**{key: value for look in LOOKS.values() for key, value in look.items()}).film
    film = replace(film, labels=(clrt.scene.film.Label("x", (0.0, 0.0, 0.0)),))
    every = replace(figure(), film=film)
    assert not develop.has_marks(bare(every).film)
    for one in (STILL, MOVING):
        assert develop.has_marks(replace(film, **one))
