"""The potential energy of a robot under a share of its loads: gradient, tangent, and distances between shapes.

Distances are those of the elastic energy of a difference, in units of bending the softest section by 1 rad.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from tendond.model.strain.minima.energy import find_energy
from tendond.model.strain.minima.hessian import stiffness_of
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.scratch import Loads, scratch_for

Array = NDArray[np.float64]

ITERATIONS = 60
"""Largest number of Newton steps to an equilibrium. Chosen; `pytest
tests/unit/strain/test_equilibria.py` passes with it."""

STRIDE = 1.0
"""Largest change in one of Newton's steps, as a distance: 1 rad of the softest section. Chosen, by
the unit of distances; `pytest tests/unit/strain/test_equilibria.py` finds all equilibria with it."""

SETTLED = 1e-9
"""Distance of a Newton step, below which a shape is an equilibrium [rad of the softest section]. Chosen:
quadratic there, the method is at rounding a step later."""


@dataclass(frozen=True)
class Equilibrium:
    """One equilibrium.

    Attributes:
        state: the robot at rest. tip: [m], shape (3,). energy: potential [J].
        stability: smallest eigenvalue of the tangent stiffness, relative to the unloaded robot's; negative: unstable.
        share: of the load that it bears [-].
    """

    state: StrainState
    tip: Array
    energy: float
    stability: float
    share: float = 1.0

    @property
    def stable(self) -> bool:
        """True if it comes back after a disturbance."""
        return self.stability > 0.0


class Potential:
    """Potential energy of a robot under loads, of which a share acts; its own weight acts whole.

    Args:
        rod: the robot.
        loads: dead loads and tensions.
    """

    def __init__(self, rod: StrainRod, loads: Loads) -> None:
        self.rod, self.loads, self.layout, self.work = rod, loads, rod.layout, scratch_for(rod.layout)
        self.stiffness = cho_factor(rod.layout.stiffness)
        self.unit = min(min(one.bending_stiffness) / one.length for one in rod.robot.sections)

    def at(self, share: float) -> Loads:
        """Return the loads of a share."""
        loads = self.loads
        return loads._replace(force=share * loads.force, tension=share * loads.tension, moment=share * loads.moment)

    def gradient(self, q: Array, share: float = 1.0) -> tuple[Array, float]:
        """Return the gradient, shape (n,), and the energy [J]."""
        energy, _ = find_energy(self.layout, self.at(share), q, 0.0, self.work)
        return self.work.residual.copy(), float(energy)

    def tangent(self, q: Array, share: float = 1.0) -> Array:
        """Return the second derivative, shape (n, n)."""
        return stiffness_of(self.layout, self.at(share), q, self.work)

    def size(self, change: Array) -> float:
        """Return the distance of two shapes by their difference."""
        return math.sqrt(float(change @ self.layout.stiffness @ change) / self.unit)

    def left(self, gradient: Array) -> float:
        """Return the distance that the unloaded robot would yield to a residual."""
        return self.size(cho_solve(self.stiffness, gradient))

    def equilibrium(self, q: Array, share: float = 1.0) -> Equilibrium:
        """Return an equilibrium with its tip, energy and stability."""
        state = StrainState(q.copy(), np.zeros_like(q))
        stability = self.rod.stability(state, self.at(share))
        return Equilibrium(state, self.rod.tip(state)[0], self.gradient(q, share)[1], stability, share)


def solved(matrix: Array, right: Array) -> Array:
    """Return the solution of a linear system."""
    return np.asarray(np.linalg.solve(matrix, right), dtype=np.float64)
