"""Drives on a CAN bus: SDO, one PDO each way, SYNC, and the heartbeat that is the drives' watchdog."""

import struct
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import can
import canopen

from tendond.drivers.cia402.objects import INVALID, OPTIONAL, RECEIVED, SENT, Entry
from tendond.drivers.dynamixel.serial.bus import TRIES, NoReplyError, PortLostError, ServoError
from tendond.drivers.dynamixel.serial.late import LateReplies
from tendond.schemas.config.drives import DrivesSection

NMT, SYNC, EMERGENCY, TPDO, RPDO, HEARTBEAT = 0x000, 0x080, 0x080, 0x180, 0x200, 0x700
"""COB-IDs of the predefined connection set (CiA 301); those after SYNC with the node id added."""

START, PRE_OPERATIONAL = 0x01, 0x80
"""NMT commands."""

OPERATIONAL = 5
"""State in a heartbeat."""

BUS_OFF = 0x40
"""Bit of an error frame's id (Linux, include/uapi/linux/can/error.h)."""

FRAME_BITS = 135
"""Longest frame with 8 bytes of data and its stuff bits [bit]."""

T = TypeVar("T")
TRIPS = 1000
DOES_NOT_EXIST = (0x06020000, 0x06090011)
"""SDO abort codes: no such object, no such subindex."""


class _Link(can.Listener):
    """Error frames and a failing adapter."""

    def __init__(self) -> None:
        self.lost = ""

    def on_message_received(self, msg: can.Message) -> None:
        if msg.is_error_frame and msg.arbitration_id & BUS_OFF:
            self.lost = "the CAN controller is bus-off: check cable, termination and bit rate"

    def on_error(self, exc: Exception) -> None:
        self.lost = f"the CAN adapter fails: {exc}"


class _Counters:
    def __init__(self) -> None:
        self.late = LateReplies()


