"""The right-hand side of the tendon-driven Cosserat rod, for one point of one rod.

Symbols are those of the field (Rucker & Webster 2011; Till, Aloi & Rucker 2019; Danesh & Janabi-Sharifi): `v` strain
[-], `u` curvature [1/m], `q` velocity [m/s], `w` angular velocity [rad/s], `n` force [N], `m` moment [N m], all in the
body frame; `R` body to world, row by row. Vectors are tuples (see `vectors`) of numbers, which are floats for one rod
and SIMD vectors (see `simd`) for several at once. A march is a chain of points, each of which waits for
the one before: latency counts as much as the number of operations. The order of operations is the one written here.
"""

import math
from typing import Any

from tendond.model.numerics.compile import inlined
from tendond.model.numerics.simd import simd_sum
from tendond.model.numerics.vectors import (
    Vector,
    add,
    cross,
    dot,
    drag,
    rotate,
    rotate_back,
    scale,
    sub,
    symmetric_adjugate,
    symmetric_times,
    times,
)

TendonSums = tuple[tuple[float, ...], tuple[float, ...], tuple[float, ...], Vector, Vector]


@inlined
def stretch(e: Vector) -> Vector:
    """v = v* + e, with v* = (0, 0, 1)."""
    return e[0], e[1], 1.0 + e[2]


@inlined
def tendon_slope(x: Any, y: Any, v: Vector, u: Vector) -> Any:
    """p_i' = v + u x r_i of tendons at r_i = (x, y, 0), body frame [-]."""
    return v[0] - u[2] * y, v[1] + u[2] * x, v[2] + u[0] * y - u[1] * x


@inlined
def tendon_sums(lanes: Any, x: Any, y: Any, tension: Any, v: Vector, u: Vector) -> tuple[TendonSums, Any]:
    """Sum the tendons' terms of the equations; and |p_i'|, their lengths per rod length.

    Args:
        lanes: a tuple, one entry per rod.
        x, y, tension: SIMD vectors of all tendons of all rods, at r = (x, y, 0) in the cross-section [m], [N].
        v, u: of their rods.

    Returns:
        A = sum A_i (11, 12, 13, 22, 23, 33), A_i = -T_i hat(p_i')^2 / |p_i'|^3; B = sum hat(r_i) A_i by rows, but for
        the last component, which is -(B11 + B22); H = -sum hat(r_i) A_i hat(r_i); sum of the pulls T_i p_i' / |p_i'|;
        b = sum r_i x a_i with a_i = A_i (u x p_i') = u x pull_i.
    """
    P = tendon_slope(x, y, v, u)
    P11, P22, P33 = times(P, P)
    square = P11 + P22 + P33
    speed, inverse = math.sqrt(square), 1.0 / square  # at once: neither waits for the other
    c1, c3 = tension * inverse * speed, tension * inverse * inverse * speed
    A11, A22, A33 = c1 - c3 * P11, c1 - c3 * P22, c1 - c3 * P33
    A12, A13, A23 = -c3 * (P[0] * P[1]), -c3 * (P[0] * P[2]), -c3 * (P[1] * P[2])
    B11, B12, B13 = y * A13, y * A23, y * A33
    B21, B22, B23 = -x * A13, -x * A23, -x * A33
    B31, B32 = x * A12 - y * A11, x * A22 - y * A12
    pull = scale(c1, P)
    a = cross(u, pull)
    A = (
        simd_sum(A11, lanes),
        simd_sum(A12, lanes),
        simd_sum(A13, lanes),
        simd_sum(A22, lanes),
        simd_sum(A23, lanes),
        simd_sum(A33, lanes),
    )
    B = (
        simd_sum(B11, lanes),
        simd_sum(B12, lanes),
        simd_sum(B13, lanes),
        simd_sum(B21, lanes),
        simd_sum(B22, lanes),
        simd_sum(B23, lanes),
        simd_sum(B31, lanes),
        simd_sum(B32, lanes),
    )
    H = (
        simd_sum(y * B13, lanes),
        simd_sum(-x * B13, lanes),
        simd_sum(x * B12 - y * B11, lanes),
        simd_sum(-x * B23, lanes),
        simd_sum(x * B22 - y * B21, lanes),
        simd_sum(x * B32 - y * B31, lanes),
    )
    pulls = (simd_sum(pull[0], lanes), simd_sum(pull[1], lanes), simd_sum(pull[2], lanes))
    b = (simd_sum(y * a[2], lanes), simd_sum(-x * a[2], lanes), simd_sum(x * a[1] - y * a[0], lanes))
    return (A, B, H, pulls, b), speed


@inlined
def strain_gradients(
    Kse: Vector, Kbt: Vector, sums: TendonSums, right_n: Vector, right_m: Vector
) -> tuple[Vector, Vector]:
    """Solve the symmetric positive definite 6x6 block for (v_s, u_s) by its Schur complement.

    Inverses are adjugates divided by determinants; work that does not need the two divisions is not delayed by them.
    """
    A, B, H, _, _ = sums
    C, d = symmetric_adjugate((Kse[0] + A[0], A[1], A[2], Kse[1] + A[3], A[4], Kse[2] + A[5]))
    g1, g2, g3 = (B[0], B[1], B[2]), (B[3], B[4], B[5]), (B[6], B[7], -(B[0] + B[4]))
    y1, y2, y3 = symmetric_times(C, g1), symmetric_times(C, g2), symmetric_times(C, g3)
    schur = (
        Kbt[0] + H[0] - d * dot(g1, y1),
        H[1] - d * dot(g1, y2),
        H[2] - d * dot(g1, y3),
        Kbt[1] + H[3] - d * dot(g2, y2),
        H[4] - d * dot(g2, y3),
        Kbt[2] + H[5] - d * dot(g3, y3),
    )
    y1, y2, y3, free = scale(d, y1), scale(d, y2), scale(d, y3), scale(d, symmetric_times(C, right_n))
    D, f = symmetric_adjugate(schur)
    r = symmetric_times(
        D, (right_m[0] - dot(y1, right_n), right_m[1] - dot(y2, right_n), right_m[2] - dot(y3, right_n))
    )
    return sub(free, scale(f, add(scale(r[0], y1), add(scale(r[1], y2), scale(r[2], y3))))), scale(f, r)


