"""Selection of the groups of parameters that the training part supports, by the Bayesian information criterion.

BIC = n ln(SSE) + k ln(n) (G. Schwarz, "Estimating the dimension of a model", Annals of Statistics 6, 1978), with the
number of independent residuals for n: neighbours of a sequence err alike, N (1 - r) / (1 + r) of them count, with r the
correlation of successive residuals (G. V. Bayley, J. M. Hammersley, "The 'effective' number of independent
observations in an autocorrelated time series", J. R. Stat. Soc. Suppl. 8, 1946).
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond.offline.validation.fitting.fit import Solution, jacobian_of
from tendond.offline.validation.fitting.problem import Problem, groups_of
from tendond.offline.validation.rods.parameters import BASIC

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Trial:
    """A group that was tried.

    Attributes:
        group: its name. predicted: change of BIC by a linear step. found: by a fit; none: not fitted.
        taken: whether the group is fitted from then on.
    """

    group: str
    predicted: float
    found: float | None
    taken: bool


def independent(residuals: Array) -> float:
    """Return the number of independent residuals of a sequence, shape (3 N,)."""
    errors = residuals.reshape(-1, 3)
    errors = errors - errors.mean(axis=0)
    total = float((errors**2).sum())
    r = float((errors[1:] * errors[:-1]).sum()) / total if total > 0.0 else 0.0
    return max(len(residuals) * (1.0 - r) / (1.0 + r), 10.0) if r > 0.0 else float(len(residuals))


def criterion(residuals: Array, count: int, independents: float) -> float:
    """Return BIC of a fit of `count` parameters."""
    return independents * float(np.log(residuals @ residuals / len(residuals))) + count * float(np.log(independents))


def select(problem: Problem) -> tuple[dict[str, float], Solution, Problem, list[Trial]]:
    """Fit BASIC groups, then add the group that lowers BIC most, until none does.

    A group's gain is predicted by one linear step, and confirmed by a fit.
    """
    problem = replace(problem, groups=BASIC)
    values, solution = problem.solve()
    trials: list[Trial] = []
    open_groups = [one for one in groups_of(problem.design) if one not in BASIC]
    while open_groups:
        count = independent(solution.residuals)
        now = criterion(solution.residuals, len(solution.z), count)
        predicted = {one: _predicted(problem, values, solution, one, count) - now for one in open_groups}
        best = min(open_groups, key=lambda one: predicted[one])
        if predicted[best] >= 0.0:
            trials += [Trial(one, predicted[one], None, False) for one in open_groups]
            break
        wider = replace(problem, groups=(*problem.groups, best), base=values)
        found_values, found = wider.solve()
        change = criterion(found.residuals, len(found.z), count) - now
        taken = change < 0.0
        trials.append(Trial(best, predicted[best], change, taken))
        open_groups.remove(best)
        if taken:
            problem, values, solution = wider, found_values, found
    return values, solution, problem, trials


def _predicted(problem: Problem, values: dict[str, float], solution: Solution, group: str, count: float) -> float:
    """Return BIC after a linear step from the present fit, with one more group."""
    alone = replace(problem, groups=(group,), base=values)
    z = alone.start()
    at = alone.residuals(z)
    jacobian = np.hstack([solution.jacobian, jacobian_of(alone.residuals, z, at)])
    offset = np.concatenate([solution.z, z])
    step = np.linalg.solve(jacobian.T @ jacobian + np.eye(len(offset)), -(jacobian.T @ at + offset))
    return criterion(at + jacobian @ step, len(offset), count)
