"""Limits of a plan as rows of the quadratic program: tension, its rate, displacement, its rate."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.predictive.horizon import Horizon
from tendond.daemon.control.predictive.program import Rows
from tendond.daemon.control.predictive.rollout import Rollout

Array = NDArray[np.float64]

BACK_OFF = 0.02
"""Part of each displacement limit that is kept free: the limits are linearised, and what the command exceeds is cut."""

ROUNDING = 1e-9
"""Part of the tension's rate that is kept free, so that rounding does not count as a limit that was met."""


@dataclass(frozen=True)
class Bounds:
    """Bounds of a robot's tendons and backbone.

    Attributes:
        tension_min, tension_max: [N]. tension_rate: [N/s].
        displacement_min, displacement_max: [m]. displacement_rate: [m/s].
        lag_factor: fraction of a step remaining after a cycle of the actuators' lag [-].
    """

    tension_min: float
    tension_max: float
    tension_rate: float
    displacement_min: float
    displacement_max: float
    displacement_rate: float
    lag_factor: float


@dataclass(frozen=True)
class Applied:
    """What the actuators are at.

    Attributes:
        tension: applied [N], shape (m,). command: commanded last [N], shape (m,).
        displacement: [m], shape (m,).
    """

    tension: Array
    command: Array
    displacement: Array


def tension_bounds(bounds: Bounds, horizon: Horizon, applied: Applied) -> tuple[Array, Array]:
    """Return the smallest and the largest tension at each knot [N], shapes (B, m).

    At the first knot they are those that the coming command may be led to, with the actuators' lag.
    """
    shape = (horizon.knots, len(applied.tension))
    low, high = np.full(shape, bounds.tension_min), np.full(shape, bounds.tension_max)
    step, kept = (1.0 - ROUNDING) * bounds.tension_rate * horizon.period, bounds.lag_factor
    first_low = np.maximum(np.minimum(bounds.tension_min, applied.command + step), applied.command - step)
    first_high = np.minimum(bounds.tension_max, applied.command + step)
    low[0] = kept * applied.tension + (1.0 - kept) * first_low
    high[0] = kept * applied.tension + (1.0 - kept) * np.maximum(first_high, first_low)
    return low, high


def rate_rows(bounds: Bounds, horizon: Horizon, plan: Array) -> Rows:
    """Return the limits of the changes from one knot to the next."""
    knots, m = plan.shape
    count = (knots - 1) * m
    matrix = np.zeros((count, knots * m))
    index = np.arange(count)
    matrix[index, index], matrix[index, index + m] = -1.0, 1.0
    change = np.diff(plan, axis=0).ravel()
    step = np.repeat(bounds.tension_rate * horizon.room[1:], m)
    return Rows(matrix, -step - change, step - change)


def displacement_rows(bounds: Bounds, horizon: Horizon, rollout: Rollout, applied: Applied) -> list[Rows]:
    """Return the limits of displacement and of its rate, at the end of each step."""
    steps, m = rollout.displacement.shape
    by_plan = rollout.displacement_by_plan.reshape(steps * m, -1)
    place = rollout.displacement.ravel()
    keep = 1.0 - BACK_OFF
    value = Rows(by_plan, keep * bounds.displacement_min - place, keep * bounds.displacement_max - place)
    before = np.concatenate((applied.displacement[None], rollout.displacement[:-1])).ravel()
    first = np.zeros((m, by_plan.shape[1]))
    by_change = by_plan - np.concatenate((first, by_plan[:-m]))
    step = keep * bounds.displacement_rate * np.repeat(horizon.lengths, m)
    change = place - before
    return [value, Rows(by_change, -step - change, step - change)]


def reachable(rows: Rows, low: Array, high: Array) -> Rows:
    """Return those rows that the bounds of v alone do not keep."""
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    centre, spread = rows.matrix @ middle, np.abs(rows.matrix) @ half
    kept = (centre + spread > rows.upper) | (centre - spread < rows.lower)
    return Rows(rows.matrix[kept], rows.lower[kept], rows.upper[kept], rows.soft)
