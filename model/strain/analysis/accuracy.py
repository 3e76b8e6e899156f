"""Distance of a tip from that of more modes and shorter steps, and the modes and step that a tolerance needs.

Two indicators cost next to nothing and need no second solution. In space: Legendre coefficients of a smooth strain
decay geometrically, so the last one kept is about as large as all that were left out (J. P. Boyd, "Chebyshev and
Fourier Spectral Methods", 2nd ed. 2001, section 2.12). In time: the implicit midpoint rule leaves dt^3 q'''/12 a step
(E. Hairer, C. Lubich, G. Wanner, "Geometric Numerical Integration", 2nd ed. 2006), with q''' from two steps. `refine`
does not rely on them: it compares solutions.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain.describe.section import Section
from tendond.model.strain.robot import Robot
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.scratch import Loads

Array = NDArray[np.float64]

KINDS = ("bending_modes", "torsion_modes", "stretch_modes", "shear_modes")

MODES_MAX = 8
"""Modes of one strain in a section."""

HALVINGS = 8
"""Halvings of the time step, at most: to a 256th of what was asked for."""

TRIAL_PERIODS = 2.0
"""Periods of the robot's first mode in a trial: one to pull, one to swing."""

TRIAL_STEPS = (10, 50)
"""Min. and max. number of the longest time steps in a trial; a slow robot is pulled faster than by its period."""

TRIAL_FORCE = 3.0
"""Force across the tip in a trial, in EI/L^2: bends a cantilever by about 50 degrees."""


class TipError(NamedTuple):
    """Estimated error of a tip's position [m].

    Attributes:
        space: of the strains' last modes. A strain of a single mode has no estimate.
        time: of the last step.
    """

    space: float
    time: float


def tip_error(rod: StrainRod, state: StrainState) -> TipError:
    """Estimate how far the tip of `state` is from that of more modes, and of a shorter last step.

    On the light wires of `tests/unit/strain/test_accuracy.py` the estimates are within a factor of five of the error.

    Args:
        rod: whose state it is.
        state: after at least one step; before, the estimate in time is 0.
    """
    jacobian = rod.tip_jacobian(state)
    last = _last_modes(rod.layout.component)
    space = float(np.linalg.norm(jacobian[:, last] @ state.strain[last]))
    if state.earlier is None:
        return TipError(space, 0.0)
    before, before_that = state.earlier
    change = state.rate - 2.0 * before + before_that
    return TipError(space, rod.time_step / 12.0 * float(np.linalg.norm(jacobian @ change)))


def _last_modes(component: NDArray[np.int64]) -> NDArray[np.int64]:
    """Indices of the last mode of each strain of each section, where it has more than one."""
    ends = [*(np.flatnonzero(np.diff(component) != 0) + 1), len(component)]
    starts = [0, *ends[:-1]]
    return np.array([end - 1 for start, end in zip(starts, ends, strict=True) if end - start > 1], dtype=np.int64)


@dataclass(frozen=True)
class Refined:
    """Robot and time step that a tolerance needs.

    Attributes:
        robot: with the modes that are needed. time_step: [s].
        error: of the tip, the largest that was left in the trials, as a part of the length.
        reached: false where modes or steps were exhausted first.
    """

    robot: Robot
    time_step: float
    error: float
    reached: bool

    def __str__(self) -> str:
        modes = "; ".join(
            ", ".join(f"{getattr(one, kind)} {kind.removesuffix('_modes')}" for kind in KINDS if getattr(one, kind))
            for one in self.robot.sections
        )
        short = "" if self.reached else ", which is all there is"
        return f"modes a section: {modes}; time step {1e3 * self.time_step:g} ms; tip within {self.error:.1e} L{short}"


