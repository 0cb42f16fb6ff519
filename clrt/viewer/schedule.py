"""Schedule: which picture is to be made next, and how large.

While something moves: small ones of one sample a pixel, as soon as the page can take another one.
At rest: whole ones of more and more samples. Each replaces the one before, and none is a mean of
pictures of different moments. Times are in seconds.
"""

from typing import NamedTuple

REST = 0.15
"""From the last change on it is at rest."""
AHEAD = 2
"""Pictures that are under way at a time: one is rendered while one is encoded, sent and shown."""
BUDGET = 0.020
"""For a picture that moves, to be rendered and encoded."""
FLUENT = 1 / 30
"""Between two pictures that move."""
SCALES = (1.0, 0.75, 0.5, 0.375, 0.25, 0.1875, 0.125, 0.0625)
"""Of the sides of a picture that moves."""
MORE = 4
"""Times as many samples as the picture before has one at rest."""


class Task(NamedTuple):
    """A picture to be made."""

    number: int
    samples: int
    scale: float = 1.0
    is_final: bool = False
    moves: bool = False


class Schedule:
    """Of one page."""

    def __init__(self) -> None:
        self.moves = False
        """Whether something has changed that no picture shows yet."""
        self._steps: list[int] = []  # samples of the pictures at rest that are still due
        self._changed = 0.0  # when
        self._number = 0
        self._under_way: dict[int, tuple[Task, float]] = {}  # and when it was begun
        self._area = SCALES[2] ** 2  # of a picture, that is fast enough

    def change(self, now: float, samples: int) -> None:
        """samples: of the last picture at rest."""
        self.moves, self._changed = True, now
        self._steps = [samples]
        while self._steps[0] > 1:
            self._steps.insert(0, max(self._steps[0] // MORE, 1))

    def next(self, now: float) -> Task | float | None:
        """The task that is due, or how long until it is; None: until something happens."""
        if len(self._under_way) >= AHEAD or not (self.moves or self._steps):
            return None
        if not self.moves and now < self._changed + REST:
            return self._changed + REST - now
        self._number += 1
        if self.moves:
            scale = next((scale for scale in SCALES if scale**2 <= self._area), SCALES[-1])
            task = Task(self._number, 1, scale, moves=True)
            self.moves = False
        else:
            samples = self._steps.pop(0)
            task = Task(self._number, samples, is_final=not self._steps)
        self._under_way[task.number] = task, now
        return task

    def drop(self, task: Task) -> None:
        """It was not made: it is due again, unless something has changed."""
        del self._under_way[task.number]
        if not self.moves:
            self._steps.insert(0, task.samples)

    def give_up(self, task: Task) -> None:
        """It cannot be made: nothing is due until something changes."""
        del self._under_way[task.number]
        self._steps = []

    def show(self, number: int, now: float, busy: float) -> None:
        """A picture is on the screen.

        busy: how long it took to render and encode.
        """
        task, begun = self._under_way.pop(number, (None, 0.0))
        if task is not None and task.moves:
            load = max(busy / BUDGET, (now - begun) / (AHEAD * FLUENT), 1e-3)
            fitting = task.scale**2 / load
            # Half way at a time: one slow picture says little.
            self._area = min(max((self._area + fitting) / 2, SCALES[-1] ** 2), 4.0)
