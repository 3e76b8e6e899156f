"""The output observer: the model runs on the commanded tension; what it misses of the tip is a slowly tracked offset.

X1 = model tip + d, where d is the low-passed difference of the measured tip and the model's tip of the time at which
the measurement was taken; X2 and the acceleration are the model's. Delays and actuator lags then reach the law only
through d, slowly, and the law keeps its margin.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ObserverState:
    """offset: measured minus model tip [m], shape (3,); past: model tips [m], newest last, shape (delay + 1, 3)."""

    offset: Array
    past: Array


def start_observer(model_tip: Array, delay: int) -> ObserverState:
    """An observer without offset, as if the model had rested at `model_tip` [m], shape (3,), for `delay` cycles."""
    return ObserverState(np.zeros(3), np.tile(model_tip, (delay + 1, 1)))


def observe(state: ObserverState, model_tip: Array, measured_tip: Array | None, gain: float) -> ObserverState:
    """One cycle of the observer.

    Args:
        state: of the last cycle.
        model_tip: of the model now [m], shape (3,).
        measured_tip: a new measurement [m], shape (3,), as old as the observer's delay; none to coast.
        gain: of the low-pass, per cycle, in (0, 1].
    """
    past = np.vstack([state.past[1:], model_tip])
    if measured_tip is None:
        return ObserverState(state.offset, past)
    return ObserverState(state.offset + gain * (measured_tip - past[0] - state.offset), past)
