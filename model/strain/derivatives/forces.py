"""Derivatives of what acts in the balance of a step: tendons' pulls, and all forces by second derivatives."""

from typing import Any

from tendond.model.numerics.compile import inlined, lean
from tendond.model.numerics.products import Lines, add_products, padded
from tendond.model.strain.derivatives.room import Room
from tendond.model.strain.layout import Layout
from tendond.model.strain.second_derivatives.curvature import add_curvature
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendon_stiffness import add_tendon_stiffness


@inlined
def _slope_before(layout: Layout, loads: Loads, i: int, work: Scratch) -> float:
    """Return the derivative of a driven tendon's mean tension by its displacement at the start; see `find_residual`."""
    k = layout.tendon_stiffness[i]
    before = loads.tension[i] - work.paths_before.displacement[i]
    after = loads.tension[i] - work.paths_after.displacement[i]
    value = 0.0
    if before > 0.0 and after > 0.0:
        value = -0.5 * k
    elif before > 0.0:
        value = -(k * before - work.taut[i]) / (before - after)
    elif after > 0.0:
        value = -work.taut[i] / (after - before)
    return value


@lean
def add_pulls(layout: Layout, loads: Loads, work: Scratch, room: Room) -> None:
    """Add the derivatives of the tendons' pulls by both ends and by the actuation."""
    n, width = len(work.q1), padded(len(work.q1))
    columns = len(room.by_input) // n
    begin = 3 * len(layout.mass) + len(layout.step)
    g0, g1 = work.paths_before.gradient, work.paths_after.gradient
    driven = False
    for i in range(len(work.taut)):
        s1, s0, given = 0.0, 0.0, 1.0
        if loads.driven[i]:
            s1, s0 = work.slack[i], _slope_before(layout, loads, i, work)
            given = -(s0 + s1)
            driven = True
        change = work.paths_after.displacement[i] - work.paths_before.displacement[i]
        room.row[2 * n + i] -= given * change
        at = (begin + i) * width
        for b in range(n):
            room.lack[b] -= (s1 * change + work.taut[i]) * g1[i, b]
            room.row[b] -= (s0 * change - work.taut[i]) * g0[i, b]
            mean = 0.5 * (g0[i, b] + g1[i, b])
            room.by_input[b * columns + 2 * n + i] -= given * mean
            room.left[at + b], room.after[at + b], room.before[at + b] = mean, -s1 * g1[i, b], -s0 * g0[i, b]
    if driven:
        left, by = Lines(room.left, begin * width, width), (0, n)
        after, before = Lines(room.after, begin * width, width), Lines(room.before, begin * width, width)
        add_products(left, after, len(work.taut), by, by, Lines(room.by_q1, 0, width))
        add_products(left, before, len(work.taut), by, by, Lines(room.by_q0, 0, width))


@lean
def add_bend(layout: Layout, shape: Any, paths: Any, work: Scratch, room: Room, out: Any) -> None:
    """Add half of what forces, tensions and own moments do through second derivatives."""
    room.curvature[:, :] = 0.0
    room.moment[:, :] = 0.0
    add_curvature(layout, shape, work.force, room.moment, work.torque, room.bends, room.curvature)
    if len(work.taut) > 0:
        add_tendon_stiffness(work.taut, paths, room.curvature)
    add_half(room, out)


@lean
def add_turn(layout: Layout, loads: Loads, shape: Any, room: Room, out: Any) -> None:
    """Add half of what dead moments do through second derivatives."""
    any_moment = False
    for k in range(len(layout.polar)):
        room.torque[k] = 0.0
        for i in range(3):
            room.moment[k, i] = -loads.moment[k, i]
            any_moment |= loads.moment[k, i] != 0.0
    if any_moment:
        room.force[:, :] = 0.0
        room.curvature[:, :] = 0.0
        add_curvature(layout, shape, room.force, room.moment, room.torque, room.bends, room.curvature)
        add_half(room, out)


@inlined
def add_half(room: Room, out: Any) -> None:
    """Add half of `room.curvature` to padded rows."""
    n, width = len(room.curvature), padded(len(room.curvature))
    for a in range(n):
        for b in range(n):
            out[a * width + b] += 0.5 * room.curvature[a, b]
