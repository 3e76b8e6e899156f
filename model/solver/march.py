"""One march along the rod, from the base's force and moment to the tip's residual, for one or several rods at once.

`lanes` is a tuple whose length is the number of rods: a compile-time constant. A quantity of a rod is a float for one
rod and a SIMD vector (see `simd`) for several: one rod is a shot; eight are the seven shots of a difference Jacobian,
at less than twice the cost. The tendons of all rods make one wide vector. Space schemes are explicit Runge-Kutta
tableaus. The time history belongs to a stage of a node: the method then is the same Runge-Kutta method applied to all
time levels stacked, and keeps its order.

The state carries the strain e = v - v* instead of v, which makes the rounding of the force 1e5 times smaller. A scheme
of one stage keeps the state in registers. Others have work memory, in rows of one float per rod: stage state (24), node
state (24), rates of all stages of a step (24 s).
"""

from typing import Any, NamedTuple

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.simd import simd_load, simd_store, simd_vector
from tendond.model.numerics.vectors import add, scale, sub, times
from tendond.model.solver.equations import body_reaction, rates, stretch, tendon_pulls, tendon_sums, tip_residual
from tendond.model.solver.lanes import (
    STATE,
    advance_state,
    combine_rates,
    lane_vector,
    load_state,
    orthonormalised,
    repeat_vector,
    row_vector,
    store_state,
    store_vector,
    vector,
    write_vector,
)
from tendond.model.solver.problem import Problem, Profile, RodData


class Shots(NamedTuple):
    """Base loads of the rods that march together, and results of their march; rows of one float per rod."""

    base: Any  # n(0) [N], m(0) [N m], shape (6 * lanes,)
    tension: Any  # [N], and zeros, shape (width * lanes,)
    node: Any  # state of the last node, written, shape (24 * lanes,)
    length: Any  # tendon path lengths [m], written, shape (width * lanes,)
    residual: Any  # force and moment missing at the tip, written, shape (6 * lanes,)
    stages: Any  # scratch, at least (48 + 24 s) * lanes where the scheme has s > 1 stages


@inlined
def _material(k: Any) -> Any:
    """Kse, Kbt, Bse, Bbt, rho A, rho J, C of a `CONSTANTS` record."""
    return (
        vector(k.Kse, 0), vector(k.Kbt, 0), vector(k.Bse, 0), vector(k.Bbt, 0), k.rhoA, vector(k.rhoJ, 0),
        vector(k.C, 0),
    )  # fmt: skip


@inlined
def _base(lanes: Any, material: Any, problem: Problem, base: Any) -> Any:
    """State at the clamped base: e, u from n(0) = Kse e + Bse v_t, m(0) = Kbt u + Bbt u_t."""
    Kse, Kbt, Bse, Bbt = material[0], material[1], material[2], material[3]
    n = sub(lane_vector(base, 0, lanes), times(Bse, row_vector(problem.history, 0, 0)))
    m = sub(lane_vector(base, 3, lanes), times(Bbt, row_vector(problem.history, 0, 3)))
    stiff, flexible = add(Kse, scale(problem.c0, Bse)), add(Kbt, scale(problem.c0, Bbt))
    e = (n[0] / stiff[0], n[1] / stiff[1], n[2] / stiff[2])
    u = (m[0] / flexible[0], m[1] / flexible[1], m[2] / flexible[2])
    zero = e[0] - e[0]
    one, rest = 1.0 + zero, (zero, zero, zero)
    return rest, (one, zero, zero, zero, one, zero, zero, zero, one), e, u, rest, rest


@inlined
def _point(
    lanes: Any, rod: RodData, material: Any, problem: Problem, shots: Shots, profile: Profile, row: int, share: float,
    state: Any,
) -> Any:  # fmt: skip
    """Rates of the state at stage `row`; the tendons' paths grow by `share` [m] of their length per rod length there.

    One rod's stage is kept in the profile.
    """
    _, R, e, u, q, w = state
    n, history = rod.tendons, problem.history
    xs, ys = simd_vector(rod.x, lanes), simd_vector(rod.y, lanes)
    tension, length = simd_load(shots.tension, 0, xs), simd_load(shots.length, 0, xs)
    sums, speed = tendon_sums(lanes, xs, ys, tension, repeat_vector(stretch(e), rod.x), repeat_vector(u, rod.x))
    simd_store(shots.length, 0, length + share * speed)
    past = (
        row_vector(history, row, 0),
        row_vector(history, row, 3),
        row_vector(history, row, 6),
        row_vector(history, row, 9),
        row_vector(history, row, 12),
        row_vector(history, row, 15),
    )
    force = add(vector(problem.loads, n + 6), scale(rod.push[row], vector(problem.loads, n + 12)))
    slope = rates(material, problem.c0, force, vector(problem.loads, n + 9), past, sums, R, e, u, q, w)
    if len(lanes) == 1:
        write_vector(profile.levels, row, 0, e)
        write_vector(profile.levels, row, 3, u)
        write_vector(profile.levels, row, 6, q)
        write_vector(profile.levels, row, 9, w)
        write_vector(profile.levels, row, 12, slope[2])
        write_vector(profile.levels, row, 15, slope[3])
    return slope


