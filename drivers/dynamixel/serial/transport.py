"""Instruction and status packets over the Dynamixel SDK, without the SDK's known faults.

SDK 4.1 has these, which are worked around here and in `port.py`: packet timeouts are on the wall clock and assume an
adapter latency of 16 ms; waiting for a reply spins; a port that fails stays marked as in use; a noisy line can keep a
read for ever; `getData` returns 0 for what never came; a reply to an earlier request is taken for one to the present
request; values that contain FF FF FD are sent unstuffed, and a servo that gets them loses synchronisation; a second
process may open the same port.
"""

import struct
import time
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress

from dynamixel_sdk import COMM_RX_TIMEOUT, COMM_SUCCESS, Protocol2PacketHandler

from tendond.drivers.dynamixel.serial.late import LateReplies
from tendond.drivers.dynamixel.serial.port import WIRE_ERRORS, NoReplyError, Port, PortLostError, open_failure
from tendond.drivers.dynamixel.serial.reading import ALERT

LATE_SECONDS = 0.02
"""Silence of the line after a missing reply, before the next request [s]: an FTDI adapter with its default timer
delays replies by 16 ms. A read of all servos does not wait: its replies are distinguished by their length."""

HEADER = b"\xff\xff\xfd"

STATUS_BYTES = 11
"""Length of a status packet without data."""


class Transport:
    """Packets on a serial port.

    Args:
        port: port of the adapter.
        baudrate: [bit/s].
        reply_timeout: timeout of a reply, beyond its time on the wire [s].

    Raises:
        PortLostError: it cannot be opened.

    Attributes:
        name: name of the port.
        late: replies that came after their timeout.
        pending: a reply is missing and may still come.
    """

    def __init__(self, port: str, baudrate: int, reply_timeout: float) -> None:
        self.name = port
        self.late = LateReplies()
        self.pending = False
        self._port = Port(port, reply_timeout)
        self._packets = Protocol2PacketHandler()
        self.set_baudrate(baudrate)

    def set_baudrate(self, baudrate: int) -> None:
        """Open the port again, at another rate.

        Raises:
            PortLostError: it cannot be opened.
        """
        self.pending = False
        try:
            self._port.setBaudRate(baudrate)
        except WIRE_ERRORS as error:
            self.close()
            raise open_failure(self.name, error) from error

    def set_reply_timeout(self, seconds: float) -> None:
        """Change the timeout of a reply, beyond its time on the wire [s]."""
        self._port.reply_timeout = seconds

    def close(self) -> None:
        """Close the port; repeated calls do nothing."""
        if self._port.is_open:
            self._port.is_open = False
            with suppress(*WIRE_ERRORS):
                self._port.ser.close()

    def wire_seconds(self, count: int) -> float:
        """Duration of so many bytes on the wire [s]."""
        return 1e-3 * float(self._port.tx_time_per_byte) * count

    @contextmanager
    def in_use(self) -> Iterator[None]:
        """Guard a use of the SDK: the port is marked as free afterwards, and its errors become those of the port.

        Raises:
            PortLostError: the port is not open, or has gone away.
            NoReplyError: the SDK failed on a reply.
        """
        if not self._port.is_open:
            raise PortLostError(f"{self.name}: is not open")
        try:
            yield
        except (struct.error, IndexError) as error:
            raise NoReplyError(f"{self.name}: the SDK failed on a reply: {error}") from error
        except WIRE_ERRORS as error:
            self.close()
            raise PortLostError(f"{self.name}: the port has gone away: {error}") from error
        finally:
            self._port.is_using = False

    def send(self, identifier: int, instruction: int, parameters: Sequence[int] | bytes) -> None:
        """Send an instruction packet; earlier input is discarded.

        Raises:
            NoReplyError: it was not sent.
        """
        self._note_pending()
        length = (len(parameters) + 3).to_bytes(2, "little")
        packet = [0, 0, 0, 0, identifier, *length, instruction, *parameters, 0, 0]
        result = self._packets.txPacket(self._port, packet)
        self._port.is_using = False
        if result != COMM_SUCCESS:
            raise NoReplyError(f"{self.name}: {self.text(result)}")

    def transact(
        self, identifier: int, instruction: int, parameters: Sequence[int] | bytes, length: int
    ) -> tuple[bytes, int, int]:
        """Send a request and read its reply: data of that length (none with an error), the SDK's result, the error."""
        self.send(identifier, instruction, parameters)
        self.late.request_sent()
        self._port.setPacketTimeout(STATUS_BYTES + length)
        return self.read_reply(identifier, (length,), fast=False)

    def request_sync_read(self, address: int, length: int, identifiers: Sequence[int], *, fast: bool) -> None:
        """Send a (Fast) Sync Read.

        Raises:
            NoReplyError: it was not sent.
        """
        if self.pending and self._port.ser.in_waiting:
            self.late.note()
        result = self._packets.syncReadTx(self._port, address, length, list(identifiers), len(identifiers), fast)
        if result != COMM_SUCCESS:
            raise NoReplyError(f"read of all servos: {self.text(result)}")
        self.late.request_sent()
        self.pending = False
        self._port.setPacketTimeout(len(identifiers) * (length + STATUS_BYTES))  # the SDK's own is far longer

    def sync_write(self, address: int, length: int, parameters: bytes) -> int:
        """Send a Sync Write, which has no reply; return the SDK's result."""
        return int(self._packets.syncWriteTxOnly(self._port, address, length, list(parameters), len(parameters)))

    def read_reply(self, identifier: int, lengths: Iterable[int], *, fast: bool) -> tuple[bytes, int, int]:
        """Read the next reply with that id and length; others belong to earlier requests, and are counted as late."""
        while True:
            packet, result = self._packets.rxPacket(self._port, fast)
            if result != COMM_SUCCESS:
                self.pending = True
                return b"", result, 0
            data = bytes(packet[9 : 5 + int.from_bytes(bytes(packet[5:7]), "little")])
            error = packet[8]
            if packet[4] == identifier and (len(data) in lengths or (error & ~ALERT and not data)):
                return data, result, error
            self.late.note()
            if self._port.isPacketTimeout():
                self.pending = True
                return b"", COMM_RX_TIMEOUT, 0

    def available(self) -> bytes:
        """Read what has arrived, of any form."""
        return bytes(self._port.ser.read(1024))

    def drain(self) -> None:
        """Wait for replies that are still pending, and discard them."""
        if not self.pending:
            return
        deadline = time.monotonic() + 3.0 * LATE_SECONDS
        silent_since = time.monotonic()
        while (now := time.monotonic()) < deadline and now - silent_since < LATE_SECONDS:
            if self.available():
                silent_since = time.monotonic()
                self.late.note()
        self.pending = False

    def _note_pending(self) -> None:
        if self.pending and self._port.ser.in_waiting:
            self.late.note()
        self.pending = False

    def crc_fits(self, packet: bytes) -> bool:
        """Return true for a packet with a correct CRC."""
        crc = self._packets.updateCRC(0, packet, len(packet) - 2)
        return bool(crc == int.from_bytes(packet[-2:], "little"))

    def text(self, result: int) -> str:
        """Return the SDK's words for a result, without their marks: 'there is no status packet'."""
        return plain(self._packets.getTxRxResult(result))

    def error_text(self, error: int) -> str:
        """Return the SDK's words for the error of a reply."""
        return plain(self._packets.getRxPacketError(error))


def plain(text: str) -> str:
    """Remove the SDK's marks: '[TxRxResult] There is no status packet!'."""
    return text.partition("] ")[2].rstrip("!").lower() or "unknown error"
