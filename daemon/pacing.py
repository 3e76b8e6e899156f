"""What a cycle waits for: the clock, or in lockstep the next pose."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from tendond.daemon.bus import Arrivals, Hub

LOCKSTEP_POLL_SECONDS = 50e-6


@dataclass(frozen=True)
class Wake:
    """A cycle's start: what has arrived; lateness after the deadline [s]; deadlines skipped before it."""

    arrivals: Arrivals
    lateness: float
    missed_ticks: int


class Pacer(Protocol):
    """Waits for the next cycle."""

    def wait(self) -> Wake | None:
        """The next cycle's start; none when the loop is to end and no cycle will come."""


class Clock:
    """Absolute deadlines on the monotonic clock; one that has passed is skipped and counted, never made up.

    Args:
        hub: of the controller.
        period: of the cycle [s].
    """

    def __init__(self, hub: Hub, period: float) -> None:
        self._hub = hub
        self._period = period
        self._deadline: float | None = None

    def wait(self) -> Wake:
        """Sleep until the next deadline."""
        now = time.monotonic()
        if self._deadline is None:
            self._deadline = now
        self._deadline += self._period
        missed = 0
        if now >= self._deadline:
            missed = int((now - self._deadline) / self._period) + 1
            self._deadline += missed * self._period
        time.sleep(max(0.0, self._deadline - now))
        return Wake(self._hub.receive(), time.monotonic() - self._deadline, missed)


class Lockstep:
    """One cycle for each pose: for simulation, faster than real time and repeatable.

    Args:
        hub: of the controller.
        stopped: true when no cycle is wanted any more.
    """

    def __init__(self, hub: Hub, stopped: Callable[[], bool]) -> None:
        self._hub = hub
        self._stopped = stopped
        self._seq: int | None = None

    def wait(self) -> Wake | None:
        """Wait for a pose with a new sequence number; a simulator without an answer publishes the same one again."""
        arrivals = Arrivals()
        while not self._stopped():
            arrivals.update(self._hub.receive())
            if arrivals.pose is not None and arrivals.pose.seq != self._seq:
                self._seq = arrivals.pose.seq
                return Wake(arrivals, 0.0, 0)
            time.sleep(LOCKSTEP_POLL_SECONDS)
        return None
