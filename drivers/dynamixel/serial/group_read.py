"""Reads of several servos at once: each replies, or an error is raised."""

from collections.abc import Sequence

from dynamixel_sdk import COMM_SUCCESS
from dynamixel_sdk.robotis_def import BROADCAST_ID

from tendond.drivers.dynamixel.serial.model import ReadRequest
from tendond.drivers.dynamixel.serial.port import NoReplyError
from tendond.drivers.dynamixel.serial.reading import ServoReading, reading_from
from tendond.drivers.dynamixel.serial.transport import Transport


def read_fast(transport: Transport, request: ReadRequest, identifiers: Sequence[int]) -> dict[int, ServoReading]:
    """Read servos by Fast Sync Read, one packet from all of them.

    Raises:
        PortLostError: the port has gone away.
        NoReplyError: a servo did not reply.
    """
    length = request.length
    transport.request_sync_read(request.address, length, identifiers, fast=True)
    stride = length + 4  # error, id, data, CRC
    whole = stride * len(identifiers)
    # The last CRC is the packet's own; the first error is at the place of a plain reply's error.
    data, result, error = transport.read_reply(BROADCAST_ID, (whole - 3,), fast=True)
    if result != COMM_SUCCESS or len(data) != whole - 3:
        raise NoReplyError(f"fast read of all servos: {transport.text(result)}")
    raw = bytes([error]) + data
    found = {}
    for index, identifier in enumerate(identifiers):
        block = raw[index * stride : (index + 1) * stride]
        if block[1] != identifier:
            raise NoReplyError(f"fast read of all servos: servo {identifier} is not in the reply")
        found[identifier] = reading_from(request, block[2 : 2 + length], block[0])
    return found


def read_plain(transport: Transport, request: ReadRequest, identifiers: Sequence[int]) -> dict[int, ServoReading]:
    """Read servos by Sync Read, one packet from each.

    Raises:
        PortLostError: the port has gone away.
        NoReplyError: a servo did not reply.
    """
    transport.request_sync_read(request.address, request.length, identifiers, fast=False)
    found = {}
    for identifier in identifiers:
        data, result, error = transport.read_reply(identifier, (request.length,), fast=False)
        if result != COMM_SUCCESS or len(data) != request.length:
            raise NoReplyError(f"servo {identifier}: read: {transport.text(result)}")
        found[identifier] = reading_from(request, data, error)
    return found
