"""What a signal does to a command: Ctrl-C ends it quietly with 130, at any moment.

A handler raises, so that what has been begun is ended; but an exception in the middle of an import, or of a call from
compiled code, may be swallowed or printed there. Nothing has been begun then, and the process just leaves.
"""

import atexit
import os
import signal
import sys
from contextlib import suppress
from types import FrameType

INTERRUPTED = 130
IS_PROGRAM = os.path.basename(sys.argv[0]) in ("tendond", "-m")
"""Whether this process is the command line, and not another program that imports it, such as a test."""

IMPORTS, CALLBACKS = "<frozen importlib", "_raw_object_cache"
"""What stands at the beginning of a file's or function's name in a stack that must not be unwound from within."""

_interrupts: list[int] = []


def leave_early() -> None:
    """Be quiet from the first line on, while the command line itself is imported."""
    if IS_PROGRAM:
        signal.signal(signal.SIGINT, _leave_at_once)


def leave_on_interrupt() -> None:
    """Exit with 130 on SIGINT, by way of whatever `finally` has been entered."""
    _interrupts.clear()
    signal.signal(signal.SIGINT, lambda number, frame: _leave(INTERRUPTED, frame))


def leave_on_signals(status: int = 0) -> None:
    """Exit on SIGINT, SIGTERM or SIGHUP, by way of whatever `finally` has been entered.

    Args:
        status: to exit with on the last two; it is 130 on the first.
    """
    leave_on_interrupt()
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, frame: _leave(status, frame))


def note(number: int) -> None:
    """Remember a signal that a loop has caught, so that the exit status tells of it."""
    _interrupts.append(number)


def was_interrupted() -> bool:
    """Whether a loop has been ended by Ctrl-C."""
    return signal.SIGINT in _interrupts


def leave_at_the_end() -> None:
    """Be quiet until the interpreter has gone: nothing is left to be ended.

    At its very end it takes handlers away, but leaves a signal ignored that is: what comes then changes nothing.
    """
    if IS_PROGRAM:
        signal.signal(signal.SIGINT, _leave_at_once)
        atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)


def _leave_at_once(number: int, frame: FrameType | None) -> None:
    os._exit(INTERRUPTED)


def _leave(status: int, frame: FrameType | None) -> None:
    if IS_PROGRAM and _must_not_unwind(frame) and not _has_children():
        with suppress(Exception):
            sys.stdout.flush()
        os._exit(status)
    raise SystemExit(status)


def _must_not_unwind(frame: FrameType | None) -> bool:
    while frame is not None:
        if frame.f_code.co_filename.startswith(IMPORTS) or frame.f_code.co_name.startswith(CALLBACKS):
            return True
        frame = frame.f_back
    return False


def _has_children() -> bool:
    """Whether there are processes that this one has to end; true where that cannot be known."""
    try:
        for thread in os.listdir("/proc/self/task"):
            with open(f"/proc/self/task/{thread}/children", encoding="ascii") as file:
                if file.read().strip():
                    return True
    except OSError:
        return True
    return False
