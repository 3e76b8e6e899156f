"""Statics and one BDF-alpha step, each one compiled call: history, first guess, shooting, continuation."""

from typing import Any

from tendond.model.numerics.compile import borrowed, inlined, kernel
from tendond.model.solver.predictor import RING, predict
from tendond.model.solver.problem import Bdf, Problem, Profile, RodData, StateData, borrowed_rod, borrowed_state
from tendond.model.solver.shooting import DIVERGED, SOLVED, solve
from tendond.model.solver.work import Work, open_work

CONTINUATION_STEP_MIN = 1.0 / 1024.0
"""Smallest part of the change of the loads that a continuation tries before it gives up."""


@kernel
def advance(rod: RodData, memory: Any, bdf: Bdf, state: StateData, loads: Any) -> tuple[int, float, int]:
    """Advance a rod by one time step; on failure everything that belongs to the last state is as it was.

    Args:
        rod, memory: the rod and its scratch memory.
        bdf: bdf of the time step.
        state: before the step; its arrays hold the new one at `step` + 1.
        loads: loads of this step, shape (n + 15,).

    Returns:
        SOLVED or DIVERGED, the residual's norm, marches spent.
    """
    rod, state, work = borrowed_rod(rod), borrowed_state(state), open_work(borrowed(memory), rod)
    count = state.step
    history = state.histories[(count + 1) % 2]
    step_history(bdf, state, history)
    problem = Problem(bdf[0], state.displacement_driven, borrowed(loads), history)
    profile = Profile(state.levels[(count + 1) % 3], state.geometries[(count + 1) % 2])
    unknown = state.unknowns[(count + 1) % RING]
    compared = unknown.shape[0] if state.displacement_driven else 6
    predict(state.unknowns, count, work.scale, work.differences, compared, unknown)
    status, error, marches = solve(rod, work, problem, unknown, profile, state.jacobian)
    if status != SOLVED:
        for j in range(unknown.shape[0]):
            unknown[j] = state.unknowns[count % RING, j]
        state.jacobian[:] = 0.0
        status, error, more = continue_to(rod, work, problem, unknown, state.loads, 1.0, profile, state.jacobian)
        marches += more
    if status == SOLVED:
        for i in range(rod.tendons):
            state.lengths[i] = work.raw[6 + i]
        for j in range(state.loads.shape[0]):
            state.loads[j] = problem.loads[j]
    return status, error, marches


@inlined
def step_history(bdf: Bdf, state: StateData, history: Any) -> None:
    """Write y_h of the step after `state`, shape (stages, 18)."""
    c0, c1, c2, d1 = bdf
    count = state.step
    old, older, past = state.levels[count % 3], state.levels[(count + 2) % 3], state.histories[count % 2]
    y_h, y1, y2, y_h1 = history.reshape(-1), old.reshape(-1), older.reshape(-1), past.reshape(-1)
    for j in range(y_h.size):
        y_h[j] = (c1 + d1 * c0) * y1[j] + c2 * y2[j] + d1 * y_h1[j]


@kernel
def relax(
    rod: RodData, memory: Any, history: Any, state: StateData, loads: Any, first: float
) -> tuple[int, float, int]:
    """Statics: follow the equilibrium from the loads of `state` to `loads`.

    Args:
        rod, memory: the rod and its scratch memory.
        history: zeros, shape (stages, 18).
        state: an equilibrium of step 0, of which the unknowns are used; the new one is written over it, but for the
            loads.
        loads: to be reached, shape (n + 15,).
        first: part of the change of the loads to try first, in (0, 1].

    Returns:
        SOLVED or DIVERGED, the residual's norm, marches spent.
    """
    rod, state, work = borrowed_rod(rod), borrowed_state(state), open_work(borrowed(memory), rod)
    problem = Problem(0.0, state.displacement_driven, borrowed(loads), borrowed(history))
    profile = Profile(state.levels[0], state.geometries[0])
    status, error, marches = continue_to(
        rod, work, problem, state.unknowns[0], state.loads, first, profile, state.jacobian
    )
    for i in range(rod.tendons):
        state.lengths[i] = work.raw[6 + i]
    return status, error, marches


@inlined
def continue_to(
    rod: RodData, work: Work, problem: Problem, unknown: Any, start: Any, first: float, profile: Profile, jacobian: Any
) -> tuple[int, float, int]:
    """Solve along the straight line from loads `start` to the problem's, halving and doubling the part per solve."""
    size, end = unknown.shape[0], problem.loads
    between = Problem(problem.c0, problem.displacement_driven, work.loads, problem.history)
    part, stride, marches, error = 0.0, first, 0, 0.0
    previous_stride = 0.0
    work.last[:] = unknown
    work.slope[:] = 0.0
    while part < 1.0:
        target = min(1.0, part + stride)
        for j in range(end.shape[0]):
            work.loads[j] = start[j] + target * (end[j] - start[j]) if target < 1.0 else end[j]
        for j in range(size):
            unknown[j] = work.last[j] + (target - part) * work.slope[j]
        status, error, more = solve(rod, work, between, unknown, profile, jacobian)
        marches += more
        if status == SOLVED:
            previous_stride = target - part
            for j in range(size):
                work.slope[j] = (unknown[j] - work.last[j]) / previous_stride
                work.last[j] = unknown[j]
            part = target
            stride = 2.0 * previous_stride
        else:
            stride *= 0.5
            jacobian[:] = 0.0
            if stride < CONTINUATION_STEP_MIN:
                return DIVERGED, error, marches
    return SOLVED, error, marches
