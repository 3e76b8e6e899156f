"""A safe excitation: free sway, steps of tension, a chirp; along the tips at which the model can rest.

A plan is a list of an operator's requests: the controller carries them out as it would anyone's, with all its limits
and faults. All motion is by references through resting tips, no faster than a part of the displacement's rate.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.planar import PLANES
from tendond.daemon.errors import DaemonError
from tendond.model.errors import ConvergenceError
from tendond.model.rod.static_curve import StaticCurve, static_curve
from tendond.model.rods.selection import model_rod
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]

SAG = 0.25
"""Deflection by the proposed mass, relative to the rod's length: clearly measurable, and well below a fold."""

SPEED = 0.7
"""Fraction of the displacement rate that a reference uses: the rest is for the law."""

FASTEST = 0.2
"""Maximum speed of a tendon [m/s], whatever the limits allow."""

RANGE = 0.9
"""Fraction of the displacement range that is used."""

TENSION = 0.6
"""Maximum fraction of the tension range that the resting model may need."""

MAX_ACROSS_ANGLE = 1.75
"""Maximum angle of the tip [rad]: beyond it the path is long and adds no information."""

SAMPLE = 0.05
"""Time between the samples of a reference [s]."""

SWAY_SECONDS = 1.2
REST_SECONDS = 0.6
KINDS = ("sway", "steps", "chirp")


class PlanError(DaemonError):
    """Error of a rig that cannot be excited within its limits."""


@dataclass(frozen=True)
class Request:
    """A request of the operator.

    Attributes:
        time: time since the plan's beginning [s].
        action: the action. reference: the new reference, where the action is one.
    """

    time: float
    action: ControlAction
    reference: ReferenceSection | None = None


@dataclass(frozen=True)
class IdentificationPlan:
    """Requests to make, in order of time.

    Attributes:
        requests: the operator's requests.
        duration: total time [s].
        parts: descriptions of the parts, with their time [s].
    """

    requests: tuple[Request, ...]
    duration: float
    parts: tuple[tuple[float, str], ...]


@dataclass(frozen=True)
class EquilibriumPath:
    """Path of resting tips within the limits, and the displacement of the agonist along it.

    Attributes:
        curve: curve of resting tips.
        arc: arc length [m]. displacement: the agonist's displacement [m]. Both of shape (k,), increasing from the
            pretension on.
    """

    curve: StaticCurve
    arc: Array
    displacement: Array

    def samples(self, displacement: Array, sample: float) -> tuple[tuple[float, float, float], ...]:
        """Return a reference through the tips that rest at these displacements [m], one every `sample` [s]."""
        points = self.curve.spline(np.interp(displacement, self.displacement, self.arc))
        return tuple((round(k * sample, 6), round(float(x), 7), round(float(z), 7)) for k, (x, z) in enumerate(points))


def path_of(config: RigConfig) -> EquilibriumPath:
    """Find the path within the limits that a plan may use.

    Raises:
        PlanError: the limits leave no room to move.
    """
    rod = model_rod(config)
    control, limits = config.control, config.limits
    curve = static_curve(rod, control.agonist, limits.tension_max, PLANES[control.plane])
    pull = np.zeros(rod.parameters.tendon_count)
    elastic = config.rod.has_elastic_tendons
    state, found = None, []
    for tension in curve.tension:
        pull[control.agonist] = tension
        try:
            state = rod.solve_static(pull, start=state)
        except ConvergenceError:
            break
        found.append(rod.displacements(state, elastic=elastic))
    displacement = np.array(found)
    count = len(displacement)
    usable = (
        (curve.tension[:count] >= config.pretension.tension)
        & (curve.tension[:count] <= TENSION * limits.tension_max)
        & (np.abs(curve.angle[:count]) <= MAX_ACROSS_ANGLE)
        & np.all(displacement <= RANGE * limits.displacement_max, axis=1)
        & np.all(displacement - limits.slack >= RANGE * limits.displacement_min, axis=1)
    )
    agonist = displacement[:, control.agonist]
    usable[1:] &= np.diff(agonist) > 0.0
    rows = np.flatnonzero(usable)
    if rows.size < 3 or agonist[rows[-1]] - agonist[rows[0]] < 0.002:
        raise PlanError(
            "the limits leave the tip no room to move: raise limits.displacement_max or tension_max, or lower "
            "pretension.tension"
        )
    return EquilibriumPath(curve, curve.arc[rows], agonist[rows])


