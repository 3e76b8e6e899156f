"""Frames from Tracker's UDP object stream."""

import socket
import struct
import time
from collections import Counter

import numpy as np

from tendond import TendondError
from tendond.drivers.vicon.frames import Frame
from tendond.drivers.vicon.geometry import Placement, rotation_from_euler
from tendond.drivers.vicon.packet import Block, PacketError, Reading, parse
from tendond.schemas.config_vicon import EulerOrder, ViconSection

MILLIMETRE = 1e-3
LARGEST = 2048
POLL_SECONDS = 0.2
SO_TIMESTAMPNS = 35
"""Of socket(7) on Linux: each packet comes with the time at which the kernel received it; Python has no name for it."""

TIMESPEC = struct.Struct("@qq")
STALE_NS = 100_000_000
"""A packet that has waited for longer is dropped."""


class ViconError(TendondError):
    """The motion capture cannot be heard."""


def placed(reading: Reading, order: EulerOrder) -> Placement | None:
    """An object's placement in SI; none when Tracker does not see it."""
    if reading.occluded:
        return None
    return Placement(
        position=np.array(reading.translation) * MILLIMETRE,
        rotation=rotation_from_euler(reading.rotation, order),
    )


class UdpSource:
    """A socket on Tracker's port; a taken port is refused, so that one driver alone listens.

    Args:
        section: [vicon].

    Raises:
        ViconError: the address cannot be listened on.

    Attributes:
        counts: packets that were none of Tracker's, by reason.
        packets: all that came.
    """

    def __init__(self, section: ViconSection) -> None:
        self._order = section.euler_order
        self.counts: Counter[str] = Counter()
        self.packets = 0
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        try:
            self._socket.bind((section.address, section.port))
        except OSError as error:
            self._socket.close()
            raise ViconError(
                f"cannot listen on UDP {section.address}:{section.port}: {error.strerror}; is another driver running"
                " there? Else mend vicon.address or vicon.port"
            ) from error
        self._socket.settimeout(POLL_SECONDS)
        self._socket.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)

    def close(self) -> None:
        """Free the port."""
        self._socket.close()

    def receive(self) -> Frame | None:
        """The next packet's frame; none when none came for a moment, one that is no packet, or one that has waited.

        Stamps are the kernel's: packets that have waited here while this process could not run are old, and say so.
        """
        try:
            payload, ancillary, _, _ = self._socket.recvmsg(LARGEST, socket.CMSG_SPACE(TIMESPEC.size))
        except TimeoutError:
            return None
        waited_ns = _waited(ancillary)
        stamp_ns = time.monotonic_ns() - waited_ns
        self.packets += 1
        if waited_ns > STALE_NS:
            self.counts["stale"] += 1
            return None
        try:
            block = parse(payload)
        except PacketError as error:
            self.counts[error.reason] += 1
            return None
        return self._frame(block, stamp_ns)

    def _frame(self, block: Block, stamp_ns: int) -> Frame:
        objects = {name: placed(reading, self._order) for name, reading in block.objects.items()}
        return Frame(block.frame, objects, stamp_ns)


def _waited(ancillary: list[tuple[int, int, bytes]]) -> int:
    """For how long a packet has been here [ns], by the kernel's stamp; 0 without one."""
    for level, kind, data in ancillary:
        if level == socket.SOL_SOCKET and kind == SO_TIMESTAMPNS and len(data) == TIMESPEC.size:
            seconds, nanoseconds = TIMESPEC.unpack(data)
            return max(0, time.time_ns() - int(seconds * 1_000_000_000 + nanoseconds))
    return 0
