"""Arguments of the kernels: a rod, the boundary value problem of a step, the state along the rod, a rod's state."""

from typing import Any, NamedTuple

import numpy as np

from tendond.model.numerics.compile import borrowed, inlined

CONSTANTS = np.dtype(
    [(name, "f8", (3,)) for name in ("Kse", "Kbt", "Bse", "Bbt", "rhoJ", "C", "tip_inertia", "tip_offset", "gravity")]
    + [("rhoA", "f8"), ("tip_mass", "f8")]
)
"""Material, tip body and gravity of a rod; the symbols are those of `equations`."""

HISTORY = 18
"""Numbers that a stage keeps in time: e, u, q, w, e_s, u_s."""

WIDTHS = (4, 8, 16)
"""Numbers of tendons that kernels are compiled for: the processor works on four or eight numbers at once."""

Bdf = tuple[float, float, float, float]
"""Coefficients of BDF-alpha: c0, c1, c2 [1/s], d1 [-]."""


class RodData(NamedTuple):
    """A rod and its discretisation: what does not change while it is simulated.

    `one` and `many` have as many entries as lanes march together. Tendons stand in SIMD vectors, whose width is that of
    `x` and `y` and belongs to the kernel's type: it is one of `WIDTHS`, and tendons that a rod has not are on the axis
    and without tension there, so that a kernel serves every number of tendons up to its width.
    """

    one: tuple[int, ...]
    many: tuple[int, ...]
    tendons: int  # n
    x: tuple[float, ...]  # tendon positions in the cross-section [m], then zeros
    y: tuple[float, ...]
    constants: Any  # array of one `CONSTANTS` record
    tableau: Any  # Butcher's a, shape (s, s)
    weights: Any  # Butcher's b, shape (s,)
    push: Any  # spread of a push over the stages [1/m], shape (stages,)
    flags: tuple[bool, bool]  # trapezoidal tendon lengths, orthonormal R
    steps: int
    ds: float  # length of a step [m]
    length: float  # of the rod [m]
    stiffness: float  # of a tendon [N/m]
    tolerance: float  # residual norm [N]
    budget: int  # marches that one solve may spend


class Problem(NamedTuple):
    """The boundary value problem of a step; of statics with c0 = 0 and a history of zeros."""

    c0: float  # of BDF-alpha [1/s]
    displacement_driven: bool  # the first n loads are commanded displacements [m] rather than tensions [N]
    loads: Any  # tendon commands n, tip force, tip moment, distributed force, distributed moment, push: (n + 15,)
    history: Any  # y_h of e, u, q, w, e_s, u_s, shape (stages, 18)


class Profile(NamedTuple):
    """The state along the rod, which a march of one rod writes."""

    levels: Any  # e, u, q, w, e_s, u_s, shape (stages, 18)
    geometry: Any  # p, R, shape (nodes, 12)


class StateData(NamedTuple):
    """A rod's state between two steps. Leading axes of rings: step k stands at k modulo their length.

    See `rod.state.RodState`, of which it has the fields.
    """

    step: int  # number of the last step
    displacement_driven: bool
    levels: Any  # ring, shape (3, stages, 18)
    histories: Any  # ring, shape (2, stages, 18)
    geometries: Any  # ring, shape (2, nodes, 12)
    unknowns: Any  # ring, shape (8, 6 + n)
    loads: Any  # of the last step, shape (n + 15,)
    lengths: Any  # tendon path lengths [m], shape (n,)
    jacobian: Any  # shape (6 + n, 6 + n)


@inlined
def borrowed_rod(rod: RodData) -> RodData:
    """The same rod, its arrays borrowed."""
    return RodData(
        rod.one, rod.many, rod.tendons, rod.x, rod.y, borrowed(rod.constants), borrowed(rod.tableau),
        borrowed(rod.weights), borrowed(rod.push), rod.flags, rod.steps, rod.ds, rod.length, rod.stiffness,
        rod.tolerance, rod.budget,
    )  # fmt: skip


@inlined
def borrowed_state(state: StateData) -> StateData:
    """The same state, its arrays borrowed."""
    return StateData(
        state.step, state.displacement_driven, borrowed(state.levels), borrowed(state.histories),
        borrowed(state.geometries), borrowed(state.unknowns), borrowed(state.loads), borrowed(state.lengths),
        borrowed(state.jacobian),
    )  # fmt: skip
