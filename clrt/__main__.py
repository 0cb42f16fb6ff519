"""The command as a process: how it answers Ctrl-C and SIGTERM."""

import os
import signal
import sys
from contextlib import suppress
from types import FrameType

# Those that are not ignored, as Ctrl-C is by a shell's background jobs.
SIGNALS = [
    number
    for number in (signal.SIGINT, signal.SIGTERM)
    if signal.getsignal(number) is not signal.SIG_IGN
]

# As long as there is nothing to clean up they end it without Python's traceback.
for number in SIGNALS:
    signal.signal(number, signal.SIG_DFL)

from clrt.cli import main as command  # noqa: E402


def _end(number: int, frame: FrameType | None) -> None:
    """Ends it by an exception, so that what it is writing is removed."""
    _ignore()
    sys.exit(128 + number)


def _ignore() -> None:
    """Does not answer any more: what is left to do is to clean up, and takes no time."""
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


def main() -> None:
    for number in SIGNALS:
        signal.signal(number, _end)
    try:
        command(prog_name="clrt")
    except SystemExit as ended:
        if ended.code == 128 + signal.SIGINT:
            with suppress(OSError):
                os.write(2, b"clrt: interrupted\n")
        raise
    finally:
        _ignore()


if __name__ == "__main__":
    main()
