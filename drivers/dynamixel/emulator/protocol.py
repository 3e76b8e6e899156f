"""Protocol 2.0 as a servo speaks it: instruction packets out of a stream of bytes, status packets in."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum

HEADER = b"\xff\xff\xfd"
BROADCAST = 0xFE
STATUS = 0x55
LONGEST = 2048


class Instruction(IntEnum):
    """Instruction of a host."""

    PING = 0x01
    READ = 0x02
    WRITE = 0x03
    REG_WRITE = 0x04
    ACTION = 0x05
    FACTORY_RESET = 0x06
    REBOOT = 0x08
    CLEAR = 0x10
    SYNC_READ = 0x82
    SYNC_WRITE = 0x83
    FAST_SYNC_READ = 0x8A
    BULK_READ = 0x92
    BULK_WRITE = 0x93


class Error(IntEnum):
    """Error in a servo's reply."""

    NONE = 0
    RESULT_FAIL = 1
    INSTRUCTION = 2
    CRC = 3
    DATA_RANGE = 4
    DATA_LENGTH = 5
    DATA_LIMIT = 6
    ACCESS = 7


@dataclass(frozen=True)
class Packet:
    """An instruction packet; `intact` is false where its CRC does not fit."""

    id: int
    instruction: int
    parameters: bytes
    intact: bool


def _crc_of_byte(byte: int) -> int:
    crc = byte << 8
    for _ in range(8):
        crc = (crc << 1) ^ 0x8005 if crc & 0x8000 else crc << 1
    return crc & 0xFFFF


_CRC = tuple(_crc_of_byte(byte) for byte in range(256))


def crc16(data: bytes) -> int:
    """CRC-16 with polynomial 0x8005, most significant bit first."""
    crc = 0
    for byte in data:
        crc = (crc << 8 & 0xFF00) ^ _CRC[crc >> 8 ^ byte]
    return crc


def stuff(body: bytes) -> bytes:
    """Insert an FD after each FF FF FD, so that nothing in a packet looks like a header."""
    return body.replace(HEADER, HEADER + b"\xfd")


def unstuff(body: bytes) -> bytes:
    """Remove the stuffed FDs."""
    return body.replace(HEADER + b"\xfd", HEADER)


def packet(identifier: int, body: bytes) -> bytes:
    """Build a packet: header, id, length, the stuffed body (instruction first), CRC."""
    stuffed = stuff(body)
    start = HEADER + bytes([0, identifier]) + (len(stuffed) + 2).to_bytes(2, "little") + stuffed
    return start + crc16(start).to_bytes(2, "little")


def status(identifier: int, error: int, parameters: bytes = b"") -> bytes:
    """Build a status packet."""
    return packet(identifier, bytes([STATUS, error]) + parameters)


def fast_status(blocks: list[tuple[int, int, bytes]], length: int) -> bytes:
    """Build the one packet in which servos reply to a Fast Sync Read, as far as the servos in `blocks` write it.

    Args:
        blocks: error, id and data of each servo that replies, in the order asked; each adds a CRC of all before it.
        length: length that the whole packet announces. It is not stuffed.
    """
    data = HEADER + bytes([0, BROADCAST]) + length.to_bytes(2, "little") + bytes([STATUS])
    for error, identifier, parameters in blocks:
        data += bytes([error, identifier]) + parameters
        data += crc16(data).to_bytes(2, "little")
    return data


class Receiver:
    """Bytes in, packets out."""

    def __init__(self) -> None:
        self._buffer = b""

    def feed(self, data: bytes) -> Iterator[Packet]:
        """Packets that are complete now; what is none is passed over."""
        self._buffer = (self._buffer + data)[-LONGEST:]
        while (start := self._buffer.find(HEADER + b"\0")) >= 0:
            rest = self._buffer[start:]
            if len(rest) < 10:
                return
            end = 7 + int.from_bytes(rest[5:7], "little")
            if end > LONGEST or end < 10:
                self._buffer = rest[3:]
                continue
            again = rest.find(HEADER + b"\0", 3)
            if len(rest) < end and again < 0:
                return
            if 0 <= again < end:  # a header within a packet: the packet was broken off, or not stuffed
                self._buffer = rest[again:]
                continue
            whole, self._buffer = rest[:end], rest[end:]
            intact = crc16(whole[:-2]) == int.from_bytes(whole[-2:], "little")
            body = unstuff(whole[7:-2])
            yield Packet(whole[4], body[0], body[1:], intact)
