"""Backward selection: candidates that are not needed beside the others are dropped."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tendond.offline.identification.fitting.candidate import (
    ALIKE,
    STRONG,
    Candidate,
    Fitted,
    ProblemOf,
    Trial,
    fit_candidates,
)
from tendond.offline.identification.fitting.solve import FitError
from tendond.offline.identification.simulation.motion import SimulationError


def without_spare(
    now: Fitted, trials: list[Trial], start: Mapping[str, float], problem_of: ProblemOf, noise: float
) -> tuple[Fitted, list[Trial]]:
    """Drop what later candidates have made superfluous, the first taken first."""
    for one in now.taken[:-1]:
        count = now.independent
        others = tuple(other for other in now.taken if other is not one)
        values = {**now.values, **{parameter.name: start[parameter.name] for parameter in one.parameters}}
        try:
            narrower = fit_candidates(others, values, problem_of, noise)
        except (FitError, SimulationError):
            continue  # there is no rod without it
        change = narrower.bic(count) - now.bic(count)
        if change < STRONG:
            now = narrower
            beside = ", ".join(other.name for other in others)
            dropped = Trial(one.name, -change, False, f"not needed beside {beside}, which were taken later")
            trials = [trial for trial in trials if trial.name != one.name] + [dropped]
    return now, trials


def eliminated(
    now: Fitted, trials: list[Trial], candidates: Sequence[Candidate], start: Mapping[str, float],
    problem_of: ProblemOf, noise: float,
) -> tuple[Fitted, list[Trial]]:  # fmt: skip
    """Fit all candidates at once and drop one after the other; return that where it beats what is taken already.

    Args:
        now, trials: what is taken already, and what became of the candidates.
        candidates: all of them, in the order of preference. start: configured values of all parameters, by name.
        problem_of: makes the problem of some. noise: of the poses [m].
    """
    try:
        fit = fit_candidates(tuple(candidates), now.values, problem_of, noise)
    except (FitError, SimulationError):
        return now, trials
    dropped: list[Trial] = []
    needed: dict[str, float] = {}
    while len(needed) < len(fit.taken):
        count = fit.independent
        costs = {one.name: _cost(fit, one, start, count) for one in fit.taken if one.name not in needed}
        spare = [one for one in fit.taken if costs.get(one.name, np.inf) <= min(costs.values()) + ALIKE][-1]
        others = tuple(one for one in fit.taken if one is not spare)
        cost = costs[spare.name]
        narrower = None
        if cost < STRONG:
            try:
                narrower = fit_candidates(others, _without(fit.values, spare, start), problem_of, noise)
                cost = narrower.bic(count) - fit.bic(count)
            except (FitError, SimulationError):
                cost = STRONG  # there is no rod without it
        if narrower is None or cost >= STRONG:
            needed[spare.name] = cost
            continue
        dropped.append(Trial(spare.name, -cost, False, "not needed beside what is taken"))
        fit, needed = narrower, {}
    if fit.bic(fit.independent) > now.bic(fit.independent) - STRONG:
        return now, trials
    kept = [Trial(one.name, -needed[one.name], True, "") for one in fit.taken]
    return fit, [*kept, *reversed(dropped)]


def _without(values: Mapping[str, float], one: Candidate, start: Mapping[str, float]) -> dict[str, float]:
    """Return the values with a candidate's at the configuration's."""
    return {**values, **{parameter.name: start[parameter.name] for parameter in one.parameters}}


def _cost(fit: Fitted, one: Candidate, start: Mapping[str, float], count: float) -> float:
    """Return the change of the criterion without a candidate, by a linear step of the others."""
    free = fit.problem.parameters
    mine = np.array([parameter in one.parameters for parameter in free])
    back = np.array([one.coordinate(start[one.name], fit.values[one.name]) for one in free])[mine]
    residuals = fit.residuals + fit.jacobian[:, mine] @ back
    others = fit.jacobian[:, ~mine]
    residuals = residuals - others @ np.linalg.lstsq(others, residuals, rcond=1e-8)[0]
    return replace(fit, residuals=residuals, jacobian=others).bic(count) - fit.bic(count)
