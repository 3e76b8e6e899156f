"""A scripted Motive: NatNet's command port and multicast frames on loopback.

The bytes are those of the NatNet SDK's own depacketising sample (OptiTrack, `PacketClient`): little-endian, unaligned;
sizes of the parts from version 4.1 on.
"""

import socket
import struct
import threading
from collections.abc import Mapping

from tests.rig.tracker import free_port

CONNECT, SERVER_INFO, REQUEST_DEFINITIONS, DEFINITIONS, FRAME = 0, 1, 4, 5, 7
TICKS = 10_000_000

Body = tuple[tuple[float, float, float], tuple[float, float, float, float], bool]
"""Position [m], quaternion x, y, z, w, and whether it is tracked."""


def message(kind: int, payload: bytes) -> bytes:
    return struct.pack("<HH", kind, len(payload)) + payload


class Motive:
    """Answers requests in a thread, and sends frames when asked to.

    Args:
        version: of NatNet.
        ids: of the rigid bodies, by name.
    """

    def __init__(self, version: tuple[int, int], ids: Mapping[str, int], group: str = "239.255.42.99") -> None:
        self._version, self._ids, self._group = version, ids, group
        self._sized = version >= (4, 1)
        self._command = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._command.bind(("127.0.0.1", 0))
        self.port = int(self._command.getsockname()[1])
        self.data_port = free_port(socket.SOCK_DGRAM)
        self._data = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._data.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        self._frame = 100
        self._thread = threading.Thread(target=self._serve, daemon=True)

    def __enter__(self) -> "Motive":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._command.sendto(b"", ("127.0.0.1", self.port))
        self._thread.join(10.0)
        self._command.close()
        self._data.close()

    def _serve(self) -> None:
        while True:
            request, sender = self._command.recvfrom(1024)
            if not request:
                return
            kind = struct.unpack_from("<H", request)[0]
            if kind == CONNECT:
                major, minor = self._version
                info = struct.pack("<256s4B4BQ", b"Motive", 3, 1, 0, 0, major, minor, 0, 0, TICKS)
                info += struct.pack("<H?4s", self.data_port, True, socket.inet_aton(self._group)) + b"\0"
                self._command.sendto(message(SERVER_INFO, info), sender)
            elif kind == REQUEST_DEFINITIONS:
                self._command.sendto(message(DEFINITIONS, self._definitions()), sender)

    def _definitions(self) -> bytes:
        payload = struct.pack("<i", len(self._ids))
        for name, number in self._ids.items():
            body = name.encode() + b"\0" + struct.pack("<ii3fi", number, -1, 0.0, 0.0, 0.0, 0)
            payload += struct.pack("<i", 1) + (struct.pack("<i", len(body)) if self._sized else b"") + body
        return payload

    def send(self, bodies: Mapping[str, Body]) -> None:
        """Multicast one frame."""
        rigid = b"".join(
            struct.pack("<i3f4ffh", self._ids[name], *position, *turn, 1e-4, tracked)
            for name, (position, turn, tracked) in bodies.items()
        )
        none = self._part(0, b"")
        parts = none + none + self._part(len(bodies), rigid) + none  # marker sets, other markers, bodies, skeletons
        parts += none if self._sized else b""  # assets
        parts += none + none + none  # labelled markers, force plates, devices
        end = struct.pack("<IIdQQQhi", 0, 0, 0.01 * self._frame, 1, 2, 3, 0, 0)
        self.send_bytes(message(FRAME, struct.pack("<i", self._frame) + parts + end))
        self._frame += 1

    def send_bytes(self, payload: bytes) -> None:
        """Multicast any payload."""
        self._data.sendto(payload, (self._group, self.data_port))

    def _part(self, count: int, content: bytes) -> bytes:
        return struct.pack("<i", count) + (struct.pack("<i", len(content)) if self._sized else b"") + content
