"""Gains of the observer, and their defaults from the rod; the equations are in `estimation.observer`.

`python -m tests.constants` runs the loop with other values of T and of the last four constants (docs/reliability.md).
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from tendond.model.rod.parameters import RodParameters

NOISE_FLOOR = 1.8e-3
"""s, of the rod's length: ten standard deviations of a camera's 0.1 mm on half a metre."""

NOISE_SHARE = 0.5
"""h: noise of 0.3 mm then moves the model's tip by less than 0.1 mm (tests/unit/model/test_observer.py)."""

INNOVATION_TIME = 0.07
"""T [s]: a quarter of the first natural period of the paper's robot; the margin of the gains holds for this T. With
half of it two more of 92 plants meet the goal of `tests.constants`, with twice of it three fewer, and the tip settles a
sixth later."""

FORCE_MAX = 3.0
"""Bound of F beside the weights, in EI/L^2: a stiffness wrong by 15 % in an arm bent by a right angle looks like 0.9 of
it; the rest is for impacts."""

PULL_MAX = 4.0
"""Bound of the pull, of that of F: with 1, two more of 92 plants miss the goal of `tests.constants`; a larger one makes
no difference there, and a smaller one is less that a wrong pose does."""

INNOVATION_LIMIT = 0.1
"""Largest innovation that F takes, of the rod's length; the bound is on its size, not on each component. On the
straight rod F then grows by no more than 0.3 Li EI/L^2 a second. With 0.03, five more of 92 plants miss the goal of
`tests.constants`, and a hung weight is found three times as badly; a larger one makes a difference for one at most."""

LATERAL_VARIANCE = 0.3
"""Expected variance of a force across gravity, of that along it: most loads hang. Three seconds after 50 g are hung on
the resting arm F is wrong by 10 % of them: with 1 by 30 %, with 0.1 by 4 %, but then two more of 92 plants miss the
goal of `tests.constants`."""

UNOBSERVABLE = 0.04
"""Motion of the tip per force that counts as none, of half the trace of C: a straight rod does not yield along itself.
With 0.01, two more of 92 plants miss the goal of `tests.constants`, and a hung weight is found half as well; with 0.16,
five more."""


class CycleGains(NamedTuple):
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
    pull_max: float
    innovation_limit: float
    lateral_variance: float
    unobservable: float


@dataclass(frozen=True)
class ObserverGains:
    """Gains of the observer's equations.

    Attributes:
        kind: 'force' or 'offset'.
        period: period of the cycle [s].
        delay: age of a measurement [s].
        delay_max: largest age that a measurement may bring with it [s]; none: it is always `delay`.
        integral: Li [1/s].
        proportional: Kp [-].
        derivative: Kd [s].
        noise_floor: s [m].
        noise_share: h [-].
        innovation_time: T [s].
        force_max: bound of the size of F [N].
        offset_gain: offset gain of the low-pass of 'offset', per cycle [-].
        pull_factor: bound of the size of the pull, of that of F [-].
        innovation_limit: largest innovation that F takes, of the rod's length [-].
        lateral_variance: expected variance of a force across gravity, of that along it [-].
        unobservable: compliance that counts as none, of half the trace of C [-].
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
    pull_factor: float = PULL_MAX
    innovation_limit: float = INNOVATION_LIMIT
    lateral_variance: float = LATERAL_VARIANCE
    unobservable: float = UNOBSERVABLE
    delay_max: float | None = None

    @cached_property
    def per_cycle(self) -> CycleGains:
        """The gains as the kernel takes them."""
        return CycleGains(
            with_force=self.kind == "force",
            offset=self.offset_gain,
            blend=min(1.0, self.period / self.innovation_time),
            noise_floor=self.noise_floor,
            noise_share=self.noise_share,
            integral=self.integral * self.period,
            proportional=self.proportional,
            derivative=self.derivative / self.innovation_time,
            force_max=self.force_max,
            pull_max=self.pull_factor * self.force_max,
            innovation_limit=self.innovation_limit,
            lateral_variance=self.lateral_variance,
            unobservable=self.unobservable,
        )


def default_force_max(rod: RodParameters, mass: float) -> float:
    """Bound of F [N] from the rod's stiffness and weight, and an unknown `mass` [kg] on its tip."""
    gravity = max(1e-9, sum(component**2 for component in rod.gravity)) ** 0.5
    weight = gravity * (rod.mass_per_length * rod.length + rod.tip_mass + mass)
    return float(FORCE_MAX * rod.bending_stiffness / rod.length**2 + weight)
