"""One march along the rod, from the base's force and moment to the tip's residual, for one or several rods at once.

`lanes` is a tuple whose length is the number of rods: a compile-time constant, so that the loop over them becomes SIMD
code. One lane is a shot; eight lanes are the seven shots of a difference Jacobian for little more than twice its cost.
`x` and `y` of the tendons are tuples for the same reason. Space schemes are explicit Runge-Kutta tableaus. The time
history belongs to a stage of a node: the method then is the same Runge-Kutta method applied to all time levels stacked,
and keeps its order.

Work memory `z`, in rows of one float per lane: stage state (24), rates (24), tensions, lengths per rod length.
State of a lane: p 3, R 9, v 3, u 3, q 3, w 3.
"""

from typing import Any

import numpy as np

from tendond.model.compile import inlined, kernel
from tendond.model.equations import NO_TENDON, add_tendon, rates, tendon_pulls, tip_residual
from tendond.model.vectors import add, scale, times

STATE = 24
HISTORY = 18  # v, u, q, w, v_s, u_s

CONSTANTS = np.dtype([(name, "f8", (3,)) for name in ("Kse", "Kbt", "Bse", "Bbt", "rhoJ", "C")] + [("rhoA", "f8")])


@inlined
def _vector(a: Any, start: int) -> Any:
    return a[start], a[start + 1], a[start + 2]


@inlined
def _row_vector(a: Any, row: int, start: int) -> Any:
    return a[row, start], a[row, start + 1], a[row, start + 2]


@inlined
def _lane_vector(z: Any, row: int, lanes: int, lane: int) -> Any:
    return z[row * lanes + lane], z[(row + 1) * lanes + lane], z[(row + 2) * lanes + lane]


@inlined
def _store(z: Any, row: int, lanes: int, lane: int, a: Any) -> None:
    z[row * lanes + lane] = a[0]
    z[(row + 1) * lanes + lane] = a[1]
    z[(row + 2) * lanes + lane] = a[2]


@inlined
def _rotation(z: Any, row: int, lanes: int, lane: int) -> Any:
    return (
        *_lane_vector(z, row, lanes, lane),
        *_lane_vector(z, row + 3, lanes, lane),
        *_lane_vector(z, row + 6, lanes, lane),
    )


@inlined
def _orthonormalise(node: Any, lanes: int, lane: int) -> None:
    """Bring R back to SO(3) by two Newton-Schulz iterations, R <- R (3 I - R'R)/2."""
    for _ in range(2):
        R = _rotation(node, 3, lanes, lane)
        g11 = 0.5 * (R[0] * R[0] + R[3] * R[3] + R[6] * R[6])
        g22 = 0.5 * (R[1] * R[1] + R[4] * R[4] + R[7] * R[7])
        g33 = 0.5 * (R[2] * R[2] + R[5] * R[5] + R[8] * R[8])
        g12 = 0.5 * (R[0] * R[1] + R[3] * R[4] + R[6] * R[7])
        g13 = 0.5 * (R[0] * R[2] + R[3] * R[5] + R[6] * R[8])
        g23 = 0.5 * (R[1] * R[2] + R[4] * R[5] + R[7] * R[8])
        for j in (0, 3, 6):
            row = (
                R[j] * (1.5 - g11) - R[j + 1] * g12 - R[j + 2] * g13,
                R[j + 1] * (1.5 - g22) - R[j] * g12 - R[j + 2] * g23,
                R[j + 2] * (1.5 - g33) - R[j] * g13 - R[j + 1] * g23,
            )
            _store(node, 3 + j, lanes, lane, row)


