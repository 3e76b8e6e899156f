"""One march along the rod, from the base's force and moment to the tip's residual, for one or several rods at once.

`lanes` is a tuple whose length is the number of rods: a compile-time constant. What belongs to a rod is a float for one
rod and a pack (see `packs`) for several: one rod is a shot; eight are the seven shots of a difference Jacobian, at less
than twice the cost. The tendons of all rods make one wide pack. Space schemes are explicit Runge-Kutta tableaus. The
time history belongs to a stage of a node: the method then is the same Runge-Kutta method applied to all time levels
stacked, and keeps its order.

State of a rod: p 3, R 9, e = v - v* 3, u 3, q 3, w 3. Carrying the strain e instead of v makes the rounding of the
force 1e5 times smaller. A scheme of one stage keeps the state in registers. Others have work memory, in rows of one
float per rod: stage state (24), node state (24), rates of all stages of a step (24 s).
"""

from typing import Any

import numpy as np

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.simd import load, pack, repeat, store
from tendond.model.numerics.vectors import add, scale, sub, times
from tendond.model.solver.equations import body_reaction, rates, stretch, tendon_pulls, tendon_sums, tip_residual

STATE = 24
HISTORY = 18  # e, u, q, w, e_s, u_s

CONSTANTS = np.dtype(
    [(name, "f8", (3,)) for name in ("Kse", "Kbt", "Bse", "Bbt", "rhoJ", "C", "tip_inertia", "tip_offset", "gravity")]
    + [("rhoA", "f8"), ("tip_mass", "f8")]
)


@inlined
def _vector(a: Any, start: int) -> Any:
    return a[start], a[start + 1], a[start + 2]


@inlined
def _row_vector(a: Any, row: int, start: int) -> Any:
    return a[row, start], a[row, start + 1], a[row, start + 2]


@inlined
def _write(a: Any, row: int, start: int, values: Any) -> None:
    a[row, start], a[row, start + 1], a[row, start + 2] = values


@inlined
def _lane_vector(z: Any, row: int, lanes: Any) -> Any:
    width = len(lanes)
    return load(z, row * width, lanes), load(z, (row + 1) * width, lanes), load(z, (row + 2) * width, lanes)


@inlined
def _store_vector(z: Any, row: int, lanes: Any, a: Any) -> None:
    width = len(lanes)
    store(z, row * width, a[0])
    store(z, (row + 1) * width, a[1])
    store(z, (row + 2) * width, a[2])


@inlined
def _load_state(z: Any, row: int, lanes: Any) -> Any:
    return (
        _lane_vector(z, row, lanes),
        _lane_vector(z, row + 3, lanes) + _lane_vector(z, row + 6, lanes) + _lane_vector(z, row + 9, lanes),
        _lane_vector(z, row + 12, lanes),
        _lane_vector(z, row + 15, lanes),
        _lane_vector(z, row + 18, lanes),
        _lane_vector(z, row + 21, lanes),
    )


@inlined
def _store_state(z: Any, row: int, lanes: Any, state: Any) -> None:
    p, R, e, u, q, w = state
    _store_vector(z, row, lanes, p)
    _store_vector(z, row + 3, lanes, (R[0], R[1], R[2]))
    _store_vector(z, row + 6, lanes, (R[3], R[4], R[5]))
    _store_vector(z, row + 9, lanes, (R[6], R[7], R[8]))
    _store_vector(z, row + 12, lanes, e)
    _store_vector(z, row + 15, lanes, u)
    _store_vector(z, row + 18, lanes, q)
    _store_vector(z, row + 21, lanes, w)


