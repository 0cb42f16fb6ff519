"""Notebook: a scene, or particles, on a canvas among the cells."""

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from clrt.errors import RequestError
from clrt.figure.plot import Picture
from clrt.files.particles.reader import read
from clrt.files.particles.suffix import is_particles
from clrt.scene.scene import Scene
from clrt.viewer import subject

if TYPE_CHECKING:
    from clrt.viewer.canvas import Canvas


def show(scene: Any, *, samples: int | None = None) -> "Canvas":
    """Shows a scene or particles in a notebook, on a canvas that turns, pans and zooms them.

    Args:
        scene: a scene, a built-in scene's name or a path; particles, or whatever clrt.read() takes;
            or a picture that clrt.plot() made of them.
        samples: the most that a pixel gets at rest; default: the scene's.

    Raises:
        SceneError: it cannot be read, or is not a scene.
        RequestError: it is none of these, anywidget is not installed, or this is no notebook.
    """
    try:
        from clrt.viewer.canvas import Canvas
    except ModuleNotFoundError as error:
        raise RequestError(f"show needs {error.name}: pip install anywidget") from None
    try:
        return Canvas(partial(_subject, scene), samples)
    except RuntimeError:
        raise RequestError("show: expected to be called in a notebook; else: clrt view") from None


def _subject(given: Any) -> subject.Subject:
    if isinstance(given, Picture):
        height, width = given.pixels.shape[:2]
        return subject.of_figure(given.scene, (width, height))
    if isinstance(given, Scene):
        return subject.of(given)
    if not isinstance(given, str | Path):
        return subject.of_particles(read(given))
    if is_particles(Path(given)):
        return subject.of_file(Path(given), {})
    return subject.of(given)
