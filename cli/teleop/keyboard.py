"""Keys of a terminal as an input: each press, and each repetition while a key is held, counts for a short time."""

import os
import select
import sys
import termios
import time
import tty
from typing import Self

from tendond.cli.teleop.hand import Wish
from tendond.daemon.errors import UsageError

KEY_SECONDS = 0.15
"""Time for which a key counts [s]: terminals repeat a held key 25 to 33 times a second, after a first pause of up to
0.66 s, in which the target rests."""

ESCAPE_SECONDS = 0.05
"""Time after which an escape alone is the key, and not the first byte of an arrow [s]."""

AWAY, BACK = (b"\x1b[C", b"\x1bOC", b"l", b"d"), (b"\x1b[D", b"\x1bOD", b"h", b"a")
"""Keys that move the target away from the straight rod, and back: arrows (ECMA-48, normal and application mode)."""

FASTER, SLOWER, END, STOP = b"+", b"-", b"q", b"\x1b"
STEPS = (0.1, 0.2, 0.5, 1.0)
"""Parts of the largest speed between which + and - choose."""


class Keyboard:
    """The keys of the terminal on standard input.

    Raises:
        UsageError: standard input is not a terminal.
    """

    help = "hold → or ← to move, + and - for the speed; q ends and holds the place, Esc stops and releases the tendons"

    def __init__(self) -> None:
        self._file = sys.stdin.fileno()
        if not os.isatty(self._file):
            raise UsageError("keys need a terminal, which standard input is not: run it in one, or give --gamepad")
        self._typed = b""
        self._escape_at = 0.0
        self._sign, self._until = 0.0, 0.0
        self._step = 1
        self._end = ""

    def __enter__(self) -> Self:
        self._before = termios.tcgetattr(self._file)
        tty.setcbreak(self._file)  # Ctrl-C remains a signal
        return self

    def __exit__(self, *_: object) -> None:
        termios.tcsetattr(self._file, termios.TCSADRAIN, self._before)

    def wait(self, seconds: float) -> Wish:
        """Read keys for a time [s], and return what holds then."""
        deadline = time.monotonic() + seconds
        while not self._end and (left := deadline - time.monotonic()) > 0.0:
            if not select.select([self._file], [], [], left)[0]:
                break
            try:
                read = os.read(self._file, 256)
            except OSError:  # the terminal is gone
                read = b""
            if not read:
                self._end = "lost"
            self._typed += read
            self._take(time.monotonic())
        now = time.monotonic()
        self._take(now)
        return Wish(self._sign * STEPS[self._step] if now < self._until else 0.0, self._end)

    def _take(self, now: float) -> None:
        """Take the keys that are complete."""
        while self._typed and not self._end:
            key = self._typed[: 3 if self._typed[:2] in (b"\x1b[", b"\x1bO") else 1]
            if key == STOP and len(self._typed) == 1:
                self._escape_at = self._escape_at or now
                if now - self._escape_at < ESCAPE_SECONDS:
                    return
            elif key in (b"\x1b[", b"\x1bO"):
                return  # the rest of an arrow is on its way
            self._escape_at = 0.0
            self._typed = self._typed[len(key) :]
            if key in AWAY + BACK:
                self._sign, self._until = (1.0 if key in AWAY else -1.0), now + KEY_SECONDS
            elif key in (FASTER, SLOWER):
                self._step = min(max(self._step + (1 if key == FASTER else -1), 0), len(STEPS) - 1)
            elif key in (END, STOP):
                self._end = "hold" if key == END else "stop"
            else:
                self._until = 0.0  # any other key lets go
