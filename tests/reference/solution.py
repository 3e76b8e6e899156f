"""One solved state of the rod: the sweep that met the tip condition, and what the next time step needs of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from tests.reference.equations import STRAIN, U_S, V_S, Loads, Q, U, W, tendon_second_slopes, tendon_slopes
from tests.reference.rod import Array, ReferenceRod, hat
from tests.reference.schemes import Scheme
from tests.reference.sweep import Sweep


@dataclass(frozen=True, eq=False)
class Tip:
    """The tip, world frame, n tendons."""

    position: Array
    """Position [m], shape (3,)."""
    R: Array
    """Body to world, shape (3, 3)."""
    velocity: Array
    """R q [m/s], shape (3,)."""
    acceleration: Array
    """R (w x q + q_t) [m/s^2], shape (3,)."""
    b_c: Array
    """-alpha_M / (rho A) [1/kg]: tip acceleration by tension at unchanged internal force, shape (3, n)."""


@dataclass(frozen=True, eq=False)
class Solution:
    """A static shape, or the end of a time step; P points, n tendons."""

    rod: ReferenceRod
    scheme: Scheme
    loads: Loads
    base_load: Array
    """n(0) [N], m(0) [N m], shape (6,): the unknowns of the shooting."""
    sweep: Sweep
    y_previous: Array
    """y one time step earlier, shape (P, 6, 3)."""
    y_t: Array
    """Derivatives of y by time at this instant: zero for a static shape, shape (P, 6, 3)."""

    @property
    def history(self) -> Array:
        """y_h of the next time step: c1 y(i-1) + c2 y(i-2) + d1 y_t(i-1), shape (P, 6, 3)."""
        return self.rod.c1 * self.sweep.y + self.rod.c2 * self.y_previous + self.rod.d1 * self.y_t

    @property
    def tensions(self) -> Array:
        """T_i [N], shape (n,)."""
        return self.loads.tensions

    @property
    def residual(self) -> Array:
        """Force [N] and moment [N m] left over at the tip, body frame, shape (6,)."""
        return self.sweep.residual

    @property
    def tendon_path_lengths(self) -> Array:
        """Path length of each tendon [m], shape (n,)."""
        return self.sweep.path_lengths

    @property
    def tendon_displacements(self) -> Array:
        """L less the path length [m], shape (n,): positive where the tendon got shorter; without elastic stretch."""
        return self.rod.length - self.sweep.path_lengths

    @property
    def positions(self) -> Array:
        """Position of the nodes [m], world frame, shape (nodes, 3)."""
        return self.sweep.p[:: self.scheme.tableau.stages]

    @property
    def rotations(self) -> Array:
        """Rotation of the nodes, body to world, shape (nodes, 3, 3)."""
        return self.sweep.R[:: self.scheme.tableau.stages]

    def nodes(self, quantity: int) -> Array:
        """A row of y (equations.U and so on; v with v* taken off) at the nodes, body frame, shape (nodes, 3)."""
        return self.sweep.y[:: self.scheme.tableau.stages, quantity]

    @property
    def v(self) -> Array:
        """v of the nodes [-], body frame, shape (nodes, 3)."""
        return self.rod.v_star + self.nodes(STRAIN)

    @cached_property
    def tip(self) -> Tip:
        """The last node."""
        p, R, y, y_t = self.sweep.p[-1], self.sweep.R[-1], self.sweep.y[-1], self.y_t[-1]
        v = self.rod.v_star + y[STRAIN]
        first = tendon_slopes(self.rod, v, y[U])
        second = tendon_second_slopes(self.rod, v, y[U], y[V_S], y[U_S])
        alpha_M = np.column_stack(
            [
                R @ hat(slope) @ hat(slope) @ curve / np.linalg.norm(slope) ** 3
                for slope, curve in zip(first, second, strict=True)
            ]
        )
        return Tip(
            position=p,
            R=R,
            velocity=R @ y[Q],
            acceleration=R @ (hat(y[W]) @ y[Q] + y_t[Q]),
            b_c=-alpha_M / self.rod.rhoA,
        )