@kernel
def march(
    lanes: Any,
    x: Any,
    y: Any,
    constants: Any,
    tableau: Any,
    weights: Any,
    flags: Any,
    steps: int,
    ds: float,
    c0: float,
    base: Any,
    tension: Any,
    loads: Any,
    history: Any,
    levels: Any,
    geometry: Any,
    work: Any,
    node: Any,
    length: Any,
    residual: Any,
) -> None:
    """Integrate every lane from its base load to the tip.

    Args:
        lanes: tuple, one entry per rod (its values do not matter).
        x, y: tendon positions in the cross-section [m], tuples of n floats.
        constants: array of one `CONSTANTS` record.
        tableau, weights: Butcher tableau, shapes (s, s), (s,).
        flags: (trapezoidal tendon lengths, orthonormal R), booleans.
        steps, ds: number of steps, their length [m].
        c0: of BDF-alpha [1/s]; 0 is statics.
        base: n(0) [N], m(0) [N m], shape (6 * lanes,).
        tension: [N], shape (n * lanes,).
        loads: tip force [N], tip moment [N m], distributed force (gravity included) [N/m] and moment [N], world frame,
            shape (12,).
        history: y_h of v, u, q, w, v_s, u_s at every stage, shape (steps * s + 1, 18).
        levels: written when there is one lane: v, u, q, w, v_s, u_s at every stage, shape as `history`.
        geometry: written when there is one lane: p, R at every node, shape (steps + 1, 12).
        work: scratch, at least (48 + 2 n + 24 s) * lanes.
        node: state of the last node, written, shape (24 * lanes,).
        length: tendon path lengths [m], written, shape (n * lanes,).
        residual: force and moment missing at the tip, written, shape (6 * lanes,).
    """
    width = len(lanes)
    tendons = len(x)
    stages = weights.shape[0]
    trapezoid, orthonormal = flags
    k = constants[0]
    Kse, Kbt, Bse, Bbt = _vector(k.Kse, 0), _vector(k.Kbt, 0), _vector(k.Bse, 0), _vector(k.Bbt, 0)
    material = (Kse, Kbt, Bse, Bbt, k.rhoA, _vector(k.rhoJ, 0), _vector(k.C, 0))
    force, moment = _vector(loads, 6), _vector(loads, 9)
    z = work
    tension_row = 2 * STATE
    speed_row = tension_row + tendons
    stored = (speed_row + tendons) * width

    for lane in range(width):
        for row in range(STATE):
            node[row * width + lane] = 0.0
        for row in (3, 7, 11):
            node[row * width + lane] = 1.0
        for j in range(3):
            node[(12 + j) * width + lane] = (base[j * width + lane] - Bse[j] * history[0, j]) / (Kse[j] + c0 * Bse[j])
            node[(15 + j) * width + lane] = (base[(3 + j) * width + lane] - Bbt[j] * history[0, 3 + j]) / (
                Kbt[j] + c0 * Bbt[j]
            )
        node[14 * width + lane] += Kse[2] / (Kse[2] + c0 * Bse[2])
    for j in range(tendons * width):
        z[tension_row * width + j] = tension[j]
        length[j] = 0.0

    row = 0
    for step in range(steps + 1):
        for s in range(stages if step < steps else 1):
            for j in range(STATE * width):
                z[j] = node[j]
            for t in range(s):
                if tableau[s, t] != 0.0:
                    for j in range(STATE * width):
                        z[j] += ds * tableau[s, t] * z[stored + t * STATE * width + j]
            past = (
                _row_vector(history, row, 0),
                _row_vector(history, row, 3),
                _row_vector(history, row, 6),
                _row_vector(history, row, 9),
                _row_vector(history, row, 12),
                _row_vector(history, row, 15),
            )
            for lane in range(width):
                R = _rotation(z, 3, width, lane)
                v, u = _lane_vector(z, 12, width, lane), _lane_vector(z, 15, width, lane)
                q, w = _lane_vector(z, 18, width, lane), _lane_vector(z, 21, width, lane)
                sums = NO_TENDON
                for i in range(tendons):
                    sums, speed = add_tendon(sums, x[i], y[i], z[(tension_row + i) * width + lane], v, u)
                    z[(speed_row + i) * width + lane] = speed
                p_s, R_s, v_s, u_s, q_s, w_s = rates(material, c0, force, moment, past, sums, R, v, u, q, w)
                _store(z, 24, width, lane, p_s)
                _store(z, 27, width, lane, (R_s[0], R_s[1], R_s[2]))
                _store(z, 30, width, lane, (R_s[3], R_s[4], R_s[5]))
                _store(z, 33, width, lane, (R_s[6], R_s[7], R_s[8]))
                _store(z, 36, width, lane, v_s)
                _store(z, 39, width, lane, u_s)
                _store(z, 42, width, lane, q_s)
                _store(z, 45, width, lane, w_s)
            for j in range(STATE * width):
                z[stored + s * STATE * width + j] = z[STATE * width + j]
            if width == 1:
                for j in range(12):
                    levels[row, j] = z[12 + j]
                for j in range(6):
                    levels[row, 12 + j] = z[36 + j]
            share = ds * weights[s] if step < steps else 0.0
            if trapezoid:
                share = ds if 0 < step < steps else 0.5 * ds
            for j in range(tendons * width):
                length[j] += share * z[speed_row * width + j]
            row += 1
        if width == 1:
            for j in range(12):
                geometry[step, j] = node[j]
        if step < steps:
            for s in range(stages):
                for j in range(STATE * width):
                    node[j] += ds * weights[s] * z[stored + s * STATE * width + j]
            if orthonormal:
                for lane in range(width):
                    _orthonormalise(node, width, lane)

    for lane in range(width):
        R = _rotation(node, 3, width, lane)
        v, u = _lane_vector(node, 12, width, lane), _lane_vector(node, 15, width, lane)
        sums = NO_TENDON
        for i in range(tendons):
            sums, _ = add_tendon(sums, x[i], y[i], tension[i * width + lane], v, u)
        v_t = add(scale(c0, v), _row_vector(history, row - 1, 0))
        u_t = add(scale(c0, u), _row_vector(history, row - 1, 3))
        n = add(times(Kse, (v[0], v[1], v[2] - 1.0)), times(Bse, v_t))
        m = add(times(Kbt, u), times(Bbt, u_t))
        missing_n, missing_m = tip_residual(tendon_pulls(sums, v, u), n, m, R, _vector(loads, 0), _vector(loads, 3))
        _store(residual, 0, width, lane, missing_n)
        _store(residual, 3, width, lane, missing_m)
