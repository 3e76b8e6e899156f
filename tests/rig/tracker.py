"""A scripted Tracker: real UDP packets on loopback."""

import socket
from collections.abc import Mapping

from tendond.drivers.vicon.packet import Block, ObjectReading, build

BASE = ObjectReading((1000.0, 200.0, 50.0), (0.1, -0.2, 0.3))
TIP = ObjectReading((1010.0, 210.0, 550.0), (0.2, 0.1, -0.4))
HIDDEN = ObjectReading((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
OTHER = ObjectReading((-5.0, 6.0, -7.0), (1.0, 0.5, -1.0))


def free_port(kind: socket.SocketKind) -> int:
    """Return a port on loopback that nobody listens on."""
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


class Tracker:
    """Sends frames to a port, of this computer, of everyone or of a group."""

    def __init__(self, port: int, address: str = "127.0.0.1") -> None:
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_BROADCAST, 1)
        self._socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        self._socket.bind(("127.0.0.1", 0))
        self.sender = "{}:{}".format(*self._socket.getsockname())
        self._address = (address, port)
        self.frame = 1000

    def __enter__(self) -> "Tracker":
        return self

    def __exit__(self, *_: object) -> None:
        self._socket.close()

    def send(self, objects: Mapping[str, ObjectReading], frame: int | None = None, size: int = 1024) -> None:
        """Send one packet; the frame's number counts up by itself."""
        if frame is not None:
            self.frame = frame
        self.send_bytes(build(Block(self.frame, objects), size))
        self.frame += 1

    def send_bytes(self, payload: bytes) -> None:
        """Send any payload."""
        self._socket.sendto(payload, self._address)