@inlined
def _advance(state: Any, h: float, slope: Any) -> Any:
    p, R, e, u, q, w = state
    p_s, D, e_s, u_s, q_s, w_s = slope
    return (
        add(p, scale(h, p_s)),
        add((R[0], R[1], R[2]), scale(h, (D[0], D[1], D[2])))
        + add((R[3], R[4], R[5]), scale(h, (D[3], D[4], D[5])))
        + add((R[6], R[7], R[8]), scale(h, (D[6], D[7], D[8]))),
        add(e, scale(h, e_s)),
        add(u, scale(h, u_s)),
        add(q, scale(h, q_s)),
        add(w, scale(h, w_s)),
    )


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
def _orthonormalised(state: Any) -> Any:
    """The state with R brought back to SO(3) by two Newton-Schulz iterations, R <- R (3 I - R'R)/2."""
    p, R, e, u, q, w = state
    for _ in range(2):
        g11 = 0.5 * (R[0] * R[0] + R[3] * R[3] + R[6] * R[6])
        g22 = 0.5 * (R[1] * R[1] + R[4] * R[4] + R[7] * R[7])
        g33 = 0.5 * (R[2] * R[2] + R[5] * R[5] + R[8] * R[8])
        g12 = 0.5 * (R[0] * R[1] + R[3] * R[4] + R[6] * R[7])
        g13 = 0.5 * (R[0] * R[2] + R[3] * R[5] + R[6] * R[8])
        g23 = 0.5 * (R[1] * R[2] + R[4] * R[5] + R[7] * R[8])
        R = (
            R[0] * (1.5 - g11) - R[1] * g12 - R[2] * g13,
            R[1] * (1.5 - g22) - R[0] * g12 - R[2] * g23,
            R[2] * (1.5 - g33) - R[0] * g13 - R[1] * g23,
            R[3] * (1.5 - g11) - R[4] * g12 - R[5] * g13,
            R[4] * (1.5 - g22) - R[3] * g12 - R[5] * g23,
            R[5] * (1.5 - g33) - R[3] * g13 - R[4] * g23,
            R[6] * (1.5 - g11) - R[7] * g12 - R[8] * g13,
            R[7] * (1.5 - g22) - R[6] * g12 - R[8] * g23,
            R[8] * (1.5 - g33) - R[6] * g13 - R[7] * g23,
        )
    return p, R, e, u, q, w


@inlined
def _repeat(a: Any, times: Any) -> Any:
    return repeat(a[0], times), repeat(a[1], times), repeat(a[2], times)


@inlined
def _base(lanes: Any, material: Any, c0: float, base: Any, history: Any) -> Any:
    """State at the clamped base: e, u from n(0) = Kse e + Bse v_t, m(0) = Kbt u + Bbt u_t."""
    Kse, Kbt, Bse, Bbt = material[0], material[1], material[2], material[3]
    n = sub(_lane_vector(base, 0, lanes), times(Bse, _row_vector(history, 0, 0)))
    m = sub(_lane_vector(base, 3, lanes), times(Bbt, _row_vector(history, 0, 3)))
    stiff, flexible = add(Kse, scale(c0, Bse)), add(Kbt, scale(c0, Bbt))
    e = (n[0] / stiff[0], n[1] / stiff[1], n[2] / stiff[2])
    u = (m[0] / flexible[0], m[1] / flexible[1], m[2] / flexible[2])
    zero = e[0] - e[0]
    one, rest = 1.0 + zero, (zero, zero, zero)
    return rest, (one, zero, zero, zero, one, zero, zero, zero, one), e, u, rest, rest


@inlined
def _point(
    lanes: Any, x: Any, y: Any, tension: Any, share: float, length: Any, material: Any, c0: float, loads: Any,
    push: Any, history: Any, levels: Any, row: int, state: Any,
) -> Any:  # fmt: skip
    """Rates of the state at a stage; the tendons' paths grow by `share` [m] of their length per rod length there.

    One rod's stage is kept among the levels.
    """
    _, R, e, u, q, w = state
    xs, ys = pack(x, lanes), pack(y, lanes)
    sums, speed = tendon_sums(lanes, xs, ys, load(tension, 0, xs), _repeat(stretch(e), x), _repeat(u, x))
    store(length, 0, load(length, 0, xs) + share * speed)
    past = (
        _row_vector(history, row, 0),
        _row_vector(history, row, 3),
        _row_vector(history, row, 6),
        _row_vector(history, row, 9),
        _row_vector(history, row, 12),
        _row_vector(history, row, 15),
    )
    force = add(_vector(loads, 6), scale(push[row], _vector(loads, 12)))
    slope = rates(material, c0, force, _vector(loads, 9), past, sums, R, e, u, q, w)
    if len(lanes) == 1:
        _write(levels, row, 0, e)
        _write(levels, row, 3, u)
        _write(levels, row, 6, q)
        _write(levels, row, 9, w)
        _write(levels, row, 12, slope[2])
        _write(levels, row, 15, slope[3])
    return slope


@inlined
def _keep_place(lanes: Any, geometry: Any, node: int, state: Any) -> None:
    """Keep where one rod's node is."""
    if len(lanes) == 1:
        R = state[1]
        _write(geometry, node, 0, state[0])
        _write(geometry, node, 3, (R[0], R[1], R[2]))
        _write(geometry, node, 6, (R[3], R[4], R[5]))
        _write(geometry, node, 9, (R[6], R[7], R[8]))


