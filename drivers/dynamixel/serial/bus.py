"""Registers of the servos on a serial bus: read, write, ping, all of them or an error."""

import struct
import time
from collections import deque
from collections.abc import Iterable, Mapping, Sequence

from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS
from dynamixel_sdk.robotis_def import INST_PING, INST_READ, INST_REBOOT, INST_WRITE

from tendond.drivers.dynamixel.serial.group_read import read_fast, read_plain
from tendond.drivers.dynamixel.serial.model import ServoModel
from tendond.drivers.dynamixel.serial.models import XL430
from tendond.drivers.dynamixel.serial.port import NoReplyError as NoReplyError
from tendond.drivers.dynamixel.serial.port import PortLostError as PortLostError
from tendond.drivers.dynamixel.serial.port import RefusedError as RefusedError
from tendond.drivers.dynamixel.serial.port import ServoError as ServoError
from tendond.drivers.dynamixel.serial.reading import ALERT, ServoReading
from tendond.drivers.dynamixel.serial.register import Register
from tendond.drivers.dynamixel.serial.transport import HEADER, STATUS_BYTES, Transport

TRIES = 8
"""Attempts for a single register: writing the same value again does no harm. Where a fifth of the replies is lost, 3 in
a million pairs of request and reply fail so often."""

SERVOS_PER_READ = 8
"""Number of servos in one read: the SDK limits packets to 1024 bytes."""

READ_BYTES = 14
"""Length of a read request without its ids."""


