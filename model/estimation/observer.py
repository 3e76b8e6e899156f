"""Holding the model to the measured tip.

The model runs on the tensions that the actuators are estimated to apply, and the innovation is the measured tip minus
the model's tip of the time at which the measurement was taken. So delays and lags that are known do not reach the law.

'force': the innovation is held for the work of a force F on the tip. With the rod's compliance C,

    F(k+1) = F(k) + g Li dt C^+ e,    pull = g C^+ (Kp e + Kd (e - m)/T),    g = h + (1 - h) m'm/(m'm + s^2)

with m the innovation's low-pass of time constant T, so that (e - m)/T is its filtered rate. F and the pull act on the
model's tip: F finds constant loads (a disturbance observer, cf. Ohnishi 1987; Chen et al., IEEE Trans. Ind. Electron.
63, 2016), the pull moves the model after impacts, as virtual springs and dampers on the tip do in Zheng et al.,
"Estimating infinite-dimensional continuum robot states from the tip" (2024). The weight g keeps noise out: while m is
well below s, most of it is noise, and only the share h of the gains is left. For F an innovation beyond a tenth of the
length counts as one of that: an impact is no constant load. The gains keep the margin of `model.margin` for masses that
the model does not know.

'offset': X1 = model tip + d, d the low-passed innovation; what the model misses stays unknown to it.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.vectors import (
    Matrix,
    Vector,
    add,
    dot,
    inverse,
    outer,
    plus_diagonal,
    product,
    rotate,
    scale,
    sub,
)
from tendond.model.rod.rod import Rod
from tendond.model.rod.state import RodState
from tendond.model.solver.lanes import vector

Array = NDArray[np.float64]

UNSEEN = 0.04
"""Motion of the tip per force that counts as none, as a part of C's mean: a straight rod does not give along itself."""

PULL = 4.0
"""Bound of the pull, of force_max."""

THROWN = 0.1
"""Of the length: innovations beyond this size count no more for F than one of it: an impact is no constant load."""

SIDEWAYS = 0.3
"""Variance that a force across gravity is expected to have, of that along it: most loads hang."""


@dataclass(frozen=True)
class ObserverGains:
    """See the equations above.

    Attributes:
        kind: 'force' or 'offset'.
        period: of the cycle [s].
        delay: age of a measurement [s].
        integral: Li [1/s]. proportional: Kp [-]. derivative: Kd [s].
        quiet: s [m]. quiet_share: h [-]. quiet_time: T, over which m is taken [s].
        force_max: bound of the size of F [N]; that of the pull is `PULL` times as large.
        offset_gain: of the low-pass of 'offset', per cycle [-].
    """

    kind: str
    period: float
    delay: float
    integral: float
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
    past = np.empty_like(state.past)
    past[:-1] = state.past[1:]
    past[-1] = model_tip
    if measured is None:
        return ObserverState(past, state.innovation, state.mean, state.offset, state.force, np.zeros(3))
    whole, part = divmod(gains.delay / gains.period, 1.0)
    new = np.empty((5, 3))
    _correct(
        gains.kind == "force", past, len(past) - 1 - int(whole), part, measured, state.mean, state.offset, state.force,
        gains.offset_gain, min(1.0, gains.period / gains.quiet_time), gains.quiet, gains.quiet_share,
        gains.integral * gains.period, gains.proportional, gains.derivative / gains.quiet_time, gains.force_max,
        rod.node_positions(model), rod.parameters.length, rod.parameters.bending_stiffness,
        np.array(rod.parameters.gravity), new,
    )  # fmt: skip
    return ObserverState(past, *new)


