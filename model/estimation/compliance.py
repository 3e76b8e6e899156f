"""Compliance of the tip of a bent rod, and the likeliest force for a motion of the tip."""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import inlined, kernel
from tendond.model.numerics.vectors import (
    Matrix,
    Vector,
    dot,
    inverse,
    outer,
    plus_diagonal,
    product,
    scale,
    sub,
)
from tendond.model.rods.interface import ModelRod, ModelState
from tendond.model.solver.lanes import vector

Array = NDArray[np.float64]


class Arm(NamedTuple):
    """The bent rod's nodes, stiffness and gravity, from which the compliance follows."""

    positions: Any  # of the nodes, with equal parts of the compliance between them [m], shape (nodes, 3)
    length: float  # [m]
    stiffness: float  # L / int ds/EI [N m^2]
    gravity: Vector  # [m/s^2]


def bent_arm(rod: ModelRod, state: ModelState) -> Arm:
    """The rod, bent as `state` is."""
    (x, y, z), own = rod.parameters.gravity, rod.parameters
    return Arm(rod.node_positions(state), own.length, rod.arm_stiffness, (float(x), float(y), float(z)))


@inlined
def likeliest_force(compliance: Matrix, gravity: Vector, lateral_variance: float, unobservable: float) -> Any:
    """C^+ = P C (C P C + r 1)^-1 [N/m]: the likeliest force for a motion of the tip.

    P is the expected variance of the force: a motion that several forces would explain is attributed to one along
    gravity. Directions in which the tip hardly yields (r) are left out.

    Args:
        compliance: C [m/N]. gravity: [m/s^2].
        lateral_variance, unobservable: see `ObserverGains`; r is the square of the latter times half the trace of C.
    """
    size = math.sqrt(dot(gravity, gravity))
    down = scale(1.0 / size if size > 0.0 else 0.0, gravity)
    across, along = (lateral_variance, 1.0 - lateral_variance) if size > 0.0 else (1.0, 0.0)
    prior = plus_diagonal(outer(scale(along, down), down), across)
    floor = (unobservable * 0.5 * (compliance[0] + compliance[4] + compliance[8])) ** 2
    prior_compliance = product(prior, compliance)
    return product(prior_compliance, inverse(plus_diagonal(product(compliance, prior_compliance), floor)))


@inlined
def compliance(arm: Arm) -> Matrix:
    """Compliance of the tip [m/N]; see `tip_compliance`."""
    places = arm.positions
    nodes = places.shape[0]
    tip = vector(places[nodes - 1], 0)
    xx, yy, zz, xy, xz, yz = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(nodes - 1):  # the tip's own arm is zero
        r = sub(tip, vector(places[k], 0))
        share = 0.5 if k == 0 else 1.0
        xx, yy, zz = xx + share * r[0] * r[0], yy + share * r[1] * r[1], zz + share * r[2] * r[2]
        xy, xz, yz = xy + share * r[0] * r[1], xz + share * r[0] * r[2], yz + share * r[1] * r[2]
    f = arm.length / (nodes - 1) / arm.stiffness
    return f * (yy + zz), -f * xy, -f * xz, -f * xy, f * (xx + zz), -f * yz, -f * xz, -f * yz, f * (xx + yy)


@kernel
def _fill_compliance(arm: Arm, out: Any) -> None:
    """Write the compliance to `out`, shape (9,)."""
    filled = compliance(arm)
    for j in range(9):
        out[j] = filled[j]


def tip_compliance(rod: ModelRod, state: ModelState) -> Array:
    """Compliance of the tip [m/N], shape (3, 3), of a slender rod bent as `state` is.

    Unit-load method (Timoshenko, Strength of Materials): C = integral of hat(r)' hat(r) / EI ds with r from s to the
    tip; torsion is counted as stiff as bending, shear, extension and the tendons' pull are left out. For gains only.
    """
    out = np.empty(9)
    _fill_compliance(bent_arm(rod, state), out)
    return out.reshape(3, 3)
