"""The observer's gains, lowered until the loop keeps a stability margin with an unknown mass on the tip.

The poles are those of `poles.loop_poles`. Why a mass matters: the law makes the tendons cancel the observer's force on
the model at once, so that the plant feels it with the opposite sign. With one mode, mass M, damping c and stiffness k,
and gains in units of k, the error obeys

    M e'''+ (c + k Kd) e'' + k (1 + Kp) e' + k Li e = 0,    stable where (c/k + Kd)(1 + Kp) > (M/k) Li  (Routh):

a mass needs a small integral gain, and damping by Kd admits a larger one. A hanging mass above its support in a bent
arm lowers k, by up to 1.5 m g / L (`min_stiffness_ratio`).
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.poles import FeedbackGains, LawRates, UnknownPlant, loop_poles
from tendond.model.rod.parameters import RodParameters

Array = NDArray[np.float64]

GAIN_MARGIN = 1.3
"""Factor by which each gain may be larger, on the worst of the plants, before the loop is unstable: 2.3 dB.
Chosen; with it all runs of `tendond study margin` settle."""

STIFFNESS_RANGE = (0.85, 1.15)
"""Range of the plant's bending stiffness, of the model's. Chosen; `tendond study margin` and `python -m
tests.plants.weights` run plants at its ends."""

UNKNOWN_DELAY = 1
"""Delay in addition to the configured one [cycles]."""

BENT_STIFFNESS = 1.2
"""Smallest tip stiffness of the arm bent by a right angle, of the straight one's; `tendond study margin` prints it."""

GRAVITY_SOFTENING = 1.5
"""Stiffness that a mass above its support takes from the bent arm, in m g / L; from the same table."""

TIP_LOAD = 1.65
"""Default P L^2/EI of the weight with which the loop must be stable: it bends the straight rod by 0.42 L; 0.1 kg on the
paper's robot."""

MAX_CYCLES = 30
"""Cycles of delay that are modelled one by one; longer delays are sampled more coarsely, which is on the safe side."""

ROUNDING = 1e-7
"""Tolerance of a spectral radius: without an integral gain F is constant, which is a pole at one."""

EARTH = 9.81
"""Gravity, for a default mass of robots that lie across it or not [m/s^2]."""

SHRINK = 0.85
"""Ratio of two successive gains that are tried: the one found is the largest but for 15 %, the 28th 1.2 % of
the first. Chosen."""


def default_tip_mass(rod: RodParameters) -> float:
    """Default of the unknown mass on the tip with which the loop must be stable [kg]: its weight is `TIP_LOAD`."""
    return TIP_LOAD * rod.bending_stiffness / (EARTH * rod.length**2)


def min_stiffness_ratio(rod: RodParameters, mass: float) -> float:
    """Smallest tip stiffness of the bent arm with `mass` [kg] above its support, of that in the observer [-]."""
    tip_stiffness = 3.0 * rod.bending_stiffness / rod.length**3
    gravity = math.hypot(*rod.gravity)
    lost = GRAVITY_SOFTENING * mass * gravity / rod.length / (BENT_STIFFNESS * tip_stiffness)
    return max(0.1, STIFFNESS_RANGE[0] - lost)


def admitted_gains(
    rod: RodParameters, period: float, alpha: float, gains: FeedbackGains, rates: LawRates, delay: float, mass: float
) -> FeedbackGains:
    """Lower `gains` until each keeps `GAIN_MARGIN` on every plant within the bounds.

    Those are plants with 0 to `mass` [kg] on the tip, a stiffness within `STIFFNESS_RANGE` and as soft as gravity makes
    them, and up to `UNKNOWN_DELAY` cycles of delay beside the configured `delay` [s]. Kp and Kd are lowered together
    where the delay asks for it, then Li where the mass does.

    A law that sets the velocity of a model with a heavy tip makes its second mode grow, whatever the gains are
    (`unstable_law_poles`). No gain of the observer changes that, so those poles are left out.
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
            radius(replace(wanted, noise_share=share), plant, ahead) < 1.0 + ROUNDING
            for plant in plants
            for ahead in (False, True)
            for share in (1.0, gains.noise_share)
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
        rod: rod of the model. period: period of the cycle [s]. alpha: alpha of BDF-alpha.
        rates: rates of the laws. ahead: as in `loop_poles`.
    """
    blind = FeedbackGains(0.0, 0.0, 0.0, period, 1.0)
    poles = loop_poles(rod, period, alpha, blind, rates, UnknownPlant(), 0, ahead=ahead)
    return poles[np.abs(poles) > 1.0 + ROUNDING]


def _shrinking() -> list[float]:
    """Factors to try, from 1 down; 0 is the last."""
    return [SHRINK**k for k in range(28)] + [0.0]


def _times(gains: FeedbackGains, *, pull: float = 1.0, integral: float = 1.0) -> FeedbackGains:
    """Multiply the gains of the pull, and the integral gain."""
    return replace(
        gains,
        proportional=pull * gains.proportional,
        derivative=pull * gains.derivative,
        integral=integral * gains.integral,
    )
