"""Pipeline: work on the next items while the caller is busy with one."""

from collections import deque
from collections.abc import Callable, Generator, Iterable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

Item = TypeVar("Item")
Result = TypeVar("Result")


def in_order(
    work: Callable[[Item], Result], items: Iterable[Item], threads: int
) -> Generator[Result, None, None]:
    """Does work on each item, several at a time, and yields the results in the items' order.

    So many threads are at it that `threads` items are under way while the caller has a result. At
    most `threads` + 1 results or items under way are held at a time. `items` is iterated in the
    caller's thread.

    An error of the items comes after the results of those before it. Once closed, it waits for the
    work that is under way.

    Raises:
        The errors of work and of items.
    """
    under_way: deque[Future[Result]] = deque()
    source = iter(items)
    fault: Exception | None = None
    with ThreadPoolExecutor(threads) as pool:
        while True:
            try:
                item = next(source)
            except StopIteration:
                break
            except Exception as error:
                fault = error
                break
            under_way.append(pool.submit(work, item))
            if len(under_way) > threads:
                yield under_way.popleft().result()
        while under_way:
            yield under_way.popleft().result()
    if fault is not None:
        raise fault
