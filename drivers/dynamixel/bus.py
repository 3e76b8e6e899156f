"""A thin wrapper round the Dynamixel SDK that closes its known holes.

What it mends (SDK 4.1): packet timeouts are on the wall clock, and reckon with an adapter latency of 16 ms; waiting for
an answer spins; a port that fails stays marked as in use; a noisy line can keep a read for ever; `getData` gives 0 for
what never came; values that hold FF FF FD are sent unstuffed, and a servo that gets them loses step; a second process
may open the same port.
"""

import os
import struct
import termios
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass

import serial
from dynamixel_sdk import COMM_SUCCESS, COMM_TX_FAIL, PortHandler, Protocol2PacketHandler

from tendond import TendondError
from tendond.drivers.dynamixel import table
from tendond.drivers.dynamixel.table import Register

READ_SLICE_SECONDS = 0.001
TRIES = 3
"""For a single register: an answer may get lost, and writing the same value again does no harm."""

GIVE_UP = 3.0
"""Timeouts after which even a line that never falls silent is no longer listened to."""

HEADER = b"\xff\xff\xfd"
ALERT = 0x80
BLOCK_FIRST = table.TORQUE_ENABLE
BLOCK_LAST = table.PRESENT_TEMPERATURE
BLOCK_BYTES = BLOCK_LAST.address + BLOCK_LAST.size - BLOCK_FIRST.address
AT_ONCE = 8
"""Servos in one read: the SDK takes packets of 1024 bytes."""

_WIRE_ERRORS = (OSError, termios.error, TypeError, ValueError)
"""What pyserial raises when a port goes away under it: not all of it is a SerialException."""


class ServoError(TendondError):
    """Something is wrong with the servos or their bus."""


class PortLostError(ServoError):
    """The port cannot be opened, or has gone away."""


class NoAnswerError(ServoError):
    """A servo does not answer, or not intelligibly."""


class RefusedError(ServoError):
    """A servo answered that it will not."""


class _Port(PortHandler):  # type: ignore[misc]
    """The SDK's port, with its own timeouts, on the monotonic clock, and for one process alone."""

    def __init__(self, name: str, answer_timeout: float) -> None:
        super().__init__(name)
        self.is_open: bool
        self._answer_ms = answer_timeout * 1e3

    def setupPort(self, cflag_baud: int) -> bool:  # noqa: N802
        if self.is_open:
            self.closePort()
        self.ser = serial.Serial(
            port=self.port_name,
            baudrate=self.baudrate,
            timeout=READ_SLICE_SECONDS,
            write_timeout=1.0,
            exclusive=True,
        )
        self.is_open = True
        self.ser.reset_input_buffer()
        self.tx_time_per_byte = 1e4 / self.baudrate
        return True

    def readPort(self, length: int) -> bytes:  # noqa: N802
        if self.getTimeSinceStart() > GIVE_UP * self.packet_timeout + self._answer_ms:
            return b""
        return bytes(self.ser.read(length))

    def setPacketTimeout(self, packet_length: int) -> None:  # noqa: N802
        self.setPacketTimeoutMillis(self.tx_time_per_byte * packet_length + self._answer_ms)

    def getCurrentTime(self) -> float:  # noqa: N802
        return time.monotonic() * 1e3


@dataclass(frozen=True)
class Reading:
    """What a servo said of itself, in units of its registers; `alert`: it has a hardware error."""

    torque: int
    hardware_error: int
    watchdog: int
    goal: int
    load: int
    position: int
    voltage: int
    temperature: int
    alert: bool


def _reading(data: bytes, error: int) -> Reading:
    def value(register: Register) -> int:
        start = register.address - BLOCK_FIRST.address
        return register.from_bytes(data[start : start + register.size])

    return Reading(
        torque=value(table.TORQUE_ENABLE),
        hardware_error=value(table.HARDWARE_ERROR_STATUS),
        watchdog=value(table.BUS_WATCHDOG),
        goal=value(table.GOAL_POSITION),
        load=value(table.PRESENT_LOAD),
        position=value(table.PRESENT_POSITION),
        voltage=value(table.PRESENT_INPUT_VOLTAGE),
        temperature=value(table.PRESENT_TEMPERATURE),
        alert=bool(error & ALERT),
    )


