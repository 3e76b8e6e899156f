"""Tracker's UDP object stream: bytes to objects, and back for tests and the simulated rig.

A packet is one block of a frame, little-endian and unaligned: frame number uint32, item count uint8, then for each item
its kind uint8 (0: object), data size uint16 (72 for an object), name of 24 bytes, translation of three doubles [mm] and
rotation of three doubles [rad]. What is left of its 256, 512 or 1024 bytes is padding.
"""

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass

from tendond.schemas.base import Vector3

SIZES = (256, 512, 1024)
HEADER = struct.Struct("<IB")
ITEM = struct.Struct("<BH")
OBJECT = struct.Struct("<24s3d3d")
OBJECT_KIND = 0


class PacketError(Exception):
    """Bytes that are no packet of Tracker's; `reason` is one of a few short phrases, for counting."""

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(reason)


@dataclass(frozen=True)
class Reading:
    """An object as Tracker sends it: translation [mm] and Euler angles [rad], both in the Vicon world."""

    translation: Vector3
    rotation: Vector3

    @property
    def occluded(self) -> bool:
        """Tracker sends zeros for what it does not see; no object rests in the origin to the last bit."""
        return not any(self.translation) and not any(self.rotation)


@dataclass(frozen=True)
class Block:
    """One packet: the frame's number, and objects by name."""

    frame: int
    objects: Mapping[str, Reading]


def parse(payload: bytes) -> Block:
    """The packet in a payload.

    Raises:
        PacketError: wrong size, truncated, garbage, or numbers that are not finite.
    """
    if len(payload) not in SIZES:
        raise PacketError("wrong size")
    frame, count = HEADER.unpack_from(payload)
    objects: dict[str, Reading] = {}
    at = HEADER.size
    for _ in range(count):
        if at + ITEM.size > len(payload):
            raise PacketError("truncated")
        kind, size = ITEM.unpack_from(payload, at)
        at += ITEM.size
        if at + size > len(payload):
            raise PacketError("truncated")
        if kind == OBJECT_KIND:
            if size != OBJECT.size:
                raise PacketError("wrong item size")
            name, reading = _object(payload, at)
            if name in objects:
                raise PacketError("same object twice")
            objects[name] = reading
        at += size
    return Block(frame, objects)


def _object(payload: bytes, at: int) -> tuple[str, Reading]:
    raw, *numbers = OBJECT.unpack_from(payload, at)
    try:
        name = raw.split(b"\0", 1)[0].decode()
    except UnicodeDecodeError:
        raise PacketError("garbage") from None
    if not name.isprintable():
        raise PacketError("garbage")
    if not all(math.isfinite(number) for number in numbers):
        raise PacketError("not finite")
    x, y, z, a, b, c = numbers
    return name, Reading((x, y, z), (a, b, c))


def build(block: Block, size: int = 1024) -> bytes:
    """The payload of a packet.

    Args:
        block: at most 3, 6 or 13 objects for the three sizes.
        size: one of `SIZES`.
    """
    payload = HEADER.pack(block.frame % 2**32, len(block.objects))
    for name, reading in block.objects.items():
        payload += ITEM.pack(OBJECT_KIND, OBJECT.size)
        payload += OBJECT.pack(name.encode(), *reading.translation, *reading.rotation)
    return payload.ljust(size, b"\0")
