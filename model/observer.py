"""Holding the model to the measured tip.

The model runs on the tensions that the actuators are estimated to apply, and the innovation is the measured tip minus
the model's tip of the time at which the measurement was taken. So delays and lags that are known do not reach the law.

'force': the innovation is held for the work of a force F on the tip. With the rod's compliance C,

    F(k+1) = F(k) + g Li dt C^+ e,    pull = g C^+ (Kp e + Kd (e - e_last)/dt),    g = h + (1 - h) m'm/(m'm + s^2)

F and the pull act on the model's tip: F finds constant loads (a disturbance observer, cf. Ohnishi 1987; Chen et al.,
IEEE Trans. Ind. Electron. 63, 2016), the pull moves the model after impacts, as virtual springs and dampers on the tip
do in Zheng et al., "Estimating infinite-dimensional continuum robot states from the tip" (2024). The weight g keeps
noise out: while the innovation's short mean m is well below s, most of it is noise, and only the share h of the gains
is left. For F an innovation beyond 50 mm counts as one of 50 mm: an impact is no constant load. Li falls with the
delay, which the loop's margin asks for.

'offset': X1 = model tip + d, d the low-passed innovation; what the model misses stays unknown to it.
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond.model.rod import Rod
from tendond.model.rod_state import RodState

Array = NDArray[np.float64]

UNSEEN = 0.04
"""Motion of the tip per force that counts as none, as a part of C's mean: a straight rod does not give along itself."""

PULL = 4.0
"""Bound of the pull, of force_max."""

THROWN = 0.05
"""[m] Innovations beyond this size count no more for F than one of this size: an impact is no constant load."""

SIDEWAYS = 0.3
"""Variance that a force across gravity is expected to have, of that along it: most loads hang."""


@dataclass(frozen=True)
class ObserverGains:
    """See the equations above.

    Attributes:
        kind: 'force' or 'offset'.
        period: of the cycle [s].
        delay: age of a measurement [s].
        integral: Li without delay [1/s]; halved at a delay of `delay_scale` [s].
        proportional: Kp [-]. derivative: Kd [s].
        quiet: s [m]. quiet_share: h [-]. quiet_time: over which m is taken [s].
        force_max: bound of the size of F [N]; that of the pull is `PULL` times as large.
        offset_gain: of the low-pass of 'offset', per cycle [-].
    """

    kind: str
    period: float
    delay: float
    integral: float
    delay_scale: float
    proportional: float
    derivative: float
    quiet: float
    quiet_share: float
    quiet_time: float
    force_max: float
    offset_gain: float


@dataclass(frozen=True)
class ObserverState:
    """What the observer carries; vectors in the world frame, shape (3,).

    Attributes:
        past: model tips [m], newest last, shape (m, 3).
        innovation: last one [m]. mean: its low-pass m [m].
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
        """On the model's tip in its next step [N], shape (3,)."""
        return self.force + self.pull


def start_observer(gains: ObserverGains, model_tip: Array, force: Array | None = None) -> ObserverState:
    """An observer of a model that has rested at `model_tip` [m], shape (3,), under `force` [N], if any."""
    zero = np.zeros(3)
    rows = int(gains.delay / gains.period) + 2
    return ObserverState(np.tile(model_tip, (rows, 1)), zero, zero, zero, zero if force is None else force, zero)


