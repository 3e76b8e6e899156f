"""The fit: nonlinear least squares on the differences of model and measurement."""

from dataclasses import dataclass
from functools import partial
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, least_squares

from tendond.daemon.errors import DaemonError
from tendond.offline.identification.fitting.evaluations import EvaluationCache
from tendond.offline.identification.fitting.problem import FitProblem
from tendond.offline.identification.parameter import Parameter, bounds

Array = NDArray[np.float64]


TOLERANCE = 1e-6
"""Relative tolerance of the coordinates and of the sum of squares."""


MAX_EVALUATIONS = 40


FINER_ROUNDS = 2
"""Gauss-Newton rounds with half the time step and the whole step's derivatives: they remove the step's own error."""


REMAINING = 1.0 / 3.0
"""Remaining error of a second-order scheme, as a fraction of the change on halving the step (Richardson)."""


Loss = Literal["linear", "soft_l1", "huber"]


LOSSES = get_args(Loss)


OUTLIER = 3.0
"""Residual, in standard deviations, above which a robust loss reduces the weight."""


class FitError(DaemonError):
    """Error of a fit without a result."""


@dataclass(frozen=True)
class FitResult:
    """Result of a fit.

    Attributes:
        parameters: the fitted parameters.
        values: values of all parameters, by name.
        coordinates: coordinates of the fitted ones, shape (p,).
        residuals: each recording's blocks, see `Simulation.residuals`, in metres.
        jacobian: derivatives of the flat residuals by the coordinates, shape (r, p).
        weights: weight of each residual by the loss, shape (r,); ones where it is linear.
        remaining: remaining error of each coordinate by the time step, shape (p,).
        evaluations: evaluations of the residuals.
        bounded: names of parameters that ended at a bound.
        prior_scale: residual that counts as one sigma of a prior [m], see `FitProblem`.
    """

    parameters: tuple[Parameter, ...]
    values: dict[str, float]
    coordinates: Array
    residuals: list[list[Array]]
    jacobian: Array
    weights: Array
    remaining: Array
    evaluations: int
    bounded: tuple[str, ...]
    prior_scale: float = 0.0


def fit(
    problem: FitProblem, cache: EvaluationCache, loss: Loss = "linear", noise: float = 1e-4, first: Array | None = None
) -> FitResult:
    """Fit the problem's parameters by least squares.

    Args:
        problem: the problem.
        cache: cache of evaluations.
        loss: one of `LOSSES`.
        noise: noise of the poses [m], which scales a robust loss.
        first: coordinates to start from, shape (p,); none: the problem's start.

    Raises:
        SimulationError: the rod has no solution at the start.
        FitError: no result.
    """
    if not problem.parameters:
        return refine(
            problem.finer(), np.zeros(0), np.zeros((problem.residuals(np.zeros(0)).size, 0)), cache, loss, noise
        )
    found = minimum(problem, cache, loss, noise, first)
    derivatives = cache.get("jacobian", found.x, partial(problem.jacobian, found.x))
    return refine(problem.finer(), found.x, derivatives, cache, loss, noise, int(found.nfev))


def minimum(
    problem: FitProblem,
    cache: EvaluationCache | None = None,
    loss: Loss = "linear",
    noise: float = 1e-4,
    first: Array | None = None,
    tolerance: float = TOLERANCE,
) -> OptimizeResult:
    """Return the minimum of a problem's residuals, with its coordinates `x` and the number of evaluations `nfev`.

    Args:
        problem, loss, noise, first: see `fit`. cache: none: nothing is kept.
        tolerance: of coordinates and sum of squares; above `TOLERANCE` the fit may end before it.

    Raises:
        SimulationError: the rod has no solution at the start.
        FitError: no result.
    """
    kept = cache or EvaluationCache(None, {})
    span = np.array([bounds(parameter, problem.start[parameter.name]) for parameter in problem.parameters])

    def residuals(at: Array) -> Array:
        return kept.get("residuals", at, partial(problem.residuals, at))

    def jacobian_at(at: Array) -> Array:
        return kept.get("jacobian", at, partial(problem.jacobian, at))

    found = least_squares(
        residuals,
        np.zeros(len(problem.parameters)) if first is None else np.clip(first, span[:, 0], span[:, 1]),
        jac=jacobian_at,
        bounds=(span[:, 0] - 1e-9, span[:, 1] + 1e-9),
        loss=loss,
        f_scale=OUTLIER * noise,
        x_scale="jac",
        xtol=tolerance,
        ftol=tolerance,
        gtol=None,
        max_nfev=MAX_EVALUATIONS,
    )
    if not np.all(np.isfinite(found.x)) or (found.status <= 0 and tolerance <= TOLERANCE):
        raise FitError(f"the fit did not converge in {found.nfev} evaluations: {found.message}")
    return found


def refine(
    fine: FitProblem, at: Array, jacobian: Array, cache: EvaluationCache, loss: Loss, noise: float, evaluations: int = 0
) -> FitResult:
    """Refine a fit by Gauss-Newton with half the time step and the whole step's derivatives.

    Raises:
        FitError: the rod has no solution at a step.
    """
    span = np.array([bounds(one, fine.start[one.name]) for one in fine.parameters]).reshape(-1, 2)
    whole, row = at, cache.get("fine", at, partial(fine.residuals, at))
    for _ in range(FINER_ROUNDS if fine.parameters else 0):
        root = np.sqrt(loss_weights(loss, row, OUTLIER * noise))
        at = at + bounded_step(root[:, None] * jacobian, root * row, span[:, 0] - at, span[:, 1] - at)
        row = cache.get("fine", at, partial(fine.residuals, at))
        if not np.all(np.isfinite(row)):
            raise FitError("the rod has no solution at the fitted parameters when the time step is halved")
    return FitResult(
        parameters=fine.parameters,
        values=fine.values(at),
        coordinates=at,
        residuals=fine.shaped(row),
        jacobian=jacobian,
        weights=loss_weights(loss, row, OUTLIER * noise),
        remaining=REMAINING * (at - whole),
        evaluations=evaluations,
        bounded=tuple(
            parameter.name
            for parameter, place, (low, high) in zip(fine.parameters, at, span, strict=True)
            if min(place - low, high - place) < 1e-3
        ),
        prior_scale=fine.prior_scale,
    )


def bounded_step(jacobian: Array, residuals: Array, low: Array, high: Array) -> Array:
    """Compute a Gauss-Newton step within bounds, shape (p,); coordinates off the bounds are solved again.

    Args:
        jacobian: shape (r, p). residuals: shape (r,). low, high: bounds of the step, shape (p,); low <= 0 <= high.
    """
    step, free = np.zeros(len(low)), np.ones(len(low), dtype=bool)
    while np.any(free):
        missing = residuals + jacobian[:, ~free] @ step[~free]
        step[free] = np.linalg.lstsq(jacobian[:, free], -missing, rcond=1e-8)[0]
        beyond = free & ((step < low) | (step > high))
        if not np.any(beyond):
            break
        step[beyond] = np.clip(step, low, high)[beyond]
        free &= ~beyond
    return step


def loss_weights(loss: str, residuals: Array, scale: float) -> Array:
    """Compute each residual's weight in the normal equations: the loss's derivative at (r / scale)^2."""
    z = (residuals / scale) ** 2
    if loss == "soft_l1":
        return np.asarray(1.0 / np.sqrt(1.0 + z))
    if loss == "huber":
        return np.asarray(np.where(z <= 1.0, 1.0, 1.0 / np.sqrt(np.maximum(z, 1.0))))
    return np.ones_like(residuals)
