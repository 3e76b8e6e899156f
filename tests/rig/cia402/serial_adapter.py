"""A serial CAN adapter (slcan, Lawicel's CAN232 protocol) behind a pseudo-terminal, with the emulated drives' bus."""

import os
import re
import select
import tty
from collections import deque
from contextlib import suppress

import can

FRAME = re.compile(rb"t([0-9A-Fa-f]{3})([0-8])((?:[0-9A-Fa-f]{2})*)")


class SerialAdapter(can.BusABC):
    """The adapter, and the far side of its bus.

    Attributes:
        port: terminal that the driver opens.
    """

    def __init__(self) -> None:
        self._master, self._slave = os.openpty()
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.port = os.ttyname(self._slave)
        self._text, self._lines = b"", deque[bytes]()
        super().__init__(self.port)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        if not self._lines and select.select([self._master], [], [], timeout)[0]:
            *lines, self._text = (self._text + os.read(self._master, 4096)).split(b"\r")
            self._lines.extend(lines)
        found = FRAME.fullmatch(self._lines.popleft()) if self._lines else None  # other lines set the adapter up
        if found is None or len(found[3]) != 2 * int(found[2]):
            return None, False
        data = bytes.fromhex(found[3].decode())
        return can.Message(arbitration_id=int(found[1], 16), data=data, is_extended_id=False), False

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        with suppress(BlockingIOError):  # nobody reads, as with a killed driver: the frame is lost
            os.write(self._master, b"t%03X%d%s\r" % (msg.arbitration_id, msg.dlc, msg.data.hex().encode()))

    def shutdown(self) -> None:
        if not self._is_shutdown:
            os.close(self._master)
            os.close(self._slave)
        super().shutdown()
