"""Pace of the servo driver: a cycle as soon as a command arrives, and one in each period at least."""

import threading
import time

EARLIEST, LATEST = 0.5, 1.5
"""Limits of the time between two cycles, in periods: commands that come faster do not fill the serial line, and one
that is a little late is waited for, or it would be sent a cycle later. Chosen: on a busy machine, commands of a
controller at 100 Hz come within 7 to 17 ms of each other."""


class CommandPace:
    """Pace of a driver.

    Args:
        period: of the driver's cycle [s].

    Attributes:
        arrived: set by who receives the commands, when one has arrived.
    """

    def __init__(self, period: float) -> None:
        self.arrived = threading.Event()
        self._period = period
        self._last = time.monotonic()

    def wait(self, *, awaited: bool) -> None:
        """Wait for the next cycle.

        Args:
            awaited: commands come, and move the servos; otherwise the period alone counts.
        """
        last, period = self._last, self._period
        earliest = last + (EARLIEST if awaited else 1.0) * period
        time.sleep(max(0.0, earliest - time.monotonic()))
        if awaited:
            self.arrived.wait(max(0.0, last + LATEST * period - time.monotonic()))
        self.arrived.clear()
        self._last = time.monotonic() if awaited else max(earliest, time.monotonic() - period)
