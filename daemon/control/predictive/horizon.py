"""The horizon of a predictive law: its time steps, and the knots between which the tensions are linear.

The first steps are as long as a cycle, so that what is applied next is predicted as the model will do it; later ones
are twice as long, four times, and so on. The general rod's scheme conserves energy and is stable at any step.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]


FINER = 0.05
"""Fineness with which the growth of the steps is sought, in doublings over the horizon. Chosen."""


@dataclass(frozen=True)
class Horizon:
    """Time steps and knots.

    Attributes:
        period: of the cycle [s].
        cycles: length of each step, in cycles: powers of two that do not fall, the first one 1; shape (N,).
        knots: number of moves B, at most as many as steps.
    """

    period: float
    cycles: tuple[int, ...]
    knots: int

    @staticmethod
    def of(length: float, steps: int, knots: int, period: float) -> "Horizon":
        """Return a horizon that is at least as long as asked for.

        Args:
            length: [s]. steps, knots: largest numbers of them. period: of the cycle [s].
        """
        wanted = max(1, round(length / period))
        count, growth = min(steps, wanted), 0.0
        while True:
            cycles = tuple(2 ** int(growth * i / count) for i in range(count))
            if sum(cycles) >= wanted:
                return Horizon(period, cycles, min(knots, count))
            growth += FINER

    @property
    def steps(self) -> int:
        """Number of steps N."""
        return len(self.cycles)

    @cached_property
    def lengths(self) -> Array:
        """Lengths of the steps [s], shape (N,)."""
        return self.period * np.array(self.cycles, dtype=np.float64)

    @cached_property
    def ends(self) -> Array:
        """Times at which the steps end, from now [s], shape (N,)."""
        return np.cumsum(self.lengths)

    @cached_property
    def middles(self) -> Array:
        """Times of the steps' middles [s], shape (N,)."""
        return self.ends - 0.5 * self.lengths

    @cached_property
    def times(self) -> Array:
        """Times of the plan's knots, middles of steps, the first and the last one among them [s], shape (B,)."""
        return self.middles[np.unique(np.round(np.linspace(0, self.steps - 1, self.knots)).astype(np.intp))]

    @cached_property
    def shares(self) -> Array:
        """Shares of the knots in the tensions of each step, which are linear between them [-], shape (N, B)."""
        return np.stack([np.interp(self.middles, self.times, one) for one in np.eye(self.knots)], axis=1)

    @cached_property
    def room(self) -> Array:
        """Times in which a tension may change from the knot before to each [s], shape (B,); to the first: a cycle."""
        return np.concatenate(([self.period], np.diff(self.times)))

    def shifted(self, plan: Array) -> Array:
        """Return a plan as it looks a cycle later, shape (B, m); its last tensions stay.

        Args:
            plan: tensions at the knots [N], shape (B, m).
        """
        return np.stack([np.interp(self.times + self.period, self.times, one) for one in plan.T], axis=1)
