"""Discretisations in space: explicit Runge-Kutta methods as Butcher tableaux; forward Euler is the one with one stage.

A rod is evaluated at `stages * steps + 1` points: every stage of every step, then s = L. Each point keeps its own
history in time. All time levels together are then one ordinary differential equation in s, solved by one Runge-Kutta
method, so that the method keeps its order.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from tests.reference.rod import Array


@dataclass(frozen=True, eq=False)
class Tableau:
    """An explicit Runge-Kutta method with S stages."""

    A: Array
    """Strictly lower triangular, shape (S, S)."""
    b: Array
    """Weights, shape (S,)."""
    c: Array
    """Abscissae, shape (S,)."""

    def __post_init__(self) -> None:
        if np.any(np.triu(self.A)) or not np.allclose(self.A.sum(axis=1), self.c) or not np.isclose(self.b.sum(), 1.0):
            raise ValueError(
                "not the tableau of an explicit Runge-Kutta method: A lower triangular, A 1 = c, sum b = 1"
            )

    @property
    def stages(self) -> int:
        """S."""
        return len(self.b)


EULER = Tableau(A=np.array([[0.0]]), b=np.array([1.0]), c=np.array([0.0]))

MIDPOINT = Tableau(A=np.array([[0.0, 0.0], [0.5, 0.0]]), b=np.array([0.0, 1.0]), c=np.array([0.0, 0.5]))

CLASSICAL_RK4 = Tableau(
    A=np.array([[0.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0], [0.0, 0.5, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]),
    b=np.array([1.0, 2.0, 2.0, 1.0]) / 6.0,
    c=np.array([0.0, 0.5, 0.5, 1.0]),
)


@dataclass(frozen=True, eq=False)
class Scheme:
    """A tableau, a number of equal steps, and the two choices in which the paper's Euler differs from the others."""

    tableau: Tableau
    steps: int
    orthonormalise: bool
    """Correction of R after each step, twice: R <- R (3 I - R'R) / 2 (Newton-Schulz)."""
    trapezoidal_path: bool
    """The path length of a tendon is a trapezoidal sum over the nodes, not the tableau's quadrature of the stages."""

    @property
    def points(self) -> int:
        """Number of points at which the rod is evaluated."""
        return self.tableau.stages * self.steps + 1


def euler(nodes: int) -> Scheme:
    """The paper's scheme: forward Euler, ds = L / (nodes - 1), on all of p, R, v, u, q, w; R is left as it comes."""
    return Scheme(EULER, nodes - 1, orthonormalise=False, trapezoidal_path=True)


def runge_kutta(steps: int, tableau: Tableau = CLASSICAL_RK4, orthonormalise: bool = True) -> Scheme:
    """An explicit Runge-Kutta method, ds = L / steps."""
    return Scheme(tableau, steps, orthonormalise, trapezoidal_path=False)