def propose(config: RigConfig, kinds: tuple[str, ...] = KINDS, reach: float = 1.0) -> IdentificationPlan:
    """Propose a plan for a rig.

    Args:
        config: the rig's configuration.
        kinds: kinds of motion, from `KINDS`, in their order.
        reach: fraction of the path that the limits allow, in (0, 1].

    Raises:
        PlanError: the limits leave no room to move, or there are kinds that do not exist.
    """
    unknown = [kind for kind in kinds if kind not in KINDS]
    if unknown or not kinds:
        raise PlanError(f"'{', '.join(unknown)}': choose among {', '.join(KINDS)}")
    config = config.with_own_rates()
    path = path_of(config)
    rate = min(SPEED * config.limits.displacement_rate, FASTEST)
    low = float(path.displacement[0])
    span = reach * (float(path.displacement[-1]) - low)
    release = config.limits.tension_max / config.limits.release_rate
    requests: list[Request] = []
    parts: list[tuple[float, str]] = []
    now = REST_SECONDS
    for words, motion, sway in _motions(kinds, low, span, rate):
        samples = path.samples(motion, SAMPLE)
        reference = ReferenceSection(kind="samples", samples=samples)
        parts.append((now, words))
        requests.append(Request(now, ControlAction.REFERENCE, reference))
        requests.append(Request(now + 0.1, ControlAction.ARM))
        now += 0.1 + config.pretension.duration + samples[-1][0]
        requests.append(Request(now, ControlAction.STOP))
        now += release + float(motion[-1]) / config.limits.displacement_rate + sway
    return IdentificationPlan(tuple(requests), now, tuple(parts))


def _motions(kinds: tuple[str, ...], low: float, span: float, rate: float) -> Iterator[tuple[str, Array, float]]:
    """Yield each part: words, displacements every `SAMPLE` [m], and how long it sways afterwards [s]."""
    for kind in KINDS:
        if kind not in kinds:
            continue
        if kind == "sway":
            for part in (0.6, 1.0, 0.8):
                goal = low + part * span
                yield (
                    f"free sway: to {goal * 1e3:.1f} mm of tendon, hold, release",
                    np.concatenate([_ramp(low, goal, rate), np.full(round(0.4 / SAMPLE), goal)]),
                    SWAY_SECONDS,
                )
        elif kind == "steps":
            levels = [low + part * span for part in (0.0, 0.35, 0.15, 0.7, 0.45, 1.0, 0.6)]
            pieces = []
            for start, end in pairwise(levels):
                pieces += [_ramp(start, end, rate), np.full(round(0.6 / SAMPLE), end)]
            yield f"steps of tension, up to {levels[5] * 1e3:.1f} mm", np.concatenate(pieces), REST_SECONDS
        else:
            middle = low + 0.6 * span
            yield (
                f"chirp about {middle * 1e3:.1f} mm, 0.3 to 2.5 Hz",
                np.concatenate([_ramp(low, middle, rate), _chirp(middle, 0.35 * span, rate)]),
                REST_SECONDS,
            )


def _ramp(start: float, end: float, rate: float) -> Array:
    """Return a minimum-jerk motion, whose speed peaks at 15/8 of its mean [m], every `SAMPLE`."""
    steps = max(2, math.ceil(1.875 * abs(end - start) / rate / SAMPLE))
    t = np.arange(steps) / steps
    return np.asarray(start + (end - start) * (10.0 * t**3 - 15.0 * t**4 + 6.0 * t**5))


def _chirp(middle: float, amplitude: float, rate: float, seconds: float = 7.0) -> Array:
    """Return sweeps from 0.3 to 2.5 Hz whose amplitude keeps the speed below `rate` [m/s]; they end at rest."""
    t = np.arange(0.0, seconds, SAMPLE)
    low, high = 0.3, 2.5
    growth = math.log(high / low) / seconds
    frequency = low * np.exp(growth * t)
    phase = 2.0 * np.pi * (frequency - low) / growth
    size = np.minimum(amplitude, rate / (2.0 * np.pi * frequency))
    fade = np.minimum(1.0, np.minimum(t, seconds - t) / 0.5)
    return np.asarray(middle + size * fade * np.sin(phase))


def proposed_weight(config: RigConfig) -> float:
    """Compute the mass that bends the straight rod by `SAG` of its length, P = 3 EI w / L^3, rounded to 5 g [kg]."""
    rod = config.rod
    stiffness = rod.youngs_modulus * math.pi * rod.radius**4 / 4.0
    gravity = math.hypot(*rod.gravity) or 9.81
    mass = 3.0 * stiffness * SAG / rod.length**2 / gravity
    return max(0.005, round(mass / 0.005) * 0.005)
