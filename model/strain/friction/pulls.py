"""Pulls of tendons that rub in the balance of a step, and these pulls' derivatives.

Over a step a cell pulls with its tension at the step's end (implicit Euler): whatever the step, the rod gets no more
than the servo's work, less what friction takes away and the tendon stores.
"""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.numerics.products import padded
from tendond.model.strain.friction.cells import find_bends, find_cells
from tendond.model.strain.friction.sliding import find_slopes, move_tendon, pull_tendon
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendon_stiffness import add_tendon_stiffness

Array = NDArray[np.float64]


@lean
def begin_friction(layout: Layout, work: Scratch) -> None:
    """Write the cells before a step, after `find_paths` there."""
    find_cells(layout, work.paths_before, work.grip, work.grip.before)


@lean
def accept_friction(work: Scratch) -> None:
    """Let the next step begin with the tensions that this one ended with."""
    start, tension = work.grip.start, work.grip.tension
    for f in range(len(start)):
        for j in range(start.shape[1]):
            start[f, j] = tension[f, j]


@lean
def find_friction(layout: Layout, loads: Loads, q: Array, work: Scratch) -> None:
    """Write the tensions along the tendons at q, after `find_paths` there, and after `begin_friction`."""
    grip = work.grip
    find_cells(layout, work.paths_after, grip, grip.after)
    find_bends(layout, q, work.paths_after, grip)
    grip.lost[0] = 0.0
    for f in range(len(grip.tendon)):
        i = grip.tendon[f]
        grip.driven[f] = loads.driven[i]
        if loads.driven[i]:
            before, after = work.paths_before.displacement[i], work.paths_after.displacement[i]
            move_tendon(layout, grip, f, loads.tension[i], before, after)
        else:
            pull_tendon(layout, grip, f, loads.tension[i])


@lean
def add_friction(layout: Layout, loads: Loads, q1: Array, work: Scratch) -> None:
    """Add the pulls of tendons that rub to the residual of a step, after `find_residual` without them."""
    grip, n, lacking = work.grip, len(q1), 0.0
    find_friction(layout, loads, q1, work)
    grip.force[:] = 0.0
    for f in range(len(grip.tendon)):
        for j in range(grip.number[f]):
            tension = grip.tension[f, 1 + j]
            if tension != 0.0:
                lacking -= tension * (grip.after.shortening[f, j] - grip.before.shortening[f, j])
                for a in range(n):
                    grip.force[a] -= 0.5 * tension * (grip.before.gradient[f, j, a] + grip.after.gradient[f, j, a])
    for a in range(n):
        lacking -= grip.force[a] * work.change[a]
    share = lacking / work.unit[2]
    work.unit[1] += share
    for a in range(n):
        work.pull[a] += grip.force[a]
        work.residual[a] += grip.force[a] + share * layout.stiffness[a, a] * work.change[a]


@lean
def add_friction_curvature(work: Scratch, out: Array) -> None:
    """Add what the tensions along the tendons do through second derivatives of their paths to `out`, shape (n, n)."""
    grip, paths = work.grip, work.paths_after
    width = len(paths.shortening)
    for f in range(len(grip.tendon)):
        for j in range(grip.number[f]):
            at = (4 * j + 3) * width + grip.tendon[f]
            grip.weight[f, j] = paths.tangent[at]
            paths.tangent[at] *= grip.tension[f, 1 + j]
    add_tendon_stiffness(grip.one, paths, out)
    for f in range(len(grip.tendon)):
        for j in range(grip.number[f]):
            paths.tangent[(4 * j + 3) * width + grip.tendon[f]] = grip.weight[f, j]


@lean
def add_friction_slopes(layout: Layout, work: Scratch) -> None:
    """Add the derivatives of the tensions along the tendons to `work.total`, and of their work to `work.share`."""
    grip, n, width = work.grip, len(work.q1), padded(len(work.q1))
    for f in range(len(grip.tendon)):
        find_slopes(layout, grip, f, n)
        for j in range(grip.number[f]):
            tension = grip.tension[f, 1 + j]
            change = grip.after.shortening[f, j] - grip.before.shortening[f, j]
            for a in range(n):
                mean = 0.5 * (grip.before.gradient[f, j, a] + grip.after.gradient[f, j, a])
                work.share[a] -= grip.slope[f, j, a] * change + tension * grip.after.gradient[f, j, a]
                for b in range(n):
                    work.total[a * width + b] -= mean * grip.slope[f, j, b]
