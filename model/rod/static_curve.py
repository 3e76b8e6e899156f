"""The curve of the resting tip under the tension of one tendon, for references that a rod can follow."""

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

from tendond.model.errors import ConvergenceError
from tendond.model.rods.interface import ModelRod

Array = NDArray[np.float64]
Pair = tuple[float, float]
"""Coordinates in the bending plane: across the straight rod, and along it."""

POINTS = 161
"""Number of equilibria through which the curve is interpolated."""


@dataclass(frozen=True)
class StaticCurve:
    """Tip of the resting rod against the tension of one tendon, the others slack; `k` equilibria and a spline.

    Attributes:
        axes: axes of the bending plane, across the straight rod and along it: indices of world axes.
        tension: [N], shape (k,), increasing.
        arc: distance travelled by the tip from the first equilibrium [m], shape (k,), increasing.
        displacement: displacement of that tendon's end, its own stretch included [m], shape (k,).
        angle: angle between the tip's direction and the straight rod [rad], in the plane, shape (k,).
        spline: spline of the tip's two coordinates in the plane against `arc` [m]; twice differentiable.
    """

    axes: tuple[int, int]
    tension: Array
    arc: Array
    displacement: Array
    angle: Array
    spline: CubicSpline

    @property
    def length(self) -> float:
        """Length of the curve [m]."""
        return float(self.arc[-1])

    def at(self, arc: float) -> tuple[Array, Array, Array]:
        """Point, first and second derivative by arc length [m, -, 1/m], each of shape (2,); ends are held."""
        inside = min(max(arc, 0.0), self.length)
        return self.spline(inside), self.spline(inside, 1), self.spline(inside, 2)

    def nearest(self, points: Array) -> Array:
        """Arc lengths [m], shape (m,), of the curve's points nearest to `points` [m], shape (m, 2)."""
        fine = np.linspace(0.0, self.length, 8 * len(self.arc))
        curve = self.spline(fine)
        return np.array([fine[np.argmin(np.sum((curve - point) ** 2, axis=1))] for point in np.atleast_2d(points)])

    def where_across(self, across: float) -> Array:
        """Arc lengths [m] at which the component across the rod is `across` [m]; increasing, may be empty."""
        return _roots(self.arc, self.spline(self.arc)[:, 0], across)

    def where_angle(self, angle: float) -> Array:
        """Arc lengths [m] at which the tip's direction is at `angle` [rad]; increasing, may be empty."""
        return _roots(self.arc, self.angle, angle)

    def tension_at(self, arc: float) -> float:
        """Tension [N] that holds the tip there."""
        return float(np.interp(arc, self.arc, self.tension))


def point_evaluator(spline: CubicSpline) -> Callable[[float], tuple[Pair, Pair, Pair]]:
    """Value and first two derivatives of a spline in the plane, for one point at a time.

    The same as scipy's to the last bit, in a twentieth of the time.
    """
    knots: list[float] = spline.x.tolist()
    pieces: Any = spline.c.transpose(1, 0, 2).tolist()

    def at(x: float) -> tuple[Pair, Pair, Pair]:
        k = min(max(bisect_right(knots, x) - 1, 0), len(pieces) - 1)
        (a3, b3), (a2, b2), (a1, b1), (a0, b0) = pieces[k]
        t = x - knots[k]
        t2 = t * t
        t3 = t2 * t
        return (
            (a0 + a1 * t + a2 * t2 + a3 * t3, b0 + b1 * t + b2 * t2 + b3 * t3),
            (a1 + a2 * t * 2.0 + a3 * t2 * 3.0, b1 + b2 * t * 2.0 + b3 * t2 * 3.0),
            (a2 * 2.0 + a3 * t * 6.0, b2 * 2.0 + b3 * t * 6.0),
        )

    return at


def _roots(arc: Array, values: Array, wanted: float) -> Array:
    """Arc lengths at which a spline through `values` equals `wanted`, increasing."""
    found = CubicSpline(arc, values).solve(wanted, extrapolate=False)
    return np.sort(found[np.isfinite(found)])


def static_curve(rod: ModelRod, tendon: int, tension_max: float, axes: tuple[int, int]) -> StaticCurve:
    """Compute the curve of a rod under its own weight.

    Args:
        rod: solved with its own scheme: a coarse one has its own curve.
        tendon: index of the one that pulls.
        tension_max: [N]; the curve ends earlier where the rod has no further equilibrium.
        axes: axes of the bending plane.

    Raises:
        ConvergenceError: the slack rod has no equilibrium.
    """
    # Near the straight rod a newton moves the tip twenty times as far as at a full bend: points by the square root.
    tensions = tension_max * np.linspace(0.0, 1.0, POINTS) ** 2
    pull = np.zeros(rod.parameters.tendon_count)
    state = rod.solve_static(pull)
    tips, displacements = [rod.tip(state)], [rod.displacements(state, elastic=True)[tendon]]
    for tension in tensions[1:]:
        pull[tendon] = tension
        try:
            state = rod.solve_static(pull, start=state)
        except ConvergenceError:
            break
        tips.append(rod.tip(state))
        displacements.append(rod.displacements(state, elastic=True)[tendon])
    points = np.array([tip.position[list(axes)] for tip in tips])
    directions = np.array([tip.rotation[:, 2][list(axes)] for tip in tips])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    angle = np.unwrap(np.arctan2(directions[:, 0], directions[:, 1]))
    return StaticCurve(axes, tensions[: len(tips)], arc, np.array(displacements), angle, CubicSpline(arc, points))
