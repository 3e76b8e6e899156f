"""A host on a serial line by Protocol 2.0, written from the manual alone: it imports neither the SDK nor tendond."""

import fcntl
import os
import select
import struct
import time
import tty
from collections.abc import Sequence
from dataclasses import dataclass

HEADER = b"\xff\xff\xfd"
TCGETS2, TCSETS2 = 0x802C542A, 0x402C542B
BOTHER, CBAUD = 0o010000, 0o010017


def crc(data: bytes) -> int:
    """CRC-16 of the manual: polynomial x^16 + x^15 + x^2 + 1, bit by bit, most significant first."""
    remainder = 0
    for byte in data:
        for bit in range(7, -1, -1):
            top = remainder >> 15 ^ byte >> bit & 1
            remainder = (remainder << 1 & 0xFFFF) ^ (0x8005 if top else 0)
    return remainder


def packet(identifier: int, instruction: int, parameters: bytes = b"") -> bytes:
    """Build an instruction packet."""
    body = bytearray()
    for byte in bytes([instruction]) + parameters:
        body.append(byte)
        if body[-3:] == HEADER:
            body.append(0xFD)
    start = HEADER + b"\0" + bytes([identifier]) + struct.pack("<H", len(body) + 2) + bytes(body)
    return start + struct.pack("<H", crc(start))


@dataclass(frozen=True)
class Status:
    """A status packet: `error` without the alert bit, and that; `data` without stuffing; `after` the question [s]."""

    id: int
    error: int
    alert: bool
    data: bytes
    after: float


class Host:
    """A serial port.

    Args:
        path: of the port.
        patience: for a reply that does not come [s].
        more: for another after the first [s].
    """

    def __init__(self, path: str, patience: float = 0.15, more: float = 0.01) -> None:
        self.patience = patience
        self.more = more
        self._file = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        tty.setraw(self._file)
        self.set_rate(57600)

    def close(self) -> None:
        """Close the port."""
        os.close(self._file)

    def set_rate(self, rate: int) -> None:
        """Set any rate [bit/s]."""
        settings = list(struct.unpack("4I20B2I", fcntl.ioctl(self._file, TCGETS2, bytes(44))))
        settings[2] = settings[2] & ~CBAUD | BOTHER
        settings[-2:] = [rate, rate]
        fcntl.ioctl(self._file, TCSETS2, struct.pack("4I20B2I", *settings))

    def send(self, data: bytes) -> list[Status]:
        """Write bytes, and take what comes until the line is silent."""
        began = time.monotonic()
        os.write(self._file, data)
        heard, arrivals = b"", []
        while select.select([self._file], [], [], self.more if heard else self.patience)[0]:
            heard += os.read(self._file, 4096)
            arrivals.append(time.monotonic() - began)
        return _replies(heard, arrivals[0] if arrivals else 0.0)

    def ask(self, identifier: int, instruction: int, parameters: bytes = b"") -> list[Status]:
        """Send an instruction; return every reply."""
        return self.send(packet(identifier, instruction, parameters))

    def read(self, identifier: int, address: int, size: int) -> Status:
        """Return the reply to a read."""
        (reply,) = self.ask(identifier, 0x02, struct.pack("<HH", address, size))
        return reply

    def value(self, identifier: int, address: int, size: int, *, signed: bool = False) -> int:
        """Return the value of a register."""
        return int.from_bytes(self.read(identifier, address, size).data, "little", signed=signed)

    def write(self, identifier: int, address: int, size: int, value: int) -> int:
        """Send a write; return its error."""
        (reply,) = self.ask(identifier, 0x03, write_parameters(address, size, value))
        return reply.error

    def quietly(self, identifier: int, address: int, size: int, value: int) -> Sequence[Status]:
        """Send a write that may have no reply."""
        return self.ask(identifier, 0x03, write_parameters(address, size, value))


def write_parameters(address: int, size: int, value: int) -> bytes:
    """Address and value of a write."""
    return struct.pack("<H", address) + value.to_bytes(size, "little", signed=value < 0)


def _replies(heard: bytes, after: float) -> list[Status]:
    """Status packets in what was heard; anything else is an error of the test."""
    found = []
    while heard:
        assert heard.startswith(HEADER + b"\0"), heard.hex(" ")
        (length,) = struct.unpack_from("<H", heard, 5)
        whole, heard = heard[: 7 + length], heard[7 + length :]
        assert crc(whole[:-2]) == int.from_bytes(whole[-2:], "little"), whole.hex(" ")
        assert whole[7] == 0x55, whole.hex(" ")
        stuffed = whole[4] != 0xFE  # a reply of several servos is not
        body = whole[8:-2].replace(HEADER + b"\xfd", HEADER) if stuffed else whole[8:-2]
        found.append(Status(whole[4], body[0] & 0x7F, bool(body[0] & 0x80), body[1:], after))
    return found
