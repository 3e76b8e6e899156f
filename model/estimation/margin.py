"""Stability of the sampled loop, and the observer's gains that keep a margin for what hangs on the tip unknown.

A planar cantilever of Hermite beam elements (Bathe, Finite Element Procedures, 1996, section 5.4) stands for the rod at
two places. The plant, with an unknown mass on its tip, is exact between samples; the model takes the controller's own
BDF-alpha steps. Both have Kelvin-Voigt damping Bbt, and are driven by the tendons' moment at the tip. Law, observer and
delay close the loop; all is linear, so that one cycle is a matrix, and the loop is stable where the matrix's spectral
radius is below one (Astrom & Wittenmark, Computer-Controlled Systems, 1997, chapter 3).

Why a mass matters: the law makes the tendons cancel the observer's force on the model at once, so that the plant feels
it with the opposite sign. With one mode, mass M, damping c and stiffness k, and gains in units of k, the error obeys

    M e'''+ (c + k Kd) e'' + k (1 + Kp) e' + k Li e = 0,    stable where (c/k + Kd)(1 + Kp) > (M/k) Li  (Routh):

a mass asks for a small integral, and damping by Kd admits a larger one. Gravity takes from k what a hanging mass has
above its support in a bent arm, up to 1.5 m g / L (`min_stiffness_ratio`).
"""

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from tendond.model.rod.parameters import RodParameters

Array = NDArray[np.float64]

ELEMENTS = 3
"""Of a beam: six modes; a fourth element moves the boundary of stability by less than 1 %."""

GAIN_MARGIN = 1.3
"""By which each gain may be larger, on the worst of the plants, before the loop is unstable: 2.3 dB."""

STIFFNESS_RANGE = (0.85, 1.15)
"""Of the plant's bending stiffness, of the model's."""

UNKNOWN_DELAY = 1
"""Cycles of delay beside the configured one."""

BENT_STIFFNESS = 1.2
"""Smallest tip stiffness of the arm bent by a right angle, of the straight one's; `tendond study margin` prints it."""

GRAVITY_SOFTENING = 1.5
"""Of m g / L, by which a mass above its support softens the bent arm; from the same table."""

TIP_LOAD = 1.65
"""Default P L^2/EI of the weight that the gains must bear: it bends the straight rod down by 0.42 L; 0.1 kg on the
paper's robot."""

MAX_CYCLES = 30
"""Of delay, that are modelled one by one; longer delays are sampled more coarsely, which is on the safe side."""

ROUNDING = 1e-7
"""On a spectral radius: without an integral, F stays as it is, which is a pole at one."""

EARTH = 9.81
SHRINK = 0.85
"""Factor between two gains that are tried."""


@dataclass(frozen=True)
class FeedbackGains:
    """What the measured tip is fed back with.

    Attributes:
        integral: Li [1/s]. proportional: Kp [-]. derivative: Kd [s].
        time: of the low-pass behind the derivative [s].
        quiet_share: factor of all gains at small innovations [-].
    """

    integral: float
    proportional: float
    derivative: float
    time: float
    quiet_share: float


@dataclass(frozen=True)
class LawRates:
    """How fast the laws make the model's tip converge [1/s].

    Attributes:
        velocity: of a law that sets the tip's velocity in proportion to its error, as the paper's do.
        position, smoothing: of a law that places the tip a cycle ahead.
    """

    velocity: float
    position: float
    smoothing: float


@dataclass(frozen=True)
class UnknownPlant:
    """What the controller does not know.

    Attributes:
        mass: on the tip [kg].
        stiffness: of the plant, of the straight rod's [-].
        model_stiffness: of the model, likewise: it carries the weight as a force, which softens it too.
        delay: of a measurement [cycles].
    """

    mass: float = 0.0
    stiffness: float = 1.0
    model_stiffness: float = 1.0
    delay: int = 0


def default_tip_mass(rod: RodParameters) -> float:
    """Mass on the tip that the gains bear by default [kg]: one that bends the rod as `TIP_LOAD` says."""
    return TIP_LOAD * rod.bending_stiffness / (EARTH * rod.length**2)


def min_stiffness_ratio(rod: RodParameters, mass: float) -> float:
    """Smallest tip stiffness of the bent arm with `mass` [kg] above its support, of what the observer believes [-]."""
    tip_stiffness = 3.0 * rod.bending_stiffness / rod.length**3
    gravity = math.hypot(*rod.gravity)
    lost = GRAVITY_SOFTENING * mass * gravity / rod.length / (BENT_STIFFNESS * tip_stiffness)
    return max(0.1, STIFFNESS_RANGE[0] - lost)


