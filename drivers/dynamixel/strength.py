"""How hard a servo may pull: its load, and the output of its motor, from `limits.tension_max`. Reads no clock."""

import math

from tendond.drivers.dynamixel.serial.table import FULL_PWM
from tendond.schemas.config.servo import NO_LOAD_SPEED, STALL_TORQUE, ServoSection

RATED_VOLTS = 11.1
"""At which the manual gives stall torque and speed; both grow in proportion to the voltage."""

GEARS = 0.1
"""Of the motor's output, for gears and for speeding up, beside load and speed. No figure of the manual's: an emulated
servo follows with 0; a real one that does not follow with 0.1 is a fault ('behind its goal'), not a danger."""

SENSE = 1.5
"""Times `servo.pretension_load`, below which a load is not told from the gears' friction."""


def load_limit(section: ServoSection, tension_max: float, spool_radius: float) -> float:
    """Load that a servo may have, of its stall torque [-].

    Args:
        section: [servo].
        tension_max: of [limits] [N].
        spool_radius: of the tendon's spool [m].
    """
    allowed = section.tension_margin * tension_max * spool_radius / STALL_TORQUE
    return min(section.load_max, max(allowed, SENSE * section.pretension_load))


def goal_pwm(limit: float, spool_radius: float, rate: float, volts: float) -> int:
    """Goal PWM with which a servo at that rate cannot pull much more than its limit [units of the register].

    A motor's voltage is shared by torque and speed: u / U = torque / stall torque + speed / no-load speed, both at U.

    Args:
        limit: load that it may have [-].
        spool_radius: of the tendon's spool [m].
        rate: at which the tendon is to move [m/s].
        volts: of the supply [V].
    """
    share = limit + GEARS + abs(rate) / spool_radius / NO_LOAD_SPEED
    return min(FULL_PWM, math.ceil(FULL_PWM * share * RATED_VOLTS / max(volts, 1.0)))
