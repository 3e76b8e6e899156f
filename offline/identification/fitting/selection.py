"""Selection of the parameters that logs support: forward by the Bayesian information criterion, and backward.

A candidate's gain is predicted by one linear step of it together with what is taken already, and confirmed by a fit. It
is taken where the criterion falls by 6 or more, strong evidence by R. E. Kass and A. E. Raftery, "Bayes factors",
J. Am. Stat. Assoc. 90, 1995; of candidates that gain alike the one of the more common physics is.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from tendond.offline.identification.fitting.candidate import (
    ALIKE,
    STRONG,
    Candidate,
    Fitted,
    ProblemOf,
    Trial,
    begun,
    fit_candidates,
    fitted_at,
)
from tendond.offline.identification.fitting.elimination import eliminated, without_spare
from tendond.offline.identification.fitting.solve import FitError, bounded_step
from tendond.offline.identification.parameter import Parameter, bounds
from tendond.offline.identification.simulation.motion import SimulationError

UNSOLVED = "the rod has no solution with a first guess of it: correct the configuration, and try again"

INCOMPLETE = 2.0
"""Residuals, in units of the poses' noise, above which what is taken one by one is compared with taking all at once."""


@dataclass(frozen=True)
class Selected:
    """The outcome. parameters: those taken. values: of all. trials: of each candidate, those taken first."""

    parameters: tuple[Parameter, ...]
    values: dict[str, float]
    trials: tuple[Trial, ...]


def select(
    candidates: Sequence[Candidate], start: Mapping[str, float], problem_of: ProblemOf, noise: float
) -> Selected:
    """Select among candidates.

    Args:
        candidates: in the order of preference. start: configured values of all parameters, by name.
        problem_of: makes the problem of some of them. noise: of the poses [m].

    Raises:
        SimulationError, FitError: no result.
    """
    now = fitted_at((), dict(start), problem_of)
    remaining, trials = list(candidates), []
    best: dict[str, tuple[float, str]] = {}  # gain of each before another one was taken, and which
    last: dict[str, float] = {}
    while remaining:
        count = now.independent
        for one in tuple(remaining):
            try:
                last[one.name] = _predicted(now, one, problem_of, count)
            except SimulationError:
                remaining.remove(one)
                trials.append(Trial(one.name, 0.0, False, UNSOLVED))
        if not remaining:
            break
        gains = [last[one.name] for one in remaining]
        chosen = next(one for one, gain in zip(remaining, gains, strict=True) if gain <= min(gains) + ALIKE)
        if last[chosen.name] > -STRONG:
            break
        remaining.remove(chosen)
        try:
            wider = fit_candidates((*now.taken, chosen), now.values, problem_of, noise)
        except (FitError, SimulationError):
            trials.append(Trial(chosen.name, 0.0, False, UNSOLVED))
            continue
        change = wider.bic(count) - now.bic(count)
        if change > -STRONG:
            trials.append(Trial(chosen.name, change, False, "no support: a fit gains less than a linear step"))
            continue
        for one in remaining:
            if last[one.name] < best.get(one.name, (-STRONG, ""))[0]:
                best[one.name] = last[one.name], chosen.name
        now = wider
        trials.insert(len(now.taken) - 1, Trial(chosen.name, change, True, ""))
    for one in remaining:
        if one.name in best:
            gain, other = best[one.name]
            why = f"not told apart from {other}: {gain:+.0f} before that was taken"
        else:
            why = "no support"
        trials.append(Trial(one.name, last[one.name], False, why))
    now, trials = without_spare(now, trials, start, problem_of, noise)
    if now.rms > INCOMPLETE * noise:  # one thing at a time leads astray where several are wrong
        now, trials = eliminated(now, trials, candidates, start, problem_of, noise)
    return Selected(tuple(now.problem.parameters), now.values, tuple(trials))


def _predicted(now: Fitted, one: Candidate, problem_of: ProblemOf, count: float) -> float:
    """Return the change of the criterion by a linear step of what is taken and one more."""
    values = begun(now.values, [one])
    alone = problem_of(one.parameters, values)
    here = np.zeros(len(one.parameters))
    residuals = now.residuals if values == now.values else alone.residuals(here)
    jacobian = np.hstack([now.jacobian, alone.jacobian(here)])
    free = [*now.problem.parameters, *one.parameters]
    span = np.array([bounds(parameter, values[parameter.name]) for parameter in free])
    step = bounded_step(jacobian, residuals, np.minimum(span[:, 0], 0.0), np.maximum(span[:, 1], 0.0))
    after = replace(now, residuals=residuals + jacobian @ step, jacobian=jacobian)
    return after.bic(count) - now.bic(count)
