"""What a signal does before there is a loop to end: nothing runs yet, so the process just leaves."""

import signal
from types import FrameType

INTERRUPTED = 130


def leave_on_signals(status: int = 0, interrupted: int = INTERRUPTED) -> None:
    """Exit on SIGINT, SIGTERM or SIGHUP, by way of whatever `finally` has been entered.

    Args:
        status: to exit with.
        interrupted: to exit with after Ctrl-C.
    """

    def leave(number: int, frame: FrameType | None) -> None:
        raise SystemExit(interrupted if number == signal.SIGINT else status)

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, leave)
