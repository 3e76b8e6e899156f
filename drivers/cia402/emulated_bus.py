"""Emulated drives on a bus of python-can, in a thread."""

import threading
import time
from collections.abc import Callable, Sequence
from contextlib import suppress

import can

from tendond.drivers.cia402.emulator import EmulatedDrive


class EmulatedDrives:
    """Drives on a bus of python-can, in a thread.

    Args:
        bus: open; closed at the end.
        drives: drives on it.
        period: time by which each SYNC advances them [s]; none: the real time.
    """

    def __init__(self, bus: can.BusABC, drives: Sequence[EmulatedDrive], period: float | None = None) -> None:
        self.drives = list(drives)
        self._bus, self._period = bus, period
        self._lock = threading.Lock()
        self._ended = False
        self._thread = threading.Thread(target=self._run, name="emulated drives", daemon=True)

    def __enter__(self) -> "EmulatedDrives":
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended = True
        self._thread.join()
        self._bus.shutdown()

    def apply(self, change: Callable[[], None]) -> None:
        """Call a function between two frames."""
        with self._lock:
            change()

    def wait(self, seconds: float, step: float = 0.002) -> None:
        """Advance all drives without a SYNC [s]."""
        for _ in range(round(seconds / step)):
            with self._lock:
                for drive in self.drives:
                    drive.advance(step)

    def _run(self) -> None:
        last = time.monotonic()
        while not self._ended:
            message = None
            with suppress(can.CanError, OSError):  # the other end is closed
                message = self._bus.recv(0.002)
            with self._lock:
                if message is not None and not message.is_error_frame:
                    for drive in self.drives:
                        drive.receive(message.arbitration_id, bytes(message.data))
                now = time.monotonic()
                passed, last = now - last, now
                if self._period is not None:
                    synced = message is not None and message.arbitration_id == 0x80 and not message.data
                    passed = self._period if synced else 0.0
                for drive in self.drives if passed else ():
                    drive.advance(passed)
                frames = [frame for drive in self.drives for frame in drive.sent()]
            for cob_id, data in frames:
                with suppress(can.CanError, OSError):
                    self._bus.send(can.Message(arbitration_id=cob_id, data=data, is_extended_id=False))
