"""Predictive control: the plan of tensions that is best along a horizon, of which the first cycle is applied.

With u the tensions at B knots, p_k(u) the tip after step k of the model (`predictive.rollout`), r_k the reference then,

    minimise  sum_k w_k |r_k - d_k - p_k(u)|^2 / L^2  +  effort sum_j |u_j - u_(j-1)|^2 / T^2
              + slack sum_j |N (u_j - u_min)|^2 / T^2        within the limits of `predictive.limits`

by one step of Gauss-Newton's method a cycle, from the last plan, shifted (real-time iteration: M. Diehl, H. G. Bock,
J. P. Schlöder, SIAM J. Control Optim. 43, 2005). d_k is the error that is left on purpose: it decays from the present
one at a rate, so that the observer keeps its margin. N projects on changes of tension
that do not move the tip at the horizon's end: of all plans that are as good, the one of least tension. L is the robot's
length, T its EI/(L r). What a plan does at rest is free of offset but for the price of slack, as the observer's loads
are in the model, and else only changes of the tensions have a price. docs/explanation/mpc.md derives it.
"""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from tendond.daemon.control.laws.law import GAIN_RATE, Convergence, Decision, LawTerms, StatefulLaw
from tendond.daemon.control.predictive import program
from tendond.daemon.control.predictive.limits import (
    displacement_rows,
    rate_rows,
    reachable,
    tension_bounds,
)
from tendond.daemon.control.predictive.program import Solution
from tendond.daemon.control.predictive.rollout import Rollout
from tendond.daemon.control.tasks.horizon import HorizonKeys, HorizonObservation, HorizonSpace
from tendond.model.errors import ConvergenceError
from tendond.schemas.base import Vector3
from tendond.schemas.config.tunable import tunable

Array = NDArray[np.float64]

RIDGE = 1e-9
"""Added to the scaled Hessian, so that there is one solution. Chosen, far below the price of any change."""

SETTING_IN = 100.0
"""Rate at which the decay of an error sets in [1/s]: that of the law `sensitivity`, with whose margin this one runs."""

REDUNDANT = 0.005
"""Response of the tip, of its largest one, below which a combination of tensions counts as redundant. Chosen."""


AVOIDING = 0.15
"""Largest `trust` with limits of the body: with 1 a plan swung from one side of a sphere to the other, and met it."""


class Parameters(HorizonKeys):
    """horizon: its length [s]. steps, knots: largest numbers of the model's steps, and of a plan's knots, between which
    the tensions are linear. avoid: plan round the constraints of [safety], with a `trust` of at most `AVOIDING`.

    rate: at which the error decays [1/s]. effort: price of changing tensions [-]. slack: price of tension that does not
    move the tip [-]. trust: largest change of a plan in a cycle, of EI/(L r) [-]. budget: largest number of the
    solver's iterations in a cycle.
    """

    rate: Annotated[float, Field(gt=0.0, le=1e4, json_schema_extra=tunable(GAIN_RATE))] = 10.0
    effort: Annotated[float, Field(ge=0.0, le=1.0)] = 1e-5
    slack: Annotated[float, Field(ge=0.0, le=1.0)] = 1e-6
    trust: Annotated[float, Field(gt=0.0, le=100.0)] = 1.0
    budget: Annotated[int, Field(ge=1, le=100_000)] = 300


@dataclass(frozen=True)
class Terms(LawTerms):
    """error: e, its first three numbers [m]. predicted: tip at the horizon's end under the plan [m].

    cost: of the plan. iterations: of the solver. active: limits that the plan meets. relaxed: 1 if limits contradicted
    each other. shifted: 1 if the last plan was used, as there was no solution within the budget.
    """

    error: Vector3
    predicted: Vector3
    cost: float
    iterations: float
    active: float
    relaxed: float
    shifted: float


@dataclass(frozen=True)
class Plan:
    """tension: at the knots [N], shape (B, m); empty before the first cycle."""

    tension: Array = field(default_factory=lambda: np.zeros((0, 0)))


def decide(parameters: Parameters, observation: HorizonObservation, state: Plan) -> Decision:
    """Return the tensions wanted, the terms and the plan."""
    horizon, applied = observation.predictor.horizon, observation.applied
    shape = (horizon.knots, len(applied.tension))
    plan = horizon.shifted(state.tension) if state.tension.shape == shape else np.tile(applied.tension, (shape[0], 1))
    low, high = tension_bounds(observation.bounds, horizon, applied)
    plan = np.minimum(np.maximum(plan, low), high)
    error = observation.target - observation.place
    try:
        rollout = observation.roll(plan)
    except ConvergenceError:  # the plan leads beyond the model: hold
        return _decision(np.tile(applied.tension, (shape[0], 1)), error, observation.situation.tip.position, None)
    solution = _improve(parameters, observation, plan, rollout, error)
    after = np.minimum(np.maximum(plan + solution.change.reshape(shape), low), high)  # within the solver's tolerance
    predicted = rollout.position[-1] + observation.beside + rollout.by_plan[-1] @ solution.change
    return _decision(after, error, predicted, solution)


