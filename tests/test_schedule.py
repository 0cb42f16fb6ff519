"""Which picture is due, at made-up times."""

import statistics

import pytest

from clrt.viewer.schedule import (
    AHEAD,
    FAR,
    FLUENT,
    GAIN,
    LOSSES,
    PATIENCE,
    REST,
    SCALES,
    SHARP,
    Schedule,
    Task,
)


def moving(schedule: Schedule, now: float) -> Task:
    schedule.change(now, 1)
    task = schedule.next(now)
    assert isinstance(task, Task)
    assert task.moves
    return task


def test_nothing_is_due_at_first() -> None:
    assert Schedule().next(0.0) is None


def test_samples_at_rest() -> None:
    schedule = Schedule()
    schedule.change(5.0, 64)
    first = schedule.next(5.0)
    assert first == Task(1, 1, SCALES[2], moves=True)
    schedule.show(1, 5.01, 0.0)
    assert schedule.next(5.05) == pytest.approx(REST - 0.05)
    found = []
    for number in range(2, 6):
        task = schedule.next(5.0 + REST + number)
        assert isinstance(task, Task)
        found.append((task.samples, task.scale, task.is_final))
        schedule.show(number, 5.0 + REST + number, 0.0)
    assert found == [(1, 1, False), (4, 1, False), (16, 1, False), (64, 1, True)]
    assert schedule.next(100.0) is None


@pytest.mark.parametrize(("samples", "expected"), [(1, [1]), (4, [1, 4]), (10, [1, 2, 10])])
def test_each_has_more_samples(samples: int, expected: list[int]) -> None:
    schedule = Schedule()
    schedule.change(0.0, samples)
    found = []
    while isinstance(task := schedule.next(10.0), Task):
        schedule.show(task.number, 10.0, 0.0)
        found += [task.samples] * (not task.moves)
    assert found == expected


def test_the_page_is_waited_for() -> None:
    schedule = Schedule()
    last = moving(schedule, 0.0)
    schedule.change(0.0, 1)
    assert schedule.next(0.0) is None
    schedule.show(last.number, 0.1, 0.0)
    schedule.show(last.number, 0.1, 0.0)  # said twice
    schedule.show(99, 0.1, 0.0)  # of none
    assert isinstance(schedule.next(0.1), Task)
    assert schedule.next(0.1) == pytest.approx(REST - 0.1)  # then one at rest


def test_at_rest_one_is_rendered_while_one_is_sent() -> None:
    schedule = Schedule()
    schedule.change(0.0, 1024)
    assert schedule.next(0.0) == Task(1, 1, SCALES[2], moves=True)
    schedule.show(1, 0.0, 0.0)
    tasks = [schedule.next(1.0) for _ in range(AHEAD + 2)]
    assert sum(isinstance(task, Task) for task in tasks) == AHEAD
    moving(schedule, 1.0)  # does not wait for them


def test_a_change_starts_anew() -> None:
    schedule = Schedule()
    schedule.show(moving(schedule, 0.0).number, 0.0, 0.0)
    schedule.change(0.0, 16)
    schedule.next(0.0)
    schedule.show(2, 0.0, 0.0)
    still = schedule.next(1.0)
    assert isinstance(still, Task)
    assert still.samples == 1
    schedule.change(1.0, 16)
    schedule.drop(still)  # it was stopped
    again = schedule.next(1.0)
    assert isinstance(again, Task)
    assert again.moves


def test_what_was_dropped_for_others_is_due_again() -> None:
    schedule = Schedule()
    schedule.change(0.0, 4)
    schedule.next(0.0)
    still = schedule.next(1.0)
    assert isinstance(still, Task)
    schedule.drop(still)
    again = schedule.next(1.0)
    assert isinstance(again, Task)
    assert again == still._replace(number=again.number)


def test_what_cannot_be_made_is_not_tried_again() -> None:
    schedule = Schedule()
    schedule.give_up(moving(schedule, 0.0))
    assert schedule.next(10.0) is None
    moving(schedule, 20.0)


def test_a_picture_that_is_lost_is_forgotten() -> None:
    """As by jupyter_server, while a cell prints much."""
    schedule = Schedule()
    lost = moving(schedule, 0.0)
    schedule.sent(lost.number, 0.1)
    schedule.change(0.2, 1)
    assert schedule.next(0.2) == pytest.approx(PATIENCE - 0.1)
    again = schedule.next(0.1 + PATIENCE)
    assert isinstance(again, Task)
    assert again.moves
    schedule.show(again.number, 2.0, 0.0)
    last = schedule.next(3.0)
    assert isinstance(last, Task)
    assert last.is_final
    schedule.sent(last.number, 3.0)
    for k in range(1, LOSSES + 1):
        assert schedule.next(3.0 + k - 0.5) == pytest.approx(0.5)
        last = schedule.next(3.0 + k)
        assert isinstance(last, Task)
        assert last.is_final
        schedule.sent(last.number, 3.0 + k)
    assert schedule.next(100.0) is None  # nobody looks
    moving(schedule, 101.0)


