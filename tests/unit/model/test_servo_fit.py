"""Fit of a servo to its steps: the dynamics that made them come out, within their standard errors."""

import numpy as np
import pytest

from tendond.model.tendons.servo import ServoDynamics, advance, at_rest
from tendond.model.tendons.servo_fit import StepResponse, fit_steps

DEAD_TIME = 0.007
TRUE = ServoDynamics(rate=0.07, acceleration=2.0, lag=0.03)
TICK = 2.3e-5


def response(start: float, goal: float, seed: int) -> StepResponse:
    """Readings of a servo about every 2 ms, in whole ticks."""
    times = np.sort(np.random.default_rng(seed).uniform(0.0, 0.4, 200))
    moved = [advance(TRUE, at_rest(start), goal, max(time - DEAD_TIME, 1e-9)).shaft for time in times.tolist()]
    return StepResponse(start, goal, times, TICK * np.round(np.array(moved) / TICK))


def test_the_dynamics_that_made_the_steps_are_found() -> None:
    fit = fit_steps([response(0.0, -0.006, 1), response(-0.006, 0.0, 2)], rate=0.085, acceleration=3.0)
    found = (fit.dead_time, fit.servo.rate, fit.servo.acceleration, fit.servo.lag)
    for value, true, error in zip(found, (DEAD_TIME, *TRUE[:3]), fit.error, strict=True):
        assert value == pytest.approx(true, abs=4.0 * error)
        assert error < 0.05 * true
    assert fit.residual < 0.5 * TICK


def test_too_few_readings_are_refused() -> None:
    step = response(0.0, -0.006, 1)
    few = StepResponse(step.start, step.goal, step.time[:7], step.position[:7])
    with pytest.raises(ValueError, match="7 readings are too few"):
        fit_steps([few], 0.085, 3.0)
