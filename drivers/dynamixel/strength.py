"""Largest load of a servo and output of its motor, from `limits.tension_max`. Reads no clock."""

import math

from tendond.drivers.dynamixel.serial.table import FULL_PWM
from tendond.schemas.config.servo import ServoSection
from tendond.schemas.motors import XL430_W250, Motor

GEAR_MARGIN = 0.1
"""Fraction of the motor's output for gear friction and acceleration, beyond load and speed. Not in the manual: an
emulated servo follows with 0; a real one that does not follow with 0.1 is a fault ('from its goal'), not a danger."""

SENSED_LOAD = 1.5
"""Multiple of `servo.pretension_load` below which a load cannot be distinguished from gear friction."""

PREDICTED_READINGS = 2.0
"""Readings by which a rising load is extrapolated: one is up to a period old, and the next one a period away."""

RANGE_LOAD = 0.5
"""Load at which a servo's sag is the distance by which a tendon may be outside its range: half of the stall torque,
between the largest loads for `limits.tension_max` of 20 and 60 N, 0.32 and 0.7. On a spool of 15 mm 2.0 mm."""

SPEED_LOAD = 2.0 / 3.0
"""Fraction of the largest load up to which a motor gets all the output for its speed: that of limits.tension_max at
the default servo.tension_margin."""


def load_limit(
    section: ServoSection, tension_max: float, spool_radius: float, full_torque: float | None = None
) -> float:
    """Return the largest load of a servo, as a fraction of its stall torque [-].

    Args:
        section: [servo].
        tension_max: limits.tension_max [N].
        spool_radius: spool radius of the tendon's spool [m].
        full_torque: torque that loads are fractions of, of a motor that is no Dynamixel [N m].
    """
    allowed = section.tension_margin * tension_max * spool_radius / (full_torque or section.motor.stall_torque)
    return min(section.load_max, max(allowed, SENSED_LOAD * section.pretension_load))


def sag(load: float, spool_radius: float, motor: Motor = XL430_W250) -> float:
    """Return the distance of a tendon at rest from its goal under a load [m].

    The position controller is proportional: at rest its output, which is the load, takes an error.

    Args:
        load: of the stall torque [-].
        spool_radius: spool radius of the tendon's spool [m].
        motor: of the servo; 'tendond servo setup' leaves its gains as they are.
    """
    return load * motor.full_error * spool_radius


def range_margin(spool_radius: float, motor: Motor = XL430_W250) -> float:
    """Return the distance by which a tendon may be outside its range, or from its zero when released [m]."""
    return sag(RANGE_LOAD, spool_radius, motor)


def arrival_distance(section: ServoSection, spool_radius: float) -> float:
    """Return the distance from its target at which a tendon that a tool moves has arrived [m].

    It is the sag under the largest load that a tool takes for none, and the gears' friction: 0.9 mm by default.
    """
    return sag(2.0 * section.pretension_load + GEAR_MARGIN, spool_radius, section.motor)


def speed_share(load: float, rise: float, limit: float) -> float:
    """Return the fraction of the output for speed that a motor gets under a load, 1 to 0.

    Output for speed becomes torque where a tendon is caught: it stops, and its motor pulls with all the output that it
    has. A load that approaches its limit therefore takes it away, and one that rises fast does so in advance: a tendon
    of 20 kN/m at 85 mm/s gains 17 N in 10 ms.

    Args:
        load: size of the newest load [-].
        rise: its increase since the last reading [-].
        limit: largest load [-].
    """
    predicted = load + PREDICTED_READINGS * max(rise, 0.0)
    return min(1.0, max(0.0, (limit - predicted) / ((1.0 - SPEED_LOAD) * limit)))


def current_bound(section: ServoSection, limit: float) -> float | None:
    """Return the current that a servo may take [A]; none where nothing limits it but the motor's output.

    A motor without a known stall torque (P series) can pull several times the torque that its loads are fractions of,
    and its Goal Current is what bounds it.

    Args:
        section: [servo].
        limit: largest load [-]; with a margin for the gears, so that a load above it is still seen.
    """
    motor = section.motor
    if not (section.current_limit or motor.continuous):
        return None
    needed = (limit + GEAR_MARGIN) * motor.stall_current
    return min(needed, section.current_limit or motor.current_max)


def goal_pwm(limit: float, spool_radius: float, rate: float, volts: float, motor: Motor = XL430_W250) -> int:
    """Return the Goal PWM [register units] with which a servo at a rate cannot pull much more than its limit.

    The voltage of a DC motor is the sum of shares for torque and speed:
    u / U = torque / stall torque + speed / no-load speed, both at U.

    Args:
        limit: largest load [-].
        spool_radius: spool radius of the tendon's spool [m].
        rate: at which the tendon is to move [m/s].
        volts: volts of the supply [V].
        motor: of the servo, one whose stall torque is known.
    """
    share = limit + GEAR_MARGIN + abs(rate) / spool_radius / motor.no_load_speed
    return min(FULL_PWM, math.ceil(FULL_PWM * share * motor.rated_volts / max(volts, 1.0)))
