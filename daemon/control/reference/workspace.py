"""Where the tip can rest under the pull of all tendons: a surface, and the bending that holds the tip at a place on it.

The bending moment M has two components, so the resting tips are a surface. Without gravity it is one of revolution;
gravity across the rod shears it. Nothing is tabulated: a place is found by Gauss and Newton's method on the rod's
statics, from the constant curvature that is nearest to it, or from the place before it.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError
from tendond.model.rod.rod import Rod
from tendond.model.rod.state import RodState
from tendond.model.tendons.allocation import Allocation

Array = NDArray[np.float64]

DIFFERENCE = 2e-3
"""[N m] For derivatives by the moment: 0.1 N at an arm of 20 mm; the statics are good to 1e-6 N."""

STEPS = 40
CLOSE = 1e-7
"""[m or rad] A step that moves the tip by less ends the search."""

MOST_BENT = 1.5 * math.pi
"""[rad] Of the first guess: beyond this the tip comes back to the straight rod."""


@dataclass(frozen=True)
class Rest:
    """An equilibrium.

    Attributes:
        moment: M [N m], shape (2,).
        state: of the rod.
        place: the tip's position [m] and direction [-], shape (6,).
        answer: of `place` to M, shape (6, 2).
    """

    moment: Array
    state: RodState
    place: Array
    answer: Array

    def seen(self, aim: str, count: int) -> tuple[Array, Array]:
        """What is compared with a wanted place, shape (count,), and its derivative, shape (count, 2).

        Args:
            aim: 'position' or 'direction'.
            count: 3: all of it; 2: of a position x and y; of a direction the tilt towards x and y.
        """
        if aim == "position":
            return self.place[:count], self.answer[:count]
        direction, answer = self.place[3:], self.answer[3:]
        if count == 3:
            return direction, answer
        across = math.hypot(direction[0], direction[1])
        if across < 1e-6:
            return direction[:2], answer[:2]
        angle, outward = math.atan2(across, direction[2]), direction[:2] / across
        radial = outward @ answer[:2]
        turning = answer[:2] - np.outer(outward, radial)
        widening = direction[2] * radial - across * answer[2]
        return angle * outward, np.outer(outward, widening) + (angle / across) * turning


class Surface:
    """The resting tips of a rod without load but its own weight, under tensions that an allocation makes of a moment.

    Args:
        rod: the controller's model.
        allocation: of its tendons.
    """

    def __init__(self, rod: Rod, allocation: Allocation) -> None:
        self.rod = rod
        self.allocation = allocation

    def rest(self, moment: Array, start: Rest | None = None) -> Rest:
        """The equilibrium under a moment [N m], shape (2,), from a neighbouring one.

        Raises:
            ConvergenceError: there is none.
        """
        place, state = self._solve(moment, None if start is None else start.state)
        columns = []
        for axis in range(2):
            moved = moment.copy()
            # inward, where the bounds of the tensions are near
            moved[axis] += DIFFERENCE * (-1.0 if moment[axis] > 0.0 else 1.0)
            columns.append((self._solve(moved, state)[0] - place) / (moved[axis] - moment[axis]))
        return Rest(moment, state, place, np.column_stack(columns))

    def find(self, wanted: Array, aim: str, *, far: bool = False, start: Rest | None = None) -> tuple[Rest, Array]:
        """The equilibrium whose tip is nearest to what is wanted, and what that misses, shape (count,).

        Args:
            wanted: see `Rest.seen`, shape (count,).
            aim: likewise.
            far: of two shapes with the same x and y, the one that is bent further.
            start: a neighbouring one; without it, the nearest constant curvature.

        Raises:
            ConvergenceError: the rod has no equilibrium on the way.
        """
        count = len(wanted)
        rest = self.rest(self._nearest_arc(wanted, aim, far)) if start is None else start
        seen, answer = rest.seen(aim, count)
        missing, ridge = wanted - seen, 0.0
        for _ in range(STEPS):
            step = self._step(rest.moment, answer, missing, ridge)
            if float(np.max(np.abs(answer @ step))) < CLOSE:
                break
            try:
                trial = self.rest(rest.moment + step, rest)
            except ConvergenceError:
                ridge = max(10.0 * ridge, 1e-2)
                continue
            seen, answer_there = trial.seen(aim, count)
            if float(np.sum((wanted - seen) ** 2)) < float(np.sum(missing**2)):
                rest, answer, missing = trial, answer_there, wanted - seen
                ridge = 0.0 if ridge < 1e-3 else 0.1 * ridge
            elif ridge > 1e6:
                break
            else:
                ridge = max(10.0 * ridge, 1e-2)
        return rest, missing

    def _solve(self, moment: Array, start: RodState | None) -> tuple[Array, RodState]:
        state = self.rod.solve_static(self.allocation.tensions(moment), start=start)
        tip = self.rod.tip(state)
        return np.concatenate([tip.position, tip.rotation[:, 2]]), state

    def _step(self, moment: Array, answer: Array, missing: Array, ridge: float) -> Array:
        """Least-squares step of the moment, damped by `ridge`, within what the tendons can give."""
        square = answer.T @ answer
        square = square + (ridge + 1e-9) * np.trace(square) * np.eye(2)
        right = answer.T @ missing
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

    def _nearest_arc(self, wanted: Array, aim: str, far: bool) -> Array:
        """Moment of the constant curvature, without weight, that comes nearest."""
        parameters = self.rod.parameters
        azimuth = math.atan2(wanted[1], wanted[0])
        bend = np.linspace(1e-3, MOST_BENT, 400)
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
                apart[: furthest if far else 0] = math.inf
                apart[len(apart) if far else furthest + 1 :] = math.inf
            angle = float(bend[int(np.argmin(apart))])
        size = angle * parameters.bending_stiffness / parameters.length
        return self.allocation.nearest(size * np.array([math.cos(azimuth), math.sin(azimuth)]))
