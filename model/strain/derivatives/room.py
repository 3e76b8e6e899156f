"""Arrays that the derivatives of a step work in."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.parked import park
from tendond.model.numerics.products import HALF, padded
from tendond.model.strain.derivatives.rates import Rates, empty_rates
from tendond.model.strain.kinematics import aligned
from tendond.model.strain.layout import Index, Layout
from tendond.model.strain.second_derivatives.bends import Bends, bends_of

Array = NDArray[np.float64]


class Room(NamedTuple):
    """Arrays of the derivatives; N inputs: strains, rates, actuation, forces on points, moments on nodes.

    Attributes:
        bends: of second derivatives. rates0, rates1: motion at both ends for the rates there.
        spin0, spin1: of the nodes' own turns for q1 - q0, shape (K + 1, N);
            spins0, spins1: the same in a row.
        left, after, before, rate: rows of `add_products`: three of each mass point, one of each interval's end, one of
            each tendon. The first is what the others, by q1, q0 and w0, are multiplied by.
        by_q1, by_q0, by_w0: of the balance, then of the momentum; padded rows.
        by_input: of the strains after the step, by the inputs; turned: of the rates. n rows, padded.
        curvature: second derivatives, shape (n, n).
        lack: derivative of what the balance lacks by q1, a padded row; early: of the points' share by q0 and w0, two
            padded rows; row: by all inputs, shape (N,).
        points: mass points on which forces act, shape (f,); nodes: on which moments do, shape (g,); dead, world frame.
        force: shape (P, 3); moment: shape (K + 1, 3); torque: shape (K + 1,); turn: three rows of N.
    """

    bends: Bends
    rates0: Rates
    rates1: Rates
    spin0: Array
    spin1: Array
    spins0: Array
    spins1: Array
    left: Array
    after: Array
    before: Array
    rate: Array
    by_q1: Array
    by_q0: Array
    by_w0: Array
    by_input: Array
    turned: Array
    curvature: Array
    lack: Array
    early: Array
    row: Array
    points: Index
    nodes: Index
    force: Array
    moment: Array
    torque: Array
    turn: Array


def room_for(layout: Layout, pushed: Sequence[int] = (), turned: Sequence[int] = ()) -> Room:
    """Return arrays for the derivatives of this robot's steps by state, actuation, forces and moments.

    Args:
        layout: of the robot.
        pushed: mass points on which forces act.
        turned: nodes on which moments do.
    """
    n, nodes, points = len(layout.component), len(layout.polar), len(layout.mass)
    inputs = 2 * n + len(layout.straight) + 3 * len(pushed) + 3 * len(turned)
    width, columns = padded.py_func(n), padded.py_func(inputs)
    own = -(-n // HALF) * HALF
    spins = aligned(nodes * own), aligned(nodes * own)
    rows = (3 * points + nodes - 1 + len(layout.straight)) * width
    room = Room(
        bends=bends_of(layout), rates0=empty_rates(layout), rates1=empty_rates(layout),
        spin0=spins[0].reshape(nodes, -1), spin1=spins[1].reshape(nodes, -1), spins0=spins[0], spins1=spins[1],
        by_input=np.zeros(n * columns),
        turned=np.zeros(n * columns), curvature=np.zeros((n, n)), lack=np.zeros(width),
        early=np.zeros(2 * width), row=np.zeros(inputs), points=np.array(pushed, dtype=np.int64),
        nodes=np.array(turned, dtype=np.int64),
        force=np.zeros((points, 3)), moment=np.zeros((nodes, 3)), torque=np.zeros(nodes), turn=aligned(3 * own),
        **{name: np.zeros(rows) for name in ("left", "after", "before", "rate")},
        **{name: np.zeros(width**2) for name in ("by_q1", "by_q0", "by_w0")},
    )  # fmt: skip
    return park(room)


def mirrored_room(room: Room) -> Room:
    """Return the same arrays with the motion at both ends exchanged, for the step that follows one with `room`."""
    values = {name: getattr(room, name) for name in Room._fields}
    values["rates0"], values["rates1"] = room.rates1, room.rates0
    return park(Room(**values))
