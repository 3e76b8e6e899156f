"""Phase of the loop against the poses': a slow, bounded phase-locked loop on the times at which poses arrive.

A pose that arrives just after a deadline waits a whole period for its command. The lock moves the deadlines until one
lies a margin behind each expected pose; the cycle begins when the pose is there, and at the deadline where it is not.

Poses need not come once a period. With T / T_poses = p / q in lowest terms their arrivals lie T / p apart, modulo T,
and the lock is to the nearest of these. T_poses is the poses' own, by their stamps and counts.

The lock is a first-order one: of the median of the last errors a fixed part is corrected each cycle (F. M. Gardner,
"Phaselock Techniques", 3rd ed. 2005, chapter 2), bounded, so that the rate stays the nominal one.
"""

from collections import deque
from fractions import Fraction

from tendond.schemas.messages import TipPose

WINDOW = 24
"""Arrivals that the error is the median of, and that must agree: it scatters by 1.25/sqrt(24), a quarter, of them."""

AGREEMENT = 0.08
"""Largest median deviation of the arrivals, of their spacing: beyond it there is no phase to lock to. Of arrivals at
random it is 0.25, with a standard deviation of 0.05 for so many."""

EARLY_MIN, EARLY_MAX = 0.03, 0.2
"""Bounds of the time before the expected pose at which the loop begins to look for it, of the period."""

EARLY_SECONDS = 150e-6
"""Smallest of these [s]: a few looks for the pose."""

SPREADS = 4.0
"""Median deviations in it: 99.3 % of normally distributed arrivals come later."""

MARGIN_MAX = 0.4
"""Largest time between the expected pose and the deadline, of the arrivals' spacing: half of it without a phase."""

LATE_FACTOR = 1.25
"""Margin to the latest pose remembered. A margin costs nothing but that the cycle of a lost pose is as much later, so
it follows the latest poses of a loaded machine, not the median ones."""

LATE_KEPT = 0.998
"""Part of the latest pose's lateness that is kept from cycle to cycle: half of it is forgotten in 350 cycles."""

GAIN = 0.1
"""Part of the error that is corrected in a cycle: 0.9^24, 8 %, is left after a window, so that it does not hunt."""

SLEW_IDLE = 0.02
"""Largest correction of a cycle while nothing is commanded, of the period."""

SLEW_ACTIVE = 0.002
"""The same while tracking, to find the lock: 0.2 % of a rate for a few seconds."""

SLEW_LOCKED = 1e-4
"""The same with the lock: 100 ppm of the rate, what two quartz clocks differ by at most."""

DENOMINATOR_MAX = 8
"""Largest p and q: beyond it the arrivals lie too close for a phase to matter."""

RATE_TOLERANCE = 2e-3
"""Tolerance of the ratio of periods [-]: a few poses' stamps do not determine it better."""

SILENCE = 5.0
"""Periods without a pose, after which the lock is lost: of the longer one of loop and poses."""


class PhaseLock:
    """Estimates the poses' phase, and says how far the next deadline is to be moved.

    Args:
        period: of the loop [s].

    Attributes:
        locked: the poses keep a phase, and the deadlines are where it wants them.
        margin: time between the expected pose and the deadline [s].
        early: time before the expected pose at which to begin to look for it [s].
    """

    def __init__(self, period: float) -> None:
        self._period = period
        self._spacing = period
        self._errors: deque[float] = deque(maxlen=WINDOW)
        self._first: TipPose | None = None
        self._last_arrival: float | None = None
        self._pose_period = period
        self.locked = False
        self._latest = 0.0
        self.early = self.margin = EARLY_MAX * period

    @property
    def once(self) -> bool:
        """True if at most one pose comes in a cycle."""
        return self._spacing == self._period

    def arrived(self, pose: TipPose, at: float, deadline: float) -> None:
        """Take note of a pose.

        Args:
            pose: that arrived. at: when [s], on the loop's clock. deadline: of the cycle it arrived for [s].
        """
        self._last_arrival = at
        self._measure_rate(pose)
        error = (at - deadline + 0.5 * self._spacing) % self._spacing - 0.5 * self._spacing
        if self._errors:  # beside the last ones, not on the other side of the circle
            error += self._spacing * round((self._errors[-1] - error) / self._spacing)
        self._errors.append(error)

    def correction(self, now: float, *, active: bool) -> float:
        """Return the time by which the next deadline is to be moved [s].

        Args:
            now: [s]. active: tendons may be taut: the rate is kept as near to the nominal one as the lock allows.
        """
        longest = SILENCE * max(self._period, self._pose_period)
        if self._last_arrival is None or now - self._last_arrival > longest:
            self.forget()
            return 0.0
        if len(self._errors) < WINDOW:
            return 0.0
        middle, deviation = _median(self._errors), 0.0
        deviation = _median([abs(one - middle) for one in self._errors])
        if deviation > AGREEMENT * self._spacing:
            self.locked = False
            return 0.0
        early_min = max(EARLY_MIN * self._period, EARLY_SECONDS)
        self.early = max(min(SPREADS * deviation, EARLY_MAX * self._period), early_min)
        self._latest = max(max(self._errors) - middle, LATE_KEPT * self._latest)
        self.margin = max(self.early, min(LATE_FACTOR * self._latest, MARGIN_MAX * self._spacing))
        wanted = middle + self.margin
        wanted -= self._spacing * round(wanted / self._spacing)
        self.locked = abs(wanted) < (0.8 if self.locked else 0.5) * self.margin
        slew = SLEW_LOCKED if self.locked and active else SLEW_ACTIVE if active else SLEW_IDLE
        moved = min(max(GAIN * wanted, -slew * self._period), slew * self._period)
        self._errors = deque((one - moved for one in self._errors), maxlen=WINDOW)
        return moved

    def opens(self, deadline: float) -> float:
        """Time from which the pose of a cycle is looked for [s]; without the lock its `deadline` [s]."""
        return deadline - self.margin - self.early if self.locked else deadline

    def forget(self) -> None:
        """Run free, until poses keep a phase again."""
        self.locked, self._first, self._last_arrival, self._latest = False, None, None, 0.0
        self._errors.clear()

    def _measure_rate(self, pose: TipPose) -> None:
        """Measure the poses' period by stamps and counts since the first one; a publisher that starts anew is one."""
        first = self._first
        if first is None or first.source != pose.source or pose.seq <= first.seq:
            self._first = pose
            self._errors.clear()
            return
        if pose.seq - first.seq < WINDOW or pose.stamp_ns <= first.stamp_ns:
            return
        self._pose_period = (pose.stamp_ns - first.stamp_ns) * 1e-9 / (pose.seq - first.seq)
        ratio = Fraction(self._period / self._pose_period).limit_denominator(DENOMINATOR_MAX)
        near = abs(float(ratio) * self._pose_period / self._period - 1.0) < RATE_TOLERANCE
        spacing = self._period / ratio.numerator if near and 0 < ratio.numerator <= DENOMINATOR_MAX else self._period
        if abs(spacing - self._spacing) > 1e-9 * self._period:
            self._spacing = spacing
            self._errors.clear()


def _median(values: "deque[float] | list[float]") -> float:
    """The middle one, of an even number the upper of both."""
    return sorted(values)[len(values) // 2]
