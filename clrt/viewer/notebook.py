"""Notebook: a scene on a canvas, among the cells."""

from typing import TYPE_CHECKING, Any

from clrt.errors import RequestError
from clrt.viewer import subject

if TYPE_CHECKING:
    from clrt.viewer.canvas import Canvas


def show(scene: Any, *, samples: int | None = None) -> "Canvas":
    """Shows a scene in a notebook, on a canvas that turns, pans and zooms it.

    Args:
        scene: a scene, a built-in scene's name or a path; or a Picture, whose scene it is.
        samples: the most that a pixel gets at rest; default: the scene's.

    Raises:
        SceneError: it cannot be read, or is not a scene.
        RequestError: anywidget is not installed, or this is no notebook.
    """
    try:
        from clrt.viewer.canvas import Canvas
    except ModuleNotFoundError as error:
        raise RequestError(f"show needs {error.name}: pip install anywidget") from None
    try:
        return Canvas(subject.of(getattr(scene, "scene", scene)), samples)
    except RuntimeError:
        raise RequestError("show: expected to be called in a notebook; else: clrt view") from None
