"""Tracker's UDP object stream: bytes to objects, and back for tests and the simulated rig.

A packet is one block of a frame, little-endian and unaligned: frame number uint32, item count uint8, then for each item
its kind uint8 (0: object), data size uint16 (72 for an object), name of 24 bytes, translation of three doubles [mm] and
rotation of three doubles [rad]. What is left of its 256, 512 or 1024 bytes is padding.
"""

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass, field

from tendond.schemas.base import Vector3

SIZES = (256, 512, 1024)
HEADER = struct.Struct("<IB")
ITEM = struct.Struct("<BH")
OBJECT = struct.Struct("<24s3d3d")
OBJECT_KIND = 0


class PacketError(Exception):
    """Bytes are not a packet of Tracker; `reason` is one of a few short phrases, for counting."""

    def __init__(self, reason: str) -> None:
        self.reason = reason
        super().__init__(reason)


@dataclass(frozen=True)
class ObjectReading:
    """An object as Tracker sends it: translation [mm] and Euler angles [rad], both in the Vicon world."""

    translation: Vector3
    rotation: Vector3

    @property
    def occluded(self) -> bool:
        """Tracker sends zeros for what it does not see; no object rests in the origin to the last bit."""
        return not any(self.translation) and not any(self.rotation)


NOT_FINITE = "not finite"
TWICE = "twice in the frame"


@dataclass(frozen=True)
class Block:
    """One packet.

    Attributes:
        frame: number of the frame.
        objects: readings by name.
        faults: reasons for which an object in the packet has no reading, by name; the others can be used all the same.
    """

    frame: int
    objects: Mapping[str, ObjectReading]
    faults: Mapping[str, str] = field(default_factory=dict)


def parse(payload: bytes, aliases: Mapping[bytes, str] | None = None) -> Block:
    """Read the packet in a payload; an object that cannot be used costs the others nothing.

    Args:
        payload: payload of a datagram.
        aliases: names by their bytes, for those that Tracker may not encode in UTF-8.

    Raises:
        PacketError: wrong size, truncated, or items that are none of Tracker's.
    """
    if len(payload) not in SIZES:
        raise PacketError("wrong size")
    frame, count = HEADER.unpack_from(payload)
    objects: dict[str, ObjectReading] = {}
    faults: dict[str, str] = {}
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
            raw, *numbers = OBJECT.unpack_from(payload, at)
            _add(objects, faults, _name(raw, aliases or {}), numbers)
        at += size
    return Block(frame, objects, faults)


def _name(raw: bytes, aliases: Mapping[bytes, str]) -> str:
    text = raw.split(b"\0", 1)[0]
    return aliases.get(text) or text.decode(errors="replace")


def _add(objects: dict[str, ObjectReading], faults: dict[str, str], name: str, numbers: list[float]) -> None:
    x, y, z, a, b, c = numbers
    reading = ObjectReading((x, y, z), (a, b, c))
    if not all(map(math.isfinite, numbers)):
        faults[name] = NOT_FINITE
    elif objects.get(name, reading) != reading:
        faults[name] = TWICE
    objects[name] = reading
    if name in faults:
        del objects[name]


def build(block: Block, size: int = 1024) -> bytes:
    """Build the payload of a packet.

    Args:
        block: at most 3, 6 or 13 objects for the three sizes.
        size: one of `SIZES`.
    """
    payload = HEADER.pack(block.frame % 2**32, len(block.objects))
    for name, reading in block.objects.items():
        payload += ITEM.pack(OBJECT_KIND, OBJECT.size)
        payload += OBJECT.pack(name.encode(), *reading.translation, *reading.rotation)
    return payload.ljust(size, b"\0")
