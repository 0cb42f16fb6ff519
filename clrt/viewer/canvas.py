"""Canvas: the view as a widget of Jupyter and Marimo, by anywidget."""

import asyncio
import contextvars
from collections.abc import Callable
from functools import cache
from typing import Any

import anywidget
import msgspec

from clrt import storage
from clrt.figure.rendering import Renderer
from clrt.viewer.painter import Painter, Stage
from clrt.viewer.session import Change, Pick, Session, Shown
from clrt.viewer.subject import Subject


@cache
def _stage() -> Stage:
    """One for all canvases."""
    return Stage(Renderer())


def _text(*names: str) -> str:
    return "".join((storage.folder("viewer") / name).read_text("utf-8") for name in names)


class Canvas(anywidget.AnyWidget):
    """A subject on as many views as a notebook has of it; each has a session of its own. Without
    views it keeps none: a notebook never lets go of what a cell has shown."""

    _esm = _text("view.js", "widget.js")
    _css = _text("view.css")

    def __init__(self, make: Callable[[], Subject], samples: int | None) -> None:
        """Raises RuntimeError: there is no event loop, as a notebook has; and what `make` does."""
        loop = asyncio.get_running_loop()
        super().__init__()
        self._make, self._samples = make, samples
        self._subject: Subject | None = make()
        self._painters: dict[str, Painter] = {}
        # The notebook's own thread sends, as from the cell that made this.
        self._loop, self._context = loop, contextvars.copy_context()
        self.on_msg(self._heard)

    def _heard(self, widget: object, content: dict[str, Any], buffers: object) -> None:
        """Answers a view's message; the first says that it is there, the last that it is gone."""
        view, message = content["view"], content["message"]
        if message is None:
            self._open(view)
        elif message is False:
            self._painters.pop(view).close()
            if not self._painters:
                self._subject = None
        elif (painter := self._painters.get(view)) is not None:
            painter.tell(msgspec.convert(message, Change | Pick | Shown))

    def _open(self, view: str) -> None:
        def send(header: dict[str, Any], file: bytes) -> None:
            content = {"view": view, "header": header}
            self._loop.call_soon_threadsafe(self.send, content, [file], context=self._context)

        self._subject = self._subject or self._make()
        session = Session(self._subject, self._samples)
        send({"about": session.about}, b"")
        self._painters[view] = Painter(_stage(), session, send).start()
