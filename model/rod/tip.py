"""The tip as control laws use it: position, motion, and the acceleration per tension of each tendon."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import kernel
from tendond.model.numerics.vectors import add, cross, dot, rotate, scale, sub
from tendond.model.solver.equations import stretch
from tendond.model.solver.lanes import vector
from tendond.model.solver.problem import RodData

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Tip:
    """The tip in the world frame.

    Attributes:
        position: [m], shape (3,).
        rotation: body to world, shape (3, 3).
        velocity: R q [m/s], shape (3,).
        acceleration: R (q_t + w x q) [m/s^2], shape (3,).
        input_gain: b_c [m/s^2/N], shape (3, n), column i the acceleration per tension of tendon i; the paper's
            b_c = -alpha_M / (rho A), alpha_i = hat(p_i')^2 p_i'' / |p_i'|^3.
        tension: now applied [N], shape (n,).
    """

    position: Array
    rotation: Array
    velocity: Array
    acceleration: Array
    input_gain: Array
    tension: Array

    @property
    def drift(self) -> Array:
        """a_c = (n_s + f_e) / (rho A) = acceleration - b_c T [m/s^2], shape (3,)."""
        return self.acceleration - self.input_gain @ self.tension


@kernel
def tip_quantities(rod: RodData, c0: float, level: Any, history: Any, place: Any, out: Any) -> None:
    """Write position 3, rotation 9, velocity 3, acceleration 3, b_c row by row to `out`, shape (18 + 3 n,).

    `level`, `history` are the tip's rows of e = v - v*, u, q, w, v_s, u_s and of their y_h; `place` its p, R.
    """
    R = (place[3], place[4], place[5], place[6], place[7], place[8], place[9], place[10], place[11])
    v, u, q, w = stretch(vector(level, 0)), vector(level, 3), vector(level, 6), vector(level, 9)
    v_s, u_s = vector(level, 12), vector(level, 15)
    q_t = add(scale(c0, q), vector(history, 6))
    for j in range(12):
        out[j] = place[j]
    out[12], out[13], out[14] = rotate(R, q)
    out[15], out[16], out[17] = rotate(R, add(q_t, cross(w, q)))
    n = rod.tendons
    for i in range(n):
        r = (rod.x[i], rod.y[i], 0.0)
        P = add(v, cross(u, r))
        P_s = add(cross(u, P), add(cross(u_s, r), v_s))
        size = math.sqrt(dot(P, P))
        # -hat(P)^2 P_s / |P|^3 = (P_s |P|^2 - P (P . P_s)) / |P|^3
        gain = scale(1.0 / (rod.constants[0].rhoA * size), sub(P_s, scale(dot(P, P_s) / (size * size), P)))
        gain_world = rotate(R, gain)
        for j in range(3):
            out[18 + n * j + i] = gain_world[j]
