"""What a signal does before there is a loop to end: nothing runs yet, so the process just leaves."""

import signal
from types import FrameType


def leave_on_signals(status: int = 0) -> None:
    """Exit on SIGINT, SIGTERM or SIGHUP, by way of whatever `finally` has been entered.

    Args:
        status: to exit with.
    """

    def leave(number: int, frame: FrameType | None) -> None:
        raise SystemExit(status)

    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, leave)
