"""Limits that suit a robot and its servos, for a configuration that sets none, and what the servos cannot meet."""

import math

from tendond.schemas.config.control import LimitsSection
from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.motors import RPM

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


def fastest_rate(section: ServoSection) -> float:
    """Largest rate of a tendon that the servos can reach [m/s]: their own limit, their profile, the motor's speed."""
    return min(
        section.displacement_rate, min(section.profile_velocity, section.motor.no_load_speed) * section.spool_radius
    )


def strongest_tension(section: ServoSection) -> float:
    """Largest tension that the servos may pull with [N]."""
    motor = section.motor
    torque = section.load_max * motor.stall_torque
    if section.current_limit:
        torque = min(torque, section.current_limit * motor.torque_constant)
    return torque / section.spool_radius


def _strength(section: ServoSection) -> str:
    """Return what bounds the servos' torque, in words."""
    motor = section.motor
    kind = "continuous" if motor.continuous else "stall"
    current = f", and {section.current_limit:g} A of servo.current_limit" if section.current_limit else ""
    return f"{motor.stall_torque:g} N m {kind} torque, servo.load_max of it{current}"


def speed_line(section: ServoSection | None, volts: float) -> tuple[float, float]:
    """Return the tension at which a servo stands [N], and its tendon's speed without load [m/s], at a voltage [V].

    Both are proportional to the voltage (ROBOTIS e-Manual, XL430-W250, Performance Graph); zeros for 0 V, no limit.
    """
    section = section or ServoSection()
    radius, motor = section.spool_radius, section.motor
    share = volts / motor.rated_volts
    return motor.torque_max * share / radius, motor.no_load_speed * share * radius


def servo_objections(
    section: ServoSection,
    tendons: int,
    tension_max: float,
    displacement_rate: float,
    displacement_min: float,
    displacement_max: float,
) -> list[str]:
    """Name the controller's limits that the servos cannot meet, one line each.

    Args:
        section: [servo].
        tendons: tendons of the rod.
        tension_max: that of [limits] [N].
        displacement_rate: displacement rate of [limits] [m/s].
        displacement_min: displacement min of [limits] [m].
        displacement_max: displacement max of [limits] [m].
    """
    objections = []
    if section.ids and len(section.ids) != tendons:
        objections.append(f"servo.ids has {len(section.ids)} servos, rod.tendon_positions {tendons} tendons")
    strongest = strongest_tension(section)
    if tension_max > strongest:
        objections.append(
            f"limits.tension_max = {tension_max:g} N is more than the servos may pull: {_strength(section)}, on"
            f" servo.spool_radius make {strongest:.1f} N"
        )
    fastest = fastest_rate(section)
    if displacement_rate > fastest * (1.0 + 1e-9):
        rpm = section.motor.no_load_speed / RPM
        objections.append(
            f"limits.displacement_rate = {displacement_rate:g} m/s is faster than the servos: {fastest:.4g} m/s by"
            f" servo.displacement_rate, servo.profile_velocity and the manual's {rpm:.3g} rpm on"
            " servo.spool_radius"
        )
    for name, limit, own, outside in (
        ("min", displacement_min, section.displacement_min, displacement_min < section.displacement_min),
        ("max", displacement_max, section.displacement_max, displacement_max > section.displacement_max),
    ):
        if outside:
            objections.append(
                f"limits.displacement_{name} = {limit:g} m is outside servo.displacement_{name} = {own:g} m:"
                " the servo driver would take it for a fault"
            )
    return objections
