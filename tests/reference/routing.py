"""Statics of a rod with any tendon routing, by the balance of a cut: an independent check, plain and slow.

A cut at s goes through backbone and tendons. Tendons slide without friction, so that each carries its tension
everywhere up to where it ends; what is beyond the cut is in balance (D. C. Rucker, R. J. Webster, "Statics and dynamics
of continuum robots with general tendon routing and external loading", IEEE T-RO 27, 2011, in integral form):

    n(s) + sum T_i t_i(s) = F,      m(s) + sum T_i (R r_i) x t_i(s) = (p(L) - p(s)) x F + M,

t_i the unit tangent of tendon i, F and M at the tip, dead. Shear is rigid. Unknown is p(L) alone.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp
from scipy.optimize import root

Array = npt.NDArray[np.float64]
Route = Callable[[float], tuple[float, float]]
Pull = tuple[float, float, Route]
"""Tension [N], end [m] and route in the cross-section [m] of a tendon."""


@dataclass(frozen=True)
class Piece:
    """A uniform stretch of backbone: length [m], EI about x and y, GJ [N m^2], EA [N], precurvature u* [1/m]."""

    length: float
    stiffness: tuple[float, float, float]
    axial: float
    curvature: tuple[float, float, float] = (0.0, 0.0, 0.0)


def _strain(
    piece: Piece, pulls: Sequence[tuple[float, Array, Array]], moment: Array, force: Array, guess: Array
) -> Array:
    """Curvature and stretch (u, v3) at a cut, where `pulls` are tension, place and slope of each tendon, body frame."""

    def missing(x: Array) -> Array:
        u, v = x[:3], np.array([0.0, 0.0, x[3]])
        n = piece.axial * (x[3] - 1.0)
        m = np.array(piece.stiffness) * (u - np.array(piece.curvature))
        for tension, r, slope in pulls:
            tangent = v + np.cross(u, r) + slope
            tangent = tangent / np.linalg.norm(tangent)
            n += tension * tangent[2]
            m = m + tension * np.cross(r, tangent)
        lacking: Array = np.concatenate((m - moment, [n - force[2]])) / np.array([*piece.stiffness, piece.axial])
        return lacking

    found = root(missing, guess, tol=1e-12)
    assert np.max(np.abs(found.fun)) < 1e-9
    return np.asarray(found.x)


def solve_routing(
    pieces: Sequence[Piece],
    tendons: Sequence[Pull],
    tip_force: Sequence[float] = (0.0, 0.0, 0.0),
    tip_moment: Sequence[float] = (0.0, 0.0, 0.0),
    guess: Array | None = None,
) -> tuple[Array, Array]:
    """Return tip position [m] and orientation; tendons as (tension [N], end [m], route in the cross-section [m])."""
    F, M = np.array(tip_force, dtype=float), np.array(tip_moment, dtype=float)
    step = 1e-6

    def run(tip: Array) -> tuple[Array, Array]:
        state, begin = np.concatenate((np.zeros(3), np.eye(3).ravel())), 0.0
        last = np.array([0.0, 0.0, 0.0, 1.0])
        for piece in pieces:
            edges = sorted(
                {begin, begin + piece.length, *(end for _, end, _ in tendons if begin < end < begin + piece.length)}
            )
            for left, right in pairwise(edges):
                middle = 0.5 * (left + right)
                here = [one for one in tendons if one[0] > 0.0 and one[1] > middle]

                def slope(s: float, y: Array, piece: Piece = piece, here: list[Pull] = here) -> Array:
                    nonlocal last
                    R = y[3:].reshape(3, 3)
                    pulls = []
                    for tension, _, route in here:
                        r = np.array((*route(s), 0.0))
                        d = (np.array(route(s + step)) - np.array(route(s - step))) / (2.0 * step)
                        pulls.append((tension, r, np.array((*d, 0.0))))
                    last = _strain(piece, pulls, R.T @ (np.cross(tip - y[:3], F) + M), R.T @ F, last)
                    x, y_, z = last[:3]
                    hat = np.array([[0.0, -z, y_], [z, 0.0, -x], [-y_, x, 0.0]])
                    return np.concatenate((R @ np.array([0.0, 0.0, last[3]]), (R @ hat).ravel()))

                state = solve_ivp(slope, (left, right), state, rtol=1e-9, atol=1e-11, method="DOP853").y[:, -1]
            begin += piece.length
        return state[:3], state[3:].reshape(3, 3)

    if not F.any():
        return run(np.zeros(3))
    first = run(np.zeros(3))[0] if guess is None else guess

    def missing(tip: Array) -> Array:
        found: Array = run(tip)[0] - tip
        return found

    found = root(missing, first, tol=1e-10)
    assert np.max(np.abs(found.fun)) < 1e-9
    return run(np.asarray(found.x))