@inlined
def _keep_node(lanes: Any, profile: Profile, node: int, state: Any) -> None:
    """Keep position and rotation of one rod's node."""
    if len(lanes) == 1:
        R = state[1]
        write_vector(profile.geometry, node, 0, state[0])
        write_vector(profile.geometry, node, 3, (R[0], R[1], R[2]))
        write_vector(profile.geometry, node, 6, (R[3], R[4], R[5]))
        write_vector(profile.geometry, node, 9, (R[6], R[7], R[8]))


@inlined
def _tip_missing(lanes: Any, rod: RodData, material: Any, problem: Problem, shots: Shots, state: Any) -> Any:
    """Residual of force and moment at the tip [N, N m], with the body on it."""
    Kse, Kbt, Bse, Bbt = material[0], material[1], material[2], material[3]
    _, R, e, u, q, w = state
    n, history, c0 = rod.tendons, problem.history, problem.c0
    xs, ys = simd_vector(rod.x, lanes), simd_vector(rod.y, lanes)
    tension = simd_load(shots.tension, 0, xs)
    pulls = tendon_pulls(lanes, xs, ys, tension, repeat_vector(stretch(e), rod.x), repeat_vector(u, rod.x))
    last = history.shape[0] - 1
    v_t = add(scale(c0, e), row_vector(history, last, 0))
    u_t = add(scale(c0, u), row_vector(history, last, 3))
    force = add(times(Kse, e), times(Bse, v_t))
    moment = add(times(Kbt, u), times(Bbt, u_t))
    missing_n, missing_m = tip_residual(pulls, force, moment, R, vector(problem.loads, n), vector(problem.loads, n + 3))
    k = rod.constants[0]
    if k.tip_mass > 0.0:
        body = k.tip_mass, vector(k.tip_inertia, 0), vector(k.tip_offset, 0), vector(k.gravity, 0)
        q_t = add(scale(c0, q), row_vector(history, last, 6))
        w_t = add(scale(c0, w), row_vector(history, last, 9))
        force, moment = body_reaction(body, R, q, w, q_t, w_t)
        missing_n, missing_m = add(missing_n, force), add(missing_m, moment)
    return missing_n, missing_m


@kernel
def march(lanes: Any, rod: RodData, problem: Problem, shots: Shots, profile: Profile) -> None:
    """Integrate every lane from its base load to the tip.

    Args:
        lanes: tuple, one entry per rod (its values do not matter).
        rod: common to all lanes.
        problem: their loads and their past.
        shots: base loads and tensions in; last node, tendon lengths and residual out.
        profile: the state along the rod, written when there is one lane.
    """
    stages, steps, ds = rod.weights.shape[0], rod.steps, rod.ds
    trapezoid, orthonormal = rod.flags
    material = _material(rod.constants[0])
    for j in range(shots.length.shape[0]):
        shots.length[j] = 0.0
    state = _base(lanes, material, problem, shots.base)
    if stages == 1:
        for step in range(steps + 1):
            last = step == steps
            h = 0.0 if last else ds * rod.weights[0]
            share = h
            if trapezoid:
                share = 0.5 * ds if last or step == 0 else ds
            _keep_node(lanes, profile, step, state)
            slope = _point(lanes, rod, material, problem, shots, profile, step, share, state)
            state = advance_state(state, h, slope)
            if orthonormal and not last:
                state = orthonormalised(state)
    else:
        size, work = STATE * len(lanes), shots.stages
        store_state(work, 0, lanes, state)
        for step in range(steps + 1):
            last = step == steps
            for j in range(size):
                work[size + j] = work[j]
            for s in range(1 if last else stages):
                if s > 0:
                    combine_rates(work, size, 2 * size, size, ds, rod.tableau[s], s)
                state = load_state(work, 0, lanes)
                if s == 0:
                    _keep_node(lanes, profile, step, state)
                share = 0.0 if last else ds * rod.weights[s]
                if trapezoid:
                    share = 0.0 if s > 0 else 0.5 * ds if last or step == 0 else ds
                row = step * stages + s
                slope = _point(lanes, rod, material, problem, shots, profile, row, share, state)
                store_state(work, (2 + s) * STATE, lanes, slope)
            if not last:
                combine_rates(work, size, 2 * size, size, ds, rod.weights, stages)
                if orthonormal:
                    store_state(work, 0, lanes, orthonormalised(load_state(work, 0, lanes)))
    store_state(shots.node, 0, lanes, state)
    missing_n, missing_m = _tip_missing(lanes, rod, material, problem, shots, state)
    store_vector(shots.residual, 0, lanes, missing_n)
    store_vector(shots.residual, 3, lanes, missing_m)