class ServoBus:
    """Servos on a serial port, all of one model. Registers are named by any model's entry.

    Args:
        port, baudrate, reply_timeout: see `Transport`, which opens the port.
        model: model of the servos.

    Raises:
        PortLostError: it cannot be opened.

    Attributes:
        port: name of the port.
        model: model of the servos; a tool that asks several sets it for each.
        transport: packets on it.
        reads: number of reads of all servos.
        round_trips: times of those with all replies, since the list was last emptied [s]; bounded.
    """

    def __init__(self, port: str, baudrate: int, reply_timeout: float, model: ServoModel = XL430) -> None:
        self.port = port
        self.model = model
        self.reads = 0
        self.round_trips: deque[float] = deque(maxlen=1000)
        self.transport = Transport(port, baudrate, reply_timeout)
        self._request = 0

    def __enter__(self) -> "ServoBus":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the port; repeated calls do nothing."""
        self.transport.close()

    def read_seconds(self, servos: int) -> float:
        """Duration of a read of so many servos on the wire alone [s]."""
        length = self.model.requests[0].length + STATUS_BYTES
        return self.transport.wire_seconds(READ_BYTES + servos + servos * length)

    def ping(self, identifier: int) -> int | None:
        """Return the model number of a servo; none without an intelligible reply.

        Raises:
            PortLostError: the port has gone away.
        """
        with self.transport.in_use():
            data, result, _ = self.transport.transact(identifier, INST_PING, (), 3)
        return int.from_bytes(data[:2], "little") if result == COMM_SUCCESS else None

    def read(self, identifier: int, register: Register) -> int:
        """Read a register.

        Raises:
            PortLostError, NoReplyError, RefusedError: see there.
        """
        entry = self.model.entry(register)
        parameters = struct.pack("<HH", entry.address, entry.size)
        data = self._confirmed(identifier, f"read {entry.name}", INST_READ, parameters, entry.size)
        return entry.from_bytes(data)

    def read_many(self, identifier: int, registers: Sequence[Register]) -> dict[Register, int]:
        """Read several registers of one servo at once, from the first to the last.

        Raises:
            PortLostError, NoReplyError, RefusedError: see there.
        """
        entries = [self.model.entry(register) for register in registers]
        first = min(one.address for one in entries)
        length = max(one.address + one.size for one in entries) - first
        data = self._confirmed(identifier, "read", INST_READ, struct.pack("<HH", first, length), length)
        return {one: one.from_bytes(data[one.address - first : one.address - first + one.size]) for one in entries}

    def write(self, identifier: int, register: Register, value: int) -> None:
        """Write a register, confirmed.

        Raises:
            PortLostError, NoReplyError, RefusedError: see there.
        """
        entry = self.model.entry(register)
        data = entry.to_bytes(value)
        if HEADER in data:
            raise RefusedError(f"servo {identifier}: {register.name} = {value} cannot be sent: it looks like a header")
        parameters = struct.pack("<H", entry.address) + data
        self._confirmed(identifier, f"write {register.name} = {value}", INST_WRITE, parameters, 0)

    def reboot(self, identifier: int) -> None:
        """Reboot a servo: its torque is then off, its hardware errors and whole turns are lost.

        Raises:
            PortLostError, NoReplyError, RefusedError: see there.
        """
        self._confirmed(identifier, "reboot", INST_REBOOT, b"", 0)

    def _confirmed(self, identifier: int, what: str, instruction: int, parameters: bytes, length: int) -> bytes:
        """Send a request until there is a reply, up to `TRIES` times."""
        result, error, data = COMM_RX_TIMEOUT, 0, b""
        transport = self.transport
        for _ in range(TRIES):
            with transport.in_use():
                transport.drain()
                data, result, error = transport.transact(identifier, instruction, parameters, length)
            if result == COMM_SUCCESS:
                break
        if result != COMM_SUCCESS:
            raise NoReplyError(f"servo {identifier}: {what}: {transport.text(result)}{transport.late.text}")
        if error & ~ALERT:
            raise RefusedError(f"servo {identifier}: {what}: {transport.error_text(error & ~ALERT)}")
        return data

    def write_all(self, register: Register, values: Mapping[int, int]) -> None:
        """Write a register of several servos in one packet, unconfirmed.

        Positions with which the packet would contain FF FF FD are changed by one tick: the SDK cannot stuff them.

        Raises:
            PortLostError: the port has gone away.
        """
        entry = self.model.entry(register)
        parameters = b""
        for identifier, wanted in values.items():
            data = entry.to_bytes(wanted)
            if HEADER in data:
                data = entry.to_bytes(wanted + 1)
            parameters += bytes([identifier]) + data
        if HEADER in parameters:
            raise RefusedError(f"write {register.name}: cannot be sent: it looks like a header")
        with self.transport.in_use():
            result = self.transport.sync_write(entry.address, entry.size, parameters)
        if result != COMM_SUCCESS:
            raise NoReplyError(f"write {register.name}: {self.transport.text(result)}")

    def read_all(self, identifiers: Sequence[int], *, fast: bool) -> dict[int, ServoReading]:
        """Read all servos; either all reply, or an error is raised.

        After a request without a reply, the next one asks for another number of bytes, so that a late reply is not
        taken for one to it.

        Args:
            identifiers: identifiers of the servos.
            fast: by Fast Sync Read, one packet from all of them.

        Raises:
            PortLostError: the port has gone away.
            NoReplyError: one or more did not reply.
        """
        readings: dict[int, ServoReading] = {}
        self.reads += 1
        began = time.monotonic()
        for start in range(0, len(identifiers), SERVOS_PER_READ):
            some = identifiers[start : start + SERVOS_PER_READ]
            if self.transport.pending:
                self._request = (self._request + 1) % len(self.model.requests)
            with self.transport.in_use():
                request = self.model.requests[self._request]
                readings |= (read_fast if fast else read_plain)(self.transport, request, some)
        self.round_trips.append(time.monotonic() - began)
        return readings

    def absent(self, identifiers: Iterable[int], tries: int = 2) -> list[int]:
        """Return the servos that do not reply to so many pings each.

        Raises:
            PortLostError: the port has gone away.
        """
        return [one for one in identifiers if all(self.ping(one) is None for _ in range(tries))]
