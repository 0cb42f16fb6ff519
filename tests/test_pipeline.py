"""Work done ahead: in order, bounded, and waited for."""

import threading
import time
from collections.abc import Iterator

import pytest

from clrt.pipeline import in_order


@pytest.mark.parametrize("threads", [1, 3])
def test_results_come_in_order_whoever_is_done_first(threads: int) -> None:
    def slow_at_first(k: int) -> int:
        time.sleep(0.02 if k % 4 == 0 else 0)
        return k

    assert list(in_order(slow_at_first, range(20), threads)) == list(range(20))
    assert not list(in_order(slow_at_first, [], threads))


@pytest.mark.parametrize("threads", [1, 3])
def test_few_are_held_and_items_come_from_the_callers_thread(threads: int) -> None:
    held = most = 0
    lock = threading.Lock()

    def items() -> Iterator[int]:
        nonlocal held, most
        for k in range(20):
            assert threading.current_thread() is threading.main_thread()
            with lock:
                held += 1
                most = max(most, held)
            yield k

    for _ in in_order(lambda k: k, items(), threads):
        with lock:
            held -= 1
    assert most == threads + 1


def test_so_many_are_under_way_at_once() -> None:
    """Each waits for two others: with fewer threads none would ever be done."""
    together = threading.Barrier(3, timeout=20)
    assert len(list(in_order(lambda _: together.wait(), range(9), 3))) == 9


def test_an_error_comes_in_its_turn() -> None:
    def fail_at_2(k: int) -> int:
        if k == 2:
            raise ValueError("2 is wrong")
        return k

    results = in_order(fail_at_2, range(9), 3)
    assert [next(results), next(results)] == [0, 1]
    with pytest.raises(ValueError, match="2 is wrong"):
        next(results)


def test_closed_it_waits_for_what_is_under_way() -> None:
    done: list[int] = []

    def work(k: int) -> None:
        time.sleep(0.05)
        done.append(k)

    results = in_order(work, range(9), 2)
    next(results)
    results.close()
    assert sorted(done) == [0, 1, 2]