def observe(
    gains: ObserverGains, state: ObserverState, rod: Rod, model: RodState, model_tip: Array, measured: Array | None
) -> ObserverState:
    """One cycle of the observer.

    Args:
        gains: of the observer.
        state: of the last cycle.
        rod, model: the model and its state now.
        model_tip: its tip [m], shape (3,).
        measured: a new measurement [m], shape (3,), as old as the observer's delay; none to coast.
    """
    past = np.vstack([state.past[1:], model_tip])
    if measured is None:
        return replace(state, past=past, pull=np.zeros(3))
    whole, part = divmod(gains.delay / gains.period, 1.0)
    newer = len(past) - 1 - int(whole)
    expected = (1.0 - part) * past[newer] + part * past[newer - 1]
    innovation = measured - expected
    if gains.kind == "offset":
        offset = state.offset + gains.offset_gain * (innovation - state.offset)
        return replace(state, past=past, innovation=innovation, offset=offset)
    mean = state.mean + min(1.0, gains.period / gains.quiet_time) * (innovation - state.mean)
    size = float((mean * mean).sum())
    weight = gains.quiet_share + (1.0 - gains.quiet_share) * size / (size + gains.quiet**2)
    stiffness = _inverse(tip_compliance(rod, model), np.array(rod.parameters.gravity))
    integral = gains.integral * gains.period / (1.0 + gains.delay / gains.delay_scale)
    rate = (innovation - state.innovation) / gains.period
    thrown = min(1.0, THROWN / max(math.hypot(*innovation.tolist()), THROWN))
    force = state.force + weight * thrown * integral * _times(stiffness, innovation)
    pull = weight * _times(stiffness, gains.proportional * innovation + gains.derivative * rate)
    return replace(
        state,
        past=past,
        innovation=innovation,
        mean=mean,
        force=_bounded(force, gains.force_max),
        pull=_bounded(pull, PULL * gains.force_max),
    )


def _bounded(force: Array, most: float) -> Array:
    """`force` [N], shape (3,), made no larger than `most` [N]."""
    return force / max(1.0, math.hypot(*force.tolist()) / most)


def _inverse(compliance: Array, gravity: Array) -> Array:
    """C^+ = P C (C P C + r 1)^-1 [N/m], shape (3, 3): the likeliest force for a motion of the tip.

    P is the variance that is expected of the force: a motion that several forces would explain is put down to one along
    gravity. What C hardly shows (r) is not looked for.
    """
    size = math.hypot(*gravity.tolist())
    prior = np.eye(3)
    if size > 0.0:
        down = gravity / size
        prior = SIDEWAYS * prior + (1.0 - SIDEWAYS) * (down[:, None] * down)
    unseen = (UNSEEN * 0.5 * float(np.trace(compliance))) ** 2
    shown = _times(prior, compliance)
    return _times(shown, _inverse_3(_times(compliance, shown) + unseen * np.eye(3)))


def _times(a: Array, b: Array) -> Array:
    """Product of small matrices. Not BLAS's, whose last bits depend on the machine's settings: a log must replay."""
    return np.asarray(np.einsum("ij,j...->i...", a, b))


def _inverse_3(m: Array) -> Array:
    """Of a matrix of shape (3, 3), by its adjugate."""
    (a, b, c), (d, e, f), (g, h, i) = m.tolist()
    p, q, r = e * i - f * h, f * g - d * i, d * h - e * g
    adjugate = np.array(
        [[p, c * h - b * i, b * f - c * e], [q, a * i - c * g, c * d - a * f], [r, b * g - a * h, a * e - b * d]]
    )
    return np.asarray(adjugate / (a * p + b * q + c * r))


def tip_compliance(rod: Rod, state: RodState) -> Array:
    """Motion of the tip per force on it [m/N], shape (3, 3), of a slender rod bent as `state` is.

    Unit-load method (Timoshenko, Strength of Materials): C = integral of hat(r)' hat(r) / EI ds with r from s to the
    tip; torsion is counted as stiff as bending, shear, extension and the tendons' pull are left out. For gains only.
    """
    r = rod.node_positions(state)
    r = r[-1] - r
    weights = np.full(len(r), rod.parameters.length / (len(r) - 1))
    weights[0] *= 0.5
    weights[-1] *= 0.5
    weighted = r * weights[:, None]
    moment = float(np.sum(weighted * r)) * np.eye(3) - np.einsum("ki,kj->ij", weighted, r)
    return np.asarray(moment / rod.parameters.bending_stiffness)
