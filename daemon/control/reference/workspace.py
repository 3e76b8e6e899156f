"""The surface of the tip's equilibria under all tendons, and the bending moment that holds the tip at a place on it.

The bending moment M has two components, so the resting tips form a surface. Without gravity it is one of revolution;
gravity across the rod shears it. Nothing is tabulated: a place is found by the Gauss-Newton method on the rod's
statics, starting from the nearest constant curvature, or from the place before it.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError
from tendond.model.rods.interface import ModelRod, ModelState
from tendond.model.tendons.allocation import Allocation

Array = NDArray[np.float64]

DIFFERENCE = 2e-3
"""Step of the finite differences by the moment on the paper's robot [N m], on others in proportion to EI/L: 0.1 N at an
arm of 20 mm; the statics are accurate to 1e-6 N."""

STEPS = 40
"""Largest number of Gauss-Newton steps."""

CLOSE = 1e-7
"""Motion of the tip below which a step ends the search [rad, or of 2 L]."""

BEND_MAX = 1.5 * math.pi
"""Largest bend of the first guess [rad]: beyond it the tip comes back to the straight rod."""


@dataclass(frozen=True)
class WorkspaceRest:
    """An equilibrium.

    Attributes:
        moment: M [N m], shape (2,).
        state: state of the rod.
        place: position [m] and direction [-] of the tip, shape (6,).
        jacobian: derivative of `place` by M, shape (6, 2).
    """

    moment: Array
    state: ModelState
    place: Array
    jacobian: Array

    def compared(self, aim: str, count: int) -> tuple[Array, Array]:
        """Return what is compared with a wanted place, shape (count,), and its derivative, shape (count, 2).

        Args:
            aim: 'position' or 'direction'.
            count: 3: all of it; 2: of a position x and y; of a direction the tilt towards x and y.
        """
        if aim == "position":
            return self.place[:count], self.jacobian[:count]
        direction, jacobian = self.place[3:], self.jacobian[3:]
        if count == 3:
            return direction, jacobian
        across = math.hypot(direction[0], direction[1])
        if across < 1e-6:
            return direction[:2], jacobian[:2]
        angle, outward = math.atan2(across, direction[2]), direction[:2] / across
        radial = outward @ jacobian[:2]
        turning = jacobian[:2] - np.outer(outward, radial)
        widening = direction[2] * radial - across * jacobian[2]
        return angle * outward, np.outer(outward, widening) + (angle / across) * turning


class Surface:
    """The resting tips of a rod under its own weight alone, with the tensions that an allocation makes of a moment.

    Args:
        rod: the controller's model.
        allocation: map from moments to tensions of its tendons.
    """

    def __init__(self, rod: ModelRod, allocation: Allocation) -> None:
        self.rod = rod
        self.allocation = allocation

    def rest(self, moment: Array, start: WorkspaceRest | None = None) -> WorkspaceRest:
        """Solve the equilibrium under a moment [N m], shape (2,), from a neighbouring one.

        Raises:
            ConvergenceError: there is none.
        """
        place, state = self._solve(moment, None if start is None else start.state)
        columns = []
        for axis in range(2):
            moved = moment.copy()
            # inward, where the bounds of the tensions are near
            moved[axis] += DIFFERENCE * self.rod.parameters.moment_scale * (-1.0 if moment[axis] > 0.0 else 1.0)
            columns.append((self._solve(moved, state)[0] - place) / (moved[axis] - moment[axis]))
        return WorkspaceRest(moment, state, place, np.column_stack(columns))

    def find(
        self, wanted: Array, aim: str, *, above_135: bool = False, start: WorkspaceRest | None = None
    ) -> tuple[WorkspaceRest, Array]:
        """Find the equilibrium whose tip is nearest to a wanted place, and what is missing to it, shape (count,).

        Args:
            wanted: see `WorkspaceRest.compared`, shape (count,).
            aim: likewise.
            above_135: of two shapes with the same x and y, the one bent by more than about 135 degrees, where the tip
                turns back.
            start: a neighbouring one; without it, the nearest constant curvature.

        Raises:
            ConvergenceError: the search leaves the rod's equilibria.
        """
        count = len(wanted)
        rest = self.rest(self._nearest_arc(wanted, aim, above_135)) if start is None else start
        place, jacobian = rest.compared(aim, count)
        missing, ridge = wanted - place, 0.0
        close = CLOSE * (2.0 * self.rod.parameters.length if aim == "position" else 1.0)
        for _ in range(STEPS):
            step = self._step(rest.moment, jacobian, missing, ridge)
            if float(np.max(np.abs(jacobian @ step))) < close:
                break
            try:
                trial = self.rest(rest.moment + step, rest)
            except ConvergenceError:
                ridge = max(10.0 * ridge, 1e-2)
                continue
            place, jacobian_there = trial.compared(aim, count)
            if float(np.sum((wanted - place) ** 2)) < float(np.sum(missing**2)):
                rest, jacobian, missing = trial, jacobian_there, wanted - place
                ridge = 0.0 if ridge < 1e-3 else 0.1 * ridge
            elif ridge > 1e6:
                break
            else:
                ridge = max(10.0 * ridge, 1e-2)
        return rest, missing

    def _solve(self, moment: Array, start: ModelState | None) -> tuple[Array, ModelState]:
        state = self.rod.solve_static(self.allocation.tensions(moment), start=start)
        tip = self.rod.tip(state)
        return np.concatenate([tip.position, tip.rotation[:, 2]]), state

    def _step(self, moment: Array, jacobian: Array, missing: Array, ridge: float) -> Array:
        """Return the least-squares step of the moment, damped by `ridge`, within the feasible moments."""
        square = jacobian.T @ jacobian
        square = square + (ridge + 1e-9) * np.trace(square) * np.eye(2)
        right = jacobian.T @ missing
        step = np.linalg.solve(square, right)
        inside = self.allocation.nearest(moment + step)
        if np.array_equal(inside, moment + step):
            return step
        # A convex quadratic whose minimum is outside a convex polygon has it on a side.
        first = self.allocation.corners - moment
        side = np.roll(first, -1, axis=0) - first
        slope = np.einsum("ki,ki->k", side, right - first @ square)
        curvature = np.einsum("ki,ij,kj->k", side, square, side)
        part = np.clip(np.divide(slope, curvature, out=np.zeros_like(slope), where=curvature > 0.0), 0.0, 1.0)
        ends = first + part[:, None] * side
        cost = 0.5 * np.einsum("ki,ij,kj->k", ends, square, ends) - ends @ right
        return np.asarray(ends[int(np.argmin(cost))])

    def _nearest_arc(self, wanted: Array, aim: str, above_135: bool) -> Array:
        """Return the moment of the weightless constant curvature that comes nearest."""
        parameters = self.rod.parameters
        azimuth = math.atan2(wanted[1], wanted[0])
        bend = np.linspace(1e-3, BEND_MAX, 400)
        if aim == "direction":
            across = math.hypot(wanted[0], wanted[1])
            angle = across if len(wanted) == 2 else math.atan2(across, wanted[2])
        else:
            out, along = parameters.length * (1.0 - np.cos(bend)) / bend, parameters.length * np.sin(bend) / bend
            apart = (out - math.hypot(wanted[0], wanted[1])) ** 2
            if len(wanted) == 3:
                apart = apart + (along - wanted[2]) ** 2
            else:
                furthest = int(np.argmax(out))
                apart[: furthest if above_135 else 0] = math.inf
                apart[len(apart) if above_135 else furthest + 1 :] = math.inf
            angle = float(bend[int(np.argmin(apart))])
        size = angle * parameters.bending_stiffness / parameters.length
        return self.allocation.nearest(size * np.array([math.cos(azimuth), math.sin(azimuth)]))
