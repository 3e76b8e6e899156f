"""Servo from goal to motion, against closed forms: trapezoidal profile, first-order lag behind a ramp, play."""

import math

import numpy as np
import pytest

from tendond.model.tendons.servo import ServoDynamics, ServoState, advance, at_rest, braking_distance

XL430 = ServoDynamics(rate=0.085, acceleration=3.0, lag=0.02)


def moved(servo: ServoDynamics, goals: list[float], step: float, parts: int = 1) -> list[ServoState]:
    """States of a servo from rest at zero, a goal each `step`, which is taken in `parts`."""
    states = [at_rest(0.0)]
    for goal in goals:
        state = states[-1]
        for _ in range(parts):
            state = advance(servo, state, goal, step / parts)
        states.append(state)
    return states[1:]


@pytest.mark.parametrize("servo", [XL430, XL430._replace(rate=0.0), XL430._replace(lag=0.0)])
def test_a_motion_does_not_depend_on_the_steps_in_which_it_is_taken(servo: ServoDynamics) -> None:
    goals = (0.004 * np.cumsum(np.random.default_rng(1).uniform(-1.0, 1.0, 300))).tolist()
    whole, parted = moved(servo, goals, 0.01), moved(servo, goals, 0.01, parts=7)
    np.testing.assert_allclose(whole, parted, atol=1e-10)
    assert np.ptp([state.end for state in whole]) > 0.01


def test_a_profile_takes_the_time_of_a_trapezoid_and_of_a_triangle() -> None:
    servo = XL430._replace(lag=0.0)
    for distance in (0.03, 0.001):
        peak = min(servo.rate, math.sqrt(servo.acceleration * distance))
        duration = distance / peak + peak / servo.acceleration
        almost = advance(servo, at_rest(0.0), distance, 0.999 * duration)
        there = advance(servo, at_rest(0.0), distance, 1.001 * duration)
        half = advance(servo, at_rest(0.0), distance, 0.5 * duration)
        assert 0.0 < distance - almost.position < 1e-5
        assert (there.position, there.velocity) == (distance, 0.0)
        assert half.position == pytest.approx(0.5 * distance)
        assert half.velocity == pytest.approx(peak)


def test_a_profile_that_is_turned_back_in_full_motion_brakes_first() -> None:
    servo = XL430._replace(lag=0.0)
    running = advance(servo, at_rest(0.0), 0.03, 0.1)
    turned = advance(servo, running, 0.0, 0.085 / 3.0)
    assert running.velocity == pytest.approx(0.085)
    assert turned.velocity == pytest.approx(0.0, abs=1e-12)
    assert turned.position - running.position == pytest.approx(0.085**2 / (2.0 * 3.0))


def test_behind_a_goal_that_moves_the_profile_is_its_braking_distance_and_the_shaft_a_time_constant() -> None:
    speed, step = 0.06, 1e-4
    state = moved(XL430, [speed * step * k for k in range(1, 5001)], step)[-1]
    behind = braking_distance(XL430, speed)
    assert behind == pytest.approx(speed**2 / (2.0 * 3.0))
    assert 0.5 * speed - state.position == pytest.approx(behind, rel=0.01)
    assert state.position - state.shaft == pytest.approx(speed * 0.02, rel=1e-3)
    assert braking_distance(XL430, -speed) == -behind
    assert braking_distance(XL430, 1.0) == braking_distance(XL430, XL430.rate)
    assert braking_distance(ServoDynamics(lag=0.02), speed) == 0.0


def test_without_a_profile_a_step_leaves_the_fraction_of_a_first_order_lag() -> None:
    servo = ServoDynamics(lag=0.05)
    ends = [state.end for state in moved(servo, [0.01] * 5, 0.01)]
    assert ends == pytest.approx([0.01 * (1.0 - math.exp(-0.2 * k)) for k in range(1, 6)])


def test_the_end_stays_within_the_play_and_a_goal_is_rounded() -> None:
    servo = ServoDynamics(backlash=1e-3, resolution=2e-4)
    ends = [state.end for state in moved(servo, [0.01009, 0.0095, 0.008], 0.01)]
    assert ends == pytest.approx([0.0095, 0.0095, 0.0085])
