"""Schedule: which picture is to be made next, and how large.

While something moves: small ones of one sample a pixel, as soon as the page can take another one.
At rest: whole ones of more and more samples. Each replaces the one before, and none is a mean of
pictures of different moments. Times are in seconds.
"""

from typing import NamedTuple

REST = 0.15
"""From the last change on it is at rest."""
AHEAD = 2
"""Pictures at rest that are under way at a time: one is rendered while one is encoded and sent. Of
those that move there is one, of the newest change; more of them would come later."""
FAR = 3
"""Those that move where the line is long, as in a notebook: so many as come in the time of one."""
FLUENT = 1 / 30
"""Between two pictures that move."""
SHARP = 0.012
"""For one whose sides are more than half of what they are at rest, to be rendered and encoded: it
shall not come later for that."""
SCALES = (1.0, 0.75, 0.5, 0.375, 1 / 3)
"""Of the sides of a picture that moves. Its pixels are three of the screen's at most: in larger
ones nobody sees what moves, so a scene that takes longer gets fewer pictures instead."""
AGAIN = 60
"""Pictures after which a size is tried again that took too long."""
GAIN = 0.75
"""Of the time that a picture takes, at most, if it was worth it to make it smaller. Its pixels are
at most 0.57 as many: where they take the time, it takes less than that."""
SAYS = 0.25
"""Of what is known of a size, the part that one picture says: others slow it down as well."""
PATIENCE = 1.0
"""From when a picture was sent: if no page has drawn it by then it was lost on its way."""
LOSSES = 4
"""In a row, after which pictures at rest are not made again: nobody looks."""
MORE = 4
"""Times as many samples as the picture before has one at rest."""


class Task(NamedTuple):
    """A picture to be made."""

    number: int
    samples: int
    scale: float = 1.0
    is_final: bool = False
    moves: bool = False


class Pace:
    """How large pictures can be that move: found by trial, for not all that takes time shrinks with
    them."""

    def __init__(self) -> None:
        self._step = 2  # of SCALES
        self._left: int | None = None  # the step that was left for this one, which is smaller
        self._number = 0
        self._loads: dict[int, tuple[float, int]] = {}  # of steps, and when they were tried

    @property
    def scale(self) -> float:
        return SCALES[self._step]

    def _load(self, step: int) -> float:
        """As far as is known; 0: it can be tried."""
        load, number = self._loads.get(step, (0.0, 0))
        return load if self._number < number + AGAIN else 0.0

    def took(self, scale: float, load: float) -> None:
        """load: of a picture of that scale, in parts of the time that there is."""
        step = SCALES.index(scale)
        known = self._load(step) or load
        load = known + SAYS * (load - known)
        self._number += 1
        self._loads[step] = load, self._number
        if step != self._step:  # begun before the last one was judged
            return
        left = self._left if scale < 0.5 else None
        if left is not None and load > GAIN * self._load(left):
            self._step, self._left = left, None  # it is not their size that takes time
        elif load <= 1:
            if step > 0 and self._load(step - 1) <= 1:
                self._step, self._left = step - 1, None
        else:
            smaller = range(step + 1, len(SCALES))
            fitting = (i for i in smaller if load * (SCALES[i] / scale) ** 2 < 2)
            down = next(fitting, len(SCALES) - 1)
            if self._load(down) < GAIN * load:
                self._step, self._left = down, step


class Schedule:
    """Of one page."""

    def __init__(self) -> None:
        self.moves = False
        """Whether something has changed that no picture shows yet."""
        self._steps: list[int] = []  # samples of the pictures at rest that are still due
        self._changed = 0.0  # when
        self._number = 0
        self._under_way: dict[int, tuple[Task, float]] = {}  # and when it was begun
        self._sent: dict[int, float] = {}  # when, of those under way
        self._patience = PATIENCE
        self._losses = 0  # in a row
        self._lost: set[int] = set()  # their numbers
        self._shown = 0.0  # when the last one was
        self._pace = Pace()
        self._line = 0.0  # how long a picture is on its way, beside being rendered and encoded

    def change(self, now: float, samples: int) -> None:
        """samples: of the last picture at rest."""
        self.moves, self._changed = True, now
        self._losses = 0
        for number in [n for n, (task, _) in self._under_way.items() if not task.moves]:
            self._end(number)
        self._steps = [samples]
        while self._steps[0] > 1:
            self._steps.insert(0, max(self._steps[0] // MORE, 1))

    def next(self, now: float) -> Task | float | None:
        """The task that is due, or how long until it is; None: until something happens."""
        forgotten = self._forget(now)
        alike = sum(task.moves == self.moves for task, _ in self._under_way.values())
        most = min(1 + int(self._line / FLUENT), FAR) if self.moves else AHEAD
        if alike >= most or not (self.moves or self._steps):
            return forgotten
        if not self.moves and now < self._changed + REST:
            return self._changed + REST - now
        self._number += 1
        if self.moves:
            task = Task(self._number, 1, self._pace.scale, moves=True)
            self.moves = False
        else:
            samples = self._steps.pop(0)
            task = Task(self._number, samples, is_final=not self._steps)
        self._under_way[task.number] = task, now
        return task

    def _forget(self, now: float) -> float | None:
        """Forgets pictures that were lost; returns how long until the next one will be."""
        for number in [n for n, sent in self._sent.items() if now >= sent + self._patience]:
            del self._sent[number]
            task, _ = self._under_way.pop(number)
            self._losses += 1
            self._lost.add(number)
            if not task.moves and self._losses <= LOSSES:
                self._again(task)
        waits = [sent + self._patience - now for sent in self._sent.values()]
        return min(waits) if waits else None

    def _end(self, number: int) -> tuple[Task | None, float]:
        """Of a picture that is under way no more: what it was, and when it was begun."""
        self._sent.pop(number, None)
        return self._under_way.pop(number, (None, 0.0))

    def _again(self, task: Task) -> None:
        self._steps = sorted({*self._steps, task.samples})

    def drop(self, task: Task) -> None:
        """It was not made: it is due again, unless something has changed."""
        if self._end(task.number)[0] is not None and not self.moves:
            self._again(task)

    def give_up(self, task: Task) -> None:
        """It cannot be made: nothing is due until something changes."""
        if self._end(task.number)[0] is not None:
            self._steps = []

    def sent(self, number: int, now: float) -> None:
        """A picture is on its way to the page."""
        if number in self._under_way:
            self._sent[number] = now

    def show(self, number: int, now: float, busy: float) -> None:
        """A page has drawn a picture.

        busy: how long it took to render and encode.
        """
        task, begun = self._end(number)
        if number in self._lost:  # the line is slow: it does not lose
            self._patience *= 2
            self._lost.clear()
        self._losses = 0
        if task is not None and task.moves:
            waited = now - max(begun, self._shown)  # for this one alone
            self._line = (self._line + max(now - begun - busy, 0.0)) / 2
            load = max(busy, waited) / FLUENT
            self._pace.took(task.scale, max(load, busy / SHARP) if task.scale > 0.5 else load)
        self._shown = now
