"""Feed-forward of the servos: the command with which the tendons' ends are where they should be a cycle later.

Parts of `model.tendons.servo`, inverted one by one: the distance by which a profile stays behind a goal that moves, and
the gears' play. Both are functions of the wanted motion alone, not of an estimate of the servo: one that accelerates
slowly, driven by its own inverse, swings between its limits. A lag is best given as `observer.command_delay`: the model
is ahead of the plant by it, and so is the reference; inverted, as by `actuation.lead`, it multiplies the camera's noise
in the command by 1/(1 - exp(-period/lag)). The result is still to be limited by `actuation.limit_displacement`.

Where the tendon turns, the command first stands still for `QUIET` of the play, which is more than the noise of a tendon
at rest, and then moves 1 + `PLAY_SLOPE` times as far as the tendon until the gears engage: a servo at rest stands, and
the rate is bounded (cf. Tao & Kokotovic, Adaptive Control of Systems with Actuator and Sensor Nonlinearities, 1996,
whose inverse of a backlash jumps).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.tendons.servo import ServoDynamics, available_rate, braking_distance
from tendond.schemas.config.rates import speed_line
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]

PLAY_SLOPE = 2.0
"""Motion that fills the play, of the wanted one [-]: with 4, the command of a circle jerks by a quarter more, and the
error is the same (`tendond study servo`)."""

QUIET = 0.1
"""Half of the motion to and fro that counts as rest, of the play [-]: 6.5 um of 65 um, where 0.1 mm of a camera's noise
moves a bent tendon by 2 um. With 0 the servos reverse five times a second at rest (`tendond bench profiles`)."""

SMOOTHING = 0.03
"""Time constant of the velocity by which a profile brakes [s]: with 0 the command's jerks at rest are a third larger
(`tendond bench profiles`), with 0.1 a circle of 2 s is followed three times as badly."""


@dataclass(frozen=True)
class ServoMotion:
    """Wanted motion of the tendons, each of shape (n,).

    Attributes:
        wanted: displacement that was wanted of the tendons' ends [m].
        velocity: its derivative, smoothed [m/s].
        turned: the same without what moves to and fro by less than `QUIET` of the play [m].
        play: part of the command that fills the gears' play [m].
    """

    wanted: Array
    velocity: Array
    turned: Array
    play: Array


def configured_servo(config: RigConfig) -> ServoDynamics | None:
    """Return the servos of a configuration; none where neither profile, play nor voltage are given."""
    section = config.observer
    if not (section.servo_acceleration or section.backlash or section.servo_voltage):
        return None
    rate, (stall, no_load) = config.limits.displacement_rate, speed_line(config.servo, section.servo_voltage)
    return ServoDynamics(rate, section.servo_acceleration, section.lag, section.backlash, 0.0, stall, no_load)


def pulling_rates(servo: ServoDynamics | None, tension: Array) -> Array | None:
    """Return the speeds at which servos can pull against tensions [N], shape (n,): [m/s]; none where no load counts."""
    if servo is None or servo.stall <= 0.0:
        return None
    return np.array([available_rate(servo, one) for one in tension.tolist()])


def servos_at(displacement: Array) -> ServoMotion:
    """Return the motion of tendons that rest at `displacement` [m], shape (n,)."""
    zeros = np.zeros_like(displacement)
    return ServoMotion(displacement, zeros, displacement, zeros)


def compensate(servo: ServoDynamics, motion: ServoMotion, wanted: Array, period: float) -> tuple[Array, ServoMotion]:
    """Return what the command leads the shafts by [m], shape (n,), for `wanted` a cycle later, and the new motion.

    Args:
        servo: dynamics.
        motion: after the last cycle.
        wanted: displacement of the ends [m], shape (n,).
        period: of the cycle [s].
    """
    quiet = QUIET * servo.backlash
    half = 0.5 * servo.backlash + quiet
    turned = np.clip(motion.turned, wanted - quiet, wanted + quiet)
    play = np.clip(motion.play + PLAY_SLOPE * (turned - motion.turned), -half, half)
    blend = period / (period + SMOOTHING)
    velocity = motion.velocity + blend * ((wanted - motion.wanted) / period - motion.velocity)
    braking = [braking_distance(servo, one) for one in velocity.tolist()]
    return turned - wanted + play + np.array(braking), ServoMotion(wanted, velocity, turned, play)
