"""Servo that winds a tendon, from its goal to the tendon's end: profile, position loop, backlash, resolution.

    p'' = a, -a or 0    v = p', |v| <= rate       trapezoidal profile towards the goal, replanned from where it is
    lag x' = p - x                                position loop and gears, of first order
    e = clip(e, x - backlash/2, x + backlash/2)   play of the gears (the play operator; Krejci 1996)
    v <= no_load (1 - load/stall)                 a motor's line of speed and load

A motor's voltage is the sum of what its torque and its speed take, so a load takes away speed, and at the stall torque
all of it. Both ends of the line are proportional to the voltage and to the duty (PWM) that the motor is allowed.

The goal is rounded to the resolution first. A profile of parts with constant acceleration has the exact solution
x = p - lag v + lag^2 a + c exp(-t/lag), so the result does not depend on the steps in which a duration is taken.
Source: ROBOTIS e-Manual, XL430-W250, "Profile Acceleration(108)", "Profile Velocity(112)", "Performance Graph".
"""

import math
from typing import NamedTuple

STALLED = 1e-9
"""Part of the speed without load at which a servo that its load stalls moves on: 0 stands for no limit."""


class ServoDynamics(NamedTuple):
    """Dynamics of a servo, in any unit of position; zeros: an ideal one.

    Attributes:
        rate: largest speed of its profile [unit/s]; 0: no limit.
        acceleration: acceleration of its profile [unit/s^2]; 0: no limit.
        lag: time constant of what follows the profile [s].
        backlash: travel that is lost when the direction changes [unit].
        resolution: smallest step of a goal [unit]; 0: none.
        stall: load at which it stands [N or N m]; 0: no load slows it down.
        no_load: speed without a load [unit/s], where there is a `stall`.
    """

    rate: float = 0.0
    acceleration: float = 0.0
    lag: float = 0.0
    backlash: float = 0.0
    resolution: float = 0.0
    stall: float = 0.0
    no_load: float = 0.0


class ServoState(NamedTuple):
    """State of a servo.

    Attributes:
        position, velocity: of the profile [unit, unit/s].
        shaft: position behind the lag [unit].
        end: position of the tendon's end, behind the backlash [unit].
    """

    position: float = 0.0
    velocity: float = 0.0
    shaft: float = 0.0
    end: float = 0.0


def at_rest(position: float) -> ServoState:
    """Return the state of a servo that has stood at `position` [unit]."""
    return ServoState(position, 0.0, position, position)


def available_rate(servo: ServoDynamics, load: float) -> float:
    """Return the speed [unit/s] that a servo has against a `load`; negative: a load that helps it."""
    if servo.stall <= 0.0:
        return math.inf
    return servo.no_load * max(0.0, 1.0 - load / servo.stall)


def _loaded(servo: ServoDynamics, load: float) -> ServoDynamics:
    """Return the servo with the speed that a load against it leaves."""
    if servo.stall <= 0.0:
        return servo
    able = max(available_rate(servo, load), STALLED * max(servo.no_load, STALLED))
    return servo._replace(rate=min(servo.rate, able) if servo.rate > 0.0 else able)


def advance(
    servo: ServoDynamics,
    state: ServoState,
    goal: float,
    duration: float,
    friction: float = 0.0,
    load: float = 0.0,
) -> ServoState:
    """Return the state after `duration` [s] of moving to `goal` [unit].

    Args:
        servo: its dynamics.
        state: before.
        goal: goal [unit].
        duration: [s].
        friction: half of a backlash that friction adds [unit].
        load: towards smaller positions, as a tendon pulls its spool [N or N m].
    """
    if servo.resolution > 0.0:
        goal = servo.resolution * round(goal / servo.resolution)
    servo = _loaded(servo, load if goal > state.shaft else -load)
    if servo.acceleration > 0.0:
        position, velocity, shaft = _trapezoid(servo, state, goal, duration)
    else:
        distance = goal - state.position
        reached = servo.rate <= 0.0 or abs(distance) <= servo.rate * duration
        position = goal if reached else state.position + math.copysign(servo.rate * duration, distance)
        velocity = (position - state.position) / duration
        shaft = position + _left(servo.lag, duration) * (state.shaft - position)
    play = 0.5 * servo.backlash + friction
    return ServoState(position, velocity, shaft, min(max(state.end, shaft - play), shaft + play))


def _left(lag: float, duration: float) -> float:
    """Return the fraction of a step that a lag leaves after `duration` [s]."""
    return math.exp(-duration / lag) if lag > 0.0 else 0.0


def _trapezoid(servo: ServoDynamics, state: ServoState, goal: float, duration: float) -> tuple[float, float, float]:
    """Return position, velocity and shaft after `duration` [s] of the fastest profile that ends at rest at the goal."""
    position, velocity, shaft = state.position, state.velocity, state.shaft
    fastest = servo.rate if servo.rate > 0.0 else math.inf
    left = duration
    for acceleration, wanted in _parts(position, velocity, goal, servo.acceleration, fastest):
        time = min(wanted, left)
        if time > 0.0:
            shaft = _followed(servo.lag, position, velocity, acceleration, shaft, time)
            position += (velocity + 0.5 * acceleration * time) * time
            velocity += acceleration * time
            left -= time
        if left <= 0.0:
            return position, velocity, shaft
    return goal, 0.0, _followed(servo.lag, goal, 0.0, 0.0, shaft, left)


def _parts(
    position: float, velocity: float, goal: float, limit: float, fastest: float
) -> tuple[tuple[float, float], ...]:
    """Return acceleration [unit/s^2] and duration [s] of the parts: speed up or turn, cruise, brake."""
    stop = position + 0.5 * velocity * abs(velocity) / limit  # where it would stand if it braked now
    sign = math.copysign(1.0, goal - stop)
    distance, along = sign * (goal - position), sign * velocity
    peak = min(math.sqrt(max(limit * distance + 0.5 * along * along, 0.0)), fastest)
    change = peak - along  # less than none where a lower rate applies than it has
    first = math.copysign(limit, change)
    travelled = (peak * peak - along * along) / (2.0 * first) + 0.5 * peak * peak / limit
    cruise = (distance - travelled) / peak if peak > 0.0 else 0.0
    return (sign * first, abs(change) / limit), (0.0, max(0.0, cruise)), (-sign * limit, peak / limit)


def _followed(lag: float, position: float, velocity: float, acceleration: float, shaft: float, time: float) -> float:
    """Return the shaft after `time` [s] behind a profile of constant acceleration; arguments are those at its start."""
    if lag <= 0.0:
        return position + (velocity + 0.5 * acceleration * time) * time
    settled = position - lag * velocity + lag * lag * acceleration
    later = position + (velocity + 0.5 * acceleration * time) * time
    return (
        later - lag * (velocity + acceleration * time) + lag * lag * acceleration
        + (shaft - settled) * math.exp(-time / lag)
    )  # fmt: skip


def braking_distance(servo: ServoDynamics, velocity: float) -> float:
    """Return the distance [unit], signed, by which the profile is behind a goal that moves with `velocity` [unit/s].

    A profile brakes before its goal, v^2/2a: behind a goal that keeps moving it stays where it can still stop at it.
    """
    if servo.acceleration <= 0.0:
        return 0.0
    bounded = min(abs(velocity), servo.rate) if servo.rate > 0.0 else abs(velocity)
    return math.copysign(0.5 * bounded * bounded / servo.acceleration, velocity)
