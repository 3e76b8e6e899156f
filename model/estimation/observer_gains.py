"""Gains of the observer, and their defaults from the rod; the equations are in `estimation.observer`."""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

from tendond.model.rod.parameters import RodParameters

NOISE_FLOOR = 1.8e-3
"""s, of the rod's length: ten standard deviations of a camera's 0.1 mm on half a metre."""

NOISE_SHARE = 0.5
"""h: noise of 0.3 mm then moves the model's tip by less than 0.1 mm (tests/unit/model/test_observer.py)."""

INNOVATION_TIME = 0.07
"""T [s]: a quarter of the first natural period of the paper's robot; the margin of the gains holds for this T."""

FORCE_MAX = 3.0
"""Bound of F beside the weights, in EI/L^2: a stiffness wrong by 15 % in an arm bent by a right angle looks like 0.9 of
it; the rest is for impacts."""


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


@dataclass(frozen=True)
class ObserverGains:
    """Gains of the observer's equations.

    Attributes:
        kind: 'force' or 'offset'.
        period: period of the cycle [s].
        delay: age of a measurement [s].
        integral: Li [1/s].
        proportional: Kp [-].
        derivative: Kd [s].
        noise_floor: s [m].
        noise_share: h [-].
        innovation_time: T [s].
        force_max: bound of the size of F [N]; that of the pull is `observer.PULL_MAX` times as large.
        offset_gain: offset gain of the low-pass of 'offset', per cycle [-].
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
        )


def default_force_max(rod: RodParameters, mass: float) -> float:
    """Bound of F [N] from the rod's stiffness and weight, and an unknown `mass` [kg] on its tip."""
    gravity = max(1e-9, sum(component**2 for component in rod.gravity)) ** 0.5
    weight = gravity * (rod.mass_per_length * rod.length + rod.tip_mass + mass)
    return float(FORCE_MAX * rod.bending_stiffness / rod.length**2 + weight)
