"""Frames from Tracker's UDP object stream."""

import select
import socket
import struct
import time

import numpy as np

from tendond.drivers.mocap.frame_clock import FrameClock
from tendond.drivers.mocap.frames import POLL_SECONDS, STALE_NS, Frame
from tendond.drivers.mocap.geometry import Placement, rotation_from_euler
from tendond.drivers.vicon.packet import Block, ObjectReading, PacketError, parse
from tendond.drivers.vicon.senders import Senders
from tendond.drivers.vicon.sockets import IP_PKTINFO, close, listen
from tendond.schemas.config.vicon import EulerOrder, ViconSection

MILLIMETRE = 1e-3
LARGEST = 2048
SO_TIMESTAMPNS = 35
"""Option of socket(7) on Linux: each packet carries the kernel's receive time; Python has no name for it."""

TIMESPEC = struct.Struct("@qq")
PKTINFO = struct.Struct("@i4s4s")


def placed(reading: ObjectReading, order: EulerOrder) -> Placement | None:
    """Return an object's placement in SI; none when Tracker does not track it."""
    if reading.occluded:
        return None
    return Placement(
        position=np.array(reading.translation) * MILLIMETRE,
        rotation=rotation_from_euler(reading.rotation, order),
    )


NEIGHBOURS_MAX = 20
"""Largest number of other objects that are named."""


class UdpSource:
    """Listen on Tracker's port; a taken port is refused, so that one driver alone listens.

    Args:
        section: [vicon], or [mocap] with system = 'vicon'.

    Raises:
        ViconError: the address cannot be listened on, or the group not be joined.

    Attributes:
        counts: packets that were none of Tracker's, or none of the kept sender's, by reason.
        packets: all that came.
    """

    def __init__(self, section: ViconSection) -> None:
        self._order = section.euler_order
        self._wanted = {section.tip, section.base} - {""}
        self._aliases = {raw: name for name in self._wanted if (raw := _code_page(name))}
        self._neighbours: set[str] = set()
        self._senders = Senders(section.sender, section.silence, section.key)
        self.counts = self._senders.counts
        self.packets = 0
        self._clock = FrameClock()
        self._sockets = listen(section)
        self._cards = dict(self._sockets)
        for one in self._cards:
            one.setsockopt(socket.SOL_SOCKET, SO_TIMESTAMPNS, 1)

    def close(self) -> None:
        """Free the port."""
        close(self._sockets)

    def news(self) -> list[str]:
        """Return the lines for people since the last call."""
        lines, self._senders.news = self._senders.news, []
        return lines

    def receive(self) -> Frame | None:
        """Return the next packet's frame; none when none came for a moment, or one that is of no use.

        Stamps are the kernel's: packets that have waited here while this process could not run are old, and say so.
        Those that were late before are told by their frame's number (`FrameClock`).
        """
        ready, _, _ = select.select(list(self._cards), [], [], POLL_SECONDS)
        if not ready:
            return None
        space = socket.CMSG_SPACE(TIMESPEC.size) + socket.CMSG_SPACE(PKTINFO.size)
        payload, ancillary, _, sender = ready[0].recvmsg(LARGEST, space)
        if self._cards[ready[0]] not in (0, _card(ancillary)):
            return None
        waited_ns = _waited(ancillary)
        stamp_ns = time.monotonic_ns() - waited_ns
        self.packets += 1
        if waited_ns > STALE_NS:
            self.counts["stale"] += 1
            return None
        if not self._senders.admit(sender, stamp_ns * 1e-9):
            return None
        try:
            block = parse(payload, self._aliases)
        except PacketError as error:
            self.counts[error.reason] += 1
            return None
        if self._wanted & (block.objects.keys() | block.faults.keys()):
            self._senders.keep(sender, stamp_ns * 1e-9)
        self._name_neighbours(block)
        return self._frame(block, stamp_ns)

    def _frame(self, block: Block, stamp_ns: int) -> Frame:
        """Build the frame of the robot's objects alone."""
        objects = {name: placed(block.objects[name], self._order) for name in self._wanted & block.objects.keys()}
        faults = {name: block.faults[name] for name in self._wanted & block.faults.keys()}
        stamp_ns = self._clock.stamp(block.frame, stamp_ns)
        return Frame(block.frame, {**objects, **dict.fromkeys(faults)}, stamp_ns, faults)

    def _name_neighbours(self, block: Block) -> None:
        """Report once that something is wrong with another object: it may be meant to be one of the robot's."""
        for name in (*block.faults, *(name for name in block.objects if "\ufffd" in name or not name.isprintable())):
            if name not in self._wanted | self._neighbours and len(self._neighbours) < NEIGHBOURS_MAX:
                self._neighbours.add(name)
                why = block.faults.get(name, "its name is not printable UTF-8")
                self._senders.news.append(f"another object, {name!a}, is passed over: {why}")


def _code_page(name: str) -> bytes:
    """Encode a name as Windows may, where Tracker runs; empty where it cannot."""
    try:
        return name.encode("cp1252")
    except UnicodeEncodeError:
        return b""


def _card(ancillary: list[tuple[int, int, bytes]]) -> int:
    """Index of the network card on which a packet came."""
    for level, kind, data in ancillary:
        if level == socket.IPPROTO_IP and kind == IP_PKTINFO and len(data) == PKTINFO.size:
            return int(PKTINFO.unpack(data)[0])
    return 0


def _waited(ancillary: list[tuple[int, int, bytes]]) -> int:
    """Return the waiting time of a packet [ns], by the kernel's stamp; 0 without one."""
    for level, kind, data in ancillary:
        if level == socket.SOL_SOCKET and kind == SO_TIMESTAMPNS and len(data) == TIMESPEC.size:
            seconds, nanoseconds = TIMESPEC.unpack(data)
            return max(0, time.time_ns() - int(seconds * 1_000_000_000 + nanoseconds))
    return 0
