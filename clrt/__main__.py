"""The command as a process: how it answers Ctrl-C, SIGTERM and a terminal that is closed, and how
it ends."""

import atexit
import gc
import os
import signal
import sys
import time
from contextlib import suppress
from types import FrameType

# A shell's background jobs ignore Ctrl-C: an ignored signal stays ignored.
SIGNALS = [
    number
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
    if signal.getsignal(number) is not signal.SIG_IGN
]

# As long as there is nothing to clean up they end it without Python's traceback.
for number in SIGNALS:
    signal.signal(number, signal.SIG_DFL)

# What imports leave behind is not rubbish: to look through it every 700 objects, as Python does by
# itself, takes a fifteenth of a short command.
gc.set_threshold(20_000)

_status: object = None  # with which it ends


def _leave() -> None:
    """Ends the process, once all that cleans up has run: Python would free each object first, which
    takes a tenth of a short command, and the system frees all memory at once."""
    if isinstance(_status, int):
        with suppress(OSError, ValueError):  # Python says what is wrong
            sys.stdout.flush()
            sys.stderr.flush()
            os._exit(_status)


# The first to be registered is the last to run: what is imported next may clean up as well.
atexit.register(_leave)

from clrt.commands.cli import main as command  # noqa: E402

PATIENCE = 1.0  # seconds to clean up in
_ended = float("-inf")  # when


def _end(number: int, frame: FrameType | None) -> None:
    """Ends the command by an exception, so that half-written files are removed."""
    global _ended
    if time.monotonic() < _ended + PATIENCE:
        return  # it is at it: `timeout` sends two, and so do the impatient
    _ended = time.monotonic()
    sys.unraisablehook = lambda unraisable: None  # half-made objects complain
    sys.exit(128 + number)


def main() -> None:
    global _status
    # The parent may have closed some of these. They are opened in this order, lest a picture
    # gets the number of one.
    if sys.stdin is None:
        sys.stdin = open(os.devnull)  # noqa: SIM115
    if sys.stdout is None:
        sys.stdout = open(os.devnull)  # noqa: SIM115  # so that to write there is an error
    if sys.stderr is None:
        sys.stderr = open(os.devnull, "w")  # noqa: SIM115  # nobody listens
    for number in SIGNALS:
        signal.signal(number, _end)
    try:
        command(prog_name="clrt")
    except SystemExit as ended:
        _status = ended.code
        if ended.code == 128 + signal.SIGINT:
            with suppress(OSError):
                os.write(2, b"clrt: interrupted\n")
        raise
    finally:
        for number in SIGNALS:  # nothing is left to do that takes time
            signal.signal(number, lambda number, frame: None)


if __name__ == "__main__":
    main()
