"""The second derivative of the energy, whose eigenvalues tell stability."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.strain.composites import curvature_of_points
from tendond.model.strain.layout import Layout
from tendond.model.strain.minima.energy import find_energy
from tendond.model.strain.second_derivatives.curvature import add_curvature
from tendond.model.strain.stepping.scratch import Loads, Scratch
from tendond.model.strain.tendon_stiffness import add_tendon_stiffness

Array = NDArray[np.float64]


@lean
def find_hessian(layout: Layout, loads: Loads, q: Array, rate: float, exact: bool, work: Scratch) -> None:
    """Write the second derivative of the energy at q to `work.hessian`, shape (n, n), after `find_energy` there.

    If not `exact`, without what the intervals between nodes do by themselves, which vanishes as they become short.
    """
    n = len(q)
    out, one, two = work.hessian, work.before, work.after
    for a in range(n):
        for b in range(n):
            out[a, b] = layout.stiffness[a, b] + rate * layout.damping[a, b]
    if exact:
        add_curvature(layout, two, work.force, work.quiet, work.calm, work.bends, out)
    else:
        curvature_of_points(layout, two, work.force, work, out)
    if len(work.taut) > 0:
        add_tendon_stiffness(work.taut, work.paths_after, out)
    for i in range(len(work.taut)):
        if loads.driven[i] and work.taut[i] > 0.0:
            for a in range(n):
                left = layout.tendon_stiffness[i] * work.paths_after.gradient[i, a]
                for b in range(n):
                    out[a, b] += left * work.paths_after.gradient[i, b]
    if rate == 0.0:
        return
    for j in range(len(layout.mass)):
        k, factor = layout.place[j], layout.mass[j] * rate * rate
        last = layout.last[k - 1]
        for a in range(last):
            x, y, z = factor * two.jacobian[j, 0, a], factor * two.jacobian[j, 1, a], factor * two.jacobian[j, 2, a]
            for b in range(last):
                out[a, b] += x * two.jacobian[j, 0, b] + y * two.jacobian[j, 1, b] + z * two.jacobian[j, 2, b]
        for c in range(3):
            if layout.drag[j, c] != 0.0:
                rx, ry, rz = one.rotation[k, c], one.rotation[k, 3 + c], one.rotation[k, 6 + c]
                along = rx * (two.point[j, 0] - one.point[j, 0]) + ry * (two.point[j, 1] - one.point[j, 1])
                along += rz * (two.point[j, 2] - one.point[j, 2])
                slope = 2.0 * layout.drag[j, c] * abs(along) * rate * rate
                for a in range(last):
                    left = rx * two.jacobian[j, 0, a] + ry * two.jacobian[j, 1, a] + rz * two.jacobian[j, 2, a]
                    for b in range(last):
                        out[a, b] += (
                            slope
                            * left
                            * (rx * two.jacobian[j, 0, b] + ry * two.jacobian[j, 1, b] + rz * two.jacobian[j, 2, b])
                        )
    for k in range(1, len(layout.polar)):
        last, factor = layout.last[k - 1], layout.polar[k] * rate * rate
        if factor != 0.0:
            for a in range(last):
                for b in range(last):
                    out[a, b] += factor * one.spin[k, a] * one.spin[k, b]


def stiffness_of(layout: Layout, loads: Loads, q: Array, work: Scratch) -> Array:
    """Return the second derivative of the energy at an equilibrium, shape (n, n); its eigenvalues tell stability."""
    find_energy(layout, loads, q, 0.0, work)
    find_hessian(layout, loads, q, 0.0, True, work)
    return work.hessian.copy()
