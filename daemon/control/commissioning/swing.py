"""Swings of a signal: whether one dies down."""

import math
from dataclasses import dataclass
from itertools import pairwise

SWINGS = 12
"""Half periods of a swing that count as sustained."""

DYING = 0.6
"""Size of two half periods, relative to the largest before them, below which a swing has died down: damping ratio 0.014
over twelve. One that is pushed then is another swing."""

EVEN = 3.0
"""Longest half period, of their mean: a longer one is a rest between two swings, as a transient and a push
leave it. Two that alternate, however unequal, last at most twice their mean."""

SLOWEST = 0.4
"""Lowest frequency of a swing that is watched for [Hz]."""


@dataclass(frozen=True)
class Swing:
    """Reversals of one signal.

    Attributes:
        up: it rises. extreme: since the last reversal.
        reversals: tick and size of the newest ones, at most `SWINGS`.
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
        return Swing(not self.up, value, (*self.reversals, (tick, self.extreme))[-SWINGS - 1 :])

    def sustained(self, period: float) -> tuple[float, float] | None:
        """Return size and frequency [Hz] of a swing that does not die down; none where there is none."""
        if len(self.reversals) <= SWINGS:
            return None
        sizes = [abs(b[1] - a[1]) for a, b in zip(self.reversals, self.reversals[1:], strict=False)]
        half_periods = [b[0] - a[0] for a, b in zip(self.reversals, self.reversals[1:], strict=False)]
        seconds = sum(half_periods) * period
        frequency = 0.5 * SWINGS / max(seconds, period)
        if frequency < SLOWEST or min(sizes[-2:]) < DYING * max(sizes):
            return None
        if any(max(pair) < DYING * max(sizes[: index + 1]) for index, pair in enumerate(pairwise(sizes))):
            return None
        if max(half_periods) * SWINGS > EVEN * sum(half_periods):
            return None
        return sizes[-1], frequency
