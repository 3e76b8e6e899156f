"""The equations at one point of the rod: Cosserat rod with tendons (Danesh and Janabi-Sharifi, section 2, corrected).

All vectors are shape (3,) and in the body frame unless the name says world. Symbols: position p [m, world], rotation R
(body to world), v [-], u [1/m], q [m/s], w [rad/s], internal force n [N] and moment m [N m]; _s and _t are derivatives.

The linear strain v - v* is carried instead of v, and v is formed from it. The equation is the same (v* is constant),
but v is close to 1 and EA is 6e5 N: the last bit of v would be 1e-10 N of internal force.
"""

from __future__ import annotations

from dataclasses import dataclass, field, fields

import numpy as np

from tests.reference.rod import Array, ReferenceRod, hat

STRAIN, U, Q, W, V_S, U_S = range(6)
"""Rows of y, shape (6, 3): the quantities of a point that have a history in time. (v - v*)_t is v_t."""


@dataclass(frozen=True, eq=False)
class Loads:
    """Loads on the rod. Vectors are in the world frame, shape (3,)."""

    tensions: Array
    """T_i [N], shape (n,)."""
    gravity: Array
    """g [m/s^2]."""
    tip_force_world: Array = field(default_factory=lambda: np.zeros(3))
    """Force on the tip [N]."""
    tip_moment_world: Array = field(default_factory=lambda: np.zeros(3))
    """Moment on the tip [N m]."""
    distributed_force_world: Array = field(default_factory=lambda: np.zeros(3))
    """f_ext [N/m], the same all along the rod."""
    distributed_moment_world: Array = field(default_factory=lambda: np.zeros(3))
    """l_ext [N], the same all along the rod."""

    def blend(self, other: Loads, fraction: float) -> Loads:
        """These loads at fraction 0, the other ones at fraction 1, on a straight line between."""
        pairs = {name: (getattr(self, name), getattr(other, name)) for name in (entry.name for entry in fields(self))}
        return Loads(**{name: (1.0 - fraction) * mine + fraction * theirs for name, (mine, theirs) in pairs.items()})


@dataclass(frozen=True, eq=False)
class Point:
    """The rod at one point of arc length."""

    y: Array
    """v - v*, u, q, w, v_s, u_s, shape (6, 3)."""
    y_t: Array
    """Their derivatives by time, shape (6, 3)."""
    p_s: Array
    """World frame, shape (3,)."""
    R_s: Array
    """Shape (3, 3)."""
    y_s: Array
    """Derivatives by arc length of v, u, q, w, shape (4, 3)."""


def tendon_slopes(rod: ReferenceRod, v: Array, u: Array) -> Array:
    """p_i' = u x r_i + v: the derivative of each tendon's path by arc length [-], shape (n, 3)."""
    return rod.tendon_positions @ hat(u).T + v


def tendon_second_slopes(rod: ReferenceRod, v: Array, u: Array, v_s: Array, u_s: Array) -> Array:
    """p_i'' = u x p_i' + u_s x r_i + v_s [1/m], shape (n, 3)."""
    return tendon_slopes(rod, v, u) @ hat(u).T + rod.tendon_positions @ hat(u_s).T + v_s


def tendon_terms(rod: ReferenceRod, tensions: Array, v: Array, u: Array) -> tuple[Array, Array, Array]:
    """Parts of the tendons in the 6x6 system: its block [[A, G], [B, H]], shape (6, 6), and a and b, shape (3,)."""
    block, a, b = np.zeros((6, 6)), np.zeros(3), np.zeros(3)
    hat_u = hat(u)
    for T, r_hat, slope in zip(tensions, rod.tendon_hats, tendon_slopes(rod, v, u), strict=True):
        slope_hat = hat(slope)
        A_i = (-T / (slope @ slope) ** 1.5) * slope_hat @ slope_hat
        B_i = r_hat @ A_i
        a_i = A_i @ (hat_u @ slope)
        block[:3, :3] += A_i
        block[:3, 3:] -= A_i @ r_hat
        block[3:, :3] += B_i
        block[3:, 3:] -= B_i @ r_hat
        a += a_i
        b += r_hat @ a_i
    return block, a, b


