"""The command line. Nothing heavy is imported before a command needs it."""

import os
import signal
from contextlib import suppress
from types import FrameType


def _leave(number: int, frame: FrameType | None) -> None:
    """End quietly: while modules are imported there is nothing to end well, and a trace helps nobody."""
    os._exit(130)


with suppress(ValueError):  # of a thread that is not the main one
    before = signal.getsignal(signal.SIGINT)
    if before is signal.default_int_handler:
        signal.signal(signal.SIGINT, _leave)

from tendond.daemon.cli.app import main  # noqa: E402

with suppress(ValueError):
    signal.signal(signal.SIGINT, before)

__all__ = ["main"]
