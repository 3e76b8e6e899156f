"""The serial port of the servos' bus, and what may go wrong between here and a servo."""

import errno
import os
import termios
import time

import serial
from dynamixel_sdk import PortHandler

from tendond import TendondError

READ_SLICE_SECONDS = 0.001

GIVE_UP = 3.0
"""Timeouts after which even a line that never falls silent is no longer listened to."""

WIRE_ERRORS = (OSError, termios.error, TypeError, ValueError)
"""What pyserial raises when a port goes away under it: not all of it is a SerialException."""

_REMEDIES = {
    errno.EACCES: "this user may not use it: adduser USER dialout, then log in again",
    errno.ENOENT: "No such file or directory: is the adapter plugged in, and servo.port right?",
    errno.EBUSY: "another process has it open",
}


class ServoError(TendondError):
    """Something is wrong with the servos or their bus."""


class PortLostError(ServoError):
    """The port cannot be opened, or has gone away."""


class NoAnswerError(ServoError):
    """A servo does not answer, or not intelligibly."""


class RefusedError(ServoError):
    """A servo answered that it will not."""


class Port(PortHandler):  # type: ignore[misc]
    """The SDK's port, with its own timeouts, on the monotonic clock, at any rate, and for one process alone."""

    def __init__(self, name: str, answer_timeout: float) -> None:
        super().__init__(name)
        self.is_open: bool
        self.answer_timeout = answer_timeout

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
        if self.getTimeSinceStart() > GIVE_UP * self.packet_timeout + 1e3 * self.answer_timeout:
            return b""
        return bytes(self.ser.read(length))

    def setPacketTimeout(self, packet_length: int) -> None:  # noqa: N802
        self.setPacketTimeoutMillis(self.tx_time_per_byte * packet_length + 1e3 * self.answer_timeout)

    def getCurrentTime(self) -> float:  # noqa: N802
        return time.monotonic() * 1e3


def open_failure(port: str, error: Exception) -> PortLostError:
    """Say why a port cannot be opened, and the remedy."""
    number = getattr(error, "errno", None)
    if "lock" in str(error):
        cause = _REMEDIES[errno.EBUSY]
    elif number in _REMEDIES:
        cause = _REMEDIES[number]
    else:
        cause = f"{os.strerror(number) if number else error}: is the adapter plugged in, and servo.port right?"
    return PortLostError(f"{port}: cannot be opened: {cause}")
