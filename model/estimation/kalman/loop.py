"""Poles of the sampled loop of law, filter, delay and plant, and the noise with which they keep a margin.

As in `estimation.poles`, a planar cantilever stands for the rod, as plant and as model, both exact between samples; the
filter has the gain of its steady state, by the discrete Riccati equation, and takes each measurement at its own time.
A filter that trusts its measurements fully corrects the model by nearly all of each innovation, and the law cancels
that at once; with a delay that is not quite as configured, or a plant that is stiffer or heavier, the loop then grows.
So measurements are taken for less certain than they are until it does not.
"""

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm, solve_discrete_are

from tendond.model.estimation.kalman.noise import Noise
from tendond.model.estimation.margin import (
    GAIN_MARGIN,
    MAX_CYCLES,
    ROUNDING,
    STIFFNESS_RANGE,
    UNKNOWN_DELAY,
    min_stiffness_ratio,
)
from tendond.model.estimation.poles import ELEMENTS, LawRates, UnknownPlant, beam
from tendond.model.rod.parameters import RodParameters

Array = NDArray[np.float64]

SHARES = tuple(0.3 * 0.5**k for k in range(8))
"""Shares of the drift of loads and tensions that are tried, the largest first. With 0.3 a circle through real servos
whose friction is told half as large is followed within 2.5 mm, where a larger one begins to swing."""

POSITION = 4e-3
"""Noise of measured positions in the loop, in the robot's length, where they are better: a correction that a law
cancels at once must not be as fast as a camera allows."""

BENT = 0.125
"""Share of the tensions' drifts in that of the load's. A bent arm with a mass that the model does not know is softer
than the beam, and the law's tensions hold it: what the filter then takes for an error of the tensions moves the arm at
once. `tendond study margin --observer kalman` has the poles of bent arms: with 1 some grow, with this one none."""

TENSION = 0.3
"""Tension at which the tendons' errors are taken, in EI/(L r): it bends the arm by 17 degrees."""


@dataclass(frozen=True)
class Design:
    """The filter's model of the beam: state (y, y', force, tension error), measured tip, and steady gain.

    Attributes:
        step: of the state, shape (2 n + 2, 2 n + 2). moment: of a moment on the tip, held over the cycle, (2 n + 2,).
        gain: of the innovation, shape (2 n + 2,). tip, speed: index of the tip's deflection, and of its rate.
    """

    step: Array
    moment: Array
    gain: Array
    tip: int
    speed: int


