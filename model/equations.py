"""The right-hand side of the tendon-driven Cosserat rod, for one point of one rod.

Symbols are those of the field (Rucker & Webster 2011; Till, Aloi & Rucker 2019; Danesh & Janabi-Sharifi): `v` strain
[-], `u` curvature [1/m], `q` velocity [m/s], `w` angular velocity [rad/s], `n` force [N], `m` moment [N m], all in the
body frame; `R` body to world, row by row. Vectors are tuples (see `vectors`), so that a loop over several rods at once
(see `march`) becomes SIMD code.

The tendons' six-by-six block is summed in a factored form. With P = p_i' = v + u x r_i, e = r_i x P, c1 = T_i/|P| and
c3 = T_i/|P|^3, tendon i contributes

    [ A_i  G_i ]        [   I     -hat(r)  ]        [ P ] [ P ]'
    [ B_i  H_i ]  =  c1 [ hat(r)  -hat(r)^2 ]  -  c3 [ e ] [ e ]

so that, for tendons parallel to the rod, six sums of c1 and one rank-one update per tendon give A, B, G, H, a and b.
"""

import math

from tendond.model.compile import inlined
from tendond.model.vectors import (
    Vector,
    add,
    cross,
    dot,
    drag,
    rotate,
    rotate_back,
    scale,
    sub,
    symmetric_inverse,
    symmetric_times,
    times,
)

# s0 sx sy sxx sxy syy: sums of c1 times 1, x, y, x^2, x y, y^2; then the upper triangle of sum c3 [P; e][P; e]'.
NO_TENDON = (0.0,) * 27


@inlined
def stretch(e: Vector) -> Vector:
    """v = v* + e, with v* = (0, 0, 1)."""
    return e[0], e[1], 1.0 + e[2]


@inlined
def add_tendon(
    sums: tuple[float, ...], x: float, y: float, tension: float, v: Vector, u: Vector
) -> tuple[tuple[float, ...], float]:
    """Add a tendon at (x, y, 0) in the cross-section to `sums`; returns them and |p_i'|, its length per rod length."""
    p1, p2, p3 = v[0] - u[2] * y, v[1] + u[2] * x, v[2] + u[0] * y - u[1] * x
    square = p1 * p1 + p2 * p2 + p3 * p3
    inverse = 1.0 / math.sqrt(square)
    c1 = tension * inverse
    c3 = c1 * inverse * inverse
    e1, e2, e3 = y * p3, -x * p3, x * p2 - y * p1
    f1, f2, f3 = c3 * p1, c3 * p2, c3 * p3
    h1, h2, h3 = c3 * e1, c3 * e2, c3 * e3
    s = sums
    return (
        s[0] + c1,
        s[1] + c1 * x,
        s[2] + c1 * y,
        s[3] + c1 * x * x,
        s[4] + c1 * x * y,
        s[5] + c1 * y * y,
        s[6] + f1 * p1,
        s[7] + f1 * p2,
        s[8] + f1 * p3,
        s[9] + f2 * p2,
        s[10] + f2 * p3,
        s[11] + f3 * p3,
        s[12] + f1 * e1,
        s[13] + f1 * e2,
        s[14] + f1 * e3,
        s[15] + f2 * e1,
        s[16] + f2 * e2,
        s[17] + f2 * e3,
        s[18] + f3 * e1,
        s[19] + f3 * e2,
        s[20] + f3 * e3,
        s[21] + h1 * e1,
        s[22] + h1 * e2,
        s[23] + h1 * e3,
        s[24] + h2 * e2,
        s[25] + h2 * e3,
        s[26] + h3 * e3,
    ), square * inverse


@inlined
def tendon_pulls(sums: tuple[float, ...], v: Vector, u: Vector) -> tuple[Vector, Vector, Vector]:
    """Sums of c1 P, c1 x P and c1 y P over the tendons: the first is the force that they carry along the rod [N]."""
    s0, sx, sy, sxx, sxy, syy = sums[0], sums[1], sums[2], sums[3], sums[4], sums[5]
    force = (s0 * v[0] - u[2] * sy, s0 * v[1] + u[2] * sx, s0 * v[2] + u[0] * sy - u[1] * sx)
    by_x = (sx * v[0] - u[2] * sxy, sx * v[1] + u[2] * sxx, sx * v[2] + u[0] * sxy - u[1] * sxx)
    by_y = (sy * v[0] - u[2] * syy, sy * v[1] + u[2] * sxy, sy * v[2] + u[0] * syy - u[1] * sxy)
    return force, by_x, by_y


