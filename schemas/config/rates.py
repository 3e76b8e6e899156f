"""Limits that suit a robot and its servos, for a configuration that sets none."""

import math

from tendond.schemas.config.control import LimitsSection
from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.servo import ServoSection, fastest_rate, strongest_tension

DERIVED = frozenset({"limits.tension_max", "limits.displacement_min", "limits.displacement_max"})
"""Keys whose default depends on [servo]: an example that sets them would take them for the user's."""

FIRST_MODE = 1.8751**2
"""First mode of a cantilever: omega = 1.8751^2 sqrt(EI/(rho A L^4)) (Timoshenko, Vibration Problems in Engineering)."""

CANTILEVER_MASS = 3.0 / FIRST_MODE**2
"""Part of a cantilever's mass that counts at its tip in the first mode, 0.243: 3 EI/L^3 over its frequency's square."""

REACH = 2.0
"""Factor on the rate that the rod can follow, as reserve of the laws against an overshoot."""


def natural_frequency(rod: RodSection) -> float:
    """Return the first natural frequency of bending, without tendons, weights and damping [rad/s]."""
    return FIRST_MODE * math.sqrt(_stiffness(rod) / (rod.density * math.pi * rod.radius**2 * rod.length**4))


def damping_ratio(rod: RodSection) -> float:
    """Return the damping ratio of the first bending mode of a uniform rod [-]: a cantilever's, with its tip's mass."""
    rod_mass = rod.density * math.pi * rod.radius**2 * rod.length
    omega = math.sqrt(3.0 * _stiffness(rod) / rod.length**3 / (rod.tip_mass + CANTILEVER_MASS * rod_mass))
    return 0.5 * rod.bending_damping[0] / _stiffness(rod) * omega


def own_tension_rate(rod: RodSection) -> float:
    """Derive the rate of tension from a rod [N/s].

    A tendon at the distance r bends a rod of the length L by a right angle with EI (pi/2) / (L r). In its first mode
    the tip needs a quarter of the period, pi / (2 omega). The quotient is EI omega / (L r); a tension that changes much
    faster does not bend the rod sooner, but excites higher modes. The paper's robot: 698 N/s.
    """
    return REACH * _stiffness(rod) * natural_frequency(rod) / (rod.length * _arm(rod))


def own_displacement_rate(rod: RodSection) -> float:
    """Derive the rate of displacement from a rod [m/s]: r pi/2 for a right angle in the same time, which gives r omega.

    The factor is twice that of the tension, so that the rate of tension is the active limit: displacements follow from
    the model's motion, which overshoots under such a tension. The paper's robot: 1.87 m/s.
    """
    return 2.0 * REACH * _arm(rod) * natural_frequency(rod)


def with_own_rates(limits: LimitsSection, rod: RodSection, lag: float = 0.0, period: float = 0.01) -> LimitsSection:
    """Return the limits with derived rates where none are given.

    The rates apply to the tendons. A command that compensates a lag changes 1 / (1 - exp(-period/lag)) times as much in
    a cycle; limited to the tendons' rate it would be too late to be stable.

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


def with_servo_limits(limits: LimitsSection, own: LimitsSection, servo: ServoSection) -> LimitsSection:
    """The limits with those of the servos where none are set, and where the servos' are narrower.

    Args:
        limits: limits of the configuration.
        own: the same, with the robot's own rates.
        servo: [servo].
    """
    changes = {}
    if limits.displacement_rate == 0.0:
        changes["displacement_rate"] = min(own.displacement_rate, fastest_rate(servo))
    if "displacement_min" not in limits.model_fields_set:
        changes["displacement_min"] = max(limits.displacement_min, servo.displacement_min)
    if "displacement_max" not in limits.model_fields_set:
        changes["displacement_max"] = min(limits.displacement_max, servo.displacement_max)
    if "tension_max" not in limits.model_fields_set:
        changes["tension_max"] = min(limits.tension_max, strongest_tension(servo))
    return limits.model_copy(update=changes) if changes else limits


def _stiffness(rod: RodSection) -> float:
    """Bending stiffness EI of the round backbone [N m^2]."""
    return rod.youngs_modulus * math.pi / 4.0 * rod.radius**4


def _arm(rod: RodSection) -> float:
    """Largest distance of a tendon from the axis [m]; the backbone's radius where all are on it."""
    return max(max(math.hypot(x, y) for x, y in rod.tendon_positions), rod.radius)
