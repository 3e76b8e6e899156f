"""Statics and one BDF-alpha step, each one compiled call: history, first guess, shooting, continuation."""

from typing import Any

from tendond.model.numerics.compile import borrowed, inlined, kernel
from tendond.model.solver.predictor import RING, predict
from tendond.model.solver.shooting import DIVERGED, SOLVED, RodData, borrowed_rod, solve
from tendond.model.solver.work import Work, open_work

SMALLEST_STEP = 1.0 / 1024.0  # of a continuation, as a part of the way


@kernel
def advance(
    rod: RodData,
    memory: Any,
    bdf: tuple[float, float, float, float],
    displacement_driven: bool,
    count: int,
    levels: Any,
    histories: Any,
    geometries: Any,
    unknowns: Any,
    past_loads: Any,
    loads: Any,
    lengths: Any,
    jacobian: Any,
) -> tuple[int, float, int]:
    """Advance a rod by one time step; on failure everything that belongs to the last state is as it was.

    The arrays with a leading axis are rings: step `count` stands at `count` modulo their length.

    Args:
        rod, memory: the rod and its scratch memory.
        bdf: c0 [1/s], c1 [1/s], c2 [1/s], d1 [-] of BDF-alpha.
        displacement_driven: see `shooting.solve`.
        count: steps taken before this one.
        levels: shape (3, stages, 18).
        histories: y_h of each step, shape (2, stages, 18).
        geometries: shape (2, nodes, 12).
        unknowns: shape (8, 6 + n).
        past_loads: loads of the last step, shape (n + 15,).
        loads: of this step, shape (n + 15,).
        lengths: tendon path lengths [m], written, shape (n,).
        jacobian: carried from step to step, shape (6 + n, 6 + n).

    Returns:
        SOLVED or DIVERGED, the residual's norm, marches spent.
    """
    rod, work = borrowed_rod(rod), open_work(borrowed(memory), len(rod.x))
    levels, histories, geometries = borrowed(levels), borrowed(histories), borrowed(geometries)
    unknowns, past_loads, loads = borrowed(unknowns), borrowed(past_loads), borrowed(loads)
    lengths, jacobian = borrowed(lengths), borrowed(jacobian)
    c0 = bdf[0]
    new, history = levels[(count + 1) % 3], histories[(count + 1) % 2]
    step_history(bdf, count, levels, histories, history)
    geometry = geometries[(count + 1) % 2]
    unknown = unknowns[(count + 1) % RING]
    compared = unknown.shape[0] if displacement_driven else 6
    predict(unknowns, count, work.scale, work.differences, compared, unknown)
    status, error, marches = solve(rod, work, c0, displacement_driven, unknown, loads, history, new, geometry, jacobian)
    if status != SOLVED:
        for j in range(unknown.shape[0]):
            unknown[j] = unknowns[count % RING, j]
        jacobian[:] = 0.0
        status, error, more = continue_to(
            rod, work, c0, displacement_driven, unknown, past_loads, loads, 1.0, history, new, geometry, jacobian
        )
        marches += more
    if status == SOLVED:
        for i in range(len(rod.x)):
            lengths[i] = work.raw[6 + i]
    return status, error, marches


@inlined
def step_history(bdf: tuple[float, float, float, float], count: int, levels: Any, histories: Any, history: Any) -> None:
    """Write y_h of step `count` + 1, shape (stages, 18), from the rings; see `advance`."""
    c0, c1, c2, d1 = bdf
    old, older, past = levels[count % 3], levels[(count + 2) % 3], histories[count % 2]
    y_h, y1, y2, y_h1 = history.reshape(-1), old.reshape(-1), older.reshape(-1), past.reshape(-1)
    for j in range(y_h.size):
        y_h[j] = (c1 + d1 * c0) * y1[j] + c2 * y2[j] + d1 * y_h1[j]


@kernel
def relax(
    rod: RodData,
    memory: Any,
    displacement_driven: bool,
    first: float,
    unknown: Any,
    past_loads: Any,
    loads: Any,
    lengths: Any,
    history: Any,
    levels: Any,
    geometry: Any,
    jacobian: Any,
) -> tuple[int, float, int]:
    """Statics: follow the equilibrium from `past_loads`, whose solution `unknown` holds, to `loads`.

    Args:
        first: first part of the way to try, in (0, 1].
        history: zeros, shape (stages, 18).
        others: see `advance`.

    Returns:
        SOLVED or DIVERGED, the residual's norm, marches spent.
    """
    work = open_work(memory, len(rod.x))
    status, error, marches = continue_to(
        rod, work, 0.0, displacement_driven, unknown, past_loads, loads, first, history, levels, geometry, jacobian
    )
    for i in range(len(rod.x)):
        lengths[i] = work.raw[6 + i]
    return status, error, marches


@inlined
def continue_to(
    rod: RodData,
    work: Work,
    c0: float,
    displacement_driven: bool,
    unknown: Any,
    start: Any,
    end: Any,
    first: float,
    history: Any,
    levels: Any,
    geometry: Any,
    jacobian: Any,
) -> tuple[int, float, int]:
    """Solve along the straight way from loads `start` to `end`, halving and doubling the part that one solve takes."""
    size = unknown.shape[0]
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
        status, error, more = solve(
            rod, work, c0, displacement_driven, unknown, work.loads, history, levels, geometry, jacobian
        )
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
            if stride < SMALLEST_STEP:
                return DIVERGED, error, marches
    return SOLVED, error, marches
