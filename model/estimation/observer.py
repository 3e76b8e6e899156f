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
innovation than `INNOVATION_LIMIT`: an impact is not a constant load. The gains keep the margin of `estimation.margin`
for masses that the model does not know.

'offset': X1 = model tip + d, d the low-passed innovation; the model itself is not corrected.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import Bound, inlined, kernel
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
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.model.rod.state import RodState
from tendond.model.solver.lanes import vector

Array = NDArray[np.float64]

NOISE_FLOOR = 1.8e-3
"""s, of the rod's length: ten standard deviations of a camera's 0.1 mm on half a metre."""

NOISE_SHARE = 0.5
"""h: noise of 0.3 mm then moves the model's tip by less than 0.1 mm (tests/unit/model/test_observer.py)."""

INNOVATION_TIME = 0.07
"""T [s]: a quarter of the first natural period of the paper's robot; the margin of the gains holds for this T."""

INNOVATION_LIMIT = 0.1
"""Largest innovation that F takes, of the rod's length; the bound is on its size, not on each component."""

FORCE_MAX = 3.0
"""Bound of F beside the weights, in EI/L^2: a stiffness wrong by 15 % in an arm bent by a right angle looks like 0.9 of
it; the rest is for impacts."""

PULL_MAX = 4.0
"""Bound of the pull, of that of F."""

UNOBSERVABLE = 0.04
"""Motion of the tip per force that counts as none, of the mean of C: a straight rod does not yield along itself."""

LATERAL_VARIANCE = 0.3
"""Expected variance of a force across gravity, of that along it: most loads hang."""


class _Gains(NamedTuple):
    """Gains per cycle: those of `ObserverGains`, but for the integral Li dt and the derivative Kd / T."""

    with_force: bool
    offset: float
    blend: float  # of the low-pass m: dt / T
    noise_floor: float
    noise_share: float
    integral: float
    proportional: float
    derivative: float
    force_max: float


@dataclass(frozen=True)
class ObserverGains:
    """Gains of the equations above.

    Attributes:
        kind: 'force' or 'offset'.
        period: of the cycle [s].
        delay: age of a measurement [s].
        integral: Li [1/s].
        proportional: Kp [-].
        derivative: Kd [s].
        noise_floor: s [m].
        noise_share: h [-].
        innovation_time: T [s].
        force_max: bound of the size of F [N]; that of the pull is `PULL_MAX` times as large.
        offset_gain: of the low-pass of 'offset', per cycle [-].
    """

    kind: str
    period: float
    delay: float
    integral: float
    proportional: float
    derivative: float
    noise_floor: float
    noise_share: float
    innovation_time: float
    force_max: float
    offset_gain: float

    @cached_property
    def per_cycle(self) -> _Gains:
        """The gains as the kernel takes them."""
        return _Gains(
            with_force=self.kind == "force",
            offset=self.offset_gain,
            blend=min(1.0, self.period / self.innovation_time),
            noise_floor=self.noise_floor,
            noise_share=self.noise_share,
            integral=self.integral * self.period,
            proportional=self.proportional,
            derivative=self.derivative / self.innovation_time,
            force_max=self.force_max,
        )


def default_force_max(rod: RodParameters, mass: float) -> float:
    """Bound of F [N] from the rod's stiffness and weight, and an unknown `mass` [kg] on its tip."""
    gravity = max(1e-9, sum(component**2 for component in rod.gravity)) ** 0.5
    weight = gravity * (rod.mass_per_length * rod.length + rod.tip_mass + mass)
    return float(FORCE_MAX * rod.bending_stiffness / rod.length**2 + weight)


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
    rows = int(gains.delay / gains.period) + 2
    at_rest = zero if force is None else np.array(force, dtype=np.float64)
    return ObserverState(np.tile(model_tip, (rows, 1)), zero, zero, zero, at_rest, zero)


class _Arm(NamedTuple):
    """The bent rod's nodes, stiffness and gravity, from which the compliance follows."""

    positions: Any  # of the nodes [m], shape (nodes, 3)
    length: float  # [m]
    stiffness: float  # EI [N m^2]
    gravity: Vector  # [m/s^2]


def _arm(rod: Rod, state: RodState) -> _Arm:
    """The rod, bent as `state` is."""
    (x, y, z), own = rod.parameters.gravity, rod.parameters
    return _Arm(rod.node_positions(state), own.length, own.bending_stiffness, (float(x), float(y), float(z)))


