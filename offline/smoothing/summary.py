"""What a smoother says of a log in a few numbers, and what the measurements do not tell apart."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.offline.smoothing.passes import SmoothedStretch

Array = NDArray[np.float64]

UNMEASURED = 0.9
"""Standard deviation, in that which was assumed, above which the measurements say nothing of a quantity. Chosen."""

ALIKE = 0.9
"""Correlation above which two quantities are not told apart: of each, a fifth of the variance is its own. Chosen."""


@dataclass(frozen=True)
class Summary:
    """Numbers of a stretch.

    Attributes:
        first, last: ticks. cycles: of it. poses: number of them.
        passes: number of smoothers. change: of the last one, in standard deviations [-].
        innovation_mm: RMS distance of poses from what the filter expected [mm]; residual_mm: from the smoothed path.
        consistency: mean square of the innovations in units of their expected spread: 1 is right [-].
        force: the largest on the tip [N], deviation: of its components [N], time: of it [s].
        jumps: times at which a load was found to have come [s].
        stiffness: of the robot, relative to the model's [-], stiffness_deviation: of it.
        tip_mass: on the tip beside the model's [kg], tip_mass_deviation: of it; none where it is taken as known.
        unmeasured: quantities of which the measurements say nothing at that time; alike: pairs not told apart.
    """

    first: int
    last: int
    cycles: int
    poses: int
    passes: int
    change: float
    innovation_mm: float
    residual_mm: float
    consistency: float
    force: tuple[float, ...]
    deviation: tuple[float, ...]
    time: float
    jumps: tuple[float, ...]
    stiffness: float
    stiffness_deviation: float
    tip_mass: float | None
    tip_mass_deviation: float | None
    unmeasured: tuple[str, ...]
    alike: tuple[str, ...]


def summarise(stretch: SmoothedStretch) -> Summary:
    """Return the numbers of a stretch."""
    errors, instants = stretch.model.estimator.errors, stretch.model.stretch.instants
    path, covariance = stretch.path.errors, stretch.found.covariance
    largest = int(np.argmax(np.linalg.norm(path[:, errors.force], axis=1)))
    spread = np.sqrt(np.maximum(np.diag(covariance[largest]), 0.0))
    residual = [one.lack[:3] for taken in stretch.model.taken(stretch.path) for one in taken if one.sensor == 0]
    weighed = errors.size > errors.tip_mass.start
    ticks = [one.tick for one in instants if one.tick is not None]
    return Summary(
        first=ticks[0],
        last=ticks[-1],
        cycles=len(ticks),
        poses=stretch.model.stretch.poses,
        passes=stretch.passes,
        change=stretch.change,
        innovation_mm=1e3 * _rms(stretch.forward.innovation),
        residual_mm=1e3 * _rms(np.array(residual)),
        consistency=stretch.found.square / max(stretch.found.numbers, 1),
        force=tuple(path[largest, errors.force].tolist()),
        deviation=tuple(spread[errors.force].tolist()),
        time=instants[largest].time,
        jumps=tuple(instants[k].time for k in sorted(stretch.jumps)),
        stiffness=float(path[largest, errors.stiffness]),
        stiffness_deviation=float(spread[errors.stiffness]),
        tip_mass=float(path[largest, -1]) if weighed else None,
        tip_mass_deviation=float(spread[-1]) if weighed else None,
        unmeasured=tuple(_unmeasured(stretch, largest)),
        alike=tuple(_alike(stretch, largest)),
    )


def _rms(vectors: Array) -> float:
    return float(np.sqrt(np.nanmean(np.sum(vectors**2, axis=1))))


def _names(stretch: SmoothedStretch) -> Sequence[str]:
    """Names of the causes, in their order."""
    errors = stretch.model.estimator.errors
    tensions, bends = errors.tension.stop - errors.tension.start, len(errors.bends)
    names = [f"force {axis}" for axis in "xyz"] + [f"tension {i}" for i in range(tensions)]
    return [
        *names,
        *(f"moment {i}" for i in range(bends)),
        "stiffness",
        *(["mass"] if errors.size > errors.tip_mass.start else []),
    ]


def _unmeasured(stretch: SmoothedStretch, k: int) -> Iterator[str]:
    """Yield the causes that are known no better than they were assumed."""
    causes = stretch.model.causes
    assumed = np.sqrt(assumed_variance(stretch)[k])
    now = np.sqrt(np.maximum(np.diag(stretch.found.covariance[k])[causes], 0.0))
    for name, before, after in zip(_names(stretch), assumed, now, strict=True):
        if before > 0.0 and after > UNMEASURED * before:
            yield name


def assumed_variance(stretch: SmoothedStretch) -> Array:
    """Return the variance of the causes at each instant without any measurement, shape (K, N - 2 k)."""
    problem, causes = stretch.problem, stretch.model.causes
    variances = [np.diag(problem.covariance)[causes]]
    for line in problem.lines:
        variances.append(line.decay**2 * variances[-1] + line.noise)
    return np.array(variances)


def _alike(stretch: SmoothedStretch, k: int) -> Iterator[str]:
    """Yield pairs of causes of which only a combination is known."""
    names, causes = _names(stretch), stretch.model.causes
    covariance = stretch.found.covariance[k][causes, causes]
    spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    for i in range(len(names)):
        for j in range(i):
            scale = float(spread[i] * spread[j])
            if scale > 0.0 and abs(covariance[i, j]) > ALIKE * scale:
                yield f"{names[j]} and {names[i]}"
