"""Fit of a servo's dynamics to its own steps: dead time, speed, acceleration and lag by least squares."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from tendond.model.tendons.servo import ServoDynamics, advance, at_rest

Array = NDArray[np.float64]

START = (0.005, 0.02)
"""Dead time and lag from which the fit begins [s]."""

SMALLEST = 1e-5
"""Lower bound of dead time and lag [s], as the fit is by their logarithms."""


@dataclass(frozen=True)
class StepResponse:
    """A step of a servo.

    Attributes:
        start, goal: position at rest before, and the goal [m].
        time: since the goal was sent [s], shape (k,). position: then [m], shape (k,).
    """

    start: float
    goal: float
    time: Array
    position: Array


@dataclass(frozen=True)
class ServoFit:
    """Dynamics that fit steps best.

    Attributes:
        servo: rate [m/s], acceleration [m/s^2] and lag [s]; without backlash and resolution.
        dead_time: from sending a goal to the beginning of the motion [s].
        error: standard error of dead time [s], rate [m/s], acceleration [m/s^2] and lag [s].
        residual: root mean square of what is left [m].
    """

    servo: ServoDynamics
    dead_time: float
    error: tuple[float, float, float, float]
    residual: float


def fit_steps(steps: Sequence[StepResponse], rate: float, acceleration: float) -> ServoFit:
    """Fit a trapezoidal profile with dead time and lag to steps.

    Args:
        steps: of one servo; at least one has to be long enough for it to reach its rate.
        rate, acceleration: those of its profile, from which the fit begins [m/s, m/s^2].

    Raises:
        ValueError: there are fewer than eight readings.
    """
    count = sum(len(step.time) for step in steps)
    if count < 8:
        raise ValueError(f"{count} readings are too few to fit four parameters: 8 at least")

    def residuals(logarithms: Array) -> Array:
        dead_time, *dynamics = np.exp(logarithms).tolist()
        return np.concatenate([_position(step, dead_time, ServoDynamics(*dynamics)) - step.position for step in steps])

    first = np.log([START[0], rate, acceleration, START[1]])
    low = np.log([SMALLEST, 0.1 * rate, 0.1 * acceleration, SMALLEST])
    high = np.log([0.2, 10.0 * rate, 10.0 * acceleration, 0.5])
    found = least_squares(residuals, first, bounds=(low, high), x_scale=0.1)
    values, slope = np.exp(found.x), np.asarray(found.jac, dtype=np.float64)
    variance = 2.0 * found.cost / max(1, count - 4)
    errors = values * np.sqrt(np.diag(np.linalg.pinv(slope.T @ slope)) * variance)
    dead_time, fastest, fitted, lag = values.tolist()
    one, two, three, four = errors.tolist()
    residual = float(np.sqrt(np.mean(found.fun**2)))
    return ServoFit(ServoDynamics(fastest, fitted, lag), dead_time, (one, two, three, four), residual)


def _position(step: StepResponse, dead_time: float, servo: ServoDynamics) -> Array:
    """Return the shaft's position at the times of a step [m], shape (k,)."""
    rest = at_rest(step.start)
    times = (step.time - dead_time).tolist()
    return np.array([advance(servo, rest, step.goal, time).shaft if time > 0.0 else step.start for time in times])
