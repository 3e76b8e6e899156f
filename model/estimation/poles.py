"""Poles of the sampled loop of law, observer, delay and plant.

A planar cantilever of Hermite beam elements (Bathe, Finite Element Procedures, 1996, section 5.4) stands for the rod,
as plant and as model. The plant, with an unknown mass on its tip, is exact between samples; the model takes the
controller's own BDF-alpha steps. Both have Kelvin-Voigt damping Bbt, and are driven by the tendons' moment at the tip.
All is linear, so that one cycle is a matrix, and the loop is stable where the matrix's spectral radius is below one
(Astrom & Wittenmark, Computer-Controlled Systems, 1997, chapter 3).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from tendond.model.rod.parameters import RodParameters

Array = NDArray[np.float64]

ELEMENTS = 3
"""Elements of a beam: six modes; a fourth element moves the boundary of stability by less than 1 %."""


@dataclass(frozen=True)
class FeedbackGains:
    """Gains of the feedback of the measured tip.

    Attributes:
        integral: Li [1/s]. proportional: Kp [-]. derivative: Kd [s].
        time: time constant of the low-pass behind the derivative [s].
        noise_share: factor of all gains at small innovations [-].
    """

    integral: float
    proportional: float
    derivative: float
    time: float
    noise_share: float


@dataclass(frozen=True)
class LawRates:
    """Rates at which the laws make the model's tip converge [1/s].

    Attributes:
        velocity: rate of a law that sets the tip's velocity in proportion to its error, as the paper's do.
        position, smoothing: rates of a law that places the tip a cycle ahead.
    """

    velocity: float
    position: float
    smoothing: float


@dataclass(frozen=True)
class UnknownPlant:
    """Properties of the plant that the controller does not know.

    Attributes:
        mass: mass on the tip [kg].
        stiffness: stiffness of the plant, of the straight rod's [-].
        model_stiffness: model stiffness of the model, likewise: it carries the weight as a force, which softens it too.
        delay: delay of a measurement [cycles].
    """

    mass: float = 0.0
    stiffness: float = 1.0
    model_stiffness: float = 1.0
    delay: int = 0


def loop_poles(
    rod: RodParameters, period: float, alpha: float, gains: FeedbackGains, rates: LawRates, plant: UnknownPlant,
    delay: int, *, ahead: bool,
) -> Array:  # fmt: skip
    """Poles of the sampled loop, largest first [complex, -].

    Args:
        rod: rod of the model. period: period of the cycle [s]. alpha: alpha of BDF-alpha.
        gains, rates: of observer and laws.
        plant: that is controlled.
        delay: delay of a measurement, as configured [cycles].
        ahead: the law places the tip a cycle ahead; else it sets its velocity.
    """
    poles = np.linalg.eigvals(_cycle_matrix(rod, period, alpha, gains, rates, plant, delay, ahead))
    return np.asarray(poles[np.argsort(-np.abs(poles))])


def beam(rod: RodParameters, stiffness: float, mass: float) -> tuple[Array, Array, Array]:
    """Return mass, damping and stiffness of a clamped beam: deflection [m] and slope [rad] of each node, tip last."""
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
    """Matrices of the plant over a cycle: of its state (y, y'), and of a moment on the tip held over the cycle."""
    M, C, K = beam(rod, plant.stiffness, plant.mass)
    n, inverse = len(M), np.linalg.inv(M)
    rates = np.zeros((2 * n + 1, 2 * n + 1))
    rates[:n, n : 2 * n] = np.eye(n)
    rates[n : 2 * n, :n], rates[n : 2 * n, n : 2 * n] = -inverse @ K, -inverse @ C
    rates[n : 2 * n, 2 * n] = inverse[:, -1]
    whole = expm(rates * period)
    return whole[: 2 * n, : 2 * n], whole[: 2 * n, 2 * n]


def _model_step(rod: RodParameters, period: float, alpha: float, stiffness: float) -> tuple[Array, Array]:
    """Matrices of the model's step: of its state (y, y before, v, v before, a), and of moment and force on the tip."""
    M, C, K = beam(rod, stiffness, 0.0)
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
    delayed_p, delayed_m = np.vstack([past_p, y_p]), np.vstack([past_m, y_m])
    e = delayed_p[-1 - plant.delay] - delayed_m[-1 - delay]
    m = m + min(1.0, period / gains.time) * (e - m)
    drift = (e - m) / gains.time
    stiffness, share = 3.0 * rod.bending_stiffness / rod.length**3, gains.noise_share
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
        delayed_p[1:],
        delayed_m[1:],
        F[None],
        T[None],
        m[None],
    ]
    return np.vstack(rows)
