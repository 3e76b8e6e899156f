"""Derivatives of the tip after a step by what acts during it: one more matrix of Newton's method.

With the balance R(q1; inputs) = 0 of a step, dq1 = -R_q1^-1 R_inputs. The matrix is Newton's own at q1: what turns with
the cross-sections, the axes of drag and the rods' own spin, counts as it is there. The whole linear model, by the state
before the step and of the rates after it, is that of `derivatives.step`, which differentiates all of it.
"""

from typing import Any

from tendond.model.numerics.columns import solve_lu_columns
from tendond.model.numerics.compile import lean
from tendond.model.numerics.elimination import factor_lu
from tendond.model.numerics.products import padded
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.stepping.tangent import find_matrix


@lean
def differentiate_inputs(
    layout: Layout, loads: Loads, h: float, tip: int, point: int, node: int, work: Scratch, by_input: Any, out: Any
) -> bool:
    """Write derivatives after the step of length h that `work` has just taken, by actuation, force and moment.

    Args:
        layout: of the robot.
        loads: held over the step.
        h: [s].
        tip: its mass point. point: mass point on which the force acts. node: on which the moment does.
        work: what the step left there.
        by_input: of the strains, n padded rows of N = m + 6 inputs: actuation of the tendons, then a dead force and a
            dead moment, world frame.
        out: position of the tip, its rotation vector, and displacements of the tendons, shape (6 + m, N).

    Returns:
        False where the step's matrix is singular.
    """
    n, m, width = len(work.q1), len(work.taut), padded(len(work.q1))
    columns = len(by_input) // n
    one, two, change, norm = work.before, work.after, work.change, work.unit[2]
    g0, g1 = work.paths_before.gradient, work.paths_after.gradient
    find_matrix(layout, h, work)
    if not factor_lu(work.matrix, work.rows, n, width, work.solving):
        return False
    by_input[:] = 0.0
    for i in range(m):
        given = 1.0
        if loads.driven[i]:
            k = layout.tendon_stiffness[i]
            before = loads.tension[i] - work.paths_before.displacement[i]
            after = loads.tension[i] - work.paths_after.displacement[i]
            # Mean over a linear move: both ends taut, or the part of it that is.
            given = 0.0
            if before > 0.0 and after > 0.0:
                given = k
            elif before > 0.0 or after > 0.0:
                given = k * max(before, after) / abs(before - after)
        lack = work.paths_after.displacement[i] - work.paths_before.displacement[i]
        for a in range(n):
            mean = 0.5 * given * (g0[i, a] + g1[i, a])
            by_input[a * columns + i] = mean
            lack -= 0.5 * (g0[i, a] + g1[i, a]) * change[a]
        for a in range(n):
            by_input[a * columns + i] += layout.stiffness[a, a] * change[a] / norm * given * lack
    last = layout.last[layout.place[point] - 1]
    for c in range(3):
        lack = two.point[point, c] - one.point[point, c]
        for a in range(last):
            mean = 0.5 * (one.jacobian[point, c, a] + two.jacobian[point, c, a])
            by_input[a * columns + m + c] = mean
            by_input[a * columns + m + 3 + c] = 0.5 * (one.twist[node, c, a] + two.twist[node, c, a])
            lack -= mean * change[a]
        for a in range(n):
            by_input[a * columns + m + c] += layout.stiffness[a, a] * change[a] / norm * lack
    solve_lu_columns(work.matrix, work.rows, by_input, n, width, columns)
    for b in range(m + 6):
        for c in range(3):
            moved, turned = 0.0, 0.0
            for a in range(n):
                moved += two.jacobian[tip, c, a] * by_input[a * columns + b]
                turned += two.twist[-1, c, a] * by_input[a * columns + b]
            out[c, b], out[3 + c, b] = moved, turned
        for i in range(m):
            shorter = 0.0
            for a in range(n):
                shorter += g1[i, a] * by_input[a * columns + b]
            out[6 + i, b] = shorter
    return True