class ServoBus:
    """Servos on a serial port.

    Args:
        port: of the adapter.
        baudrate: [bit/s].
        answer_timeout: for an answer, beside its time on the wire [s].

    Raises:
        PortLostError: it cannot be opened.
    """

    def __init__(self, port: str, baudrate: int, answer_timeout: float) -> None:
        self.port = port
        self._port = _Port(port, answer_timeout)
        self._packets = Protocol2PacketHandler()
        self.set_baudrate(baudrate)

    def __enter__(self) -> "ServoBus":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def set_baudrate(self, baudrate: int) -> None:
        """Open the port anew, at another rate.

        Raises:
            PortLostError: it cannot be opened.
        """
        try:
            opened = self._port.setBaudRate(baudrate)
        except _WIRE_ERRORS as error:
            self.close()
            number = getattr(error, "errno", None)
            cause = f"{os.strerror(number) if number else error}; is the adapter plugged in, and servo.port right?"
            if "lock" in str(error):
                cause = "another process has it open"
            raise PortLostError(f"{self.port}: cannot be opened: {cause}") from error
        if not opened:
            raise PortLostError(f"{self.port}: {baudrate} bit/s is no rate that the SDK knows")

    def close(self) -> None:
        """Let go of the port; once is enough."""
        if self._port.is_open:
            self._port.is_open = False
            with suppress(*_WIRE_ERRORS):
                self._port.ser.close()

    def ping(self, identifier: int) -> int | None:
        """Model number of a servo; none where none answers.

        Raises:
            PortLostError: the port has gone away.
        """
        with _Wire(self):
            model, result, _ = self._packets.ping(self._port, identifier)
        return int(model) if result == COMM_SUCCESS else None

    def read(self, identifier: int, register: Register) -> int:
        """A register's value.

        Raises:
            PortLostError, NoAnswerError, RefusedError: see there.
        """
        result, tries = COMM_TX_FAIL, TRIES
        while result != COMM_SUCCESS and tries > 0:
            tries -= 1
            with _Wire(self):
                data, result, error = self._packets.readTxRx(self._port, identifier, register.address, register.size)
        self._check(identifier, f"read {register.name}", result, error)
        if len(data) != register.size:
            raise NoAnswerError(f"servo {identifier}: read {register.name}: {len(data)} bytes, not {register.size}")
        return register.from_bytes(bytes(data))

    def write(self, identifier: int, register: Register, value: int) -> None:
        """Set a register, and have it confirmed.

        Raises:
            PortLostError, NoAnswerError, RefusedError: see there.
        """
        data = register.to_bytes(value)
        if HEADER in data:
            raise RefusedError(f"servo {identifier}: {register.name} = {value} cannot be sent: it looks like a header")
        result, tries = COMM_TX_FAIL, TRIES
        while result != COMM_SUCCESS and tries > 0:
            tries -= 1
            with _Wire(self):
                result, error = self._packets.writeTxRx(
                    self._port, identifier, register.address, register.size, list(data)
                )
        self._check(identifier, f"write {register.name} = {value}", result, error)

    def _check(self, identifier: int, what: str, result: int, error: int) -> None:
        if result != COMM_SUCCESS:
            raise NoAnswerError(f"servo {identifier}: {what}: {_plain(self._packets.getTxRxResult(result))}")
        if error & ~ALERT:
            raise RefusedError(f"servo {identifier}: {what}: {_plain(self._packets.getRxPacketError(error & ~ALERT))}")

    def write_all(self, register: Register, values: Mapping[int, int]) -> None:
        """Set a register of several servos in one packet; nobody confirms it.

        Positions that would make the packet hold FF FF FD are sent one tick beside: the SDK cannot stuff them.

        Raises:
            PortLostError: the port has gone away.
        """
        parameters = b""
        for identifier, wanted in values.items():
            data = register.to_bytes(wanted)
            if HEADER in data:
                data = register.to_bytes(wanted + 1)
            parameters += bytes([identifier]) + data
        if HEADER in parameters:
            raise RefusedError(f"write {register.name}: cannot be sent: it looks like a header")
        with _Wire(self):
            result = self._packets.syncWriteTxOnly(
                self._port, register.address, register.size, list(parameters), len(parameters)
            )
        if result != COMM_SUCCESS:
            raise NoAnswerError(f"write {register.name}: {_plain(self._packets.getTxRxResult(result))}")

    def read_all(self, identifiers: Sequence[int], *, fast: bool) -> dict[int, Reading]:
        """What every servo says of itself: all of them, or an error; never a number that nobody sent.

        Args:
            identifiers: of the servos.
            fast: one packet from all of them.

        Raises:
            PortLostError: the port has gone away.
            NoAnswerError: one or more did not answer.
        """
        readings: dict[int, Reading] = {}
        for start in range(0, len(identifiers), AT_ONCE):
            some = identifiers[start : start + AT_ONCE]
            with _Wire(self):
                readings |= self._read_fast(some) if fast else self._read_plain(some)
        return readings

    def _ask(self, identifiers: Sequence[int], *, fast: bool) -> None:
        result = self._packets.syncReadTx(
            self._port, BLOCK_FIRST.address, BLOCK_BYTES, list(identifiers), len(identifiers), fast
        )
        if result != COMM_SUCCESS:
            raise NoAnswerError(f"read of all servos: {_plain(self._packets.getTxRxResult(result))}")
        self._port.setPacketTimeout(len(identifiers) * (BLOCK_BYTES + 11))  # the SDK reckons with far more

    def _read_fast(self, identifiers: Sequence[int]) -> dict[int, Reading]:
        self._ask(identifiers, fast=True)
        stride = BLOCK_BYTES + 4  # error, id, data, CRC
        data, result, _ = self._packets.fastSyncReadRx(self._port, 0xFE, stride * len(identifiers))
        if result != COMM_SUCCESS:
            raise NoAnswerError(f"fast read of all servos: {_plain(self._packets.getTxRxResult(result))}")
        raw = bytes(data)
        found = {}
        for index, identifier in enumerate(identifiers):
            block = raw[index * stride : (index + 1) * stride]
            if len(block) < BLOCK_BYTES + 2 or block[1] != identifier:
                raise NoAnswerError(f"fast read of all servos: servo {identifier} is not in the answer")
            found[identifier] = _reading(block[2 : 2 + BLOCK_BYTES], block[0])
        return found

    def _read_plain(self, identifiers: Sequence[int]) -> dict[int, Reading]:
        self._ask(identifiers, fast=False)
        found = {}
        for identifier in identifiers:
            data, result, error = self._packets.readRx(self._port, identifier, BLOCK_BYTES)
            if result != COMM_SUCCESS or len(data) != BLOCK_BYTES:
                raise NoAnswerError(f"servo {identifier}: read: {_plain(self._packets.getTxRxResult(result))}")
            found[identifier] = _reading(bytes(data), error)
        return found

    def absent(self, identifiers: Iterable[int]) -> list[int]:
        """Which of the servos do not answer, after two tries each.

        Raises:
            PortLostError: the port has gone away.
        """
        return [one for one in identifiers if self.ping(one) is None and self.ping(one) is None]


class _Wire:
    """Round each use of the SDK: the port is marked as free afterwards whatever happens, and its loss has one name."""

    def __init__(self, bus: ServoBus) -> None:
        self._bus = bus

    def __enter__(self) -> None:
        if not self._bus._port.is_open:
            raise PortLostError(f"{self._bus.port}: is not open")

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        self._bus._port.is_using = False
        if isinstance(error, struct.error | IndexError):
            raise NoAnswerError(f"{self._bus.port}: the SDK stumbled over an answer: {error}") from error
        if isinstance(error, _WIRE_ERRORS):
            self._bus.close()
            raise PortLostError(f"{self._bus.port}: the port has gone away: {error}") from error


def _plain(text: str) -> str:
    """The SDK's words without its marks: '[TxRxResult] There is no status packet!'."""
    return text.partition("] ")[2].rstrip("!").lower() or "unknown error"
