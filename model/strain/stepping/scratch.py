"""Loads on the robot over a step, and the arrays that a step works in."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.parked import park
from tendond.model.numerics.products import padded
from tendond.model.strain.discretise.modes import BENDING_Y, STRETCH
from tendond.model.strain.friction.grip import Grip, empty_grip
from tendond.model.strain.kinematics import Shape, empty_shape
from tendond.model.strain.layout import Layout
from tendond.model.strain.second_derivatives.bends import Bends, bends_of
from tendond.model.strain.spans import spans_of
from tendond.model.strain.tendons import Paths, empty_paths

Array = NDArray[np.float64]


class Loads(NamedTuple):
    """Loads on a robot over a step.

    Attributes:
        force: dead forces on the mass points, world frame [N], shape (P, 3).
        tension: of each tendon [N]; or its displacement [m] where `driven`. shape (m,).
        driven: whether a tendon is driven by displacement, shape (m,).
        moment: dead moments on the nodes, world frame [N m], shape (K + 1, 3).
    """

    force: Array
    tension: Array
    driven: NDArray[np.bool_]
    moment: Array


class Scratch(NamedTuple):
    """Arrays of a step, kept from call to call so that none is allocated in it.

    Attributes:
        before, after: shapes at both ends. paths_before, paths_after: tendons there.
        matrix: derivative of the residual by q1, or its factors. rows: of its pivots, shape (n,).
        mass: factors of the mass matrix after the step. solving: room for `elimination`.
        residual: shape (n,). force: on the mass points, shape (P, 3). velocity: of them at q0, shape (P, 3).
        spin: rotation rates of the nodes at q0, shape (K + 1,); torque: moments of inertia on them, shape (K + 1,).
        taut: mean tensions, shape (m,); slack: their derivatives by the displacement at the end, shape (m,).
        elastic: the linear part of the matrix, shape (n, n); held: of the residual, shape (n,).
        scale: rotation or stretch per unit of each mode, squared, shape (n,).
        unit: energy of bending by 1 rad [J], then share and norm of the balance, shape (3,).
        q0, w0, q1, w1, trial, change, correction, pull, push, row: vectors, shape (n,).
        trend: rates beyond those before the step, for a first guess, shape (n,): see `state.trend_of`.
        hessian: second derivative of the energy, shape (n, n).
        pushes, others, turns: six rows of a section's modes. apart: six by six matrices of the sections beyond.
        share: derivative of what the balance lacks, a padded row. spun: of own turns, padded rows.
        base: of the step, if it moves, shape (25,); carried: its motion over the step, shape (15,): see `carried`.
        moved: of the mass points beside the base, shape (P, 3).
        bends: of second derivatives. quiet, calm: no moments on the nodes, shapes (K + 1, 3) and (K + 1,).
        grip: of the tendons that rub on their guides.
        left, right, total: matrices for `add_products`, as are `matrix` and `mass`: rows one after the other, padded.
    """

    before: Shape
    after: Shape
    paths_before: Paths
    paths_after: Paths
    matrix: Array
    mass: Array
    solving: Array
    rows: NDArray[np.int64]
    residual: Array
    force: Array
    velocity: Array
    spin: Array
    torque: Array
    taut: Array
    slack: Array
    elastic: Array
    held: Array
    scale: Array
    unit: Array
    q0: Array
    w0: Array
    q1: Array
    w1: Array
    trial: Array
    change: Array
    correction: Array
    pull: Array
    push: Array
    row: Array
    hessian: Array
    left: Array
    right: Array
    total: Array
    spun: Array
    pushes: Array
    others: Array
    turns: Array
    apart: Array
    base: Array
    carried: Array
    moved: Array
    share: Array
    trend: Array
    bends: Bends
    quiet: Array
    calm: Array
    grip: Grip


def scratch_for(layout: Layout) -> Scratch:
    """Return arrays for the steps of this robot."""
    n, points, tendons, nodes = len(layout.component), len(layout.mass), len(layout.straight), len(layout.polar)
    width = padded.py_func(n)  # numba compiles a call from Python anew in each process
    lengths = np.zeros(n)
    for first, last, step in zip(layout.first, layout.last, layout.step, strict=True):
        lengths[first:last] += step
    scale = np.where(layout.component < STRETCH - 2, lengths**2, 1.0) / (2.0 * layout.order + 1.0)
    bends = (layout.component <= BENDING_Y) & (layout.order == 0)
    unit = np.min(np.diag(layout.stiffness)[bends] / lengths[bends] ** 2)
    vectors = (
        "q0",
        "w0",
        "q1",
        "w1",
        "trial",
        "change",
        "correction",
        "pull",
        "push",
        "row",
        "residual",
        "held",
        "trend",
    )
    rows = max(3 * points + nodes + tendons + 6, 3 * len(layout.step))  # of the balance; of second derivatives
    work = Scratch(
        before=empty_shape(layout), after=empty_shape(layout),
        paths_before=empty_paths(layout), paths_after=empty_paths(layout),
        rows=np.zeros(n, dtype=np.int64), force=np.zeros((points, 3)), velocity=np.zeros((points, 3)),
        spin=np.zeros(nodes), torque=np.zeros(nodes), taut=np.zeros(tendons), slack=np.zeros(tendons), scale=scale,
        unit=np.array([unit, 0.0, 0.0]), left=np.zeros(rows * width), right=np.zeros(rows * width),
        base=np.zeros(25), carried=np.zeros(15), moved=np.zeros((points, 3)),
        bends=bends_of(layout), quiet=np.zeros((nodes, 3)), calm=np.zeros(nodes),
        grip=empty_grip(layout), solving=np.zeros(3 * width), apart=np.zeros(2 * 36), share=np.zeros(width),
        **{name: np.zeros(6 * spans_of(layout).width[0]) for name in ("pushes", "others", "turns")},
        **{name: np.zeros(width**2) for name in ("total", "spun", "matrix", "mass")},
        **{name: np.zeros((n, n)) for name in ("elastic", "hessian")},
        **{name: np.zeros(n) for name in vectors},
    )  # fmt: skip
    return park(work)


def mirrored(work: Scratch) -> Scratch:
    """Return the same arrays with both ends of a step exchanged, for the step that follows one with `work`."""
    values = {name: getattr(work, name) for name in Scratch._fields}
    values["before"], values["after"] = work.after, work.before
    values["paths_before"], values["paths_after"] = work.paths_after, work.paths_before
    return park(Scratch(**values))