def loop_poles(
    rod: RodParameters, period: float, alpha: float, gains: FeedbackGains, rates: LawRates, plant: UnknownPlant,
    delay: int, *, ahead: bool,
) -> Array:  # fmt: skip
    """Poles of the sampled loop, largest first [complex, -].

    Args:
        rod: of the model. period: of the cycle [s]. alpha: of BDF-alpha.
        gains, rates: of observer and laws.
        plant: that is controlled.
        delay: of a measurement, as configured [cycles].
        ahead: the law places the tip a cycle ahead; else it sets its velocity.
    """
    poles = np.linalg.eigvals(_cycle_matrix(rod, period, alpha, gains, rates, plant, delay, ahead))
    return np.asarray(poles[np.argsort(-np.abs(poles))])


def admitted_gains(
    rod: RodParameters, period: float, alpha: float, gains: FeedbackGains, rates: LawRates, delay: float, mass: float
) -> FeedbackGains:
    """`gains`, lowered until each keeps `GAIN_MARGIN` on every plant that the controller may meet.

    Those are plants with 0 to `mass` [kg] on the tip, a stiffness within `STIFFNESS_RANGE` and as soft as gravity makes
    them, and up to `UNKNOWN_DELAY` cycles of delay beside the configured `delay` [s]. Kp and Kd are lowered together
    where the delay asks for it, then Li where the mass does.

    A law that sets the velocity of a model with a heavy tip makes its second mode grow, whatever the gains are
    (`unstable_law_poles`). No gain mends that, so those poles are left aside.
    """
    step = max(period, delay / MAX_CYCLES)
    known = round(delay / step)
    delays = range(known, known + UNKNOWN_DELAY + 1)
    loads = sorted({0.0, 0.2 * mass, mass})
    plants = [
        UnknownPlant(load, stiffness, delay=late)
        for late in delays
        for load in loads
        for stiffness in (min_stiffness_ratio(rod, load), STIFFNESS_RANGE[1])
    ]

    laws = {ahead: unstable_law_poles(rod, step, alpha, rates, ahead=ahead) for ahead in (False, True)}

    def radius(wanted: FeedbackGains, plant: UnknownPlant, ahead: bool) -> float:
        poles = loop_poles(rod, step, alpha, wanted, rates, plant, known, ahead=ahead)
        for pole in laws[ahead]:
            poles = np.delete(poles, np.argmin(np.abs(poles - pole)))
        return float(np.max(np.abs(poles)))

    def stable(wanted: FeedbackGains) -> bool:
        return all(
            radius(replace(wanted, quiet_share=share), plant, ahead) < 1.0 + ROUNDING
            for plant in plants
            for ahead in (False, True)
            for share in (1.0, gains.quiet_share)
        )

    found = replace(gains, integral=0.0)
    for part in _shrinking():
        found = replace(found, proportional=part * gains.proportional, derivative=part * gains.derivative)
        if stable(_times(found, pull=GAIN_MARGIN)):
            break
    for part in _shrinking():
        found = replace(found, integral=part * gains.integral)
        if stable(_times(found, integral=GAIN_MARGIN)):
            break
    return found


def unstable_law_poles(rod: RodParameters, period: float, alpha: float, rates: LawRates, *, ahead: bool) -> Array:
    """Unstable poles of the law on its own model, without an observer [complex, -]; none without a heavy tip.

    Args:
        rod: of the model. period: of the cycle [s]. alpha: of BDF-alpha.
        rates: of the laws. ahead: as in `loop_poles`.
    """
    blind = FeedbackGains(0.0, 0.0, 0.0, period, 1.0)
    poles = loop_poles(rod, period, alpha, blind, rates, UnknownPlant(), 0, ahead=ahead)
    return poles[np.abs(poles) > 1.0 + ROUNDING]


def _shrinking() -> list[float]:
    """Factors to try, from 1 down; 0 is the last."""
    return [SHRINK**k for k in range(28)] + [0.0]


def _times(gains: FeedbackGains, *, pull: float = 1.0, integral: float = 1.0) -> FeedbackGains:
    return replace(
        gains,
        proportional=pull * gains.proportional,
        derivative=pull * gains.derivative,
        integral=integral * gains.integral,
    )


def _beam(rod: RodParameters, stiffness: float, mass: float) -> tuple[Array, Array, Array]:
    """Mass, damping and stiffness of a clamped beam; deflection [m] and slope [rad] of each node, the tip's last."""
    h, n = rod.length / ELEMENTS, 2 * ELEMENTS + 2
    bend = np.array(
        [
            [12.0, 6 * h, -12.0, 6 * h],
            [6 * h, 4 * h * h, -6 * h, 2 * h * h],
            [-12.0, -6 * h, 12.0, -6 * h],
            [6 * h, 2 * h * h, -6 * h, 4 * h * h],
        ]
    )
    inert = np.array(
        [
            [156.0, 22 * h, 54.0, -13 * h],
            [22 * h, 4 * h * h, 13 * h, -3 * h * h],
            [54.0, 13 * h, 156.0, -22 * h],
            [-13 * h, -3 * h * h, -22 * h, 4 * h * h],
        ]
    )
    M, C, K = np.zeros((n, n)), np.zeros((n, n)), np.zeros((n, n))
    for element in range(ELEMENTS):
        at = slice(2 * element, 2 * element + 4)
        M[at, at] += rod.mass_per_length * h / 420.0 * inert
        C[at, at] += rod.bending_damping[0] / h**3 * bend
        K[at, at] += stiffness * rod.bending_stiffness / h**3 * bend
    M[-2, -2] += rod.tip_mass + mass
    return M[2:, 2:], C[2:, 2:], K[2:, 2:]


