"""Frames: how they are found in a file, and found again."""

import hashlib
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Protocol

import numpy as np

from clrt import storage
from clrt.errors import ClrtError, CutError, FrameError, SceneError
from clrt.files.particles import rules
from clrt.files.particles.text import Lines, Mark
from clrt.particles.particles import Particles


class Frames(Protocol):
    """The frames of an open file."""

    def frame(self, k: int) -> Particles | None:
        """Frame k, or None after the last one."""

    def count(self) -> int:
        """How many there are."""

    def close(self) -> None: ...


class Single:
    """The one frame of a file that has no more."""

    def __init__(self, load: Callable[[], Particles], close: Callable[[], None]) -> None:
        self.load, self.close = load, close

    def frame(self, k: int) -> Particles | None:
        return self.load() if k == 0 else None

    def count(self) -> int:
        return 1


class Trajectory:
    """The frames of a text file, one in memory at a time.

    Where each begins is noted on the way, and kept in the cache by path, size and time for the next
    process.

    Args:
        read, skip: read the frame that begins where the lines are, or go on to the next one.
    """

    def __init__(
        self, lines: Lines, read: Callable[[Lines], Particles], skip: Callable[[Lines], None]
    ) -> None:
        self.lines, self.read, self.skip = lines, read, skip
        self._starts = [Mark(0, 0)]
        self._count: int | None = None
        self._is_cut = self._said = False
        self._key = self._state()
        self._kept: tuple[int, int | None] | None = None  # what the cache has; None: not asked

    def frame(self, k: int) -> Particles | None:
        """Frame k, or None after the last whole one.

        Raises:
            SceneError: it, or one on the way to it, is no frame.
        """
        if not self._find(k):
            return None
        with self._cut_at(k):
            self.lines.seek(self._starts[k])
            found = self.read(self.lines)
            self._note(k)
            return found
        return None

    def count(self) -> int:
        while self._count is None:
            self._find(len(self._starts))
            # A line may be cut as well, which only reading it shows.
            if self._count is not None and not self._is_cut and not self.lines.ends_with_a_line():
                self.frame(self._count - 1)
        return self._count

    def close(self) -> None:
        # Where frame 1 begins is known to whoever reads frame 0, and not worth a file.
        if len(self._starts) > 2 and self._state() == self._key:
            self._keep()
        self.lines.file.close()

    def _find(self, k: int) -> bool:
        if k >= len(self._starts):
            self._recall()
        while k >= len(self._starts) and self._count is None:
            with self._cut_at(len(self._starts) - 1):
                self.lines.seek(self._starts[-1])
                self.skip(self.lines)
                self._note(len(self._starts) - 1)
        if self._is_cut:
            self._say_cut()
        return k < (len(self._starts) if self._count is None else self._count)

    @contextmanager
    def _cut_at(self, k: int) -> Iterator[None]:
        """Frame k is the last one and cut short, if the file ends in it: there are k.

        Raises:
            SceneError: it is wrong in another way, or the first one.
        """
        try:
            yield
        except (SceneError, EOFError) as error:
            if k == 0:
                raise
            if not (isinstance(error, CutError | EOFError) or self.lines.is_cut()):
                said = str(error).removeprefix(f"{self.lines.path}: ")
                raise FrameError(f"{self.lines.path}: frame {k}: {said}") from None
            self._count, self._is_cut = k, True
            self._say_cut()

    def _say_cut(self) -> None:
        if not self._said:
            self._said = True
            text = f"frame {self._count} is cut short: there are {self._count} whole frames"
            rules.say(str(self.lines.path), text)

    def _note(self, k: int) -> None:
        """Notes where frame k + 1 begins, as frame k ends here."""
        if k + 1 == len(self._starts) and self._count is None:
            self.lines.skip_blank()
            if self.lines.peek() is None:
                self._count = k + 1
            else:
                self._starts.append(self.lines.mark())

    def _recall(self) -> None:
        """Asks the cache, once."""
        if self._kept is not None or self._key is None:
            return
        self._kept = 1, None
        with suppress(ClrtError):
            if content := storage.kept(storage.cache_folder() / self._key):
                *starts, (count, cut) = np.frombuffer(content, np.int64).reshape(-1, 2).tolist()
                self._kept = len(starts), count or None
                if len(starts) > len(self._starts):
                    self._starts = [Mark(*start) for start in starts]
                self._count = count or self._count
                self._is_cut = bool(cut)

    def _keep(self) -> None:
        self._recall()
        if self._key is not None and (len(self._starts), self._count) != self._kept:
            found = np.array([*self._starts, (self._count or 0, self._is_cut)], np.int64)
            with suppress(ClrtError):  # there is no cache: they are found anew next time
                storage.keep(storage.cache_folder() / self._key, found.tobytes())

    def _state(self) -> str | None:
        """A name in the cache that is another one once the file is changed; None: it is none."""
        try:
            status = os.fstat(self.lines.file.fileno())
        except OSError:
            return None
        file = str(self.lines.path.absolute()), status.st_size, status.st_mtime_ns
        return hashlib.sha256(repr(("starts of frames", *file)).encode()).hexdigest()
