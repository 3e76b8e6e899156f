"""Equilibria along a growing load, through folds.

An arc length of shape and load together is prescribed, so that the path passes where the load has to turn back (E.
Riks, "An incremental approach to the solution of snapping and buckling problems", Int. J. Solids Struct. 15, 1979).
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.strain.analysis.potential import ITERATIONS, SETTLED, STRIDE, Equilibrium, Potential, solved
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.scratch import Loads

Array = NDArray[np.float64]

SMALLEST = 1e-4
"""Step of the arc length below which a path is given up."""


@dataclass(frozen=True)
class LoadPath:
    """Equilibria along a load.

    Attributes:
        equilibria: in the order of the path. folds: the last ones before the load turns back, by their index.
        complete: whether the path reached its last share of the load.
    """

    equilibria: tuple[Equilibrium, ...]
    folds: tuple[int, ...]
    complete: bool


def follow_load(
    rod: StrainRod,
    loads: Loads,
    start: StrainState,
    first: float = 0.0,
    last: float = 1.0,
    step: float = 0.1,
    steps: int = 400,
) -> LoadPath:
    """Follow the equilibria from one share of a load to another, through folds.

    Args:
        rod: the robot.
        loads: dead loads and tensions, all of which grow together; gravity acts in full throughout.
        start: near an equilibrium at `first`.
        first, last: shares of the load. The path ends at `last`, or where it is back at `first`.
        step: of the arc length of shape [rad] and share [-]; halved where it must be.
        steps: largest number of equilibria.

    Raises:
        ParameterError: a tendon is driven by displacement.
        ConvergenceError: there is no equilibrium near the start.
    """
    if np.any(loads.driven):
        raise ParameterError("loads: a path follows tensions, not displacements, of tendons")
    statics = Potential(rod, loads)
    q = _settled(statics, start.strain, first)
    share, direction = first, math.copysign(1.0, last - first)
    before = np.append(np.zeros_like(q), direction)
    path = [statics.equilibrium(q, share)]
    folds: list[int] = []
    size = step
    while len(path) < steps:
        tangent = _direction(statics, q, share, before)
        corrected = _corrected(statics, q, share, tangent, size)
        if corrected is None:
            size *= 0.5
            if size < SMALLEST:
                return LoadPath(tuple(path), tuple(folds), False)
            continue
        if tangent[-1] * before[-1] < 0.0:
            folds.append(len(path) - 1)
        at, then = corrected
        if (then - last) * direction >= 0.0:
            path.append(statics.equilibrium(_settled(statics, at, last), last))
            return LoadPath(tuple(path), tuple(folds), True)
        if (then - first) * direction < 0.0:
            return LoadPath(tuple(path), tuple(folds), False)
        q, share, before = at, then, tangent
        path.append(statics.equilibrium(q, share))
        size = min(step, 1.5 * size)
    return LoadPath(tuple(path), tuple(folds), False)


def _settled(statics: Potential, guess: Array, share: float) -> Array:
    """Equilibrium near a shape by Newton's method, stable or not."""
    q = guess.copy()
    for _ in range(ITERATIONS):
        gradient, _ = statics.gradient(q, share)
        change = -solved(statics.tangent(q, share), gradient)
        if statics.size(change) < SETTLED:
            return q
        q = q + change * min(1.0, 0.3 * STRIDE / max(statics.size(change), 1e-300))
    raise ConvergenceError("statics: no equilibrium near the start of the path", 0.0, statics.size(change), ITERATIONS)


def _bordered(statics: Potential, q: Array, share: float, row: Array) -> Array:
    """Tangent and load's derivative, which is exact for dead loads, above a row; shape (n + 1, n + 1)."""
    n = len(q)
    matrix = np.zeros((n + 1, n + 1))
    matrix[:n, :n] = statics.tangent(q, share)
    matrix[:n, n] = statics.gradient(q, share + 1.0)[0] - statics.gradient(q, share)[0]
    matrix[n] = row
    return matrix


def _row(statics: Potential, tangent: Array) -> Array:
    """Row that measures the arc length along a direction."""
    return np.append(statics.layout.stiffness @ tangent[:-1] / statics.unit, tangent[-1])


def _direction(statics: Potential, q: Array, share: float, before: Array) -> Array:
    """Direction of the path, of unit arc length, on from the one before."""
    right = np.zeros(len(q) + 1)
    right[-1] = 1.0
    found = solved(_bordered(statics, q, share, _row(statics, before)), right)
    return np.asarray(found / math.sqrt(float(found @ _row(statics, found))))


def _corrected(statics: Potential, q: Array, share: float, tangent: Array, size: float) -> tuple[Array, float] | None:
    """The next point of the path, by Newton's method across its direction; none where it does not settle quickly."""
    row = _row(statics, tangent)
    at, then = q + size * tangent[:-1], share + size * float(tangent[-1])
    for _ in range(8):
        gradient, _ = statics.gradient(at, then)
        along = float(row @ np.append(at - q, then - share)) - size
        try:
            change = -solved(_bordered(statics, at, then, row), np.append(gradient, along))
        except np.linalg.LinAlgError:
            return None
        length = math.hypot(statics.size(change[:-1]), float(change[-1]))
        if not length < 2.0 * size:
            return None
        at, then = at + change[:-1], then + float(change[-1])
        if length < SETTLED:
            return at, then
    return None