@kernel
def _correct(
    with_force: bool, past: Any, newer: int, part: float, measured: Any, last_mean: Any, offset: Any, last_force: Any,
    offset_gain: float, blend: float, quiet: float, quiet_share: float, integral: float, proportional: float,
    derivative: float, force_max: float, places: Any, length: float, stiffness: float, gravity: Any, new: Any,
) -> None:  # fmt: skip
    """Innovation, mean, offset, force and pull, written to `new`, shape (5, 3); the equations stand above.

    The measurement is as old as `past[newer]` and, for the share `part`, the tip before it. `integral` is Li dt,
    `derivative` is Kd / T.
    """
    x = vector(measured, 0)
    expected = add(scale(1.0 - part, vector(past[newer], 0)), scale(part, vector(past[newer - 1], 0)))
    e, d = sub(x, expected), vector(offset, 0)
    m, force, pull = vector(last_mean, 0), vector(last_force, 0), (0.0, 0.0, 0.0)
    if with_force:
        m = add(m, scale(blend, sub(e, m)))
        size = dot(m, m)
        weight = quiet_share + (1.0 - quiet_share) * size / (size + quiet * quiet)
        spring = _likeliest_force(_compliance(places, length, stiffness), vector(gravity, 0))
        thrown = THROWN * length / max(math.sqrt(dot(e, e)), THROWN * length)
        force = _bounded(add(force, scale(weight * thrown * integral, rotate(spring, e))), force_max)
        wanted = add(scale(proportional, e), scale(derivative, sub(e, m)))
        pull = _bounded(scale(weight, rotate(spring, wanted)), PULL * force_max)
    else:
        d = add(d, scale(offset_gain, sub(e, d)))
    for j in range(3):
        new[0, j], new[1, j], new[2, j], new[3, j], new[4, j] = e[j], m[j], d[j], force[j], pull[j]


@inlined
def _bounded(force: Vector, most: float) -> Any:
    """`force` [N] made no larger than `most` [N]."""
    return scale(1.0 / max(1.0, math.sqrt(dot(force, force)) / most), force)


@inlined
def _likeliest_force(compliance: Matrix, gravity: Vector) -> Any:
    """C^+ = P C (C P C + r 1)^-1 [N/m]: the likeliest force for a motion of the tip.

    P is the variance that is expected of the force: a motion that several forces would explain is put down to one along
    gravity. What C hardly shows (r) is not looked for.
    """
    size = math.sqrt(dot(gravity, gravity))
    down = scale(1.0 / size if size > 0.0 else 0.0, gravity)
    across, along = (SIDEWAYS, 1.0 - SIDEWAYS) if size > 0.0 else (1.0, 0.0)
    prior = plus_diagonal(outer(scale(along, down), down), across)
    unseen = (UNSEEN * 0.5 * (compliance[0] + compliance[4] + compliance[8])) ** 2
    shown = product(prior, compliance)
    return product(shown, inverse(plus_diagonal(product(compliance, shown), unseen)))


@inlined
def _compliance(places: Any, length: float, stiffness: float) -> Matrix:
    """See `tip_compliance`; `places` are the nodes' positions [m], shape (nodes, 3)."""
    nodes = places.shape[0]
    tip = vector(places[nodes - 1], 0)
    xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(nodes - 1):  # the tip's own arm is zero
        r = sub(tip, vector(places[k], 0))
        share = 0.5 if k == 0 else 1.0
        xx, yy, zz = xx + share * r[0] * r[0], yy + share * r[1] * r[1], zz + share * r[2] * r[2]
        xy, xz, yz = xy + share * r[0] * r[1], xz + share * r[0] * r[2], yz + share * r[1] * r[2]
    f = length / (nodes - 1) / stiffness
    return f * (yy + zz), -f * xy, -f * xz, -f * xy, f * (xx + zz), -f * yz, -f * xz, -f * yz, f * (xx + yy)


@kernel
def _fill_compliance(places: Any, length: float, stiffness: float, out: Any) -> None:
    filled = _compliance(places, length, stiffness)
    for j in range(9):
        out[j] = filled[j]


def tip_compliance(rod: Rod, state: RodState) -> Array:
    """Motion of the tip per force on it [m/N], shape (3, 3), of a slender rod bent as `state` is.

    Unit-load method (Timoshenko, Strength of Materials): C = integral of hat(r)' hat(r) / EI ds with r from s to the
    tip; torsion is counted as stiff as bending, shear, extension and the tendons' pull are left out. For gains only.
    """
    out = np.empty(9)
    _fill_compliance(rod.node_positions(state), rod.parameters.length, rod.parameters.bending_stiffness, out)
    return out.reshape(3, 3)