def refine(
    robot: Robot, time_step: float = 0.01, tolerance: float = 1e-3, *, bend: float = math.pi, shorten: bool = True
) -> Refined:
    """Find the modes and the time step with which the tip keeps within `tolerance` of converged motions.

    The trials: each tendon in turn is pulled, evenly over one period of the first mode, to what bends its stretch by
    `bend`; and a force across the tip is let go, of the unloaded robot and of one that its tendons bend. Modes are
    added, and the step halved, until that changes no tip by more than the tolerance. Faster loads on a light rod need
    more; `tip_error` tells.

    Args:
        robot: its modes are the least that are tried.
        time_step: the longest that is tried [s].
        tolerance: of the tip's position, as a part of the length.
        bend: in the trials [rad].
        shorten: whether the time step may become shorter.

    Raises:
        ParameterError: a tolerance that is not finite or not above 0.
        ConvergenceError: a trial has no solution.
    """
    if not (math.isfinite(tolerance) and tolerance > 0.0):
        raise ParameterError(f"refine: tolerance = {tolerance!r} must be finite and above 0")
    plain = StrainRod(replace(robot, gravity=(0.0, 0.0, 0.0)))
    period = 1.0 / float(plain.frequencies(plain.rest(), plain.loads())[0])
    steps = min(max(TRIAL_STEPS[0], math.ceil(TRIAL_PERIODS * period / time_step)), TRIAL_STEPS[1])
    duration = steps * time_step
    period = min(period, duration / TRIAL_PERIODS)
    reached, error, step = True, 0.0, time_step
    tips = _trials(robot, step, duration, period, bend)
    while True:
        larger = [(one, _trials(one, step, duration, period, bend)) for one in _with_more_modes(robot)]
        errors = [_distance(tips, found) / robot.length for _, found in larger]
        error = max(errors, default=0.0)
        if error <= tolerance:
            break
        robot, tips = larger[int(np.argmax(errors))]
        if all(section.bending_modes == MODES_MAX for section in robot.sections):
            reached = False
            break
    if shorten:
        for _ in range(HALVINGS):
            finer = _trials(robot, 0.5 * step, duration, period, bend)
            in_time = _distance(tips, finer[:, 1::2]) / robot.length * 4.0 / 3.0  # second order: Richardson
            if in_time <= tolerance:
                return Refined(robot, step, max(error, in_time), reached)
            step, tips = 0.5 * step, finer
        reached = False
    return Refined(robot, step, error, reached)


def _with_more_modes(robot: Robot) -> Iterator[Robot]:
    """The robots with one more mode of one strain, of those that it has at all, in every section."""
    for kind in KINDS:
        sections = tuple(_with_one_more(section, kind) for section in robot.sections)
        if sections != robot.sections:
            yield replace(robot, sections=sections)


def _with_one_more(section: Section, kind: str) -> Section:
    number = getattr(section, kind)
    changed: dict[str, Any] = {kind: number + 1}
    return replace(section, **changed) if 0 < number < MODES_MAX else section


def _distance(one: Array, other: Array) -> float:
    return float(np.linalg.norm(one - other, axis=-1).max())


def _trials(robot: Robot, time_step: float, duration: float, period: float, bend: float) -> Array:
    """Tips of all trials [m], shape (trials, steps, 3)."""
    rod = StrainRod(robot, time_step)
    steps = round(duration / time_step)
    rest = rod.solve_static(rod.loads())
    stiffness = min(min(section.bending_stiffness) for section in robot.sections)
    across = TRIAL_FORCE * stiffness / robot.length**2
    tips = []
    pulls = [_pull(robot, index, bend * stiffness) for index in range(len(robot.tendons))]
    shares = np.minimum(1.0, time_step * (np.arange(steps) + 0.5) / period)  # of the steps' middles
    tips += [_tips(rod, rest, [rod.loads(share * pull) for share in shares]) for pull in pulls]
    for pull in [np.zeros(len(pulls)), *(0.5 * pull for pull in pulls)]:
        for direction in ((across, 0.0, 0.0), (0.0, across, 0.0)):
            bent = rod.solve_static(rod.loads(pull, tip_force=direction), rest)
            tips.append(_tips(rod, bent, [rod.loads(pull)] * steps))
    return np.array(tips)


def _pull(robot: Robot, index: int, moment: float) -> Array:
    """Tensions of which one tendon's alone bends the stretch that it passes by `moment` [N m rad] [N], shape (m,)."""
    tendon = robot.tendons[index]
    reach = max(math.hypot(*tendon.at(s)) for s in np.linspace(0.0, tendon.end, 9))
    pull = np.zeros(len(robot.tendons))
    pull[index] = moment / (tendon.end * reach) if reach > 0.0 else 0.0
    return pull


def _tips(rod: StrainRod, state: StrainState, program: Sequence[Loads]) -> Array:
    found = np.zeros((len(program), 3))
    for k, loads in enumerate(program):
        state = rod.step(state, loads)
        found[k] = rod.tip(state)[0]
    return found
