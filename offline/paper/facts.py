"""Numbers of a run that the page's paragraphs name."""

import numpy as np

from tendond.daemon.control.laws import select_law
from tendond.offline.paper.published import LAWS
from tendond.offline.paper.run import PaperRun


def tpl(run: PaperRun, count: int) -> float:
    """Compute the total path length of x over the first iterations [mm]."""
    return 1e3 * float(np.abs(np.diff(run.tip[: count + 1, 0])).sum())


def mean_error(run: PaperRun, first: int, last: int | None) -> float:
    """Compute |target - mean of x| over some iterations [mm]."""
    return 1e3 * abs(float(run.tip[first:last, 0].mean() - run.target[0]))


def off(run: PaperRun) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    """Compute the tip minus the target in the plane [m], shape (k, 2)."""
    return np.asarray((run.tip - run.target)[:, [0, 2]])


def deviation(run: PaperRun, start: int) -> float:
    """Compute the maximum distance from the target, from an iteration on [mm]."""
    return 1e3 * float(np.linalg.norm(off(run)[start:], axis=1).max())


def gains(run: PaperRun) -> tuple[float, float, float, float]:
    """Compute kp [1/s^2] and kd [1/s] of a law, its fast gain times the period [-], and epsilon [m/s^2]."""
    control = run.scenario.config.control
    values = select_law(control.law, control.laws)[1].model_dump()
    period = run.scenario.config.loop.period
    if run.law == LAWS[0]:
        a1, a2 = values["alpha1"], values["alpha2"]
        return 1.0 + a1 * a2, a1 + a2, a1 * period, 0.0
    c, k = values["c"], values["k"]
    return c * k, c + k, c * period, values["epsilon"]
