"""The mass matrix of a shape."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.numerics.compile import lean
from tendond.model.numerics.products import add_products, padded
from tendond.model.strain.kinematics import Shape
from tendond.model.strain.layout import Layout
from tendond.model.strain.stepping.scratch import Scratch

Array = NDArray[np.float64]


@lean
def find_mass(layout: Layout, shape: Shape, work: Scratch) -> None:
    """Write the mass matrix of a shape to `work.mass`, by sections: fast, with the scratch arrays."""
    width = padded(len(layout.component))
    left, right, total, jacobian, spin = work.left, work.right, work.mass, shape.jacobian, shape.spin
    left[:], right[:], total[:] = 0.0, 0.0, 0.0
    row = first = j = 0
    for k in range(1, len(layout.polar)):
        last, inertia = layout.last[k - 1], layout.polar[k]
        if inertia != 0.0:
            for a in range(last):
                left[row * width + a] = inertia * spin[k, a]
                right[row * width + a] = spin[k, a]
            row += 1
        while j < len(layout.mass) and layout.place[j] == k:
            m = layout.mass[j]
            for i in range(3):
                for a in range(last):
                    left[row * width + a] = m * jacobian[j, i, a]
                    right[row * width + a] = jacobian[j, i, a]
                row += 1
            j += 1
        if k + 1 == len(layout.polar) or layout.last[k] != last:
            add_products(left, right, width, (first, row), (0, last), (0, last), total)
            first = row


def mass_matrix(layout: Layout, shape: Shape, work: Scratch) -> Array:
    """Return the mass matrix of a shape, shape (n, n)."""
    n = len(layout.component)
    find_mass(layout, shape, work)
    return work.mass.reshape(-1, padded.py_func(n))[:n, :n].copy()
