"""Signal handling of a command: Ctrl-C ends it quietly with 130, at any moment.

A handler raises, so that open resources are closed; but an exception in the middle of an import, or of a call from
compiled code, may be swallowed or printed there. Nothing is open yet then, and the process exits at once.
"""

import atexit
import os
import signal
import sys
from contextlib import suppress
from types import FrameType

INTERRUPTED = 130
IS_PROGRAM = os.path.basename(sys.argv[0]) in ("tendond", "-m")
"""True if this process is the command line, and not another program that imports it, such as a test."""

IMPORTS, CALLBACKS = "<frozen importlib", "_raw_object_cache"
"""Prefixes of file and function names in a stack that must not be unwound by an exception."""

_interrupts: list[int] = []


def exit_early() -> None:
    """Exit quietly on SIGINT while the command line itself is imported."""
    if IS_PROGRAM:
        signal.signal(signal.SIGINT, _exit_at_once)


def exit_on_interrupt() -> None:
    """Exit with 130 on SIGINT, running the `finally` blocks that have been entered."""
    _interrupts.clear()
    signal.signal(signal.SIGINT, lambda number, frame: _exit(INTERRUPTED, frame))


def exit_on_signals(status: int = 0) -> None:
    """Exit on SIGINT, SIGTERM or SIGHUP, running the `finally` blocks that have been entered.

    Args:
        status: exit status of the last two; that of the first is 130.
    """
    exit_on_interrupt()
    for number in (signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, frame: _exit(status, frame))


def note(number: int) -> None:
    """Remember a signal that a loop has caught, for the exit status."""
    _interrupts.append(number)


def was_interrupted() -> bool:
    """Check whether a loop was ended by Ctrl-C."""
    return signal.SIGINT in _interrupts


def exit_at_the_end() -> None:
    """Exit quietly on SIGINT until the interpreter has gone: nothing is open any more.

    At its very end it removes handlers, but keeps ignoring an ignored signal: a late one has no effect.
    """
    if IS_PROGRAM:
        signal.signal(signal.SIGINT, _exit_at_once)
        atexit.register(signal.signal, signal.SIGINT, signal.SIG_IGN)


def _exit_at_once(number: int, frame: FrameType | None) -> None:
    os._exit(INTERRUPTED)


def _exit(status: int, frame: FrameType | None) -> None:
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
    """Check whether this process has children to end; true if that is unknown."""
    try:
        for thread in os.listdir("/proc/self/task"):
            with open(f"/proc/self/task/{thread}/children", encoding="ascii") as file:
                if file.read().strip():
                    return True
    except OSError:
        return True
    return False