def _exact_step(rod: RodParameters, period: float, plant: UnknownPlant) -> tuple[Array, Array]:
    """The plant over a cycle: its state (y, y'), and what a moment on the tip held over the cycle does."""
    M, C, K = _beam(rod, plant.stiffness, plant.mass)
    n, inverse = len(M), np.linalg.inv(M)
    rates = np.zeros((2 * n + 1, 2 * n + 1))
    rates[:n, n : 2 * n] = np.eye(n)
    rates[n : 2 * n, :n], rates[n : 2 * n, n : 2 * n] = -inverse @ K, -inverse @ C
    rates[n : 2 * n, 2 * n] = inverse[:, -1]
    whole = expm(rates * period)
    return whole[: 2 * n, : 2 * n], whole[: 2 * n, 2 * n]


def _model_step(rod: RodParameters, period: float, alpha: float, stiffness: float) -> tuple[Array, Array]:
    """The model's BDF-alpha step: its state (y, y before, v, v before, a), and what moment and force on the tip do."""
    M, C, K = _beam(rod, stiffness, 0.0)
    n, one, zero = len(M), np.eye(len(M)), np.zeros((len(M), len(M)))
    c0, c1 = (1.5 + alpha) / (period * (1.0 + alpha)), -2.0 / period
    c2, d1 = (0.5 + alpha) / (period * (1.0 + alpha)), alpha / (1.0 + alpha)
    v_h = np.hstack([c1 * one, c2 * one, d1 * one, zero, zero])
    a_h = np.hstack([zero, zero, c1 * one, c2 * one, d1 * one])
    inverse = np.linalg.inv(c0 * c0 * M + c0 * C + K)
    y = -inverse @ (M @ (c0 * v_h + a_h) + C @ v_h)
    v = c0 * y + v_h
    same = np.eye(5 * n)
    load = inverse[:, [-1, -2]]
    step = np.vstack([y, same[:n], v, same[2 * n : 3 * n], c0 * v + a_h])
    return step, np.vstack([load, 0.0 * load, c0 * load, 0.0 * load, c0 * c0 * load])


def _cycle_matrix(
    rod: RodParameters, period: float, alpha: float, gains: FeedbackGains, rates: LawRates, plant: UnknownPlant,
    delay: int, ahead: bool,
) -> Array:  # fmt: skip
    """One cycle of the loop as a matrix; the columns of `z` below are states of the loop, one unit vector each.

    State: plant, model, past tips of both, F, the tendons' moment, the innovation's low-pass m.
    """
    A, b = _exact_step(rod, period, plant)
    S, B = _model_step(rod, period, alpha, plant.model_stiffness)
    n, keep = 2 * ELEMENTS, max(delay, plant.delay) + 1
    ends = np.cumsum([2 * n, 5 * n, keep, keep, 1, 1, 1])
    z = np.eye(ends[-1])
    x_p, x_m, past_p, past_m, F, T, m = (part for part in np.split(z, ends[:-1]))
    F, T, m = F[0], T[0], m[0]
    y_p, y_m, v_m = x_p[n - 2], x_m[n - 2], x_m[3 * n - 2]
    seen_p, seen_m = np.vstack([past_p, y_p]), np.vstack([past_m, y_m])
    e = seen_p[-1 - plant.delay] - seen_m[-1 - delay]
    m = m + min(1.0, period / gains.time) * (e - m)
    drift = (e - m) / gains.time
    stiffness, share = 3.0 * rod.bending_stiffness / rod.length**3, gains.quiet_share
    F = F + share * stiffness * gains.integral * period * e
    force = F + share * stiffness * (gains.proportional * e + gains.derivative * drift)
    if ahead:
        slow, fast = math.exp(-rates.position * period), math.exp(-rates.smoothing * period)
        then = S[n - 2] @ x_m + B[n - 2, 0] * T + B[n - 2, 1] * force
        kept = (slow + fast - slow * fast) * y_m + slow * fast * period * v_m
        T = T + (kept - then) / B[n - 2, 0]
    else:  # all of the velocity's error within a cycle, as `actuation.net_tension` bounds it
        T = T - (v_m + rates.velocity * y_m) / B[3 * n - 2, 0]
    rows = [
        A @ x_p + np.outer(b, T),
        S @ x_m + np.outer(B[:, 0], T) + np.outer(B[:, 1], force),
        seen_p[1:],
        seen_m[1:],
        F[None],
        T[None],
        m[None],
    ]
    return np.vstack(rows)
