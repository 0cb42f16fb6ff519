"""Terminal: lines and progress bars on stderr."""

import math
import sys
import time
from contextlib import suppress
from typing import TYPE_CHECKING, Any, Self

import click

if TYPE_CHECKING:
    from tqdm import tqdm


def say(text: str) -> None:
    """Prints a line on stderr. Control characters of file names and scenes are spelt out."""
    with suppress(OSError):  # nobody listens
        click.echo("".join(c if c.isprintable() else ascii(c)[1:-1] for c in text), err=True)


class Progress:
    """A bar of tqdm's on a terminal, for work that takes longer than it takes to import tqdm."""

    def __init__(self, rows: int, quiet: bool) -> None:
        self.total = rows
        self.done = 0
        shown = sys.stderr.isatty() and not quiet
        self.due = time.perf_counter() + 0.3 if shown else math.inf
        self.bar: tqdm[Any] | None = None

    def __enter__(self) -> Self:
        return self

    def add(self, rows: int) -> None:
        self.done += rows
        if self.bar is not None:
            self.bar.update(rows)
        elif time.perf_counter() > self.due:
            from tqdm import tqdm

            self.bar = tqdm(total=self.total, initial=self.done, unit="row", leave=False)

    def __exit__(self, *error: object) -> None:
        if self.bar is not None:
            self.bar.close()
