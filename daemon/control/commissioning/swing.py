"""Swings of a signal: whether one dies down."""

import math
from dataclasses import dataclass
from itertools import pairwise

SWINGS = 12
"""Half periods of a swing that count as sustained. Chosen; `tendond study robustness` has no false alarm with it."""

SECONDS = 1.0
"""Shortest time that they span [s]: a command that rings at 16 Hz after a push, as a law fed with differences does,
dies down within it (`tendond study robustness --feedback direct`, its false alarms)."""

MEMORY = 64
"""Reversals that are kept: those of a second up to 32 Hz."""

DYING = 0.6
"""Size of two half periods, relative to the largest before them, below which a swing has died down: damping ratio 0.014
over twelve. One that is pushed then is another swing."""

EVEN = 3.0
"""Longest half period, of their mean: a longer one is a rest between two swings, as a transient and a push
leave it. Two that alternate, however unequal, last at most twice their mean."""

SLOWEST = 0.4
"""Lowest frequency of a swing that is watched for [Hz]: its twelve half periods take 15 s. Chosen; `tendond study
robustness` has no false alarm with it."""


@dataclass(frozen=True)
class Swing:
    """Reversals of one signal.

    Attributes:
        up: it rises. extreme: since the last reversal.
        reversals: tick and value of the newest ones, at most `MEMORY`.
    """

    up: bool = True
    extreme: float = -math.inf
    reversals: tuple[tuple[int, float], ...] = ()

    def add(self, value: float, tick: int, hysteresis: float) -> "Swing":
        """Return the swing with one more value; one that turns by less than `hysteresis` has not turned."""
        sign = 1.0 if self.up else -1.0
        if sign * value >= sign * self.extreme:
            return Swing(self.up, value, self.reversals)
        size = sign * (self.extreme - value)
        if size < hysteresis:
            return self
        return Swing(not self.up, value, (*self.reversals, (tick, self.extreme))[-MEMORY:])

    def sustained(self, period: float) -> tuple[float, float] | None:
        """Return size and frequency [Hz] of a swing that does not die down; none where there is none."""
        newest, first = self.reversals, len(self.reversals) - SWINGS - 1
        if first < 0:
            return None
        while first > 0 and (newest[-1][0] - newest[first][0]) * period < SECONDS:
            first -= 1
        seconds = (newest[-1][0] - newest[first][0]) * period
        if seconds < SECONDS and len(newest) < MEMORY:
            return None
        sizes = [abs(b[1] - a[1]) for a, b in pairwise(newest[first:])]
        half_periods = [b[0] - a[0] for a, b in pairwise(newest[first:])]
        frequency = 0.5 * len(sizes) / max(seconds, period)
        if frequency < SLOWEST or min(sizes[-2:]) < DYING * max(sizes):
            return None
        if any(max(pair) < DYING * max(sizes[: index + 1]) for index, pair in enumerate(pairwise(sizes))):
            return None
        if max(half_periods) * len(sizes) > EVEN * sum(half_periods):
            return None
        return sizes[-1], frequency
