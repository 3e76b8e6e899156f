"""Rates of tension and displacement that suit a robot, for a configuration that names none."""

import math

from tendond.schemas.config.control import LimitsSection
from tendond.schemas.config.robot import RodSection

FIRST_MODE = 1.8751**2
"""Of a cantilever: omega = 1.8751^2 sqrt(EI / (rho A L^4)) (Timoshenko, Vibration Problems in Engineering)."""

REACH = 2.0
"""Times the rate at which the rod can follow; the rest is for the laws to catch an overshoot."""


def natural_frequency(rod: RodSection) -> float:
    """First natural frequency of the rod's bending, without tendons, weights and damping [rad/s]."""
    return FIRST_MODE * math.sqrt(_stiffness(rod) / (rod.density * math.pi * rod.radius**2 * rod.length**4))


def own_tension_rate(rod: RodSection) -> float:
    """Rate of tension that suits a rod [N/s].

    A tendon at the distance r bends a rod of the length L by a right angle with EI (pi/2) / (L r). In its first mode
    the tip cannot get there in less than a quarter of the period, pi / (2 omega). The one divided by the other is
    EI omega / (L r); a tension that changes much faster does not bend the rod sooner, but makes it whip. The paper's
    robot: 698 N/s.
    """
    return REACH * _stiffness(rod) * natural_frequency(rod) / (rod.length * _arm(rod))


def own_displacement_rate(rod: RodSection) -> float:
    """Rate of displacement that suits a rod [m/s]: a right angle takes r pi/2, and the same time, which makes r omega.

    Twice as many times that as of the tension, whose rate is to be the one that bounds: displacements follow from the
    model's motion, which under such a tension swings past its rest. The paper's robot: 1.87 m/s.
    """
    return 2.0 * REACH * _arm(rod) * natural_frequency(rod)


def with_own_rates(limits: LimitsSection, rod: RodSection, lag: float = 0.0, period: float = 0.01) -> LimitsSection:
    """The limits with the robot's own rates where none are named.

    The rates are meant for what the tendons do. A command that leads a lag changes by 1 / (1 - exp(-period/lag)) times
    as much as they do in a cycle, and may do so: bounded by the tendons' own rate it would come too late to be stable.

    Args:
        limits, rod: of the configuration.
        lag: time constant of the actuators, as configured [s]. period: of the cycle [s].
    """
    lead = 1.0 / (1.0 - math.exp(-period / lag)) if lag > 0.0 else 1.0
    changes = {}
    if limits.tension_rate == 0.0:
        changes["tension_rate"] = lead * own_tension_rate(rod)
    if limits.displacement_rate == 0.0:
        changes["displacement_rate"] = lead * own_displacement_rate(rod)
    return limits.model_copy(update=changes) if changes else limits


def _stiffness(rod: RodSection) -> float:
    """EI of the round backbone [N m^2]."""
    return rod.youngs_modulus * math.pi / 4.0 * rod.radius**4


def _arm(rod: RodSection) -> float:
    """Largest distance of a tendon from the axis [m]; the backbone's radius where all are on it."""
    return max(max(math.hypot(x, y) for x, y in rod.tendon_positions), rod.radius)
