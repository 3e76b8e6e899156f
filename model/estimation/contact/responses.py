"""What forces along the body do to strains and rates within a step, as the errors of the filter see it.

With the matrix T of the step's balance (`kalman.transition`), a force f at a place with the Jacobian J, held over the
step, changes strains and rates after it by

    dq1 = T^-1 J' f,    dw1 = (2/h) dq1.
"""

from typing import Any

from tendond.model.estimation.kalman.transition import solve_back
from tendond.model.numerics.compile import lean


@lean
def find_responses(matrix: Any, jacobian: Any, points: Any, kept: Any, h: float, responses: Any) -> None:
    """Write strains and rates after a step by forces during it.

    Args:
        matrix: T after Gaussian elimination without pivots: its upper triangle, shape (k, k).
        jacobian: of the mass points by the modes [m], shape (P, 3, n or more).
        points: mass points of the p places, shape (p,).
        kept: modes that have errors, shape (k,).
        h: [s].
        responses: takes them, three columns a place, shape (2 k, 3 p).
    """
    k, places = len(kept), len(points)
    for i in range(k):
        for p in range(places):
            for c in range(3):
                responses[i, 3 * p + c] = jacobian[points[p], c, kept[i]]
    columns = 3 * places
    for i in range(k):
        inverse = 1.0 / matrix[i, i]
        for l in range(i + 1, k):
            part = matrix[i, l] * inverse  # what the symmetric matrix had below its pivot
            if part != 0.0:
                for j in range(columns):
                    responses[l, j] -= part * responses[i, j]
    solve_back(matrix, h, responses, columns)