class _Last(NamedTuple):
    """Estimates of the last cycle, each of shape (3,)."""

    mean: Any
    offset: Any
    force: Any


def observe(
    gains: ObserverGains, state: ObserverState, rod: Rod, model: RodState, model_tip: Array, measured: Array | None
) -> ObserverState:
    """Compute one cycle of the observer.

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
    arm = _arm(rod, model)
    last = _Last(state.mean, state.offset, state.force)
    new = np.empty((5, 3))
    measured = np.ascontiguousarray(measured, dtype=np.float64)  # as the kernel is bound to it
    _bound_correct.call(gains.per_cycle, arm, last, past, len(past) - 1 - int(whole), part, measured, new)
    return ObserverState(past, *new)


@kernel
def _correct(
    gains: _Gains, arm: _Arm, last: _Last, past: Any, newer: int, part: float, measured: Any, new: Any
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
        spring = _likeliest_force(_compliance(arm), arm.gravity)
        limit = INNOVATION_LIMIT * arm.length / max(math.sqrt(dot(e, e)), INNOVATION_LIMIT * arm.length)
        force = _bounded(add(force, scale(weight * limit * gains.integral, rotate(spring, e))), gains.force_max)
        wanted = add(scale(gains.proportional, e), scale(gains.derivative, sub(e, m)))
        pull = _bounded(scale(weight, rotate(spring, wanted)), PULL_MAX * gains.force_max)
    else:
        d = add(d, scale(gains.offset, sub(e, d)))
    for j in range(3):
        new[0, j], new[1, j], new[2, j], new[3, j], new[4, j] = e[j], m[j], d[j], force[j], pull[j]


_bound_correct = Bound(_correct)


@inlined
def _bounded(force: Vector, force_max: float) -> Any:
    """Scale `force` [N] to a size of at most `force_max` [N]."""
    return scale(1.0 / max(1.0, math.sqrt(dot(force, force)) / force_max), force)


@inlined
def _likeliest_force(compliance: Matrix, gravity: Vector) -> Any:
    """C^+ = P C (C P C + r 1)^-1 [N/m]: the likeliest force for a motion of the tip.

    P is the expected variance of the force: a motion that several forces would explain is attributed to one along
    gravity. Directions in which the tip hardly yields (r) are left out.
    """
    size = math.sqrt(dot(gravity, gravity))
    down = scale(1.0 / size if size > 0.0 else 0.0, gravity)
    across, along = (LATERAL_VARIANCE, 1.0 - LATERAL_VARIANCE) if size > 0.0 else (1.0, 0.0)
    prior = plus_diagonal(outer(scale(along, down), down), across)
    floor = (UNOBSERVABLE * 0.5 * (compliance[0] + compliance[4] + compliance[8])) ** 2
    prior_compliance = product(prior, compliance)
    return product(prior_compliance, inverse(plus_diagonal(product(compliance, prior_compliance), floor)))


@inlined
def _compliance(arm: _Arm) -> Matrix:
    """Compliance of the tip [m/N]; see `tip_compliance`."""
    places = arm.positions
    nodes = places.shape[0]
    tip = vector(places[nodes - 1], 0)
    xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(nodes - 1):  # the tip's own arm is zero
        r = sub(tip, vector(places[k], 0))
        share = 0.5 if k == 0 else 1.0
        xx, yy, zz = xx + share * r[0] * r[0], yy + share * r[1] * r[1], zz + share * r[2] * r[2]
        xy, xz, yz = xy + share * r[0] * r[1], xz + share * r[0] * r[2], yz + share * r[1] * r[2]
    f = arm.length / (nodes - 1) / arm.stiffness
    return f * (yy + zz), -f * xy, -f * xz, -f * xy, f * (xx + zz), -f * yz, -f * xz, -f * yz, f * (xx + yy)


@kernel
def _fill_compliance(arm: _Arm, out: Any) -> None:
    """Write the compliance to `out`, shape (9,)."""
    filled = _compliance(arm)
    for j in range(9):
        out[j] = filled[j]


def tip_compliance(rod: Rod, state: RodState) -> Array:
    """Compliance of the tip [m/N], shape (3, 3), of a slender rod bent as `state` is.

    Unit-load method (Timoshenko, Strength of Materials): C = integral of hat(r)' hat(r) / EI ds with r from s to the
    tip; torsion is counted as stiff as bending, shear, extension and the tendons' pull are left out. For gains only.
    """
    out = np.empty(9)
    _fill_compliance(_arm(rod, state), out)
    return out.reshape(3, 3)
