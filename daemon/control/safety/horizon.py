"""The motion that follows if a command is held: the model's step, linearised once and continued until it rests.

With x the strains and their rates, x(1) = f(x(0), T) the coming step under the tensions applied now, A and B its
derivatives, and y(i) = x(i) - x(0),

    y(i+1) = A y(i) + B (T(i) - T) + x(1) - x(0),    T(i) - T = (1 - l^(i+1)) u

for a command that differs by u from now on and is held, with actuators of lag factor l. The first step is the model's
own; later ones have the first one's derivatives. Powers of the augmented matrix by squaring reach any time in a few
products, so that the whole settling is sampled: `SAMPLES` times through the slowest swing, then twice as late each.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.body.ahead import look_ahead
from tendond.model.numerics.compile import Bound
from tendond.model.strain.derivatives.results import StepSensitivity

Array = NDArray[np.float64]

SAMPLES = 12
"""Samples of the first period of the slowest mode: a peak between two of them is missed by 1 - cos(pi/12) = 3 % of the
amplitude, which the declared error of the stiffness covers."""

LATER = 4
"""Samples after it, each twice as late as the one before: 9 to 16 periods, in which a mode damped by 5 % is at rest."""


class Horizon:
    """Times at which the motion is looked at.

    Args:
        period: of the slowest mode [s]. time_step: [s]. lag_factor: of the actuators [-].

    Attributes:
        doublings: the samples of the first period are 2^doublings steps apart. spacing: that time [s].
        count: number of samples, k. lag_factor: of the actuators from one of the first samples to the next [-].
    """

    def __init__(self, period: float, time_step: float, lag_factor: float) -> None:
        self.doublings = max(0, int(np.floor(np.log2(max(period / (SAMPLES * time_step), 1.0)))))
        self.spacing = 2.0**self.doublings * time_step
        self._lag, self._look = float(lag_factor), Bound(look_ahead)
        self.count = int(np.ceil(period / self.spacing)) + LATER
        self.lag_factor = lag_factor**2**self.doublings if lag_factor else 0.0

    def motion(self, before: Array, step: StepSensitivity, points: Array, bends: Array) -> tuple[Array, Array, bool]:
        """Return moves of points, shape (k, P, 1 + m), changes of bends, (k, b, 1 + m), and whether both are finite.

        The first column is the motion without a change of the command, the others are derivatives by the command [1/N].

        Args:
            before: strains and rates before a step, shape (2 n,). step: from there, with its derivatives.
            points, bends: their derivatives by the strains, shapes (P, n) and (b, n).
        """
        columns = 1 + step.b.shape[1]
        moves, turns = np.empty((self.count, len(points), columns)), np.empty((self.count, len(bends), columns))
        coming = np.concatenate((step.state.strain, step.state.rate)) - before
        each, later = self.count - LATER, LATER
        finite = self._look.call(
            step.a, step.b, coming, self._lag, self.doublings, each, later, points, bends, moves, turns
        )  # fmt: skip
        return moves, turns, finite
