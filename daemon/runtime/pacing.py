"""Pacing of the cycles by the clock."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

from tendond.daemon.runtime.arrivals import Arrivals
from tendond.daemon.runtime.phase import PhaseLock
from tendond.schemas.messages import TendonCommand

SPECULATION_SHARE = 0.3
"""Longest speculation, of the period: one that ends late does harm. Chosen; `tendond bench loop` has the times."""

AHEAD_SECONDS = 1000e-6
"""Time before the loop speculates, or wakes, from which on it wants the interpreter to itself [s]."""

REMEMBERED = 0.998
"""Fraction of the longest speculation that is remembered in the next cycle: a stall is forgotten in 112. Chosen."""

SPIN_SECONDS = 300e-6
"""Time awake before each deadline [s]: a sleeping processor loses the caches' content, and wakes up late."""

POLL_SECONDS = 30e-6
"""Pause between two looks for the expected pose [s]."""

POLLS = 20
"""Looks for a pose in a period, while its phase is searched for."""

TIMED = 0.35
"""Longest time between two looks, of the period, that still times a pose: that of a speculation."""


@dataclass(frozen=True)
class Wake:
    """A cycle's start.

    Attributes:
        at: time on the monotonic clock [s].
        arrivals: since the last one.
        lateness: after the deadline [s]; negative where the expected pose was there before it.
        missed_ticks: deadlines skipped before it.
        speculation: time that was spent on one [s].
        pose_wait: time for which the newest pose has waited, as far as it was seen to arrive [s]; none without one.
        locked: the cycle is in phase with the poses.
    """

    at: float
    arrivals: Arrivals
    lateness: float
    missed_ticks: int
    speculation: float = 0.0
    pose_wait: float | None = None
    locked: bool = False


class Pacer(Protocol):
    """Waits for the next cycle."""

    def wait(self) -> Wake | None:
        """The next cycle's start; none when the loop is to end and no cycle will come."""


class MessageSource(Protocol):
    """Part of the `Hub` that a clock needs."""

    @property
    def last_command(self) -> TendonCommand | None:
        """Newest command that was published."""

    def receive(self, arrivals: Arrivals) -> Arrivals:
        """Add all that has come in since the last call to `arrivals`; never block."""


class Clock:
    """Absolute deadlines on the monotonic clock; one that has passed is skipped and counted, never made up.

    With a phase lock, deadlines move until they lie a margin behind the poses, and a cycle begins as soon as the
    expected pose is there.

    Args:
        hub: hub of the controller.
        period: period of the cycle [s].
        speculate: called shortly before each deadline, where there is time for it, with what has arrived by then.
        announce: called with the time when the loop will next want the interpreter to itself [s], before it sleeps.
        phase: lock to the phase of the poses; none: the deadlines stay where they began.
    """

    def __init__(
        self,
        hub: MessageSource,
        period: float,
        speculate: Callable[[Arrivals], None] | None = None,
        announce: Callable[[float], None] = lambda moment: None,
        phase: PhaseLock | None = None,
    ) -> None:
        self._hub = hub
        self._period = period
        self._speculate = speculate
        self._announce = announce
        self._phase = phase
        self._took = SPECULATION_SHARE * period
        self._deadline: float | None = None
        self._looked = 0.0  # when for messages, last
        self._late = True  # the pose of the last cycle
        self._pose_at: float | None = None  # arrival of the newest pose, if it was seen

    def wait(self) -> Wake:
        """Sleep until the next deadline, or until the expected pose has arrived."""
        now = time.monotonic()
        if self._deadline is None:
            self._deadline = now
        self._deadline += self._period
        if self._phase is not None:
            command = self._hub.last_command
            self._deadline += self._phase.correction(now, active=command is not None and command.armed)
        missed = 0
        if now >= self._deadline:
            missed = int((now - self._deadline) / self._period) + 1
            self._deadline += missed * self._period
        arrivals, speculation, self._pose_at = Arrivals(), 0.0, None
        locked = self._phase is not None and self._phase.locked
        opens = self._deadline if self._phase is None else self._phase.opens(self._deadline)
        if self._phase is not None and (not locked or self._late):
            self._search(arrivals, self._begin(opens))
        if self._speculate is None:
            self._announce(opens - AHEAD_SECONDS)
        else:
            speculation = self._prepare(self._speculate, arrivals, opens)
            time.sleep(max(0.0, opens - SPIN_SECONDS - time.monotonic()))
            while time.monotonic() < opens:
                if self._phase is not None and not locked:
                    self._receive(arrivals)
        time.sleep(max(0.0, opens - time.monotonic()))
        if locked:
            self._await_pose(arrivals)
        now = time.monotonic()
        self._receive(arrivals)
        self._late = arrivals.pose is None
        waited = None if self._pose_at is None or arrivals.pose is None else max(0.0, now - self._pose_at)
        return Wake(now, arrivals, now - self._deadline, missed, speculation, waited, locked)

    def _receive(self, arrivals: Arrivals, *, expected: bool = False) -> bool:
        """Add what has arrived; true if a pose has. The phase learns when, if the last look was not long ago.

        Args:
            arrivals: of this cycle so far.
            expected: a pose that is there counts as having arrived now.
        """
        before, now = arrivals.pose, time.monotonic()
        gap, self._looked = now - self._looked, now
        self._hub.receive(arrivals)
        if arrivals.pose is None or arrivals.pose is before:
            return False
        if gap <= TIMED * self._period:
            self._pose_at = now - 0.5 * gap
        else:
            self._pose_at = now if expected else None
        if self._phase is not None and self._pose_at is not None and self._deadline is not None:
            self._phase.arrived(arrivals.pose, self._pose_at, self._deadline)
        return True

    def _search(self, arrivals: Arrivals, until: float) -> None:
        """Look for poses now and again, so that their phase is known."""
        self._receive(arrivals)
        step = self._period / POLLS
        while (left := until - time.monotonic()) > 0.0:
            time.sleep(min(step, left))
            self._receive(arrivals)

    def _await_pose(self, arrivals: Arrivals) -> None:
        """Look for the expected pose until it or the deadline is there."""
        assert self._phase is not None
        assert self._deadline is not None
        # One that came before it was expected does as well, unless poses come several times a cycle.
        if self._receive(arrivals, expected=self._phase.once and not self._late) and self._phase.once:
            return
        while time.monotonic() < self._deadline:
            time.sleep(POLL_SECONDS)
            if self._receive(arrivals):
                return

    def _begin(self, opens: float) -> float:
        """Time at which a speculation has to begin so that it ends in time [s]."""
        return opens if self._speculate is None else opens - SPIN_SECONDS - self._took

    def _prepare(self, speculate: Callable[[Arrivals], None], arrivals: Arrivals, opens: float) -> float:
        """Speculate just before the cycle, as early as the longest of the last speculations asks for.

        One that would take too long is left out, and tried again when that one is forgotten. Returns how long it took.
        """
        self._took *= REMEMBERED
        longest = SPECULATION_SHARE * self._period
        begin = self._begin(opens)
        possible = self._took <= longest and time.monotonic() <= begin
        self._announce((begin if possible else opens) - AHEAD_SECONDS)
        if not possible:
            return 0.0
        time.sleep(max(0.0, begin - time.monotonic()))
        started = time.monotonic()
        if started > begin + SPIN_SECONDS:  # woken so late that it would hold up the cycle itself
            return 0.0
        self._receive(arrivals)
        speculate(arrivals)
        took = time.monotonic() - started
        self._took = min(max(self._took, 1.2 * took), 1.25 * longest)  # a stall is forgotten in 112 cycles
        return took
