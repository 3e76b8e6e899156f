"""A learned correction of a model's tip: ridge regression of its error, bounded, off outside of its data."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.residual import Residual, feature_names
from tendond.offline.files import write_whole
from tendond.schemas.config.observer import ResidualSection

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DEGREES = (1, 2, 3, 4)
RIDGES = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
MOST = 60
"""Largest number of features: few enough to be read."""

FOLDS = 5
PLAY = 0.005
"""Half-width of the sides' play, in parts of the largest range of a command."""


def as_section(residual: Residual) -> ResidualSection:
    """Return the correction as [observer.residual] holds it."""
    return ResidualSection.model_validate(
        {name: one.tolist() if isinstance(one, np.ndarray) else one for name, one in vars(residual).items()}
    )


def save(residual: Residual, path: Path) -> None:
    """Write the correction as JSON, with the keys of [observer.residual]."""
    write_whole(path, as_section(residual).model_dump_json(indent=1) + "\n")


def train(command: Array, error: Array, block: Index, training: NDArray[np.bool_]) -> Residual:
    """Return the correction of a model whose error, measured minus predicted [m], is known on the training part.

    Degree and penalty are those that predict left-out blocks of the training part best.

    Args:
        command: of the whole sequence [m], shape (N, n): the sides follow from the order.
        error: shape (N, 3); only its training rows are looked at. block: shape (N,). training: shape (N,).
    """
    known = command[training]
    low, high = known.min(axis=0), known.max(axis=0)
    width = PLAY * float(np.max(high - low))
    target = error[training]
    folds = np.searchsorted(np.unique(block[training]), block[training]) % FOLDS
    best = (np.inf, 1, RIDGES[0])
    for degree in DEGREES:
        if len(feature_names(command.shape[1], degree)) > MOST and degree > 1:
            break
        features = _features(command, low, high, degree, width)[training]
        for ridge in RIDGES:
            lost = 0.0
            for fold in np.unique(folds):
                out = folds == fold
                if out.all():
                    continue
                left = features[out] @ ridge_solve(features[~out], target[~out], ridge) - target[out]
                lost += float((left**2).sum())
            best = min(best, (lost, degree, ridge))
    _, degree, ridge = best
    features = _features(command, low, high, degree, width)[training]
    coefficients = ridge_solve(features, target, ridge)
    bound = float(np.percentile(np.linalg.norm(features @ coefficients, axis=1), 99))
    return Residual(degree, width, tuple(feature_names(command.shape[1], degree)), coefficients, low, high, bound)


def _features(command: Array, low: Array, high: Array, degree: int, width: float) -> Array:
    """Return the features along a sequence of commands, shape (N, F)."""
    names = tuple(feature_names(command.shape[1], degree))
    bare = Residual(degree, width, names, np.zeros((len(names), 3)), low, high, 0.0)
    return bare.features_at(command, bare.along(command))


def along(residual: Residual, command: Array) -> Array:
    """Return the correction along a sequence of commands [m], shape (N, 3)."""
    return residual.shift(command, residual.along(command))


def ridge_solve(features: Array, target: Array, ridge: float) -> Array:
    """Return coefficients that minimise |features c - target|^2 + ridge N |c|^2, shape (C, 3)."""
    normal = features.T @ features + ridge * len(features) * np.eye(features.shape[1])
    return np.asarray(np.linalg.solve(normal, features.T @ target))
