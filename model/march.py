"""One march along the rod, from the base's force and moment to the tip's residual, for one or several rods at once.

`lanes` is a tuple whose length is the number of rods: a compile-time constant, so that the loop over them becomes SIMD
code. One lane is a shot; eight lanes are the seven shots of a difference Jacobian for little more than twice its cost.
`x` and `y` of the tendons are tuples for the same reason. Space schemes are explicit Runge-Kutta tableaus. The time
history belongs to a stage of a node: the method then is the same Runge-Kutta method applied to all time levels stacked,
and keeps its order.

Work memory `z`, in rows of one float per lane: stage state (24), rates (24), tensions (n), lengths per rod length (n),
node state (24), rates of all stages of a step (24 s).
State of a lane: p 3, R 9, e = v - v* 3, u 3, q 3, w 3. Carrying the strain e instead of v makes the rounding of the
force 1e5 times smaller.
"""

from typing import Any

import numpy as np

from tendond.model.compile import inlined, kernel
from tendond.model.equations import NO_TENDON, add_tendon, rates, stretch, tendon_pulls, tip_residual
from tendond.model.vectors import add, scale, times

STATE = 24
RATES = STATE  # row of the rates in the work memory, behind the stage's state
HISTORY = 18  # e, u, q, w, e_s, u_s

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
def _advance(z: Any, row: int, lanes: int, lane: int, ahead: float, a: Any, a_s: Any) -> None:
    """Keep a rate, and move the state ahead by it."""
    _store(z, RATES + row, lanes, lane, a_s)
    _store(z, row, lanes, lane, add(a, scale(ahead, a_s)))


@inlined
def _level(levels: Any, row: int, e: Any, u: Any, q: Any, w: Any, v_s: Any, u_s: Any) -> None:
    levels[row, 0], levels[row, 1], levels[row, 2] = e
    levels[row, 3], levels[row, 4], levels[row, 5] = u
    levels[row, 6], levels[row, 7], levels[row, 8] = q
    levels[row, 9], levels[row, 10], levels[row, 11] = w
    levels[row, 12], levels[row, 13], levels[row, 14] = v_s
    levels[row, 15], levels[row, 16], levels[row, 17] = u_s


@inlined
def _combine(z: Any, node: int, stored: int, size: int, ds: float, factors: Any, count: int) -> None:
    """Stage state = node + ds * sum of the first `count` stored rates, each times its factor."""
    for j in range(size):
        z[j] = z[node + j]
    for t in range(count):
        factor = ds * factors[t]
        if factor != 0.0:
            for j in range(size):
                z[j] += factor * z[stored + t * size + j]


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
        history: y_h of e, u, q, w, e_s, u_s at every stage, shape (steps * s + 1, 18).
        levels: written when there is one lane: e, u, q, w, e_s, u_s at every stage, shape as `history`.
        geometry: written when there is one lane: p, R at every node, shape (steps + 1, 12).
        work: scratch, at least (72 + 2 n + 24 s) * lanes.
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
    tension_row = RATES + STATE
    speed_row = tension_row + tendons
    node_row = speed_row + tendons
    stored = (node_row + STATE) * width

    for lane in range(width):
        for row in range(STATE):
            z[row * width + lane] = 0.0
        for row in (3, 7, 11):
            z[row * width + lane] = 1.0
        for j in range(3):
            z[(12 + j) * width + lane] = (base[j * width + lane] - Bse[j] * history[0, j]) / (Kse[j] + c0 * Bse[j])
            z[(15 + j) * width + lane] = (base[(3 + j) * width + lane] - Bbt[j] * history[0, 3 + j]) / (
                Kbt[j] + c0 * Bbt[j]
            )
    for j in range(tendons * width):
        z[tension_row * width + j] = tension[j]
        length[j] = 0.0

    row = 0
    for step in range(steps + 1):
        last = step == steps
        if width == 1:
            for j in range(12):
                geometry[step, j] = z[j]
        if stages > 1:
            for j in range(STATE * width):
                z[node_row * width + j] = z[j]
        for s in range(1 if last else stages):
            if s > 0:
                _combine(z, node_row * width, stored, STATE * width, ds, tableau[s], s)
            past = (
                _row_vector(history, row, 0),
                _row_vector(history, row, 3),
                _row_vector(history, row, 6),
                _row_vector(history, row, 9),
                _row_vector(history, row, 12),
                _row_vector(history, row, 15),
            )
            ahead = (
                ds * weights[0] if stages == 1 and not last else 0.0
            )  # a scheme of one stage needs no more than this
            for lane in range(width):
                p, R = _lane_vector(z, 0, width, lane), _rotation(z, 3, width, lane)
                e, u = _lane_vector(z, 12, width, lane), _lane_vector(z, 15, width, lane)
                q, w = _lane_vector(z, 18, width, lane), _lane_vector(z, 21, width, lane)
                v = stretch(e)
                sums = NO_TENDON
                for i in range(tendons):
                    sums, speed = add_tendon(sums, x[i], y[i], z[(tension_row + i) * width + lane], v, u)
                    z[(speed_row + i) * width + lane] = speed
                p_s, R_s, v_s, u_s, q_s, w_s = rates(material, c0, force, moment, past, sums, R, e, u, q, w)
                if width == 1:
                    _level(levels, row, e, u, q, w, v_s, u_s)
                _advance(z, 0, width, lane, ahead, p, p_s)
                _advance(z, 3, width, lane, ahead, (R[0], R[1], R[2]), (R_s[0], R_s[1], R_s[2]))
                _advance(z, 6, width, lane, ahead, (R[3], R[4], R[5]), (R_s[3], R_s[4], R_s[5]))
                _advance(z, 9, width, lane, ahead, (R[6], R[7], R[8]), (R_s[6], R_s[7], R_s[8]))
                _advance(z, 12, width, lane, ahead, e, v_s)
                _advance(z, 15, width, lane, ahead, u, u_s)
                _advance(z, 18, width, lane, ahead, q, q_s)
                _advance(z, 21, width, lane, ahead, w, w_s)
            if stages > 1:
                for j in range(STATE * width):
                    z[stored + s * STATE * width + j] = z[RATES * width + j]
            share = ds * weights[s] if step < steps else 0.0
            if trapezoid:
                share = ds if 0 < step < steps else 0.5 * ds
            for j in range(tendons * width):
                length[j] += share * z[speed_row * width + j]
            row += 1
        if stages > 1 and not last:
            _combine(z, node_row * width, stored, STATE * width, ds, weights, stages)
        if orthonormal and not last:
            for lane in range(width):
                _orthonormalise(z, width, lane)
    for j in range(STATE * width):
        node[j] = z[j]

    for lane in range(width):
        R = _rotation(node, 3, width, lane)
        e, u = _lane_vector(node, 12, width, lane), _lane_vector(node, 15, width, lane)
        v = stretch(e)
        sums = NO_TENDON
        for i in range(tendons):
            sums, _ = add_tendon(sums, x[i], y[i], tension[i * width + lane], v, u)
        v_t = add(scale(c0, e), _row_vector(history, row - 1, 0))
        u_t = add(scale(c0, u), _row_vector(history, row - 1, 3))
        n = add(times(Kse, e), times(Bse, v_t))
        m = add(times(Kbt, u), times(Bbt, u_t))
        missing_n, missing_m = tip_residual(tendon_pulls(sums, v, u), n, m, R, _vector(loads, 0), _vector(loads, 3))
        _store(residual, 0, width, lane, missing_n)
        _store(residual, 3, width, lane, missing_m)
