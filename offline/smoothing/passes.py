"""The passes over a stretch: the estimator forward, then smoothers about the path that the last one found.

A smoother that is linearised anew about its own result is the Gauss-Newton method for the likeliest path: B. M. Bell,
"The iterated Kalman smoother as a Gauss-Newton method", SIAM J. Optim. 4, 1994. Derivatives are the estimator's, which
leave out how fast the mass and the stiffness change with the shape, and the finer modes; what a step itself does
is exact.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.kalman.estimator import Estimator
from tendond.offline.smoothing.linear import Problem, Smoothed, likeliest_jump, smooth
from tendond.offline.smoothing.path import Path, PathModel
from tendond.offline.smoothing.stretches import Stretch

Array = NDArray[np.float64]

PASSES = 3
"""Largest number of smoothers, one after the other."""

ENOUGH = 0.2
"""Largest change of an error, in its standard deviation, after which a path is taken for the likeliest: each smoother
changes a fifth of what the one before has changed (`pytest tests/unit/smoothing`)."""

ODDS = 100.0
"""Odds against a jump of the load anywhere in a stretch that the measurements have to outweigh. Chosen."""

JUMPS = 20
"""Largest number of jumps of the load in a stretch: where more are asked for, it is the model that is wrong. Chosen."""

Progress = Callable[[str], None]


@dataclass(frozen=True)
class Forward:
    """What the estimator knew at each instant, by the measurements until then.

    Attributes:
        errors: as those of a path, shape (K, N). tip: [m], shape (K, 3). tip_deviation: standard deviation of it [m].
        force_deviation: of the force on the tip [N], shape (K, 3).
        innovation: of each tip pose that arrived [m], NaN in an instant without one, shape (K, 3).
    """

    errors: Array
    tip: Array
    tip_deviation: Array
    force_deviation: Array
    innovation: Array


@dataclass(frozen=True)
class SmoothedStretch:
    """A stretch, and all that is known of it.

    Attributes:
        model: what moved along it. forward: see `Forward`. path: the likeliest one.
        problem: the last linear model. found: its result: the covariance of the path's errors, and how well it fitted.
        passes: number of smoothers. change: of the last one, largest change in standard deviations [-].
        jumps: instants before which a load came, went or changed at once.
    """

    model: PathModel
    forward: Forward
    path: Path
    problem: Problem
    found: Smoothed
    passes: int
    change: float
    jumps: tuple[int, ...]


def smooth_stretch(estimator: Estimator, stretch: Stretch, progress: Progress = lambda what: None) -> SmoothedStretch:
    """Return the likeliest path of a stretch.

    Args:
        estimator: of the robot. stretch: of a log. progress: is told each pass as it begins.

    Raises:
        ConvergenceError: the model has no solution.
    """
    progress("forward")
    model = PathModel(estimator, stretch)
    forward = run_forward(model)
    errors, passes, change = forward.errors, 0, np.inf
    variance, jumps = estimator.noise.load_jump**2, tuple[int, ...]()
    while passes < PASSES and change > ENOUGH:
        passes += 1
        progress(f"smoother {passes}")
        path = model.follow(errors)
        problem = model.problem(path)
        for k in jumps:
            problem = problem.with_jump(k, variance)
        problem, found, more = with_jumps(problem, variance, JUMPS - len(jumps))
        jumps += more
        errors = path.errors + found.mean
        change = _largest(found)
    return SmoothedStretch(model, forward, model.follow(errors), problem, found, passes, change, jumps)


def with_jumps(problem: Problem, variance: float, most: int) -> tuple[Problem, Smoothed, tuple[int, ...]]:
    """Smooth with as many jumps of the load as the measurements ask for, the likeliest first.

    Args:
        problem: without further jumps. variance: of each component of a jump [N^2]. most: number of them.

    Returns:
        The problem with the jumps, the smoother's result, and the instants before which they are.
    """
    found, jumps = smooth(problem), tuple[int, ...]()
    while len(jumps) < most:
        k, gain = likeliest_jump(found, variance)
        if gain < math.log(ODDS * len(problem.taken)):
            break
        problem, jumps = problem.with_jump(k, variance), (*jumps, k)
        found = smooth(problem)
    return problem, found, jumps


def _largest(found: Smoothed) -> float:
    """Return the largest mean error in its standard deviation; one that cannot be has none."""
    variance = np.einsum("kii->ki", found.covariance)
    known = variance > 0.0
    return float(np.max(np.abs(found.mean[known]) / np.sqrt(variance[known]), initial=0.0))


def run_forward(model: PathModel) -> Forward:
    """Run the estimator over a stretch.

    Raises:
        ConvergenceError: the model has no solution.
    """
    estimator, estimate, state = model.estimator, model.start, model.rest
    rows: list[tuple[Array, ...]] = []
    force = np.eye(estimator.errors.size)[estimator.errors.force]
    for instant in model.stretch.instants:
        estimate, state = estimator.correct(estimate, state, instant.readings)
        factors = estimator.factors(estimate)
        posed = any(one.sensor == 0 for one in instant.readings)
        rows.append(
            (
                model.vector(state, estimate),
                state.position,
                np.sqrt(np.diag(estimator.tip_covariance(estimate, factors))),
                np.sqrt(np.diag(factors.along(force))),
                estimate.innovation if posed else np.full(3, np.nan),
            )
        )
        after = estimator.step(estimate, state, instant.tensions)
        estimate, state = estimator.advance(estimate, state, after), after
    return Forward(*(np.array(column) for column in zip(*rows, strict=True)))
