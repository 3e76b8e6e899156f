"""Pacing of the cycles: by the clock, or in lockstep by the next pose."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from tendond.daemon.runtime.bus import Arrivals, Hub

LOCKSTEP_POLL_SECONDS = 50e-6
LOCKSTEP_PATIENCE_SECONDS = 5.0
"""Longest step of a simulator before it counts as gone [s]."""


SPECULATION_SHARE = 0.3
"""Longest speculation, of the period: one that ends after the deadline does harm."""

AHEAD_SECONDS = 1000e-6
"""Time before the loop speculates, or wakes, from which on it wants the interpreter to itself [s]."""

REMEMBERED = 0.998
"""Fraction of the longest speculation that is remembered from one cycle to the next."""

SPIN_SECONDS = 300e-6
"""Time awake before each deadline [s]: a sleeping processor loses the caches' content, and wakes up late."""


@dataclass(frozen=True)
class Wake:
    """A cycle's start.

    Attributes:
        at: time on the monotonic clock [s].
        arrivals: since the last one.
        lateness: after the deadline [s].
        missed_ticks: deadlines skipped before it.
        speculation: time that was spent on one [s].
    """

    at: float
    arrivals: Arrivals
    lateness: float
    missed_ticks: int
    speculation: float = 0.0


class Pacer(Protocol):
    """Waits for the next cycle."""

    def wait(self) -> Wake | None:
        """The next cycle's start; none when the loop is to end and no cycle will come."""


class Clock:
    """Absolute deadlines on the monotonic clock; one that has passed is skipped and counted, never made up.

    Args:
        hub: hub of the controller.
        period: period of the cycle [s].
        speculate: called shortly before each deadline, where there is time for it, with what has arrived by then.
        announce: called with the time when the loop will next want the interpreter to itself [s], before it sleeps.
    """

    def __init__(
        self,
        hub: Hub,
        period: float,
        speculate: Callable[[Arrivals], None] | None = None,
        announce: Callable[[float], None] = lambda moment: None,
    ) -> None:
        self._hub = hub
        self._period = period
        self._speculate = speculate
        self._announce = announce
        self._took = SPECULATION_SHARE * period
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
        arrivals, speculation = Arrivals(), 0.0
        if self._speculate is None:
            self._announce(self._deadline - AHEAD_SECONDS)
        else:
            speculation = self._prepare(self._speculate, arrivals)
            time.sleep(max(0.0, self._deadline - SPIN_SECONDS - time.monotonic()))
            while time.monotonic() < self._deadline:
                pass
        time.sleep(max(0.0, self._deadline - time.monotonic()))
        now = time.monotonic()
        return Wake(now, self._hub.receive(arrivals), now - self._deadline, missed, speculation)

    def _prepare(self, speculate: Callable[[Arrivals], None], arrivals: Arrivals) -> float:
        """Speculate just before the deadline, as early as the longest of the last speculations asks for.

        One that would take too long is left out, and tried again when that one is forgotten. Returns how long it took.
        """
        assert self._deadline is not None
        self._took *= REMEMBERED
        longest = SPECULATION_SHARE * self._period
        begin = self._deadline - SPIN_SECONDS - self._took
        possible = self._took <= longest and time.monotonic() <= begin
        self._announce((begin if possible else self._deadline) - AHEAD_SECONDS)
        if not possible:
            return 0.0
        time.sleep(max(0.0, begin - time.monotonic()))
        started = time.monotonic()
        if started > begin + SPIN_SECONDS:  # woken so late that it would hold up the cycle itself
            return 0.0
        speculate(self._hub.receive(arrivals))
        took = time.monotonic() - started
        self._took = min(max(self._took, 1.2 * took), 1.25 * longest)  # a stall is forgotten in 112 cycles
        return took


class Lockstep:
    """One cycle for each pose: for simulation, faster than real time and repeatable.

    A simulator that has not had its answer publishes the same pose again, and gets the same command again. When no pose
    comes for a while, cycles come all the same: faults, requests and the release need them.

    Args:
        hub: hub of the controller.
        period: period of the cycle [s].
        stopped: true when the process is to end; asked while no pose has come yet.
    """

    def __init__(self, hub: Hub, period: float, stopped: Callable[[], bool]) -> None:
        self._hub = hub
        self._period = period
        self._stopped = stopped
        self._seq: int | None = None
        self._patience = LOCKSTEP_PATIENCE_SECONDS

    def wait(self) -> Wake | None:
        """Wait for a pose with a new sequence number."""
        arrivals = Arrivals()
        started = time.monotonic()
        while self._seq is not None or not self._stopped():
            self._hub.receive(arrivals, repeating=True)
            if arrivals.pose is not None:
                self._patience = LOCKSTEP_PATIENCE_SECONDS
                if arrivals.pose.seq != self._seq:
                    self._seq = arrivals.pose.seq
                    return Wake(time.monotonic(), arrivals, 0.0, 0)
                arrivals.pose = None
                self._hub.repeat_command()
            elif self._seq is not None and time.monotonic() - started > self._patience:
                self._patience = self._period
                return Wake(time.monotonic(), arrivals, 0.0, 0)
            time.sleep(LOCKSTEP_POLL_SECONDS)
        return None
