"""From what a law wants to what the tendons are told: the one place that bounds a command.

In order: the inverse of b_c, bounded where the rod is nearly straight (`net_tension`), the share of a pair of tendons
and its least tension (`share`), bounds and rate of the tension (`limit_tension`), the actuators' lag (`lead`,
`follow`), range and rate of the displacement (`limit_displacement`, and `attainable`: how much of a tension step can be
wound in a cycle).
Whatever comes in, what goes out is finite.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.schemas.config import LimitsSection

Array = NDArray[np.float64]


def net_tension(
    gain: Array, missing: Array, applied: float, gain_min: float, rate: float = 0.0, response: Array | None = None
) -> float:
    """Net tension of the pair [N] for an acceleration that the tip is still missing.

    The paper's U = b_c^+ (-a_c + ...), with a_c = acceleration now - b_c U_applied: incremental, which is its integral
    action. b_c^+ = b'/(b'b); the paper writes 1/b_c and leaves open how a column is inverted.

    b_c vanishes as the rod straightens, but what a newton does to the tip's velocity within a cycle, the response D,
    does not. A velocity error e makes the law ask for kd e, so that a cycle takes kd b'D/(b'b) of it away: more than
    all of it near the straight rod, and from twice on the loop swings, cycle by cycle, between the limits. So b'b is
    replaced by kd b'D where that is larger: all of the error in one cycle, which is what a kd beyond 1/period means. D
    takes b_c's place where b_c is too small or points against it.

    Args:
        gain: agonist's column of b_c in the bending plane [m/s^2/N], shape (2,).
        missing: wanted minus present acceleration [m/s^2], shape (2,).
        applied: net tension applied now [N].
        gain_min: below this b_c has no direction [m/s^2/N]; without a response the inverse grows no further.
        rate: kd, the law's gain on the velocity error [1/s].
        response: D of the agonist in the plane [m/s/N], shape (2,); none: the law as it is written.
    """
    if response is None or not response.any():
        return applied + float((gain * missing).sum()) / max(float((gain * gain).sum()), gain_min**2)
    way = gain if float((gain * response).sum()) > gain_min * math.hypot(*response.tolist()) else response
    taken = max(float((way * gain).sum()), rate * float((way * response).sum()))
    return applied + float((way * missing).sum()) / taken


def share(count: int, agonist: int, antagonist: int | None, net: float, least: float) -> Array:
    """Tensions [N], shape (count,), whose difference across the pair is `net` [N]; the others are slack.

    With an antagonist both tendons keep `least` [N]; without one, the agonist alone is told `net`, negative or not.
    """
    tension = np.zeros(count)
    if antagonist is None:
        tension[agonist] = net
    else:
        tension[agonist] = least + max(net, 0.0)
        tension[antagonist] = least + max(-net, 0.0)
    return tension


def lag_share(lag: float, period: float) -> float:
    """Part of a step that an actuator of time constant `lag` [s] still lacks after `period` [s]."""
    return math.exp(-period / lag) if lag > 0.0 else 0.0


def lead(wanted: Array, last: Array, lagging: float) -> Array:
    """What to command so that a lagging actuator that stands at `last` is at `wanted` a cycle later."""
    return (wanted - lagging * last) / (1.0 - lagging)


def follow(command: Array, last: Array, lagging: float) -> Array:
    """Where a lagging actuator that stands at `last` is a cycle after `command`."""
    return command + lagging * (last - command)


def limit_tension(limits: LimitsSection, period: float, wanted: Array, last: Array) -> tuple[Array, tuple[str, ...]]:
    """`wanted` within tension and tension rate, and the names of the limits that it met.

    Args:
        limits: of the configuration.
        period: of the cycle [s].
        wanted: [N], shape (n,); a value that is not finite counts as no change.
        last: commanded in the last cycle [N], shape (n,).
    """
    met = []
    tension = np.where(np.isfinite(wanted), wanted, last)
    if not np.all(np.isfinite(wanted)):
        met.append("not finite")
    step = limits.tension_rate * period
    rated = np.clip(tension, last - step, last + step)
    if np.any(rated != tension):
        met.append("tension rate")
    bounded = np.clip(rated, limits.tension_min, limits.tension_max)
    if np.any(rated > limits.tension_max):
        met.append("tension max")
    if np.any(rated < limits.tension_min):
        met.append("tension min")
    return bounded, tuple(met)


def limit_displacement(
    limits: LimitsSection, period: float, wanted: Array, last: Array
) -> tuple[Array, tuple[str, ...]]:
    """`wanted` displacement within its range and rate [m], shape (n,), and the names of the limits that it met."""
    met = []
    step = limits.displacement_rate * period
    rated = np.clip(wanted, last - step, last + step)
    if np.any(rated != wanted):
        met.append("displacement rate")
    bounded = np.clip(rated, limits.displacement_min, limits.displacement_max)
    if np.any(bounded != rated):
        met.append("displacement")
    return bounded, tuple(met)


def attainable(held: Array, wanted: Array, allowed: Array) -> float:
    """Part of a tension step that can be wound, in [0, 1].

    Args:
        held: displacements if the tensions stay [m], shape (n,).
        wanted: displacements if they take the whole step [m].
        allowed: `wanted` within its limits [m].
    """
    way, short = wanted - held, wanted - allowed
    parts = 1.0 - np.divide(short, way, out=(short != 0.0).astype(np.float64), where=way != 0.0)
    part = float(np.min(parts))
    return min(1.0, max(0.0, part)) if math.isfinite(part) else 0.0
