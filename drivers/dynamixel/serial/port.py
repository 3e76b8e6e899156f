"""Serial port of the servos' bus, and its errors."""

import errno
import os
import termios
import time

import serial
from dynamixel_sdk import PortHandler

from tendond import TendondError

READ_SLICE_SECONDS = 0.001

GIVE_UP = 3.0
"""Number of timeouts after which a line that never falls silent is no longer read."""

WIRE_ERRORS = (OSError, termios.error, TypeError, ValueError)
"""Exceptions of pyserial when a port disappears: not all are a SerialException."""

_REMEDIES = {
    errno.EACCES: "permission denied: adduser USER dialout, then log in again",
    errno.ENOENT: "No such file or directory: is the adapter plugged in, and is servo.port right?",
    errno.EBUSY: "another process has it open",
}


class ServoError(TendondError):
    """Error of the servos or their bus."""


class PortLostError(ServoError):
    """The port cannot be opened, or has gone away."""


class NoReplyError(ServoError):
    """A servo does not reply intelligibly."""


class RefusedError(ServoError):
    """A servo refuses an instruction."""


class Port(PortHandler):  # type: ignore[misc]  # the SDK has no types
    """Port of the SDK with timeouts on the monotonic clock, any baud rate, and exclusive use."""

    def __init__(self, name: str, reply_timeout: float) -> None:
        super().__init__(name)
        self.is_open: bool
        self.reply_timeout = reply_timeout

    def setBaudRate(self, baudrate: int) -> bool:  # noqa: N802
        self.baudrate = baudrate
        return self.setupPort(baudrate)

    def setupPort(self, cflag_baud: int) -> bool:  # noqa: N802
        if self.is_open:
            self.closePort()
        self.ser = serial.Serial(
            port=self.port_name,
            baudrate=cflag_baud,
            timeout=READ_SLICE_SECONDS,
            write_timeout=1.0,
            exclusive=True,
        )
        self.is_open = True
        self.ser.reset_input_buffer()
        self.tx_time_per_byte = 1e4 / self.baudrate
        return True

    def readPort(self, length: int) -> bytes:  # noqa: N802
        if self.getTimeSinceStart() > GIVE_UP * self.packet_timeout + 1e3 * self.reply_timeout:
            return b""
        return bytes(self.ser.read(length))

    def setPacketTimeout(self, packet_length: int) -> None:  # noqa: N802
        self.setPacketTimeoutMillis(self.tx_time_per_byte * packet_length + 1e3 * self.reply_timeout)

    def getCurrentTime(self) -> float:  # noqa: N802
        return time.monotonic() * 1e3


def open_failure(port: str, error: Exception) -> PortLostError:
    """Explain why a port cannot be opened, with the remedy."""
    number = getattr(error, "errno", None)
    if "lock" in str(error):
        cause = _REMEDIES[errno.EBUSY]
    elif number in _REMEDIES:
        cause = _REMEDIES[number]
    else:
        cause = f"{os.strerror(number) if number else error}: is the adapter plugged in, and is servo.port right?"
    return PortLostError(f"{port}: cannot be opened: {cause}")