def internal_force(rod: ReferenceRod, strain: Array, v_t: Array) -> Array:
    """n = Kse (v - v*) + Bse v_t [N]."""
    return rod.Kse @ strain + rod.Bse @ v_t


def internal_moment(rod: ReferenceRod, u: Array, u_t: Array) -> Array:
    """m = Kbt (u - u*) + Bbt u_t [N m]."""
    return rod.Kbt @ (u - rod.u_star) + rod.Bbt @ u_t


def evaluate(rod: ReferenceRod, loads: Loads, c0: float, y_h: Array, R: Array, state: Array) -> Point:
    """Everything at one point from its state v - v*, u, q, w, shape (4, 3), and its history y_h, shape (6, 3).

    y_t = c0 y + y_h; c0 = 0 and y_h = 0 is statics.
    """
    strain, u, q, w = state
    v = rod.v_star + strain
    v_t, u_t, q_t, w_t = c0 * state + y_h[:4]
    n = internal_force(rod, strain, v_t)
    m = internal_moment(rod, u, u_t)

    block, a, b = tendon_terms(rod, loads.tensions, v, u)
    block[:3, :3] += rod.Kse + c0 * rod.Bse
    block[3:, 3:] += rod.Kbt + c0 * rod.Bbt
    force = (
        rod.rhoA * (hat(w) @ q + q_t)
        - rod.rhoA * R.T @ loads.gravity
        + rod.C @ (q * np.abs(q))
        - R.T @ loads.distributed_force_world
        - a
        - hat(u) @ n
        - rod.Bse @ y_h[V_S]
    )
    moment = (
        hat(w) @ rod.rhoJ @ w
        + rod.rhoJ @ w_t
        - hat(v) @ n
        - R.T @ loads.distributed_moment_world
        - b
        - hat(u) @ m
        - rod.Bbt @ y_h[U_S]
    )
    solved = np.linalg.solve(block, np.concatenate([force, moment]))
    v_s, u_s = solved[:3], solved[3:]

    q_s = v_t - hat(u) @ q + hat(w) @ v
    w_s = u_t - hat(u) @ w
    y = np.array([strain, u, q, w, v_s, u_s])
    return Point(y=y, y_t=c0 * y + y_h, p_s=R @ v, R_s=R @ hat(u), y_s=np.array([v_s, u_s, q_s, w_s]))


def tip_residual(rod: ReferenceRod, loads: Loads, R: Array, point: Point) -> Array:
    """n(L) and m(L) less what tendons and external loads ask for [N, N m], body frame, shape (6,)."""
    strain, u = point.y[STRAIN], point.y[U]
    v = rod.v_star + strain
    n = R.T @ loads.tip_force_world
    m = R.T @ loads.tip_moment_world
    for T, r_hat, slope in zip(loads.tensions, rod.tendon_hats, tendon_slopes(rod, v, u), strict=True):
        pull = -T * slope / np.linalg.norm(slope)
        n = n + pull
        m = m + r_hat @ pull
    if rod.tip_mass > 0.0:  # Newton and Euler about the centre of mass, moved to the tip
        q, w, q_t, w_t = point.y[Q], point.y[W], point.y_t[Q], point.y_t[W]
        centre = q_t + hat(w) @ q + hat(w_t) @ rod.tip_offset + hat(w) @ hat(w) @ rod.tip_offset
        held = rod.tip_mass * (R.T @ loads.gravity - centre)
        J = np.diag(rod.tip_inertia)
        n = n + held
        m = m + hat(rod.tip_offset) @ held - J @ w_t - hat(w) @ J @ w
    return np.concatenate(
        [
            internal_force(rod, strain, point.y_t[STRAIN]) - n,
            internal_moment(rod, u, point.y_t[U]) - m,
        ]
    )
