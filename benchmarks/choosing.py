"""Prints how long an expression over 10^6 particles takes; a hash table of texts beside sorting.

The first of nine calls, which finds the different texts, and the median:
`python benchmarks/choosing.py`.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable

import numpy as np

import clrt
from clrt.particles import choose, texts

N = 10**6


def show(name: str, call: Callable[[], object]) -> None:
    times = []
    for _ in range(9):
        started = time.perf_counter()
        call()
        times.append(1e3 * (time.perf_counter() - started))
    print(f"{name:10} first {times[0]:.1f} ms, median {statistics.median(times):.1f} ms")


def main() -> None:
    random = np.random.default_rng(1)
    chains = np.array(["A", "B", "C", "D"])[random.integers(0, 4, N)]
    particles = clrt.Particles(
        random.normal(size=(N, 3)), texts={"chain": chains}, types=random.integers(1, 4, N)
    )
    columns = particles.columns
    select = 'x > 0 and type == 1 and chain != "B"'
    show("select", lambda: choose.selected(columns, N, select, None))
    show("hash table", lambda: texts.distinct(chains))
    show("sorting", lambda: np.unique(chains, return_inverse=True))


if __name__ == "__main__":
    main()
