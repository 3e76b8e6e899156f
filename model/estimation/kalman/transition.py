"""The linear model of a step for the errors: strains and rates after it, by all errors before it.

With the mass M, the damping D and the tangent stiffness K of the shape before the step, the balance of the step
(`strain.stepping.balance`) has, for small changes,

    T dq1 = (T - K) dq0 + (2/h) M dw0 + B du,    dw1 = (2/h) (dq1 - dq0) - dw0,    T = 2 M/h^2 + D/h + (1/2 + e) K,

M and K those of a shape that hardly moves in one step. The exact derivatives (`derivatives.linearise`) cost as much as
four of these; `pytest tests/unit/estimation` holds the two against each other.
"""

from typing import Any

from tendond.model.numerics.compile import lean
from tendond.model.numerics.products import padded
from tendond.model.strain.layout import Layout
from tendond.model.strain.minima.energy import find_energy
from tendond.model.strain.minima.hessian import find_hessian
from tendond.model.strain.stepping.balance import DISSIPATION
from tendond.model.strain.stepping.mass import find_mass
from tendond.model.strain.stepping.scratch import Loads, Scratch


@lean
def solve_back(matrix: Any, h: float, right: Any, columns: int) -> None:
    """Solve for the strains after a step, and write their rates, 2/h times as large, to the rows below.

    Args:
        matrix: upper triangle of T after Gaussian elimination, shape (k, k). h: [s].
        right: eliminated right sides in its first k rows, shape (2 k, `columns` or more).
        columns: of them.
    """
    k = len(matrix)
    for i in range(k - 1, -1, -1):
        for l in range(i + 1, k):
            part = matrix[i, l]
            for j in range(columns):
                right[i, j] -= part * right[l, j]
        inverse = 1.0 / matrix[i, i]
        for j in range(columns):
            right[i, j] *= inverse
    for i in range(k):
        for j in range(columns):
            right[k + i, j] = 2.0 / h * right[i, j]


@lean
def find_transition(
    layout: Layout, loads: Loads, q: Any, h: float, kept: Any, bends: Any, arms: Any, tip: int, factor: float,
    work: Scratch, matrix: Any, top: Any,
) -> bool:  # fmt: skip
    """Write the strains and rates after a step from the strains q, by the errors before it.

    Args:
        layout: of the robot. loads: held over the step, with tensions.
        q: strains, shape (n,). h: [s].
        kept, bends, arms: see `ErrorLayout`. tip: mass point on which the force acts.
        factor: by which the layout's stiffness is above the robot's own.
        work: room. matrix: room, shape (k, k).
        top: shape (2 k, N); see `ErrorLayout`.

    Returns:
        False where the step has no such model: the matrix is not positive definite.
    """
    n, k, m = len(q), len(kept), len(work.taut)
    width, columns = padded(n), 2 * k + 3 + m + len(bends) + 1
    find_energy(layout, loads, q, 0.0, work)
    find_hessian(layout, loads, q, 0.0, False, work)
    find_mass(layout, work.after, work)
    paths, shape = work.paths_after, work.after
    for i in range(k):
        a = kept[i]
        for j in range(k):
            b = kept[j]
            mass = work.mass[min(a, b) * width + max(a, b)]
            stiffness = work.hessian[a, b]
            matrix[i, j] = 2.0 * mass / (h * h) + layout.damping[a, b] / h + (0.5 + DISSIPATION) * stiffness
            top[i, j] = matrix[i, j] - stiffness
            top[i, k + j] = 2.0 * mass / h
        for c in range(3):
            top[i, 2 * k + c] = shape.jacobian[tip, c, a]
        for c in range(m):
            top[i, 2 * k + 3 + c] = paths.gradient[c, a] if work.taut[c] > 0.0 else 0.0
        for c in range(len(bends)):
            top[i, 2 * k + 3 + m + c] = arms[c] if bends[c] == i else 0.0
        bent = 0.0
        for b in range(n):
            bent -= layout.stiffness[a, b] * q[b]
        top[i, columns - 1] = bent / factor
    for i in range(k):  # Gaussian elimination of a symmetric matrix: no pivots
        pivot = matrix[i, i]
        if not (pivot > 0.0 and pivot < 1e300):
            return False
        for l in range(i + 1, k):
            part = matrix[l, i] / pivot
            if part != 0.0:
                for j in range(i, k):
                    matrix[l, j] -= part * matrix[i, j]
                for j in range(columns):
                    top[l, j] -= part * top[i, j]
    solve_back(matrix, h, top, columns)
    for i in range(k):
        top[k + i, i] -= 2.0 / h
        top[k + i, k + i] -= 1.0
    return True
