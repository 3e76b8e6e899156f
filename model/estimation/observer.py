"""Correct the model by the measured tip.

The model runs on the tensions that the actuators are estimated to apply, and the innovation is the measured tip minus
the model's tip of the time at which the measurement was taken. So configured delays and lags do not reach the law.

'force': the innovation is attributed to a force F on the tip. With the rod's compliance C,

    F(k+1) = F(k) + g Li dt C^+ e,    pull = g C^+ (Kp e + Kd (e - m)/T),    g = h + (1 - h) m'm/(m'm + s^2)

with m the innovation's low-pass of time constant T, so that (e - m)/T is its filtered rate. F and the pull act on the
model's tip: F finds constant loads (a disturbance observer, cf. Ohnishi 1987; Chen et al., IEEE Trans. Ind. Electron.
63, 2016), the pull moves the model after impacts, as virtual springs and dampers on the tip do in Zheng et al.,
"Estimating infinite-dimensional continuum robot states from the tip" (2024). The weight g suppresses noise: while m is
well below the noise floor s, most of it is noise, and only the share h of the gains is left. F takes no larger
innovation than a limit: an impact is not a constant load. The gains keep the margin of `estimation.margin` for masses
that the model does not know.

'offset': X1 = model tip + d, d the low-passed innovation; the model itself is not corrected.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.compliance import Arm, bent_arm, compliance, likeliest_force
from tendond.model.estimation.observer_gains import CycleGains, ObserverGains
from tendond.model.numerics.compile import Bound, inlined, kernel
from tendond.model.numerics.vectors import Vector, add, dot, rotate, scale, sub
from tendond.model.rods.interface import ModelRod, ModelState
from tendond.model.solver.lanes import vector

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ObserverState:
    """State of the observer; vectors in the world frame, shape (3,).

    Attributes:
        past: model tips [m], newest last, shape (m, 3).
        innovation: last one, e [m]. mean: its low-pass m [m].
        offset: d [m].
        force: F, estimated force on the tip beside the rod's weight [N].
        pull: force on the model's tip that moves it to the measured one [N]; not a load of the real rod.
    """

    past: Array
    innovation: Array
    mean: Array
    offset: Array
    force: Array
    pull: Array

    @property
    def tip_force(self) -> Array:
        """Force on the model's tip in its next step [N], shape (3,)."""
        return self.force + self.pull


def start_observer(gains: ObserverGains, model_tip: Array, force: Array | None = None) -> ObserverState:
    """Start the observer of a model that has rested at `model_tip` [m], shape (3,), under `force` [N], if any."""
    zero = np.zeros(3)
    rows = int((gains.delay if gains.delay_max is None else gains.delay_max) / gains.period) + 2
    at_rest = zero if force is None else np.array(force, dtype=np.float64)
    return ObserverState(np.tile(model_tip, (rows, 1)), zero, zero, zero, at_rest, zero)


class _Last(NamedTuple):
    """Estimates of the last cycle, each of shape (3,)."""

    mean: Any
    offset: Any
    force: Any


def observe(
    gains: ObserverGains,
    state: ObserverState,
    rod: ModelRod,
    model: ModelState,
    model_tip: Array,
    measured: Array | None,
    delay: float | None = None,
) -> ObserverState:
    """Compute one cycle of the observer.

    Args:
        gains: gains of the observer.
        state: state of the last cycle.
        rod, model: the model and its state now.
        model_tip: its tip [m], shape (3,).
        measured: a new measurement [m], shape (3,); none to coast.
        delay: its age [s], limited to what is remembered; default: the observer's delay.
    """
    past = np.empty_like(state.past)
    past[:-1] = state.past[1:]
    past[-1] = model_tip
    if measured is None:
        return ObserverState(past, state.innovation, state.mean, state.offset, state.force, np.zeros(3))
    oldest = (len(past) - 2) * gains.period
    age = gains.delay if delay is None else min(max(delay, 0.0), oldest)
    whole, part = divmod(age / gains.period, 1.0)
    arm = bent_arm(rod, model)
    last = _Last(state.mean, state.offset, state.force)
    new = np.empty((5, 3))
    measured = np.ascontiguousarray(measured, dtype=np.float64)  # as the kernel is bound to it
    _bound_correct.call(gains.per_cycle, arm, last, past, len(past) - 1 - int(whole), part, measured, new)
    return ObserverState(past, *new)


@kernel
def _correct(
    gains: CycleGains, arm: Arm, last: _Last, past: Any, newer: int, part: float, measured: Any, new: Any
) -> None:
    """Write innovation, mean, offset, force and pull to `new`, shape (5, 3), by the equations above.

    The measurement is as old as `past[newer]` and, for the share `part`, the tip before it.
    """
    x = vector(measured, 0)
    expected = add(scale(1.0 - part, vector(past[newer], 0)), scale(part, vector(past[newer - 1], 0)))
    e, d = sub(x, expected), vector(last.offset, 0)
    m, force, pull = vector(last.mean, 0), vector(last.force, 0), (0.0, 0.0, 0.0)
    if gains.with_force:
        m = add(m, scale(gains.blend, sub(e, m)))
        size = dot(m, m)
        weight = gains.noise_share + (1.0 - gains.noise_share) * size / (size + gains.noise_floor * gains.noise_floor)
        spring = likeliest_force(compliance(arm), arm.gravity, gains.lateral_variance, gains.unobservable)
        limit = gains.innovation_limit * arm.length / max(math.sqrt(dot(e, e)), gains.innovation_limit * arm.length)
        force = _bounded(add(force, scale(weight * limit * gains.integral, rotate(spring, e))), gains.force_max)
        wanted = add(scale(gains.proportional, e), scale(gains.derivative, sub(e, m)))
        pull = _bounded(scale(weight, rotate(spring, wanted)), gains.pull_max)
    else:
        d = add(d, scale(gains.offset, sub(e, d)))
    for j in range(3):
        new[0, j], new[1, j], new[2, j], new[3, j], new[4, j] = e[j], m[j], d[j], force[j], pull[j]


_bound_correct = Bound(_correct)


@inlined
def _bounded(force: Vector, force_max: float) -> Any:
    """Scale `force` [N] to a size of at most `force_max` [N]."""
    return scale(1.0 / max(1.0, math.sqrt(dot(force, force)) / force_max), force)
