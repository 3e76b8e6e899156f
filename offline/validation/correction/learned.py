"""A learned correction of a model's tip: ridge regression of its error, bounded, off outside of its data."""

import json
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from tendond.offline.files import write_whole
from tendond.offline.validation.baselines.polynomial import ridge_solve
from tendond.offline.validation.correction.features import features_of, names_of
from tendond.offline.validation.datasets.poses import DatasetError

Array = NDArray[np.float64]
Index = NDArray[np.int64]

DEGREES = (1, 2, 3, 4)
RIDGES = (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)
MOST = 60
"""Largest number of features: few enough to be read."""

FOLDS = 5
MARGIN = 0.1
"""Part of a command's range beyond it over which the correction goes to zero."""

PLAY = 0.005
"""Half-width of the sides' play, in parts of the largest range of a command."""


@dataclass(frozen=True)
class Correction:
    """Correction that is added to a model's tip.

    Attributes:
        degree: of the products of commands. width: half-width of the sides' play [m]. ridge: penalty.
        features: names. coefficients: of them [m], F rows of x, y, z.
        low, high: of the training commands [m], m numbers. bound: largest length of the correction [m].
    """

    degree: int
    width: float
    ridge: float
    features: list[str]
    coefficients: list[list[float]]
    low: list[float]
    high: list[float]
    bound: float

    def shift(self, command: Array) -> Array:
        """Return the correction along a sequence of commands [m], camera's frame [m], shape (N, 3)."""
        low, high = np.array(self.low), np.array(self.high)
        raw = features_of(command, low, high, self.degree, self.width) @ np.array(self.coefficients)
        size = np.linalg.norm(raw, axis=1)
        bounded = raw * np.minimum(1.0, self.bound / np.maximum(size, 1e-12))[:, None]
        reach = np.maximum(high - low, 1e-12)
        beyond = np.max(np.maximum(np.maximum(low - command, command - high), 0.0) / reach, axis=1)
        return np.asarray(bounded * np.clip(1.0 - beyond / MARGIN, 0.0, 1.0)[:, None])

    def save(self, path: Path) -> None:
        """Write the correction as JSON."""
        write_whole(path, json.dumps(asdict(self), indent=1) + "\n")

    @staticmethod
    def load(path: Path) -> "Correction":
        """Read what `save` has written.

        Raises:
            DatasetError: not such a file, or features that this version does not have.
        """
        try:
            found = Correction(**json.loads(path.read_text(encoding="utf-8")))
        except (OSError, ValueError, TypeError) as error:
            raise DatasetError(f"{path}: is not a correction: {error}") from None
        if found.features != names_of(len(found.low), found.degree):
            raise DatasetError(f"{path}: its features are not those of this version; train it again")
        return found


def train(command: Array, error: Array, block: Index, training: NDArray[np.bool_]) -> Correction:
    """Return the correction of a model whose error, measured minus predicted [m], is known on the training part.

    Degree and penalty are those that predict left-out blocks of the training part best.

    Args:
        command: of the whole sequence [m], shape (N, m): the sides follow from the order.
        error: shape (N, 3); only its training rows are looked at. block: shape (N,). training: shape (N,).
    """
    known = command[training]
    low, high = known.min(axis=0), known.max(axis=0)
    width = PLAY * float(np.max(high - low))
    target = error[training]
    folds = np.searchsorted(np.unique(block[training]), block[training]) % FOLDS
    best = (np.inf, 1, RIDGES[0])
    for degree in DEGREES:
        if len(names_of(command.shape[1], degree)) > MOST and degree > 1:
            break
        features = features_of(command, low, high, degree, width)[training]
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
    features = features_of(command, low, high, degree, width)[training]
    coefficients = ridge_solve(features, target, ridge)
    bound = float(np.percentile(np.linalg.norm(features @ coefficients, axis=1), 99))
    names = names_of(command.shape[1], degree)
    return Correction(degree, width, ridge, names, coefficients.tolist(), low.tolist(), high.tolist(), bound)
