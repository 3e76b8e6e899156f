"""A thin wrapper round the Dynamixel SDK that closes its known holes.

What it mends (SDK 4.1): packet timeouts are on the wall clock, and reckon with an adapter latency of 16 ms; waiting for
an answer spins; a port that fails stays marked as in use; a noisy line can keep a read for ever; `getData` gives 0 for
what never came; an answer to the question before is taken for one to this; values that hold FF FF FD are sent
unstuffed, and a servo that gets them loses step; a second process may open the same port.
"""

import struct
import time
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress

from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS, Protocol2PacketHandler
from dynamixel_sdk.robotis_def import BROADCAST_ID, INST_PING, INST_READ, INST_REBOOT, INST_WRITE

from tendond.drivers.dynamixel.serial.port import WIRE_ERRORS, Port, open_failure
from tendond.drivers.dynamixel.serial.port import NoAnswerError as NoAnswerError
from tendond.drivers.dynamixel.serial.port import PortLostError as PortLostError
from tendond.drivers.dynamixel.serial.port import RefusedError as RefusedError
from tendond.drivers.dynamixel.serial.port import ServoError as ServoError
from tendond.drivers.dynamixel.serial.reading import ALERT, READ_REQUESTS, ServoReading, reading_from
from tendond.drivers.dynamixel.serial.table import Register

TRIES = 8
"""For a single register: writing the same value again does no harm. Of answers of which a fifth is lost, 3 in a million
pairs of question and answer fail so often."""

LATE_SECONDS = 0.02
"""For which a line must be silent after an answer has failed to come, before the next question: an FTDI adapter as it
is shipped keeps answers for 16 ms. A read of all servos does without: its answers are told apart by their length."""

PING_SLOT_SECONDS = 0.003
"""For each id after a ping to all: the SDK reckons with so much."""

HEADER = b"\xff\xff\xfd"
AT_ONCE = 8
"""ServoGroup in one read: the SDK takes packets of 1024 bytes."""

STATUS_BYTES = 11
PING_BYTES = 14


