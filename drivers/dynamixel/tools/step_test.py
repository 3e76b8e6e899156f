"""Step test of a servo with a slack tendon: it pays out and returns, at the configured profile, and its motion is read.

The tendon never goes beyond where it stood: only slack is made and taken up again. The servo is monitored as in
operation, and its torque is off afterwards.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from tendond.drivers.dynamixel.checks import profile_units
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.bus import ServoBus, ServoError
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.strength import goal_pwm, load_limit
from tendond.drivers.dynamixel.tools.motion import ServoMotion, energised
from tendond.model.tendons.servo_fit import StepResponse
from tendond.schemas.config.servo import ServoSection

SEQUENCE = (-0.5, -1.0, -0.5, 0.0, -1.0, 0.0)
"""Goals of the test, of its travel, from where the tendon stands: half of the travel is reached from both sides."""

STEP_SECONDS = 0.4
"""Time for which each step is read [s]: a servo with a lag of 50 ms that travels 6 mm at 85 mm/s is within 1 % then."""


@dataclass(frozen=True)
class StepTest:
    """steps: of the servo. hysteresis: difference of where it rests at one goal, reached from both sides [m]."""

    steps: tuple[StepResponse, ...]
    hysteresis: float


def step_test(
    bus: ServoBus,
    section: ServoSection,
    spool: Spool,
    tension_max: float,
    travel: float,
    stopped: Callable[[], bool] = lambda: False,
) -> StepTest:
    """Pay out a tendon by `travel` [m] and return, in steps; its servo is off afterwards.

    Args:
        bus: open.
        section: [servo]; its profile is tested.
        spool: spool of the tendon.
        tension_max: limits.tension_max [N].
        travel: largest distance from where it stands [m].
        stopped: true when the operator interrupts it.

    Raises:
        ServoError: the tendon pulls or leaves its range, an error of the servo, or it was interrupted.
    """
    servo = spool.calibration.servo
    if not 0.0 < travel < section.following_error:
        raise ServoError(
            f"servo {servo}: a travel of {travel * 1e3:g} mm is beyond servo.following_error,"
            f" {section.following_error * 1e3:g} mm: choose a shorter one"
        )
    if bus.read(servo, table.TORQUE_ENABLE):
        raise ServoError(f"servo {servo}: holds its tendon: stop the driver, and run 'tendond servo home'")
    with energised(bus, section, spool, tension_max) as motion:
        motion.rest()
        start = motion.displacement
        if motion.load >= section.pretension_load:
            raise ServoError(f"servo {servo}: its tendon pulls (load {motion.load:.0%}): slacken it")
        if not section.displacement_min <= start - travel:
            raise ServoError(f"servo {servo}: {(start - travel) * 1e3:.1f} mm are beyond servo.displacement_min")
        _set_profile(bus, section, motion, load_limit(section, tension_max, spool.calibration.spool_radius))
        steps = []
        for part in SEQUENCE:
            steps.append(_step(bus, motion, start + part * travel, stopped))
    above, below = steps[0].position[-1], steps[2].position[-1]
    return StepTest(tuple(steps), abs(float(above - below)))


def _set_profile(bus: ServoBus, section: ServoSection, motion: ServoMotion, limit: float) -> None:
    """Write the profile of operation, and the motor output that it needs."""
    speed, acceleration = profile_units(bus.model, section)
    radius, volts = motion.spool.calibration.spool_radius, motion.latest.voltage * table.VOLTAGE_UNIT
    bus.write(motion.id, table.PROFILE_VELOCITY, speed)
    bus.write(motion.id, table.PROFILE_ACCELERATION, acceleration)
    if not section.motor.continuous:
        pwm = goal_pwm(limit, radius, section.profile_velocity * radius, volts, section.motor)
        bus.write(motion.id, table.GOAL_PWM, pwm)


def _step(bus: ServoBus, motion: ServoMotion, goal: float, stopped: Callable[[], bool]) -> StepResponse:
    """Send a goal [m] and read the servo until it has moved there, as fast as it replies."""
    start, times, positions = motion.displacement, [], []
    ticks = motion.spool.ticks(goal)
    sent = time.monotonic()
    bus.write_all(table.GOAL_POSITION, {motion.id: ticks})
    while (asked := time.monotonic()) - sent < STEP_SECONDS:
        if stopped():
            raise ServoError(f"servo {motion.id}: stopped")
        if motion.look():
            times.append(0.5 * (asked + time.monotonic()) - sent)
            positions.append(motion.displacement)
            motion.judge(goal)
    if not positions:
        raise ServoError(f"servo {motion.id}: no reply within {STEP_SECONDS:g} s")
    return StepResponse(start, motion.spool.displacement(ticks), np.array(times), np.array(positions))