def design(rod: RodParameters, period: float, noise: Noise, arm: float) -> Design:
    """Return the filter for this noise; `arm`: of a tendon [m]."""
    free, by_force, by_moment = _exact(rod, period, 1.0, 0.0)
    n = len(free)
    step = np.eye(n + 2)
    step[:n, :n], step[:n, n], step[:n, n + 1] = free, by_force, by_moment * arm
    step[n + 1, n + 1] = np.exp(-period / noise.tension_time)
    moment = np.concatenate((by_moment, [0.0, 0.0]))
    tension = TENSION * rod.bending_stiffness / (rod.length * arm)
    spread = noise.tension_share * tension + noise.tension_floor
    grown = np.diag(np.full(n + 2, 1e-16 * rod.length**2))
    grown[n, n] = noise.load_rate**2 * period
    grown[n + 1, n + 1] = (1.0 - step[n + 1, n + 1] ** 2) * spread**2
    measured = np.zeros((1, n + 2))
    tip = n // 2 - 2
    measured[0, tip] = 1.0
    variance = noise.position**2
    spread_of = solve_discrete_are(step.T, measured.T, grown, np.array([[variance]]))
    gain = spread_of[:, tip] / (spread_of[tip, tip] + variance)
    return Design(step, moment, np.asarray(gain), tip, n // 2 + tip)


def filter_poles(
    rod: RodParameters, period: float, made: Design, rates: LawRates, plant: UnknownPlant, delay: int, *, ahead: bool,
    margin: float = 1.0,
) -> Array:  # fmt: skip
    """Return the poles of the sampled loop, largest first [complex, -].

    Args:
        rod: of the model. period: of the cycle [s]. made: the filter. rates: of the laws.
        plant: that is controlled. delay: of a measurement, as configured [cycles].
        ahead: the law places the tip a cycle ahead; else it sets its velocity.
        margin: factor on the filter's gain.
    """
    free, _, by_moment = _exact(rod, period, plant.stiffness, plant.mass)
    n, m, keep = len(free), len(made.step), max(delay, plant.delay) + 1
    ends = np.cumsum([n, m, keep, keep, 1])
    parts = np.split(np.eye(ends[-1]), ends[:-1])
    x_p, x_m, past_p, past_m, (pull,) = parts
    seen_p, seen_m = np.vstack([past_p, x_p[made.tip]]), np.vstack([past_m, x_m[made.tip]])
    lack = margin * (seen_p[-1 - plant.delay] - seen_m[-1 - delay])
    change = np.outer(made.gain, lack)
    for back in range(delay, 0, -1):  # the memory carries the correction on
        seen_m[-1 - back] = seen_m[-1 - back] + change[made.tip]
        change = made.step @ change
    seen_m[-1] = seen_m[-1] + change[made.tip]
    x_m = x_m + change
    y_m, v_m = x_m[made.tip], x_m[made.speed]
    if ahead:
        slow, fast = np.exp(-rates.position * period), np.exp(-rates.smoothing * period)
        then = made.step[made.tip] @ x_m + made.moment[made.tip] * pull
        kept = (slow + fast - slow * fast) * y_m + slow * fast * period * v_m
        pull = pull + (kept - then) / made.moment[made.tip]
    else:
        then = made.step[made.speed] @ x_m + made.moment[made.speed] * pull
        pull = pull - (then + rates.velocity * y_m) / made.moment[made.speed]
    rows = [
        free @ x_p + np.outer(by_moment, pull),
        made.step @ x_m + np.outer(made.moment, pull),
        seen_p[1:],
        seen_m[1:],
        pull[None],
    ]
    poles = np.linalg.eigvals(np.vstack(rows))
    return np.asarray(poles[np.argsort(-np.abs(poles))])


def noise_in_loop(noise: Noise, rod: RodParameters, share: float) -> Noise:
    """Return the noise with which the filter corrects a model that a law acts on; `share`: of a load's drift."""
    return replace(
        noise,
        position=max(noise.position, POSITION * rod.length),
        load_rate=share * noise.load_rate,
        tension_share=BENT * share * noise.tension_share,
        tension_floor=BENT * share * noise.tension_floor,
    )


@lru_cache(maxsize=64)
def admitted_noise(
    rod: RodParameters, period: float, noise: Noise, rates: LawRates, delay: float, mass: float, arm: float
) -> Noise:
    """Return the noise of `noise_in_loop` with the largest share with which the loop keeps `margin.GAIN_MARGIN`.

    On every plant with 0 to `mass` [kg] on the tip, a stiffness within `margin.STIFFNESS_RANGE` and as soft as gravity
    makes them, and up to `margin.UNKNOWN_DELAY` cycles of delay beside the configured `delay` [s]; the least of
    `SHARES` where none keeps it. Poles of a law that is unstable by itself do not count, as in `margin`.
    """
    step = max(period, delay / MAX_CYCLES)
    known = round(delay / step)
    plants = [
        UnknownPlant(load, stiffness, delay=late)
        for late in range(known + UNKNOWN_DELAY, known - 1, -1)
        for load in sorted({0.0, 0.2 * mass, mass}, reverse=True)
        for stiffness in (min_stiffness_ratio(rod, load), STIFFNESS_RANGE[1])
    ]
    tried = [noise_in_loop(noise, rod, share) for share in SHARES]
    return next(
        (one for one in tried if all(_stable(rod, step, one, rates, plant, known, arm) for plant in plants)), tried[-1]
    )


def _stable(
    rod: RodParameters, step: float, noise: Noise, rates: LawRates, plant: UnknownPlant, known: int, arm: float
) -> bool:
    made = design(rod, step, noise, arm)
    for ahead in (False, True):
        alone = filter_poles(rod, step, made, rates, UnknownPlant(), 0, ahead=ahead, margin=0.0)
        poles = filter_poles(rod, step, made, rates, plant, known, ahead=ahead, margin=GAIN_MARGIN)
        for pole in alone[np.abs(alone) > 1.0 + ROUNDING]:
            poles = np.delete(poles, np.argmin(np.abs(poles - pole)))
        if float(np.max(np.abs(poles))) >= 1.0 + ROUNDING:
            return False
    return True


def _exact(rod: RodParameters, period: float, stiffness: float, mass: float) -> tuple[Array, Array, Array]:
    """Step of a beam's state (y, y') over a cycle, and by a force and a moment on the tip, held over it."""
    M, C, K = beam(rod, stiffness, mass)
    n, inverse = len(M), np.linalg.inv(M)
    rates = np.zeros((2 * n + 2, 2 * n + 2))
    rates[:n, n : 2 * n] = np.eye(n)
    rates[n : 2 * n, :n], rates[n : 2 * n, n : 2 * n] = -inverse @ K, -inverse @ C
    rates[n : 2 * n, 2 * n], rates[n : 2 * n, 2 * n + 1] = inverse[:, -2], inverse[:, -1]
    whole = expm(rates * period)
    assert n == 2 * ELEMENTS
    return whole[: 2 * n, : 2 * n], whole[: 2 * n, 2 * n], whole[: 2 * n, 2 * n + 1]
