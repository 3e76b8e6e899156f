"""The motion that follows if a command is held: the model's step, linearised once and continued until it rests.

With x the strains and their rates, x(1) = f(x(0), T) the coming step under the tensions applied now, A and B its
derivatives, and y(i) = x(i) - x(0),

    y(i+1) = A y(i) + B (T(i) - T) + x(1) - x(0),    T(i) - T = (1 - l^(i+1)) u

for a command that differs by u from now on and is held, with actuators of lag factor l. The first step is the model's
own; later ones have the first one's derivatives. Powers of the augmented matrix by squaring reach any time in a few
products, so that the whole settling is sampled: `SAMPLES` times through the slowest swing, then twice as late each.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.derivatives.results import StepSensitivity

Array = NDArray[np.float64]

SAMPLES = 12
"""Samples of the first period of the slowest mode: a peak between two of them is missed by 1 - cos(pi/12) = 3 % of the
amplitude, which the declared error of the stiffness covers."""

LATER = 4
"""Samples after it, each twice as late as the one before: 9 to 16 periods, in which a mode damped by 5 % is at rest."""


@dataclass(frozen=True)
class Motion:
    """Changes of the strains, from those now, at the samples: without a change of the command, and by one.

    Attributes:
        free: shape (k, n). by_command: [1/N], shape (k, n, m).
    """

    free: Array
    by_command: Array


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
        self._each = int(np.ceil(period / self.spacing))
        self._lag = lag_factor
        self.count = self._each + LATER
        self.lag_factor = lag_factor**2**self.doublings if lag_factor else 0.0

    def motion(self, before: Array, step: StepSensitivity) -> Motion:
        """Return the motion from strains and rates before a step, shape (2 n,), and that step."""
        a, b = step.a, step.b
        size, m = len(a), b.shape[1]
        coming = np.concatenate((step.state.strain, step.state.rate)) - before
        whole = size + (m if self._lag else 0)
        power, offset = np.zeros((whole, whole)), np.zeros((whole, 1 + m))
        power[:size, :size] = a
        offset[:size, 0], offset[:size, 1:] = coming, b
        start = np.zeros((whole, 1 + m))
        if self._lag:
            power[:size, size:] = -b
            np.fill_diagonal(power[size:, size:], self._lag)
            start[size:, 1:] = self._lag * np.eye(m)
        for _ in range(self.doublings):
            offset = power @ offset + offset
            power = power @ power
        n, now = size // 2, start
        found = np.empty((self.count, n, 1 + m))
        for k in range(self._each):
            now = power @ now + offset
            found[k] = now[:n]
        for _ in range(max(0, int(np.log2(self._each)))):
            offset = power @ offset + offset
            power = power @ power
        for k in range(self._each, self.count):
            now = power @ now + offset
            found[k] = now[:n]
            if k + 1 < self.count:
                offset = power @ offset + offset
                power = power @ power
        return Motion(found[:, :, 0], found[:, :, 1:])
