"""Painter: threads that draw a session's pictures, and send them.

One renders, another one encodes and sends: so at rest the next picture is rendered meanwhile.
"""

import io
import queue
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError
from contextlib import contextmanager, nullcontext, suppress
from functools import partial
from typing import Any, NamedTuple, Self

from msgspec.structs import replace
from PIL import Image

from clrt.errors import ClrtError
from clrt.figure.rendering import Array, Renderer
from clrt.files import image
from clrt.scene.scene import Scene
from clrt.viewer.overlay import Overlay, bare, needs_depth
from clrt.viewer.preview import preview
from clrt.viewer.quick import has_closed_form, quick, sky_of
from clrt.viewer.schedule import Schedule, Task
from clrt.viewer.session import Change, Look, Pick, Session, Shot, Shown

QUALITY = 80
"""Of JPEG: of all pictures but the last, which loses nothing."""


PREVIEWS = 0.05
"""Seconds between two of them."""
COMPILES = 1.0
"""Seconds after which the first picture is late since its program is compiled."""
SKY_SIZE = 96
"""Pixels of the longer side of the pictures that sky_of() compares."""
CACHED = 0.3
"""Seconds in which a program is found that was compiled before."""
COMPILING = "compiling for this kind of scene, once: till then a preview"


class Stage:
    """A renderer that painters share. Moving pictures go before pictures at rest."""

    def __init__(self, renderer: Renderer) -> None:
        self.renderer = renderer
        self._moving = 0
        self._lock = threading.Lock()
        self._compiler: threading.Thread | None = None

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

    def has_compiled(self, scene: Scene) -> bool:
        """Whether the programs are there of the first scene that this was asked for. They are
        compiled beside the pictures, which need not wait for that."""
        with self._lock:
            if self._compiler is None:
                self._compiler = threading.Thread(target=self._compile, args=(scene,), daemon=True)
                self._compiler.start()
        self._compiler.join(CACHED)
        return not self._compiler.is_alive()

    def _compile(self, scene: Scene) -> None:
        """Into the cache, by a renderer of its own: one that compiles makes no pictures."""
        mine = self.renderer
        options: dict[str, Any] = {"precision": mine.precision, "lanes": mine.lanes}
        with suppress(ClrtError), Renderer(device=mine.device, **options) as other:
            other.quiet = True
            other.prepare(scene, "uint8", alpha=False)

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
    depth: Array | None
    """(height, width), if what is drawn over it needs that."""
    header: dict[str, Any]


class Painter:
    """Two threads for one page, from start() to close()."""

    def __init__(
        self, stage: Stage, session: Session, send: Callable[[dict[str, Any], bytes], None]
    ) -> None:
        """send: takes a header and a picture's file; there is none (empty) with some headers."""
        self._stage, self._session, self._send = stage, session, send
        self._schedule = Schedule()
        self._overlay = Overlay()
        self._waits = True
        """Whether nothing was rendered yet."""
        self._previewed = -PREVIEWS  # when
        self._sky: float | None = None  # what sky_of() said
        self._sky_of: Scene | None = None  # of this one
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
                    return
                self._changes += 1
                try:
                    self._session.change(message)
                finally:  # a picture says that it was heard
                    self._schedule.change(now, self._session.scene.samples)
                shot, state = self._session.shot, self._session.state
            if shot is not None and self._waits and now >= self._previewed + PREVIEWS:
                self._previewed = now
                header = {"preview": True, "moves": True, "layers": []} | state
                self._send(header, _jpeg(preview(shot.scene, shot.size)))
        except Exception as error:
            of = {"of": message.key} if isinstance(message, Look) else {}
            self._send({"error": _said(error)} | of, b"")

    def _pick(self, message: Pick) -> None:
        """Marks what is at a pixel, and tells the page what it is."""
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
        index = int(passes["id"][0, 0])
        found = shot.subject.described(shot.scene, shot.frame, index)
        with self._changed:
            self._session.marked = -1 if found is None else index
            marked = self._session.shot or shot
        told = {"name": marked.name, "mark": marked.mark, "command": marked.command}
        self._send({"picked": found, "changes": self._changes} | told, b"")

    def _draw(self) -> None:
        while (due := self._next()) is not None:
            task, shot, header = due
            line = threading.Timer(COMPILES, self._send, [{"say": COMPILING}, b""])
            try:
                started = time.perf_counter()
                if self._waits:
                    line.start()
                film, depth = self._film(task, shot)
                self._waits = False
            except CancelledError:
                with self._changed:
                    self._schedule.drop(task)
            except Exception as error:  # the page shows it; the next change may mend it
                with self._changed:
                    self._schedule.give_up(task)
                self._send({"error": _said(error)}, b"")
            else:
                header["render"] = time.perf_counter() - started
                self._rendered.put(Picture(task, shot, film, depth, header))
                if task.is_final:
                    with suppress(Exception):  # the next picture tells what is wrong
                        self._fit_sky(shot)
            finally:
                line.cancel()
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

    def _film(self, task: Task, shot: Shot) -> tuple[Array, Array | None]:
        """A picture, and its depths if what is drawn over it needs them. Only the last one has that
        in it: the others have it beside them, and less noise than their samples leave."""
        scene = replace(shot.scene, samples=task.samples)
        progress = partial(self._go_on, task.moves)
        if task.is_final:
            final = self._stage.renderer.render(scene, *shot.size, dtype="uint8", progress=progress)
            return final, None
        width, height = (max(round(task.scale * side), 1) for side in shot.size)
        names = ("depth",) if needs_depth(scene.film) else ()
        with self._stage.at_once() if task.moves else nullcontext(self._stage.renderer) as renderer:
            film, passes = renderer.render(
                quick(bare(scene), self._sky if task.moves else None),
                width,
                height,
                dtype="uint8",
                alpha=False,
                passes=names,
                progress=progress,
            )
        return film, passes.get("depth")

    def _go_on(self, moves: bool, rows: int) -> None:
        """Asked while a picture is rendered, that moves or not.

        Raises:
            CancelledError: another one is due.
        """
        if self._is_closed or (self._schedule.moves and not moves):
            raise CancelledError
        if not moves:
            self._stage.give_way()

    def _fit_sky(self, shot: Shot) -> None:
        """Once for each scene that is at rest: so it is as bright when it moves on.

        Raises:
            CancelledError: another picture is due.
        """
        if self._sky_of is shot.scene or not has_closed_form(shot.scene):
            return
        scene = bare(shot.scene)
        if not self._stage.has_compiled(quick(replace(scene, samples=1), sky=1.0)):
            return
        size = [max(round(side * SKY_SIZE / max(shot.size)), 1) for side in shot.size]

        def picture(scene: Scene) -> Array:
            return self._stage.renderer.render(
                scene, *size, dtype="uint8", alpha=False, progress=partial(self._go_on, False)
            )

        self._sky, self._sky_of = sky_of(scene, picture), shot.scene

    def _encode(self) -> None:
        while (picture := self._rendered.get()) is not None:
            started = time.perf_counter()
            task, shot, header = picture.task, picture.shot, picture.header
            if task.is_final:
                transfer = shot.scene.film.transfer
                command = shot.command if shot.subject.is_noted else ""
                file = image.as_png(picture.film, transfer=transfer, command=command)
                header |= {"command": shot.command, "toml": shot.toml}
                header["layers"] = []
            else:
                over = self._overlay.layers(shot.scene, shot.size, picture.depth)
                header["layers"] = [(each.x, each.y, len(each.file)) for each in over]
                file = b"".join((*(each.file for each in over), _jpeg(picture.film)))
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