class DriveBus:
    """Open CAN bus.

    Args:
        section: [drives].
        nodes: node ids of the drives.

    Raises:
        PortLostError: the adapter cannot be opened.

    Attributes:
        port: interface and channel, for messages.
        reads: number of exchanges.
        round_trips: durations of those that all drives replied to [s]; bounded.
        emergencies: newest emergency error code, by node.
    """

    def __init__(self, section: DrivesSection, nodes: Iterable[int]) -> None:
        self.port = f"{section.interface} {section.channel}"
        self.reads = 0
        self.round_trips: deque[float] = deque(maxlen=TRIPS)
        self.transport = _Counters()
        self.emergencies: dict[int, int] = {}
        self._section = section
        self._nodes = tuple(nodes)
        self._received: dict[int, bytes] = {}
        self._arrived = threading.Condition()
        self._link = _Link()
        try:
            self._bus: can.BusABC = can.Bus(
                interface=section.interface, channel=section.channel, bitrate=section.bitrate, ignore_config=True
            )
        except (can.CanError, OSError, ImportError, ValueError) as error:
            raise PortLostError(
                f"{self.port}: cannot be opened: {error}: check drives.interface and drives.channel, and that the"
                " adapter is up"
            ) from error
        self._network = canopen.Network(self._bus)
        self._network.NOTIFIER_CYCLE = 0.1  # closing waits for it
        self._network.listeners.append(self._link)  # type: ignore[arg-type]  # typed by its first element
        self._sdo: dict[int, canopen.RemoteNode] = {}
        for node in self._nodes:
            self._network.subscribe(TPDO + node, self._take)
            self._network.subscribe(EMERGENCY + node, self._take_emergency)
            self._sdo[node] = self._network.add_node(node, canopen.ObjectDictionary())
        self._network.connect()

    def close(self) -> None:
        """Close the adapter; a second time does nothing."""
        if self._network.bus is None:
            return
        try:
            self._network.disconnect()
        except (can.CanError, OSError):
            self._network.bus = None  # it is gone

    def read_seconds(self, servos: int) -> float:
        """Return the time of an exchange on the wire [s]."""
        return (2 * servos + 2) * FRAME_BITS / self._section.bitrate

    def _take(self, can_id: int, data: bytearray, _: float) -> None:
        with self._arrived:
            self._received[can_id - TPDO] = bytes(data)
            self._arrived.notify_all()

    def _take_emergency(self, can_id: int, data: bytearray, _: float) -> None:
        if len(data) >= 2:
            self.emergencies[can_id - EMERGENCY] = int(struct.unpack_from("<H", data)[0])

    def send(self, cob_id: int, data: bytes) -> None:
        """Send a frame.

        Raises:
            PortLostError: the adapter or its bus is gone.
        """
        if self._link.lost:
            raise PortLostError(f"{self.port}: {self._link.lost}")
        try:
            self._network.send_message(cob_id, data)
        except (can.CanError, OSError, RuntimeError) as error:
            raise PortLostError(f"{self.port}: the CAN adapter fails: {error}") from error

    def command(self, node: int, state: int) -> None:
        """Send an NMT command."""
        self.send(NMT, bytes((state, node)))

    def write(self, node: int, entry: Entry, value: int) -> None:
        """Write an object by SDO; one that is optional may be absent.

        Raises:
            ServoError: the drive refuses or does not reply.
        """
        try:
            self._transfer(node, lambda sdo: sdo.download(entry.index, entry.subindex, entry.pack(value)))
        except canopen.SdoAbortedError as error:
            if entry in OPTIONAL and error.code in DOES_NOT_EXIST:
                return
            raise ServoError(f"servo {node}: refuses {value} for {entry}: {error}") from error

    def read(self, node: int, entry: Entry) -> int:
        """Read an object by SDO.

        Raises:
            ServoError: the drive refuses or does not reply.
        """
        try:
            return entry.unpack(self._transfer(node, lambda sdo: sdo.upload(entry.index, entry.subindex)))
        except canopen.SdoAbortedError as error:
            raise ServoError(f"servo {node}: does not have {entry}: {error}") from error

    def _transfer(self, node: int, use: Callable[[Any], T]) -> T:
        """Use the SDO client of a node, again where a reply is lost: writing a value twice does no harm."""
        for _ in range(TRIES):
            try:
                return use(self._sdo[node].sdo)
            except canopen.SdoCommunicationError:
                continue
            except (can.CanError, OSError, RuntimeError) as error:
                raise PortLostError(f"{self.port}: the CAN adapter fails: {error}") from error
        raise NoReplyError(self._silent(node))

    def _silent(self, node: int) -> str:
        return f"{self.port}: no reply from servo {node}: is it powered, are its node id and bit rate right?"

    def map_objects(self, node: int, cob_id: Entry, entries: Sequence[Entry], identifier: int) -> None:
        """Map entries to a PDO that is sent or applied at each SYNC.

        Args:
            node: node id of the drive.
            cob_id: entry of the PDO's COB-ID; its type and mapping are beside it.
            entries: contents.
            identifier: COB-ID.
        """
        mapping = cob_id.index + 0x200
        count = Entry("PDO mapping parameter", mapping, 0, "B")
        self.write(node, cob_id, INVALID | identifier)
        self.write(node, Entry(cob_id.name, cob_id.index, 2, "B"), 1)
        self.write(node, count, 0)
        for number, entry in enumerate(entries, 1):
            self.write(node, Entry(count.name, mapping, number, "I"), entry.mapping)
        self.write(node, count, len(entries))
        self.write(node, cob_id, identifier)

    def exchange(self, outputs: Mapping[int, tuple[int, int]]) -> dict[int, tuple[int, int, int]]:
        """Send controlwords and targets, the heartbeat and SYNC; return what each drive replies.

        The heartbeat is of this call and no thread's, so that a driver that hangs is one that the drives miss.

        Args:
            outputs: controlword and target position [counts], by node.

        Returns:
            Statusword, position [counts] and torque [1/1000 of the rated one], by node; without the silent ones.

        Raises:
            PortLostError: the adapter or its bus is gone.
        """
        begin = time.monotonic()
        self.transport.late.request_sent()
        with self._arrived:
            self._received.clear()
        for node, values in outputs.items():
            self.send(RPDO + node, b"".join(entry.pack(value) for entry, value in zip(SENT, values, strict=True)))
        self.send(HEARTBEAT + self._section.host_node, bytes((OPERATIONAL,)))
        self.send(SYNC, b"")
        with self._arrived:
            complete = self._arrived.wait_for(
                lambda: self._received.keys() >= outputs.keys(), self._section.reply_timeout
            )
            received = dict(self._received)
        self.reads += 1
        if complete:
            self.round_trips.append(time.monotonic() - begin)
        return {node: _values(data) for node, data in received.items() if len(data) >= sum(e.size for e in RECEIVED)}

    def absent(self, identifiers: Sequence[int]) -> list[int]:
        """Return the drives that did not reply to the newest SYNC."""
        with self._arrived:
            return [one for one in identifiers if one not in self._received]


def _values(data: bytes) -> tuple[int, int, int]:
    status, position, torque = struct.unpack_from("<" + "".join(entry.kind for entry in RECEIVED), data)
    return int(status), int(position), int(torque)
