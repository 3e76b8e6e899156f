"""A gamepad as an input: the kernel's event device, read as it is documented in linux/input.h and input-event-codes.h.

Nothing moves unless the left shoulder button is held. Events that the kernel had to drop let go of it.
"""

import fcntl
import os
import select
import struct
import time
from pathlib import Path
from typing import Self

from tendond.cli.teleop.hand import Wish
from tendond.daemon.errors import UsageError

EVENT = struct.Struct("llHHi")
"""struct input_event: seconds, microseconds, type, code, value."""

ABSOLUTE = struct.Struct("6i")
"""struct input_absinfo: value, minimum, maximum, fuzz, flat, resolution."""

EV_SYN, EV_KEY, EV_ABS = 0x00, 0x01, 0x03
SYN_DROPPED, ABS_X = 0x03, 0x00
BTN_EAST, BTN_TL, BTN_START = 0x131, 0x136, 0x13B
EVIOCGABS = 0x80184540
"""Request of an axis' range, _IOR('E', 0x40 + axis, struct input_absinfo)."""

RANGE = (-32768, 32767)
"""Range of an axis that does not say its own, as of a recorded stream of events."""

DEAD_ZONE = 0.1
"""Part of the stick's way at its centre that is no motion: sticks do not return exactly. Chosen."""

FOLDER = Path("/dev/input/by-id")
EVENTS_AT_ONCE = 64


def found_gamepad() -> Path:
    """Return the first gamepad of the machine.

    Raises:
        UsageError: there is none.
    """
    names = sorted(FOLDER.glob("*-event-joystick"))
    if not names:
        raise UsageError(f"no gamepad in {FOLDER}: connect one, or name its device: --gamepad /dev/input/eventN")
    return names[0]


class Gamepad:
    """A gamepad.

    Args:
        path: its event device.
    """

    help = (
        "hold the left shoulder button and move the left stick right or left; Start ends and holds the place, the "
        "right one of the four buttons (B, circle) stops and releases the tendons"
    )

    def __init__(self, path: Path) -> None:
        self._path = path
        self._rest = b""
        self._held = False
        self._part = 0.0
        self._end = ""

    def __enter__(self) -> Self:
        try:
            self._file = os.open(self._path, os.O_RDONLY | os.O_NONBLOCK)
        except OSError as error:
            raise UsageError(
                f"{self._path}: the gamepad cannot be read ({error.strerror}): is it connected, and are you in the "
                "group 'input'?"
            ) from None
        self._low, self._high = self._range()
        return self

    def __exit__(self, *_: object) -> None:
        os.close(self._file)

    def wait(self, seconds: float) -> Wish:
        """Read events for a time [s], and return what holds then."""
        deadline = time.monotonic() + seconds
        while not self._end and (left := deadline - time.monotonic()) > 0.0:
            if not select.select([self._file], [], [], left)[0]:
                break
            try:
                read = os.read(self._file, EVENTS_AT_ONCE * EVENT.size)
            except BlockingIOError:
                continue
            except OSError:  # it was unplugged
                read = b""
            if not read:
                self._end = "lost"
            data = self._rest + read
            whole = len(data) - len(data) % EVENT.size
            for _, _, kind, code, value in EVENT.iter_unpack(data[:whole]):
                self._take(kind, code, value)
            self._rest = data[whole:]
        return Wish(self._part if self._held and not self._end else 0.0, self._end)

    def _take(self, kind: int, code: int, value: int) -> None:
        if kind == EV_SYN and code == SYN_DROPPED:
            self._held = False
        elif kind == EV_KEY and code == BTN_TL:
            self._held = value != 0
        elif kind == EV_KEY and code in (BTN_EAST, BTN_START) and value:
            self._end = self._end or ("stop" if code == BTN_EAST else "hold")
        elif kind == EV_ABS and code == ABS_X:
            part = min(1.0, max(-1.0, 2.0 * (value - self._low) / (self._high - self._low) - 1.0))
            beyond = max(0.0, abs(part) - DEAD_ZONE) / (1.0 - DEAD_ZONE)
            self._part = beyond if part > 0.0 else -beyond

    def _range(self) -> tuple[int, int]:
        answer = bytearray(ABSOLUTE.size)
        try:
            fcntl.ioctl(self._file, EVIOCGABS + ABS_X, answer)
        except OSError:
            return RANGE
        _, low, high, *_ = ABSOLUTE.unpack(answer)
        return (low, high) if high > low else RANGE
