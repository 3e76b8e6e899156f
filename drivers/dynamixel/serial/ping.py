"""Ping to all ids at once, whose replies may garble each other."""

import time

from dynamixel_sdk.robotis_def import BROADCAST_ID, INST_PING

from tendond.drivers.dynamixel.serial.transport import HEADER, Transport

PING_SLOT_SECONDS = 0.003
"""Time for each id after a ping to all, as in the SDK [s]."""

PING_BYTES = 14
"""Length of a ping's reply."""


def ping_all(transport: Transport, patience: float = PING_SLOT_SECONDS * BROADCAST_ID) -> tuple[dict[int, int], bool]:
    """Ping all ids at once.

    Args:
        transport: open.
        patience: silence of the line after which all have replied [s].

    Returns:
        Model number by id; and true where there were bytes that are not a reply: noise, or two servos of one id.

    Raises:
        PortLostError: the port has gone away.
    """
    received = b""
    with transport.in_use():
        transport.send(BROADCAST_ID, INST_PING, ())
        wire = transport.wire_seconds(PING_BYTES)
        silent_since = time.monotonic()
        while time.monotonic() - silent_since < patience + wire:
            if more := transport.available():
                received += more
                silent_since = time.monotonic()
    found = {}
    rest = received
    while (start := rest.find(HEADER + b"\0")) >= 0 and len(rest) >= start + PING_BYTES:
        packet = rest[start : start + PING_BYTES]
        if transport.crc_fits(packet):
            found[packet[4]] = int.from_bytes(packet[9:11], "little")
        rest = rest[start + PING_BYTES :]
    return found, len(received) != PING_BYTES * len(found)
