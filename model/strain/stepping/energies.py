"""Energy of a state: of its motion, of the backbone's strain, and of its weight."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.describe.base import Base
from tendond.model.strain.kinematics import Shape
from tendond.model.strain.layout import Layout

Array = NDArray[np.float64]


def energies(layout: Layout, shape: Shape, q: Array, w: Array, base: Base | None) -> tuple[float, float, float]:
    """Return kinetic, elastic and gravity's energy [J] of a shape at strains q and rates w, shape (n,), on its base."""
    velocity, turned = shape.jacobian[:, :, : len(q)] @ w, shape.spin[:, : len(q)] @ w
    if base is not None:
        velocity, turned = velocity + base.velocity_at(shape.point), turned + shape.rotation[:, 2::3] @ base.spin
    kinetic = 0.5 * float(layout.mass @ np.sum(velocity**2, axis=1) + layout.polar @ turned**2)
    return kinetic, 0.5 * float(q @ layout.stiffness @ q), -float(layout.mass @ (shape.point @ layout.gravity))
