"""Bounds of a command: the one place between what a law wants and what is commanded to the tendons.

In order: the inverse of b_c, bounded where the rod is nearly straight (`net_tension`); the share of a pair of tendons
and its minimum tension (`share`); bounds and rate of the tension (`limit_tension`); the actuators' lag (`lead`,
`follow`); range and rate of the displacement (`limit_displacement`); and the part of a tension step that the
displacement can follow in a cycle (`attainable`). The output is finite whatever the input.
"""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.schemas.config.control import LimitsSection

Array = NDArray[np.float64]

TENSION_LIMITS = ("not finite", "tension rate", "tension max", "tension min")
DISPLACEMENT_LIMITS = ("displacement rate", "displacement")
"""Names of the limits, in the order in which they are met."""

STEP_PART = 0.5
"""Part of a velocity error that is removed in a cycle at most, where b_c is that of whole steps: the loop bears a b_c
that is a quarter of the real one, where all of the error would leave it a factor of two."""


def net_tension(
    gain: Array, missing: Array, applied: float, gain_min: float, rate: float = 0.0, jacobian: Array | None = None
) -> float:
    """Return the net tension of the pair [N] for an acceleration that the tip still lacks.

    The paper's U = b_c^+ (-a_c + ...), with a_c = acceleration now - b_c U_applied: incremental, which is its integral
    action. b_c^+ = b'/(b'b); the paper writes 1/b_c and leaves open how a column is inverted.

    b_c vanishes as the rod straightens, but the derivative D of the tip's velocity after a cycle by the tension
    does not. A velocity error e makes the law ask for kd e, so that a cycle takes kd b'D/(b'b) of it away: more than
    all of it near the straight rod, and from twice on the loop swings, cycle by cycle, between the limits. So b'b is
    replaced by kd b'D where that is larger: all of the error in one cycle, which is what a kd beyond 1/period means. D
    takes b_c's place where b_c is too small or points against it.

    Args:
        gain: agonist's column of b_c in the bending plane [m/s^2/N], shape (2,).
        missing: wanted minus present acceleration [m/s^2], shape (2,).
        applied: net tension applied now [N].
        gain_min: below this b_c has no direction [m/s^2/N]; without D the inverse grows no further.
        rate: kd, the law's gain on the velocity error [1/s].
        jacobian: D of the agonist in the plane [m/s/N], shape (2,); none: the law as published.
    """
    (g0, g1), (m0, m1) = gain.tolist(), missing.tolist()
    size = g0 * g0 + g1 * g1
    if jacobian is None or not jacobian.any():
        return float(applied + (g0 * m0 + g1 * m1) / max(size, gain_min**2))
    d0, d1 = jacobian.tolist()
    towards = g0 * d0 + g1 * d1
    if towards > gain_min * math.hypot(d0, d1):
        return float(applied + (g0 * m0 + g1 * m1) / max(size, rate * towards))
    return float(applied + (d0 * m0 + d1 * m1) / max(towards, rate * (d0 * d0 + d1 * d1)))


def net_tension_of_step(
    gain: Array, wanted: Array, present: Array, applied: float, gain_min: float, rate: float, period: float
) -> float:
    """Return the net tension of the pair [N] for a wanted acceleration, where b_c is that of whole steps.

    (v(k+1) - v(k)) / h = present + b_c (U - applied) is exact then, so the tip's own acceleration counts in full: of a
    rod that hardly damps it is most of the motion. A velocity error e makes the law ask for kd e; beyond
    `STEP_PART` / h that is more than this part of e in a cycle, and what is wanted is scaled down to it.

    Args:
        gain: agonist's column of b_c in the bending plane [m/s^2/N], shape (2,).
        wanted: acceleration [m/s^2], shape (2,). present: that of the coming step at the tensions now applied.
        applied, gain_min, rate: see `net_tension`.
        period: h [s].
    """
    (g0, g1), (w0, w1), (p0, p1) = gain.tolist(), wanted.tolist(), present.tolist()
    part = min(1.0, STEP_PART / (rate * period)) if rate > 0.0 else 1.0
    missing = g0 * (part * w0 - p0) + g1 * (part * w1 - p1)
    return float(applied + missing / max(g0 * g0 + g1 * g1, gain_min**2))