def test_a_change_forgets_what_was_at_rest() -> None:
    schedule = Schedule()
    moving(schedule, 0.0)
    still = schedule.next(1.0)
    assert isinstance(still, Task)
    schedule.change(1.0, 16)
    schedule.drop(still)
    schedule.show(still.number, 1.1, 0.0)
    assert schedule.moves


def test_a_slow_line_is_not_taken_for_one_that_loses() -> None:
    """Or pictures would wait there, more and more."""
    schedule, now = Schedule(), 0.0
    waiting: list[tuple[float, int]] = []
    for _ in range(100):
        schedule.change(now, 1)
        if isinstance(task := schedule.next(now), Task):
            schedule.sent(task.number, now)
            waiting.append((max([now, *(at for at, _ in waiting)]) + 1.5, task.number))
        now += 0.25
        while waiting and waiting[0][0] <= now:
            schedule.show(waiting.pop(0)[1], now, 0.0)
    assert len(waiting) <= FAR + 1


PIXELS = 1920 * 1080


def settled(fixed: float, each: float, line: float = 0.0) -> list[Task]:
    """The last pictures of many.

    fixed, each: seconds that a picture and a pixel take to render and encode.
    line: seconds that a picture is on its way, whatever its size.
    """
    schedule, now, found = Schedule(), 0.0, []
    for _ in range(60):
        task = moving(schedule, now)
        busy = fixed + each * task.scale**2 * PIXELS
        now += busy + 0.001 + line
        schedule.show(task.number, now, busy)
        found.append(task)
    return found[-30:]


@pytest.mark.parametrize("fixed", [0.0, 0.009, 0.01])
@pytest.mark.parametrize("each", [1e-9, 4e-9, 1e-8, 4e-8, 2e-7])
def test_pictures_are_as_large_as_is_fluent(fixed: float, each: float) -> None:
    scales = [task.scale for task in settled(fixed, each)]
    usual = statistics.median(scales)

    def is_soon(scale: float) -> bool:
        busy = fixed + each * scale**2 * PIXELS
        return busy + 0.001 <= FLUENT and (scale <= 0.5 or busy <= SHARP)

    # Or smaller ones would hardly come sooner, or there are none.
    smaller = [scale for scale in SCALES if scale < usual]
    hardly = not smaller or fixed + each * smaller[0] ** 2 * PIXELS > GAIN * SHARP
    assert is_soon(usual) or hardly
    larger = [scale for scale in SCALES if scale > usual]
    assert not larger or not is_soon(larger[-1])
    # Now and then a larger one is tried, but seldom.
    assert sum(scale > usual for scale in scales) <= 3


def test_pictures_get_small_at_once_where_they_take_seconds() -> None:
    schedule = Schedule()
    task = moving(schedule, 0.0)
    schedule.show(task.number, 5.0, 5.0)
    assert moving(schedule, 5.0).scale == SCALES[-1]


def test_a_long_line_does_not_make_them_small() -> None:
    """They would not come sooner."""
    assert statistics.median(task.scale for task in settled(0.002, 1e-9, line=0.1)) >= 0.375


def test_on_a_long_line_there_are_more() -> None:
    """As in a notebook: they come as often as on a short one."""
    schedule, now, waiting, shown = Schedule(), 0.0, list[tuple[float, int]](), 0
    while now < 10:
        schedule.change(now, 1)
        if isinstance(task := schedule.next(now), Task):
            waiting.append((now + 0.08, task.number))
        now += 0.005
        while waiting and waiting[0][0] <= now:
            schedule.show(waiting.pop(0)[1], now, 0.005)
            shown += 1
    assert shown > 30 * 10
    assert len(waiting) <= FAR


def test_a_thin_line_makes_them_small() -> None:
    schedule, now = Schedule(), 0.0
    for _ in range(60):
        task = moving(schedule, now)
        now += 1.0 * task.scale**2
        schedule.show(task.number, now, 0.001)
    assert task.scale == SCALES[-1]


def test_what_others_slow_down_stays_as_large() -> None:
    """Where a browser and the kernel share two cores, some pictures take thrice as long."""
    schedule, now, found = Schedule(), 0.0, []
    for k in range(400):
        task = moving(schedule, now)
        now += (0.012 + 2e-8 * task.scale**2 * PIXELS) * (3 if k % 9 == 8 else 1)
        schedule.show(task.number, now, 0.015)
        found.append(task.scale)
    assert sum(scale < 0.5 for scale in found) < 80


def test_no_picture_is_coarser_than_three_pixels() -> None:
    assert min(SCALES) >= 1 / 3
    assert {task.scale for task in settled(0.0, 1e-6)} == {SCALES[-1]}