def _decision(plan: Array, error: Array, predicted: Array, solution: Solution | None) -> Decision:
    x, y, z = [*error.tolist(), 0.0][:3]
    u, v, w = predicted.tolist()
    terms = Terms(
        error=(x, y, z),
        predicted=(u, v, w),
        cost=0.0 if solution is None else solution.cost,
        iterations=0.0 if solution is None else float(solution.iterations),
        active=0.0 if solution is None else float(solution.active),
        relaxed=float(solution is not None and solution.relaxed),
        shifted=float(solution is None or not solution.found),
    )
    return Decision(plan[0].copy(), terms, Plan(plan))


def _improve(
    parameters: Parameters, observation: HorizonObservation, plan: Array, rollout: Rollout, error: Array
) -> Solution:
    """Return the change of the plan, by the quadratic program about it."""
    horizon, bounds, applied = observation.predictor.horizon, observation.bounds, observation.applied
    places, by_plan = observation.along(rollout)
    missing = observation.targets - places - _left(parameters, horizon.ends, error)
    weight = horizon.lengths / horizon.ends[-1] / observation.length**2
    flat = by_plan.reshape(-1, by_plan.shape[-1])
    weighted = flat * np.repeat(weight, missing.shape[1])[:, None]
    hessian = weighted.T @ flat
    gradient = -(weighted.T @ missing.ravel())
    _add_effort(parameters, observation, plan, by_plan[-1], hessian, gradient)
    low, high = tension_bounds(bounds, horizon, applied)
    trust = parameters.trust if observation.body is None else min(parameters.trust, AVOIDING)
    trust *= observation.tension_unit
    lower = np.maximum(low - plan, -trust).ravel()
    upper = np.maximum(np.minimum(high - plan, trust).ravel(), lower)
    rows = [rate_rows(bounds, horizon, plan), *displacement_rows(bounds, horizon, rollout, applied)]
    if observation.body is not None:
        rows += observation.body.rows(horizon, rollout, plan, applied.tension, observation.shift)
    kept = [one for one in (reachable(row, lower, upper) for row in rows) if len(one.upper)]
    return program.solve(hessian, gradient, lower, upper, kept, parameters.budget)


def _left(parameters: Parameters, times: Array, error: Array) -> Array:
    """Return the error that is left at times [s], shape (N, r)."""
    return np.exp(-parameters.rate * times)[:, None] * error


def _add_effort(
    parameters: Parameters,
    observation: HorizonObservation,
    plan: Array,
    last: Array,
    hessian: Array,
    gradient: Array,
) -> None:
    """Add the prices of changing tensions, and of tensions that do not move the tip."""
    knots, m = plan.shape
    horizon, unit = observation.predictor.horizon, observation.tension_unit
    price = parameters.effort / unit**2 * horizon.ends[-1] / knots / horizon.room
    change = np.diff(plan, axis=0, prepend=observation.applied.tension[None])
    total = last.reshape(len(last), knots, m).sum(axis=1)
    _, sizes, rows = np.linalg.svd(total)
    moving = rows[: len(sizes)][sizes > REDUNDANT * max(float(sizes[0]), 1e-12)]
    redundant = np.eye(m) - moving.T @ moving
    idle = parameters.slack / unit**2 / knots
    excess = (plan - observation.bounds.tension_min) @ redundant
    for j in range(knots):
        one = slice(j * m, (j + 1) * m)
        hessian[one, one] += price[j] * np.eye(m) + idle * redundant + RIDGE / unit**2 * np.eye(m)
        gradient[one] += price[j] * change[j] + idle * excess[j]
        if j > 0:
            past = slice((j - 1) * m, j * m)
            hessian[past, past] += price[j] * np.eye(m)
            hessian[one, past] -= price[j] * np.eye(m)
            hessian[past, one] -= price[j] * np.eye(m)
            gradient[past] -= price[j] * change[j]


def rates(parameters: Parameters) -> Convergence:
    """Return the rate of the error's decay, which a plan does not exceed, and that at which it sets in."""
    return Convergence(parameters.rate, SETTING_IN)


LAW = StatefulLaw("mpc", Parameters, Plan, decide, HorizonSpace("mpc"), rates=rates)