def share(count: int, agonist: int, antagonist: int | None, net: float, tension_min: float) -> Array:
    """Return tensions [N], shape (count,), whose difference across the pair is `net` [N]; the others are slack.

    With an antagonist both tendons keep `tension_min` [N]; without one, the agonist alone takes `net`, of either sign.
    """
    tension = np.zeros(count)
    if antagonist is None:
        tension[agonist] = net
    else:
        tension[agonist] = tension_min + max(net, 0.0)
        tension[antagonist] = tension_min + max(-net, 0.0)
    return tension


def lag_factor_of(lag: float, period: float) -> float:
    """Return the fraction of a step remaining after `period` [s] of a first-order lag of time constant `lag` [s]."""
    return math.exp(-period / lag) if lag > 0.0 else 0.0


def lead(wanted: Array, last: Array, lag_factor: float) -> Array:
    """Return the command with which a lagging actuator that is at `last` will be at `wanted` a cycle later."""
    return (wanted - lag_factor * last) / (1.0 - lag_factor) if lag_factor else wanted


def follow(command: Array, last: Array, lag_factor: float) -> Array:
    """Return the position of a lagging actuator a cycle after `command`, starting from `last`."""
    return command + lag_factor * (last - command) if lag_factor else command


# A handful of tendons are floats: numpy takes ten times as long for so few.


def limit_tension(limits: LimitsSection, period: float, wanted: Array, last: Array) -> tuple[Array, tuple[str, ...]]:
    """Return `wanted` within tension and tension rate, and the names of the limits that it met.

    Args:
        limits: limits of the configuration.
        period: period of the cycle [s].
        wanted: [N], shape (n,); a value that is not finite counts as no change.
        last: commanded in the last cycle [N], shape (n,).
    """
    step, tension_min, tension_max = limits.tension_rate * period, limits.tension_min, limits.tension_max
    tensions, met = [], set()
    for tension, before in zip(wanted.tolist(), last.tolist(), strict=True):
        if not math.isfinite(tension):
            tension = before
            met.add("not finite")
        rated = min(max(tension, before - step), before + step)
        if rated != tension:
            met.add("tension rate")
        floor = min(tension_min, before + step)  # a slack tendon reaches its minimum at the same rate
        if rated > tension_max:
            met.add("tension max")
        elif rated < floor:
            met.add("tension min")
        tensions.append(min(max(rated, floor), tension_max))
    return np.array(tensions), tuple(name for name in TENSION_LIMITS if name in met) if met else ()


def limit_displacement(
    limits: LimitsSection, period: float, wanted: Array, last: Array, pulling: Array | None = None
) -> tuple[Array, tuple[str, ...]]:
    """Return `wanted` displacement within range and rate [m], shape (n,), and the names of the limits that it met.

    Args:
        limits: limits of the configuration.
        period: period of the cycle [s].
        wanted: [m], shape (n,).
        last: commanded in the last cycle [m], shape (n,).
        pulling: rates at which each servo can pull against its tension [m/s], shape (n,); none: as limited.
    """
    step, low, high = limits.displacement_rate * period, limits.displacement_min, limits.displacement_max
    up = [step] * len(wanted) if pulling is None else [min(step, rate * period) for rate in pulling.tolist()]
    displacements, met = [], set()
    for displacement, before, most in zip(wanted.tolist(), last.tolist(), up, strict=True):
        rated = min(max(displacement, before - step), before + most)
        if rated != displacement:
            met.add("displacement rate")
        if not low <= rated <= high:
            met.add("displacement")
        displacements.append(min(max(rated, low), high))
    return np.array(displacements), tuple(name for name in DISPLACEMENT_LIMITS if name in met) if met else ()


def attainable(held: Array, wanted: Array, allowed: Array) -> float:
    """Return the part of a tension step that the displacement can follow, in [0, 1].

    Args:
        held: displacements if the tensions stay [m], shape (n,).
        wanted: displacements if they take the whole step [m].
        allowed: `wanted` within its limits [m].
    """
    part = 1.0
    for before, asked, within in zip(held.tolist(), wanted.tolist(), allowed.tolist(), strict=True):
        distance, missing = asked - before, asked - within
        if not (math.isfinite(distance) and math.isfinite(missing)):
            return 0.0
        part = min(part, 1.0 - missing / distance if distance else float(missing == 0.0))
    return max(0.0, part)