@inlined
def _missing(
    lanes: Any, x: Any, y: Any, tension: Any, material: Any, body: Any, c0: float, loads: Any, history: Any, state: Any
) -> Any:
    """Force and moment missing at the tip."""
    Kse, Kbt, Bse, Bbt = material[0], material[1], material[2], material[3]
    _, R, e, u, q, w = state
    xs, ys = pack(x, lanes), pack(y, lanes)
    pulls = tendon_pulls(lanes, xs, ys, load(tension, 0, xs), _repeat(stretch(e), x), _repeat(u, x))
    last = history.shape[0] - 1
    v_t = add(scale(c0, e), _row_vector(history, last, 0))
    u_t = add(scale(c0, u), _row_vector(history, last, 3))
    n = add(times(Kse, e), times(Bse, v_t))
    m = add(times(Kbt, u), times(Bbt, u_t))
    missing_n, missing_m = tip_residual(pulls, n, m, R, _vector(loads, 0), _vector(loads, 3))
    if body[0] > 0.0:
        q_t = add(scale(c0, q), _row_vector(history, last, 6))
        w_t = add(scale(c0, w), _row_vector(history, last, 9))
        force, moment = body_reaction(body, R, q, w, q_t, w_t)
        missing_n, missing_m = add(missing_n, force), add(missing_m, moment)
    return missing_n, missing_m


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
    push: Any,
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
        loads: tip force [N], tip moment [N m], distributed force (gravity included) [N/m] and moment [N], a push [N],
            world frame, shape (15,).
        push: how the push is spread: its part per length at every stage [1/m], shape (steps * s + 1,).
        history: y_h of e, u, q, w, e_s, u_s at every stage, shape (steps * s + 1, 18).
        levels: written when there is one lane: e, u, q, w, e_s, u_s at every stage, shape as `history`.
        geometry: written when there is one lane: p, R at every node, shape (steps + 1, 12).
        work: scratch, at least (48 + 24 s) * lanes where the scheme has s > 1 stages.
        node: state of the last node, written, shape (24 * lanes,).
        length: tendon path lengths [m], written, shape (n * lanes,).
        residual: force and moment missing at the tip, written, shape (6 * lanes,).
    """
    stages = weights.shape[0]
    trapezoid, orthonormal = flags
    k = constants[0]
    material = (
        _vector(k.Kse, 0), _vector(k.Kbt, 0), _vector(k.Bse, 0), _vector(k.Bbt, 0), k.rhoA, _vector(k.rhoJ, 0),
        _vector(k.C, 0),
    )  # fmt: skip
    body = k.tip_mass, _vector(k.tip_inertia, 0), _vector(k.tip_offset, 0), _vector(k.gravity, 0)
    for j in range(length.shape[0]):
        length[j] = 0.0
    state = _base(lanes, material, c0, base, history)
    if stages == 1:
        for step in range(steps + 1):
            last = step == steps
            h = 0.0 if last else ds * weights[0]
            share = h
            if trapezoid:
                share = 0.5 * ds if last or step == 0 else ds
            _keep_place(lanes, geometry, step, state)
            slope = _point(lanes, x, y, tension, share, length, material, c0, loads, push, history, levels, step, state)
            state = _advance(state, h, slope)
            if orthonormal and not last:
                state = _orthonormalised(state)
    else:
        size = STATE * len(lanes)
        _store_state(work, 0, lanes, state)
        for step in range(steps + 1):
            last = step == steps
            for j in range(size):
                work[size + j] = work[j]
            for s in range(1 if last else stages):
                if s > 0:
                    _combine(work, size, 2 * size, size, ds, tableau[s], s)
                state = _load_state(work, 0, lanes)
                if s == 0:
                    _keep_place(lanes, geometry, step, state)
                share = 0.0 if last else ds * weights[s]
                if trapezoid:
                    share = 0.0 if s > 0 else 0.5 * ds if last or step == 0 else ds
                row = step * stages + s
                slope = _point(
                    lanes, x, y, tension, share, length, material, c0, loads, push, history, levels, row, state
                )
                _store_state(work, (2 + s) * STATE, lanes, slope)
            if not last:
                _combine(work, size, 2 * size, size, ds, weights, stages)
                if orthonormal:
                    _store_state(work, 0, lanes, _orthonormalised(_load_state(work, 0, lanes)))
    _store_state(node, 0, lanes, state)
    missing_n, missing_m = _missing(lanes, x, y, tension, material, body, c0, loads, history, state)
    _store_vector(residual, 0, lanes, missing_n)
    _store_vector(residual, 3, lanes, missing_m)
