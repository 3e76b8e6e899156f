"""Motion of the tip during a recording, as a rod computes it."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.errors import DaemonError

Array = NDArray[np.float64]

RELEASED = -1.0
"""Displacement of a tendon whose servo has no torque [m]: slack in every shape."""


class SimulationError(DaemonError):
    """Error of parameters with which the rod has no solution."""


@dataclass(frozen=True)
class TipMotion:
    """Motion of the rod during a recording.

    Attributes:
        step: time step [s]; 0 for rests. first: time of the first tip since the recording began [s].
        tips: positions every `step` [m], shape (steps + 1, 3); of rests one each.
        tensions: tendon tensions after each step [N], shape (steps, n).
    """

    step: float
    first: float
    tips: Array
    tensions: Array

    def at(self, times: Array) -> Array:
        """Interpolate the tip by cubics, at times since the recording began [s]; shape (k, 3)."""
        at = np.clip((times - self.first) / self.step, 0.0, len(self.tips) - 1.001)
        whole = at.astype(np.intp)
        t = (at - whole)[:, None]
        tips = self.tips
        before, after = tips[np.maximum(whole - 1, 0)], tips[np.minimum(whole + 2, len(tips) - 1)]
        one, two = tips[whole], tips[whole + 1]
        return np.asarray(
            0.5 * (2.0 * one + t * (two - before)
            + t**2 * (2.0 * before - 5.0 * one + 4.0 * two - after)
            + t**3 * (3.0 * (one - two) + after - before))
        )  # fmt: skip


def shown(values: object) -> str:
    """Format values by name, for messages."""
    assert isinstance(values, dict)
    return ", ".join(f"{name} {value:.4g}" for name, value in values.items() if value not in (0.0, 1.0))