class ServoBus:
    """ServoGroup on a serial port.

    Args:
        port: of the adapter.
        baudrate: [bit/s].
        answer_timeout: for an answer, beside its time on the wire [s].

    Raises:
        PortLostError: it cannot be opened.

    Attributes:
        late: answers that came after their question was given up, so far.
        late_by: the latest of them, after its question [s].
        reads: of all servos, asked so far.
        round_trips: of those answered since somebody last emptied the list [s]; bounded.
    """

    def __init__(self, port: str, baudrate: int, answer_timeout: float) -> None:
        self.port = port
        self.late = 0
        self.late_by = 0.0
        self.reads = 0
        self.round_trips: deque[float] = deque(maxlen=1000)
        self._port = Port(port, answer_timeout)
        self._packets = Protocol2PacketHandler()
        self._owed = False
        self._asked = 0.0
        self._question = 0
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
        self._owed = False
        try:
            self._port.setBaudRate(baudrate)
        except WIRE_ERRORS as error:
            self.close()
            raise open_failure(self.port, error) from error

    def set_answer_timeout(self, seconds: float) -> None:
        """Wait so long for an answer from now on, beside its time on the wire [s]."""
        self._port.answer_timeout = seconds

    @property
    def lateness(self) -> str:
        """Answers that came too late, and the likely cause, in words; empty if none did."""
        if not self.late:
            return ""
        by = self.late_by * 1e3
        return f"; {self.late} answers came late, by up to {by:.0f} ms: is the adapter's latency timer 1 ms?"

    def wire_seconds(self, servos: int) -> float:
        """What a read of so many servos takes on the wire alone [s]."""
        asked = 14 + servos
        return 1e-3 * self._port.tx_time_per_byte * (asked + servos * (READ_REQUESTS[0].length + STATUS_BYTES))

    def close(self) -> None:
        """Let go of the port; once is enough."""
        if self._port.is_open:
            self._port.is_open = False
            with suppress(*WIRE_ERRORS):
                self._port.ser.close()

    def ping(self, identifier: int) -> int | None:
        """Model number of a servo; none where none answers intelligibly.

        Raises:
            PortLostError: the port has gone away.
        """
        with _Wire(self):
            data, result, _ = self._transact(identifier, INST_PING, (), 3)
        return int.from_bytes(data[:2], "little") if result == COMM_SUCCESS else None

    def ping_all(self, patience: float = PING_SLOT_SECONDS * BROADCAST_ID) -> tuple[dict[int, int], bool]:
        """Ask every id at once.

        Args:
            patience: for which the line must be silent before it is taken that all have answered [s].

        Returns:
            Model number by id; and whether something came that is no answer: noise, or two servos of one id.

        Raises:
            PortLostError: the port has gone away.
        """
        heard = b""
        with _Wire(self):
            self._send(BROADCAST_ID, INST_PING, ())
            wire = 1e-3 * self._port.tx_time_per_byte * PING_BYTES
            silent_since = time.monotonic()
            while time.monotonic() - silent_since < patience + wire:
                if more := bytes(self._port.ser.read(1024)):
                    heard += more
                    silent_since = time.monotonic()
        found = {}
        rest = heard
        while (start := rest.find(HEADER + b"\0")) >= 0 and len(rest) >= start + PING_BYTES:
            packet = rest[start : start + PING_BYTES]
            if self._packets.updateCRC(0, packet, PING_BYTES - 2) == int.from_bytes(packet[-2:], "little"):
                found[packet[4]] = int.from_bytes(packet[9:11], "little")
            rest = rest[start + PING_BYTES :]
        return found, len(heard) != PING_BYTES * len(found)

    def read(self, identifier: int, register: Register) -> int:
        """A register's value.

        Raises:
            PortLostError, NoAnswerError, RefusedError: see there.
        """
        parameters = struct.pack("<HH", register.address, register.size)
        data = self._insist(identifier, f"read {register.name}", INST_READ, parameters, register.size)
        return register.from_bytes(data)

    def read_many(self, identifier: int, registers: Sequence[Register]) -> dict[Register, int]:
        """Values of several registers of one servo, in one read from the first to the last.

        Raises:
            PortLostError, NoAnswerError, RefusedError: see there.
        """
        first = min(register.address for register in registers)
        length = max(register.address + register.size for register in registers) - first
        data = self._insist(identifier, "read", INST_READ, struct.pack("<HH", first, length), length)
        return {one: one.from_bytes(data[one.address - first : one.address - first + one.size]) for one in registers}

    def write(self, identifier: int, register: Register, value: int) -> None:
        """Set a register, and have it confirmed.

        Raises:
            PortLostError, NoAnswerError, RefusedError: see there.
        """
        data = register.to_bytes(value)
        if HEADER in data:
            raise RefusedError(f"servo {identifier}: {register.name} = {value} cannot be sent: it looks like a header")
        parameters = struct.pack("<H", register.address) + data
        self._insist(identifier, f"write {register.name} = {value}", INST_WRITE, parameters, 0)

    def reboot(self, identifier: int) -> None:
        """Start a servo anew: its torque is off then, its hardware errors and whole turns are gone.

        Raises:
            PortLostError, NoAnswerError, RefusedError: see there.
        """
        self._insist(identifier, "reboot", INST_REBOOT, b"", 0)

    def _insist(self, identifier: int, what: str, instruction: int, parameters: bytes, length: int) -> bytes:
        """Ask until an answer comes, `TRIES` times at most."""
        result, error, data = COMM_RX_TIMEOUT, 0, b""
        for _ in range(TRIES):
            with _Wire(self):
                self._settle()
                data, result, error = self._transact(identifier, instruction, parameters, length)
            if result == COMM_SUCCESS:
                break
        if result != COMM_SUCCESS:
            said = _plain(self._packets.getTxRxResult(result))
            raise NoAnswerError(f"servo {identifier}: {what}: {said}{self.lateness}")
        if error & ~ALERT:
            raise RefusedError(f"servo {identifier}: {what}: {_plain(self._packets.getRxPacketError(error & ~ALERT))}")
        return data

    def _settle(self) -> None:
        """Let answers that are still owed come, and drop them."""
        if not self._owed:
            return
        deadline = time.monotonic() + 3.0 * LATE_SECONDS
        silent_since = time.monotonic()
        while (now := time.monotonic()) < deadline and now - silent_since < LATE_SECONDS:
            if self._port.ser.read(1024):
                silent_since = time.monotonic()
                self._note_late()
        self._owed = False

    def _note_late(self) -> None:
        self.late += 1
        self.late_by = max(self.late_by, time.monotonic() - self._asked)

    def _send(self, identifier: int, instruction: int, parameters: Sequence[int] | bytes) -> None:
        """Send an instruction packet, whatever has come before it dropped.

        Raises:
            NoAnswerError: it did not go out.
        """
        if self._owed and self._port.ser.in_waiting:
            self._note_late()
        self._owed = False
        length = (len(parameters) + 3).to_bytes(2, "little")
        packet = [0, 0, 0, 0, identifier, *length, instruction, *parameters, 0, 0]
        result = self._packets.txPacket(self._port, packet)
        self._port.is_using = False
        if result != COMM_SUCCESS:
            raise NoAnswerError(f"{self.port}: {_plain(self._packets.getTxRxResult(result))}")

    def _transact(
        self, identifier: int, instruction: int, parameters: Sequence[int] | bytes, length: int
    ) -> tuple[bytes, int, int]:
        """One question and its answer: data of that length or an error's none, the SDK's result, the error."""
        self._send(identifier, instruction, parameters)
        self._asked = time.monotonic()
        self._port.setPacketTimeout(STATUS_BYTES + length)
        return self._answer(identifier, (length,), fast=False)

    def _answer(self, identifier: int, lengths: Iterable[int], *, fast: bool) -> tuple[bytes, int, int]:
        """The next answer of that id and length; others belong to questions before, and are counted."""
        while True:
            packet, result = self._packets.rxPacket(self._port, fast)
            if result != COMM_SUCCESS:
                self._owed = True
                return b"", result, 0
            data = bytes(packet[9 : 5 + int.from_bytes(bytes(packet[5:7]), "little")])
            error = packet[8]
            if packet[4] == identifier and (len(data) in lengths or (error & ~ALERT and not data)):
                return data, result, error
            self._note_late()
            if self._port.isPacketTimeout():
                self._owed = True
                return b"", COMM_RX_TIMEOUT, 0

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
        owed = self._owed
        with _Wire(self):
            result = self._packets.syncWriteTxOnly(
                self._port, register.address, register.size, list(parameters), len(parameters)
            )
        self._owed = owed
        if result != COMM_SUCCESS:
            raise NoAnswerError(f"write {register.name}: {_plain(self._packets.getTxRxResult(result))}")

    def read_all(self, identifiers: Sequence[int], *, fast: bool) -> dict[int, ServoReading]:
        """What every servo says of itself: all of them, or an error; never a number that nobody sent.

        After a question without an answer the next one asks for another number of bytes, so that an answer which comes
        late is not taken for one to it.

        Args:
            identifiers: of the servos.
            fast: one packet from all of them.

        Raises:
            PortLostError: the port has gone away.
            NoAnswerError: one or more did not answer.
        """
        readings: dict[int, ServoReading] = {}
        self.reads += 1
        began = time.monotonic()
        for start in range(0, len(identifiers), AT_ONCE):
            some = identifiers[start : start + AT_ONCE]
            if self._owed:
                self._question = (self._question + 1) % len(READ_REQUESTS)
            with _Wire(self):
                readings |= self._read_fast(some) if fast else self._read_plain(some)
        self.round_trips.append(time.monotonic() - began)
        return readings

    def _ask(self, identifiers: Sequence[int], length: int, *, fast: bool) -> None:
        if self._owed and self._port.ser.in_waiting:
            self._note_late()
        result = self._packets.syncReadTx(
            self._port, READ_REQUESTS[self._question].address, length, list(identifiers), len(identifiers), fast
        )
        if result != COMM_SUCCESS:
            raise NoAnswerError(f"read of all servos: {_plain(self._packets.getTxRxResult(result))}")
        self._asked = time.monotonic()
        self._owed = False
        self._port.setPacketTimeout(len(identifiers) * (length + STATUS_BYTES))  # the SDK reckons with far more

    def _read_fast(self, identifiers: Sequence[int]) -> dict[int, ServoReading]:
        first = READ_REQUESTS[self._question]
        length = first.length
        self._ask(identifiers, length, fast=True)
        stride = length + 4  # error, id, data, CRC
        whole = stride * len(identifiers)
        # the last CRC is the packet's own; the first error stands where a plain answer has its error
        data, result, error = self._answer(BROADCAST_ID, (whole - 3,), fast=True)
        if result != COMM_SUCCESS or len(data) != whole - 3:
            raise NoAnswerError(f"fast read of all servos: {_plain(self._packets.getTxRxResult(result))}")
        raw = bytes([error]) + data
        found = {}
        for index, identifier in enumerate(identifiers):
            block = raw[index * stride : (index + 1) * stride]
            if block[1] != identifier:
                raise NoAnswerError(f"fast read of all servos: servo {identifier} is not in the answer")
            found[identifier] = reading_from(first, block[2 : 2 + length], block[0])
        return found

    def _read_plain(self, identifiers: Sequence[int]) -> dict[int, ServoReading]:
        first = READ_REQUESTS[self._question]
        self._ask(identifiers, first.length, fast=False)
        found = {}
        for identifier in identifiers:
            data, result, error = self._answer(identifier, (first.length,), fast=False)
            if result != COMM_SUCCESS or len(data) != first.length:
                raise NoAnswerError(f"servo {identifier}: read: {_plain(self._packets.getTxRxResult(result))}")
            found[identifier] = reading_from(first, data, error)
        return found

    def absent(self, identifiers: Iterable[int], tries: int = 2) -> list[int]:
        """Which of the servos do not answer, after so many tries each.

        Raises:
            PortLostError: the port has gone away.
        """
        return [one for one in identifiers if all(self.ping(one) is None for _ in range(tries))]


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
        if isinstance(error, WIRE_ERRORS):
            self._bus.close()
            raise PortLostError(f"{self._bus.port}: the port has gone away: {error}") from error


def _plain(text: str) -> str:
    """The SDK's words without its marks: '[TxRxResult] There is no status packet!'."""
    return text.partition("] ")[2].rstrip("!").lower() or "unknown error"
