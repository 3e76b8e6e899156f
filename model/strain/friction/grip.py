"""Arrays of the tendons that rub on their guides: tensions along them, cells of their paths, bends between these.

A cell is what a tendon point stands for in the quadrature of the path: its length, its tension, its stretch. Between
two cells, and before the first, is a contact at which the tendon sticks or slides.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.parked import park
from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]
Index = NDArray[np.int64]


class Cells(NamedTuple):
    """Cells of the tendons' paths in one shape; F tendons that rub, Q tendon points.

    Attributes:
        shortening: less each cell's length [m], shape (F, Q). gradient: of it by the modes, shape (F, Q, n).
    """

    shortening: Array
    gradient: Array


class Grip(NamedTuple):
    """Tendons that rub, F of them; contact j is before cell j.

    Attributes:
        tendon: which tendons these are, shape (F,). number: of their cells, shape (F,).
        driven: whether by displacement, shape (F,).
        before, after: cells in the shapes at both ends of a step.
        start, tension: at the servo's end and in the cells, before a step and after it [N], shape (F, 1 + Q).
        bend: of the path at each contact [rad], shape (F, Q); turn: its derivative by the modes, shape (F, Q, n).
        ratio: of tensions at a contact that slides, exp(-mu bend), shape (F, Q).
        slid: 1 where a contact slides towards the servo, -1 towards the tip, 0 where it sticks, shape (F, Q).
        stuck: tension of each cell if the contact before it sticks [N], shape (Q,).
        slope: of the tensions by the modes, shape (F, Q, n); share: of a cell in its block's first one, shape (Q,).
        lost: work of friction over a step [J], shape (1,).
        strain: bending and twist at the tendon points [1/m], shape (Q, 3). weight: of the tangents, kept, shape (F, Q).
        force: on the modes, shape (n,). one: 1 for the tendons that rub, else 0, shape (m,).
    """

    tendon: Index
    number: Index
    driven: Index
    before: Cells
    after: Cells
    start: Array
    tension: Array
    bend: Array
    turn: Array
    ratio: Array
    slid: Index
    stuck: Array
    slope: Array
    share: Array
    lost: Array
    strain: Array
    weight: Array
    force: Array
    one: Array


def empty_grip(layout: Layout) -> Grip:
    """Return arrays for the tendons of this robot that rub; of size 0 where none does."""
    tendon = np.flatnonzero(layout.friction > 0.0).astype(np.int64)
    number = np.count_nonzero(layout.weight[:, tendon], axis=0).astype(np.int64)
    rubbing, n = len(tendon), len(layout.component)
    points = len(layout.weight) if rubbing else 0
    cells = [park(Cells(np.zeros((rubbing, points)), np.zeros((rubbing, points, n)))) for _ in range(2)]
    grip = Grip(
        tendon=tendon, number=number, driven=np.zeros_like(tendon), before=cells[0], after=cells[1],
        start=np.zeros((rubbing, 1 + points)), tension=np.zeros((rubbing, 1 + points)),
        turn=np.zeros((rubbing, points, n)), slope=np.zeros((rubbing, points, n)),
        slid=np.zeros((rubbing, points), dtype=np.int64), lost=np.zeros(1), strain=np.zeros((points, 3)),
        force=np.zeros(n), one=(layout.friction > 0.0).astype(np.float64),
        **{name: np.zeros((rubbing, points)) for name in ("bend", "ratio", "weight")},
        **{name: np.zeros(points) for name in ("stuck", "share")},
    )  # fmt: skip
    return park(grip)
