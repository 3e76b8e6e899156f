"""Arrays that the derivatives of a step work in."""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.parked import park
from tendond.model.strain.derivatives.rates import Rates, empty_rates
from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]


class Room(NamedTuple):
    """Arrays of the derivatives; N inputs: strains, rates, actuation, forces on points, moments on nodes.

    Attributes:
        rates0, rates1: motion at both ends for the rates there. spin0, spin1: of the nodes' own turns for q1 - q0.
        by_q1: of the balance by q1, shape (n, n); by_input: of balance, then momentum, by the inputs, shape (n, N).
        curvature: second derivatives, then those of the momentum by q1, shape (n, n).
        lack: derivative of what the balance lacks by q1, shape (n,); row: by the inputs, shape (N,).
        force: shape (P, 3); moment: shape (K + 1, 3); torque: shape (K + 1,); turn: shape (3, n).
        by_force0, by_force1: of a point's force by q0 and q1, shape (3, n). q0, w0: before the step, shape (n,).
    """

    rates0: Rates
    rates1: Rates
    spin0: Array
    spin1: Array
    by_q1: Array
    by_input: Array
    curvature: Array
    lack: Array
    row: Array
    force: Array
    moment: Array
    torque: Array
    turn: Array
    by_force0: Array
    by_force1: Array
    q0: Array
    w0: Array


def room_for(layout: Layout, inputs: int) -> Room:
    """Return arrays for the derivatives of this robot's steps by `inputs` numbers, 2 n + m at least."""
    n, nodes, points = len(layout.component), len(layout.polar), len(layout.mass)
    room = Room(
        empty_rates(layout), empty_rates(layout), np.zeros((nodes, n)), np.zeros((nodes, n)), np.zeros((n, n)),
        np.zeros((n, inputs)), np.zeros((n, n)), np.zeros(n), np.zeros(inputs), np.zeros((points, 3)),
        np.zeros((nodes, 3)), np.zeros(nodes), np.zeros((3, n)), np.zeros((3, n)), np.zeros((3, n)), np.zeros(n),
        np.zeros(n),
    )  # fmt: skip
    return park(room)
