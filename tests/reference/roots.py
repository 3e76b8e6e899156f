"""Roots of smooth systems: scipy's hybr for the way, Newton with a difference Jacobian for the last digits."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.optimize import root

from tests.reference.rod import Array

Function = Callable[[Array], Array]


class NoRootError(RuntimeError):
    """The iteration did not arrive."""


def difference_jacobian(function: Function, x: Array, relative_step: float = 1e-7) -> Array:
    """Forward differences, shape (len(x), len(x)); the unknowns are of order 1, or smaller and then not of interest."""
    base, columns = function(x), []
    for index in range(len(x)):
        step = np.zeros(len(x))
        step[index] = relative_step * max(1.0, abs(x[index]))
        columns.append((function(x + step) - base) / step[index])
    return np.column_stack(columns)


def largest(residual: Array) -> float:
    """Largest magnitude."""
    return float(np.max(np.abs(residual)))


def polish(function: Function, x: Array, tolerance: float) -> tuple[Array, float]:
    """Newton from close by with one Jacobian kept, while the largest residual exceeds the tolerance and still halves.

    Returns x and its largest residual.
    """
    residual = function(x)
    if not tolerance < largest(residual) < 1e-3:
        return x, largest(residual)
    jacobian = difference_jacobian(function, x)
    while largest(residual) > tolerance:
        trial = x - np.linalg.solve(jacobian, residual)
        trial_residual = function(trial)
        if not largest(trial_residual) < largest(residual) / 2.0:
            break
        x, residual = trial, trial_residual
    return x, largest(residual)


def find_root(function: Function, guess: Array, scale: Array, tolerance: float, accept: float) -> Array:
    """x with function(x) = 0, shape as `guess`, near `guess`; `scale` is the size of each unknown.

    Stops when the largest residual is below `tolerance`, or can get no smaller and is below `accept`.
    Raises NoRootError otherwise.
    """

    def scaled(x: Array) -> Array:
        return function(x * scale)

    def jacobian(x: Array) -> Array:  # hybr's own steps are relative to each unknown: useless where one is almost zero
        return difference_jacobian(scaled, x)

    try:
        with np.errstate(all="ignore"):
            found = root(scaled, guess / scale, method="hybr", jac=jacobian, tol=1e-13)
            x, error = polish(scaled, found.x, tolerance)
    except np.linalg.LinAlgError as singular:
        raise NoRootError(f"a singular system on the way from {guess}") from singular
    if not error <= accept:
        raise NoRootError(f"no root found from {guess}: {error} is left of the residual")
    return x * scale