@inlined
def strain_gradients(
    stiffness_se: Vector, stiffness_bt: Vector, sums: tuple[float, ...], right_n: Vector, right_m: Vector
) -> tuple[Vector, Vector]:
    """Solve the symmetric positive definite 6x6 block for (v_s, u_s) by its Schur complement: two divisions in all."""
    s = sums
    a = (
        stiffness_se[0] + s[0] - s[6],
        -s[7],
        -s[8],
        stiffness_se[1] + s[0] - s[9],
        -s[10],
        stiffness_se[2] + s[0] - s[11],
    )
    g1 = (-s[12], -s[15], -s[18] + s[2])
    g2 = (-s[13], -s[16], -s[19] - s[1])
    g3 = (-s[14] - s[2], -s[17] + s[1], -s[20])
    inverse = symmetric_inverse(a)
    y1, y2, y3 = symmetric_times(inverse, g1), symmetric_times(inverse, g2), symmetric_times(inverse, g3)
    schur = (
        stiffness_bt[0] + s[5] - s[21] - dot(g1, y1),
        -s[4] - s[22] - dot(g1, y2),
        -s[23] - dot(g1, y3),
        stiffness_bt[1] + s[3] - s[24] - dot(g2, y2),
        -s[25] - dot(g2, y3),
        stiffness_bt[2] + s[3] + s[5] - s[26] - dot(g3, y3),
    )
    reduced = (right_m[0] - dot(y1, right_n), right_m[1] - dot(y2, right_n), right_m[2] - dot(y3, right_n))
    u_s = symmetric_times(symmetric_inverse(schur), reduced)
    free = symmetric_times(inverse, right_n)
    return sub(free, add(scale(u_s[0], y1), add(scale(u_s[1], y2), scale(u_s[2], y3)))), u_s


@inlined
def rates(
    constants: tuple[Vector, Vector, Vector, Vector, float, Vector, Vector],
    c0: float,
    load_force: Vector,
    load_moment: Vector,
    history: tuple[Vector, Vector, Vector, Vector, Vector, Vector],
    sums: tuple[float, ...],
    R: tuple[float, ...],
    e: Vector,
    u: Vector,
    q: Vector,
    w: Vector,
) -> tuple[Vector, tuple[float, ...], Vector, Vector, Vector, Vector]:
    """Derivatives along the rod (p_s, R_s, v_s, u_s, q_s, w_s) at strain e = v - v*.

    `constants` are Kse, Kbt, Bse, Bbt, rho A, rho J, C (diagonals); `load_force` and `load_moment` the distributed
    loads in the world frame, gravity included [N/m, N]; `history` the parts y_h of v_t, u_t, q_t, w_t, v_st, u_st that
    the past determines.
    """
    Kse, Kbt, Bse, Bbt, rhoA, rhoJ, C = constants
    v = stretch(e)
    v_t = add(scale(c0, e), history[0])
    u_t = add(scale(c0, u), history[1])
    q_t = add(scale(c0, q), history[2])
    w_t = add(scale(c0, w), history[3])
    n = add(times(Kse, e), times(Bse, v_t))
    m = add(times(Kbt, u), times(Bbt, u_t))

    pull, pull_x, pull_y = tendon_pulls(sums, v, u)
    b = sub(scale(pull_x[0] + pull_y[1], u), add(scale(u[0], pull_x), scale(u[1], pull_y)))

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
def tip_residual(
    pulls: tuple[Vector, Vector, Vector], n: Vector, m: Vector, R: tuple[float, ...], force: Vector, moment: Vector
) -> tuple[Vector, Vector]:
    """What is missing from equilibrium at the tip [N, N m]: n(L) + tendon pull - R'F, m(L) + its moment - R'M."""
    pull, pull_x, pull_y = pulls
    pull_moment = (pull_y[2], -pull_x[2], pull_x[1] - pull_y[0])
    return sub(add(n, pull), rotate_back(R, force)), sub(add(m, pull_moment), rotate_back(R, moment))
