"""The kernel that steps many rods of one structure, one after the other, in the same arrays.

It releases the GIL, so that a pool of threads takes parts of them.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import kernel, lean
from tendond.model.numerics.parked import parked_at
from tendond.model.strain.layout import Index, Layout
from tendond.model.strain.stepping.advance import advance
from tendond.model.strain.stepping.carried import MOVING, is_moving
from tendond.model.strain.stepping.scratch import Loads, Scratch, scratch_for

Array = NDArray[np.float64]


class Room(NamedTuple):
    """Arrays in which a worker steps rods.

    Attributes:
        work, other: scratch arrays, and the same with the ends of a step exchanged. loads: of a step.
        tip: mass point of the tip, shape (1,).
    """

    work: Scratch
    other: Scratch
    loads: Loads
    tip: Index


class Kinds(NamedTuple):
    """Robots of a batch.

    Attributes:
        addresses: of each rod's layout, shape (N,). of: each rod's row of `measures`, shape (N,).
        measures: of each robot, see `measures_of`; what a row is longer than these is zeros.
    """

    addresses: Index
    of: Index
    measures: Array


class Inputs(NamedTuple):
    """What acts on N rods over some steps; each of them for every step, or once for all: shape (steps or 1, N, ...).

    Attributes:
        actuation: tensions [N] or displacements [m] of the tendons, shape (..., m). driven: whether displacements.
        tip_force: [N], shape (..., 3). base: `Base.row`, or zeros: where the robot has it, shape (..., 25).
    """

    actuation: Array
    driven: bool
    tip_force: Array
    base: Array


class Motion(NamedTuple):
    """Motion of N rods.

    Attributes:
        strain: strains, shape (N, n). rate: of them [1/s], shape (N, n). counts: what `RodBatch` sums up, shape (N, 3).
        earlier: rates one and two steps before, shape (N, 2, n); begun: whether there are any, shape (N,).
        pulls: tensions along the tendons with friction [N], shape (N, F, 1 + Q), of a rod as many as it has.
        lost: work of friction in the last step [J], shape (N,).
    """

    strain: Array
    rate: Array
    counts: Index
    earlier: Array
    begun: NDArray[np.bool_]
    pulls: Array
    lost: Array


class Track(NamedTuple):
    """Motion that is kept, of all steps or of none: tips [m], shape (S, N, 3); displacements [m], shape (S, N, m)."""

    tip: Array
    displacement: Array


def measures_of(layout: Layout) -> Array:
    """Parameters that scratch arrays hold, in a row: measures of strains and of energy, modes and routes at points."""
    work = scratch_for(layout)
    paths, weights = work.paths_before, work.before.directions.weights
    return np.concatenate(
        (work.scale, work.unit[:1], weights, paths.routes, layout.base, layout.origin, paths.modes)
    )  # fmt: skip


@lean
def take_measures(work: Scratch, row: Any) -> None:
    """Write a robot's parameters into arrays that those of other robots were in; see `measures_of`."""
    at = len(work.scale)
    for a in range(at):
        work.scale[a] = row[a]
    work.unit[0] = row[at]
    at += 1
    weights, routes, modes = (
        len(work.before.directions.weights),
        len(work.paths_before.routes),
        len(work.paths_before.modes),
    )
    for a in range(weights):
        work.before.directions.weights[a] = work.after.directions.weights[a] = row[at + a]
    at += weights
    for a in range(routes):
        work.paths_before.routes[a] = work.paths_after.routes[a] = row[at + a]
    at += routes
    for c in range(9):
        work.before.rotation[0, c] = work.after.rotation[0, c] = row[at + c]
    for c in range(3):
        work.before.position[0, c] = work.after.position[0, c] = row[at + 9 + c]
    at += 12
    for a in range(modes):
        work.paths_before.modes[a] = work.paths_after.modes[a] = row[at + a]


@lean
def take_base(layout: Layout, row: Any, work: Scratch) -> bool:
    """Write the base of a step; return whether it is, and was, where the robot has it."""
    if row[MOVING] == 0.0 and not is_moving(work):
        return True
    for c in range(len(work.base)):
        work.base[c] = row[c]
    if row[MOVING] == 0.0:  # else `advance` places it
        for c in range(9):
            work.before.rotation[0, c] = work.after.rotation[0, c] = layout.base[c]
        for c in range(3):
            work.before.position[0, c] = work.after.position[0, c] = layout.origin[c]
    return False


@lean
def take_pulls(work: Scratch, pulls: Any) -> None:
    """Write the tensions along a rod's tendons with which a step begins [N], shape (F, 1 + Q)."""
    start = work.grip.start
    for f in range(len(start)):
        for j in range(start.shape[1]):
            start[f, j] = pulls[f, j]


@kernel
def advance_many(
    like: Layout,
    room: Room,
    kinds: Kinds,
    inputs: Inputs,
    motion: Motion,
    track: Track,
    h: float,
    tolerance: float,
    lanes: Index,
    steps: int,
) -> None:
    """Advance some of the rods, by their numbers, by some steps, in place; see `RodBatch`."""
    kept = len(track.tip) > 0
    work, other, loads, tip = room.work, room.other, room.loads, room.tip[0]
    loads.driven[:] = inputs.driven
    grip, held = work.grip, -1
    for i in lanes:
        layout = parked_at(like, kinds.addresses[i])
        if kinds.of[i] != held:
            held = kinds.of[i]
            take_measures(work, kinds.measures[held])
        take_pulls(work, motion.pulls[i])
        for k in range(steps):
            now, pushed = min(k, len(inputs.actuation) - 1), min(k, len(inputs.tip_force) - 1)
            known = take_base(layout, inputs.base[min(k, len(inputs.base) - 1), i], work) and k > 0
            for a in range(len(loads.tension)):
                loads.tension[a] = inputs.actuation[now, i, a]
            for c in range(3):
                loads.force[tip, c] = inputs.tip_force[pushed, i, c]
            rate, earlier = motion.rate[i], motion.earlier[i]
            for a in range(len(rate)):
                work.trend[a] = 0.5 * (earlier[0, a] - earlier[1, a]) if motion.begun[i] else 0.0  # `trend_of`
                earlier[1, a] = earlier[0, a] if motion.begun[i] else rate[a]
                earlier[0, a] = rate[a]
            motion.begun[i] = True
            total, parts, damped = advance(layout, loads, motion.strain[i], motion.rate[i], h, tolerance, work, known)
            if kept:
                for c in range(3):
                    track.tip[k, i, c] = work.after.position[-1, c]
                for a in range(len(loads.tension)):
                    track.displacement[k, i, a] = work.paths_after.displacement[a]
            work, other = other, work
            motion.counts[i, 0] += total
            motion.counts[i, 1] += parts
            motion.counts[i, 2] += damped
        for f in range(len(grip.tension)):
            for j in range(grip.tension.shape[1]):
                motion.pulls[i, f, j] = grip.tension[f, j]
        motion.lost[i] = grip.lost[0]