@inlined
def rates(
    constants: tuple[Vector, Vector, Vector, Vector, float, Vector, Vector],
    c0: float,
    load_force: Vector,
    load_moment: Vector,
    history: tuple[Vector, Vector, Vector, Vector, Vector, Vector],
    sums: TendonSums,
    R: tuple[float, ...],
    e: Vector,
    u: Vector,
    q: Vector,
    w: Vector,
) -> tuple[Vector, tuple[float, ...], Vector, Vector, Vector, Vector]:
    """Derivatives along the rod (p_s, R_s, v_s, u_s, q_s, w_s) at strain e = v - v*.

    `constants` are Kse, Kbt, Bse, Bbt, rho A, rho J, C (diagonals); `load_force` and `load_moment` the distributed
    loads in the world frame, gravity included [N/m, N]; `history` the parts y_h of v_t, u_t, q_t, w_t, v_st, u_st that
    the past determines; `sums` come from `tendon_sums`.
    """
    Kse, Kbt, Bse, Bbt, rhoA, rhoJ, C = constants
    v = stretch(e)
    v_t = add(scale(c0, e), history[0])
    u_t = add(scale(c0, u), history[1])
    q_t = add(scale(c0, q), history[2])
    w_t = add(scale(c0, w), history[3])
    n = add(times(Kse, e), times(Bse, v_t))
    m = add(times(Kbt, u), times(Bbt, u_t))
    _, _, _, pull, b = sums

    right_n = add(scale(rhoA, add(cross(w, q), q_t)), drag(C, q))
    # a = u x pull and hat(u) n in one
    right_n = sub(right_n, add(rotate_back(R, load_force), add(cross(u, add(n, pull)), times(Bse, history[4]))))
    right_m = add(cross(w, times(rhoJ, w)), times(rhoJ, w_t))
    right_m = sub(right_m, add(cross(v, n), rotate_back(R, load_moment)))
    right_m = sub(right_m, add(b, add(cross(u, m), times(Bbt, history[5]))))
    v_s, u_s = strain_gradients(add(Kse, scale(c0, Bse)), add(Kbt, scale(c0, Bbt)), sums, right_n, right_m)

    R_s = (
        R[1] * u[2] - R[2] * u[1],
        R[2] * u[0] - R[0] * u[2],
        R[0] * u[1] - R[1] * u[0],
        R[4] * u[2] - R[5] * u[1],
        R[5] * u[0] - R[3] * u[2],
        R[3] * u[1] - R[4] * u[0],
        R[7] * u[2] - R[8] * u[1],
        R[8] * u[0] - R[6] * u[2],
        R[6] * u[1] - R[7] * u[0],
    )
    q_s = add(sub(v_t, cross(u, q)), cross(w, v))
    w_s = sub(u_t, cross(u, w))
    return rotate(R, v), R_s, v_s, u_s, q_s, w_s


@inlined
def tendon_pulls(lanes: Any, x: Any, y: Any, tension: Any, v: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Force that the tendons carry along the rod, and its moment [N, N m]; arguments as those of `tendon_sums`."""
    P = tendon_slope(x, y, v, u)
    pull = scale(tension / math.sqrt(dot(P, P)), P)
    moment = (y * pull[2], -x * pull[2], x * pull[1] - y * pull[0])
    return (
        (simd_sum(pull[0], lanes), simd_sum(pull[1], lanes), simd_sum(pull[2], lanes)),
        (simd_sum(moment[0], lanes), simd_sum(moment[1], lanes), simd_sum(moment[2], lanes)),
    )


@inlined
def tip_residual(
    pulls: tuple[Vector, Vector], n: Vector, m: Vector, R: tuple[float, ...], force: Vector, moment: Vector
) -> tuple[Vector, Vector]:
    """Residual of the equilibrium at the tip [N, N m]: n(L) + tendon pull - R'F, m(L) + its moment - R'M."""
    return sub(add(n, pulls[0]), rotate_back(R, force)), sub(add(m, pulls[1]), rotate_back(R, moment))


@inlined
def body_reaction(
    body: tuple[float, Vector, Vector, Vector], R: tuple[float, ...], q: Vector, w: Vector, q_t: Vector, w_t: Vector
) -> tuple[Vector, Vector]:
    """Force and moment that accelerate a rigid body on the tip, and hold it against gravity's moment, body frame.

    Newton and Euler about the tip, c from the tip to the centre of mass: a = q_t + w x q + w_t x c + w x (w x c),
    force = m a, moment = J w_t + w x J w + c x m (a - R'g). The weight m g itself is part of the tip's load.

    Args:
        body: mass m [kg], diagonal of J about the centre of mass [kg m^2], c [m], g [m/s^2, world].
        R, q, w, q_t, w_t: of the tip.
    """
    mass, inertia, offset, gravity = body
    swing = add(cross(w_t, offset), cross(w, cross(w, offset)))
    force = scale(mass, add(add(q_t, cross(w, q)), swing))
    turn = add(times(inertia, w_t), cross(w, times(inertia, w)))
    return force, add(turn, cross(offset, sub(force, scale(mass, rotate_back(R, gravity)))))
