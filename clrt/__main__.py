"""The command as a process: how it answers Ctrl-C and SIGTERM."""

import os
import signal
import sys
from contextlib import suppress
from types import FrameType

SIGNALS = (signal.SIGINT, signal.SIGTERM)

# As long as there is nothing to clean up they end it without Python's traceback.
signal.signal(signal.SIGINT, signal.SIG_DFL)

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
