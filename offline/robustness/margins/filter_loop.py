"""The sampled loop of law, filter, delay and plant about a rest of the arm, as a matrix: its poles, its margin.

The cycle is the controller's: the filter takes the pose that arrives, at its own time, and carries the correction on;
the law asks for tensions by the corrected model; model and plant make their step under them.
"""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.margin import ROUNDING
from tendond.offline.robustness.margins.filter_parts import FAST, ModelParts, PlantParts

Array = NDArray[np.float64]

FACTORS = (1.0, 1.1, 1.2, 1.3, 1.5, 2.0, 3.0, 4.0)
"""Factors on the gain that are tried."""


def loop_matrix(model: ModelParts, plant: PlantParts, known: int, late: int, factor: float = 1.0) -> Array:
    """Return the matrix of a cycle.

    Args:
        model, plant: parts about their rests. known: delay of a pose, as configured [cycles]. late: beyond that.
        factor: on the filter's gain.
    """
    n2, m = plant.pull.shape
    causes = len(model.decay)
    keep = known + late
    sizes = [n2, n2, 3, causes, m, m, 3, 6 * keep, 6 * known]
    ends = np.cumsum(sizes)
    x_p, x_m, speed, cause, pull, acted, pushed, past_p, past_m = np.split(np.eye(ends[-1]), ends[:-1])
    seen_p = [*np.split(past_p, keep), plant.pose @ x_p] if keep else [plant.pose @ x_p]
    seen_m = [*np.split(past_m, known), model.pose @ x_m] if known else [model.pose @ x_m]
    change = factor * model.gain @ (seen_p[0] - seen_m[0])
    for back in range(known, 0, -1):
        seen_m[-1 - back] = seen_m[-1 - back] + model.pose @ change[:n2]
        change = model.carry @ change
    seen_m[-1] = seen_m[-1] + model.pose @ change[:n2]
    half = n2 // 2
    x_m, cause = x_m + change[:n2], cause + change[n2:]
    speed = speed + model.pose[:3, :half] @ change[half:n2]
    force, wrong, bend = cause[:3], cause[3 : 3 + m], cause[3 + m :]
    wanted = model.law @ np.concatenate((x_m, speed, pull, force, wrong, acted, pushed))
    acting = wanted + wrong
    x_next = model.step @ x_m + model.pull @ acting + model.push @ np.concatenate((force, bend))
    moved = model.pose[:3] @ (x_next - x_m)
    rows = [
        plant.step @ x_p + plant.pull @ wanted, x_next, moved / model.period, model.decay[:, None] * cause,
        wanted, acting, force, *seen_p[1:], *seen_m[1:],
    ]  # fmt: skip
    return np.concatenate(rows)


def poles(model: ModelParts, plant: PlantParts, known: int, late: int, factor: float = 1.0) -> Array:
    """Return the poles of the loop but those of `law_poles` and of fast modes, largest first; see `loop_matrix`."""
    found = np.linalg.eigvals(loop_matrix(model, plant, known, late, factor))
    for pole in np.concatenate((law_poles(model), plant.fast)):
        found = np.delete(found, np.argmin(np.abs(found - pole)))
    return np.asarray(found[np.argsort(-np.abs(found))])


def radius(model: ModelParts, plant: PlantParts, known: int, late: int, factor: float = 1.0) -> float:
    """Return the largest size of `poles`."""
    return float(np.abs(poles(model, plant, known, late, factor)[0]))


def law_poles(model: ModelParts) -> Array:
    """Return poles of law and model alone that no filter changes [complex, -], as `margin` leaves them out.

    Those outside the circle are the law's own. Those that alternate from step to step are the model's fastest modes,
    which hardly move the tip: its scheme does not damp them, and no law sees them.
    """
    n2, m, causes = len(model.step), model.pull.shape[1], len(model.decay)
    still = PlantParts(0.0 * model.step, 0.0 * model.pull, 0.0 * model.pose, np.zeros(0))
    whole = loop_matrix(model, still, 0, 0, 0.0)
    kept = np.r_[n2 : 2 * n2 + 3, 2 * n2 + 3 + causes : 2 * n2 + 6 + causes + 2 * m]
    found = np.linalg.eigvals(whole[np.ix_(kept, kept)])
    return np.asarray(found[(np.abs(found) > 1.0 + ROUNDING) | ((np.abs(found) > FAST) & (np.real(found) < 0.0))])


def gain_margin(model: ModelParts, plants: Sequence[tuple[PlantParts, int]], known: int) -> float:
    """Return the smallest of `FACTORS` on the filter's gain with which the loop is unstable on a plant; else infinity.

    Args:
        model: its parts. plants: with their unknown delays [cycles]. known: delay as configured [cycles].
    """
    for factor in FACTORS:
        if any(radius(model, plant, known, late, factor) >= 1.0 for plant, late in plants):
            return factor
    return math.inf
