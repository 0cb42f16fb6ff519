"""The simulation of a cluster against closed forms."""

import pytest

from benchmarks.scale import CASES, rendered, simulated

OWN = {"start": 0.0, "each other": 0.0}
SCENE = {"start": 0.5, "cold start": 2.0, "frame": 0.1, "start to encode": 0.25, "encode": 0.02}


@pytest.mark.parametrize(
    ("workers", "frames", "seconds"),
    [
        (1, 100, 0.5 + 10.0),
        (4, 100, 0.5 + 2.5),
        (3, 100, 0.5 + 3.4),  # one has 34 frames
        (100, 100, 0.5 + 0.1),
        (1000, 100, 0.5 + 0.1),
    ],
)
def test_alone_each_worker_takes_its_start_and_its_share(
    workers: int, frames: int, seconds: float
) -> None:
    assert rendered(workers, frames, 0.1, 0.5, OWN) == pytest.approx(seconds)


def test_shared_storage_serves_one_after_the_other() -> None:
    """The last of n waits for n starts and for n (n - 1) / 2 looks at others."""
    storage = {"start": 0.01, "each other": 0.001}
    seconds = rendered(100, 100, 0.1, 0.5, storage)
    assert seconds == pytest.approx(100 * 0.01 + 4950 * 0.001 + 0.5 + 0.1)


def test_the_cases() -> None:
    cache = {"start": 0.01, "each other": 0.001}
    found = simulated(2, SCENE, 100, cache)
    carried = 0.5 + 50 * 0.1
    expected = (
        carried,
        carried - 0.01 + 2 * 0.01 + 0.001,
        carried - 0.01 + 2 * 0.1 + 0.01,
        2.0 + 50 * 0.1,
        carried + 0.25 + 100 * 0.02,
    )
    assert found == pytest.approx(dict(zip(CASES, expected, strict=True)))
