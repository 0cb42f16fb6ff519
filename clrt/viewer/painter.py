"""Painter: threads that draw a session's pictures, and send them.

One renders, another one encodes and sends: so at rest the next picture is rendered meanwhile.
"""

import io
import queue
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager
from typing import Any, NamedTuple, Self

from msgspec.structs import replace
from PIL import Image

from clrt.errors import ClrtError
from clrt.figure.rendering import Array, Renderer
from clrt.files import image
from clrt.viewer.schedule import Schedule, Task
from clrt.viewer.session import Change, Pick, Session, Shot, Shown

QUALITY = 80
"""Of JPEG: of all pictures but the last, which loses nothing."""


class Stage:
    """A renderer that painters share. Moving pictures go before pictures at rest."""

    def __init__(self, renderer: Renderer) -> None:
        self.renderer = renderer
        self._moving = 0
        self._lock = threading.Lock()

    @contextmanager
    def at_once(self) -> Iterator[Renderer]:
        """The renderer for who moves."""
        with self._lock:
            self._moving += 1
        try:
            yield self.renderer
        finally:
            with self._lock:
                self._moving -= 1

    def give_way(self) -> None:
        """Asked now and then by who is at rest.

        Raises:
            CancelledError: somebody moves.
        """
        if self._moving:
            raise CancelledError


class Picture(NamedTuple):
    """A film, and the message that is sent before it."""

    task: Task
    shot: Shot
    film: Array
    header: dict[str, Any]


class Painter:
    """Two threads for one page, from start() to close()."""

    def __init__(
        self, stage: Stage, session: Session, send: Callable[[dict[str, Any], bytes], None]
    ) -> None:
        """send: takes a header and a picture's file; there is none (empty) with some headers."""
        self._stage, self._session, self._send = stage, session, send
        self._schedule = Schedule()
        self._changed = threading.Condition()  # guards all but the queue
        self._changes = 0
        self._busy: dict[int, float] = {}
        self._is_closed = False
        self._rendered: queue.Queue[Picture | None] = queue.Queue(1)
        self._threads = [
            threading.Thread(target=w, daemon=True) for w in (self._draw, self._encode)
        ]

    def start(self) -> Self:
        for thread in self._threads:
            thread.start()
        return self

    def close(self) -> None:
        """Ends the picture that is under way."""
        with self._changed:
            self._is_closed = True
            self._changed.notify()
        for thread in self._threads:
            thread.join()

    def tell(self, message: Change | Pick | Shown) -> None:
        """Answers a page's message; if it cannot, the page is told why."""
        try:
            if isinstance(message, Pick):
                self._pick(message)
                return
            now = time.perf_counter()
            with self._changed:
                self._changed.notify()  # as soon as this is done
                if isinstance(message, Shown):
                    self._schedule.show(message.number, now, self._busy.pop(message.number, 0.0))
                else:
                    self._changes += 1
                    try:
                        self._session.change(message)
                    finally:  # a picture says that it was heard
                        self._schedule.change(now, self._session.scene.samples)
        except Exception as error:
            self._send({"error": _said(error)}, b"")

    def _pick(self, message: Pick) -> None:
        """Tells the page which sphere is at a pixel."""
        with self._changed:
            shot = self._session.shot
        if shot is None:
            return
        (width, height), names = shot.size, ("id",)
        x, y = min(message.x, width - 1), min(message.y, height - 1)
        with self._stage.at_once() as renderer:
            _, passes = renderer.render(
                shot.scene, width, height, region=(x, y, x + 1, y + 1), passes=names
            )
        found = shot.subject.described(shot.scene, shot.frame, int(passes["id"][0, 0]))
        self._send({"picked": found}, b"")

    def _draw(self) -> None:
        while (due := self._next()) is not None:
            task, shot, header = due
            try:
                started = time.perf_counter()
                film = self._film(task, shot)
            except CancelledError:
                with self._changed:
                    self._schedule.drop(task)
            except Exception as error:  # the page shows it; the next change may mend it
                with self._changed:
                    self._schedule.give_up(task)
                self._send({"error": _said(error)}, b"")
            else:
                header["render"] = time.perf_counter() - started
                self._rendered.put(Picture(task, shot, film, header))
        self._rendered.put(None)

    def _next(self) -> tuple[Task, Shot, dict[str, Any]] | None:
        """The next picture, when it is due. None: there is none any more."""
        with self._changed:
            while not self._is_closed:
                shot = self._session.shot
                due = None if shot is None else self._schedule.next(time.perf_counter())
                if shot is not None and isinstance(due, Task):
                    counted = {"number": due.number, "changes": self._changes}
                    return due, shot, counted | self._session.state
                self._changed.wait(None if isinstance(due, Task) else due)
        return None

    def _film(self, task: Task, shot: Shot) -> Array:
        scene = replace(shot.scene, samples=task.samples)

        def progress(rows: int) -> None:
            if self._is_closed or (self._schedule.moves and not task.moves):
                raise CancelledError
            if not task.moves:
                self._stage.give_way()

        if task.moves:
            width, height = (max(round(task.scale * side), 1) for side in shot.size)
            with self._stage.at_once() as renderer:
                return renderer.render(
                    scene, width, height, dtype="uint8", alpha=False, progress=progress
                )
        alpha = None if task.is_final else False  # which JPEG has not
        return self._stage.renderer.render(
            scene, *shot.size, dtype="uint8", alpha=alpha, progress=progress
        )

    def _encode(self) -> None:
        while (picture := self._rendered.get()) is not None:
            started = time.perf_counter()
            task, shot, header = picture.task, picture.shot, picture.header
            if task.is_final:
                transfer = shot.scene.film.transfer
                command = shot.command if shot.subject.is_noted else ""
                file = image.as_png(picture.film, transfer=transfer, command=command)
                header |= {"command": shot.command, "toml": shot.toml}
            else:
                file = _jpeg(picture.film)
            header["encode"] = time.perf_counter() - started
            with self._changed:
                self._busy[task.number] = header["render"] + header["encode"]
            header |= {"samples": task.samples, "moves": task.moves, "final": task.is_final}
            header["size"] = picture.film.shape[1::-1]
            self._send(header, file)
            with self._changed:
                self._schedule.sent(task.number, time.perf_counter())
                self._changed.notify()


def _jpeg(film: Array) -> bytes:
    file = io.BytesIO()
    Image.fromarray(film).save(file, "JPEG", quality=QUALITY)
    return file.getvalue()


def _said(error: Exception) -> str:
    return str(error) if isinstance(error, ClrtError) else f"this is a bug in clrt: {error!r}"
