"""Natural modes about an equilibrium: frequencies, damping ratios and shapes."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from tendond.model.strain.kinematics import empty_shape, find_shape
from tendond.model.strain.minima.hessian import stiffness_of
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.stepping.mass import mass_matrix
from tendond.model.strain.stepping.scratch import Loads, scratch_for

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Modes:
    """Natural modes in order of their frequency; k of them.

    Attributes:
        frequency: undamped [Hz], shape (k,); 0 for a mode in which the equilibrium is unstable.
        damping_ratio: [-], shape (k,); nan for a mode without stiffness.
        strain: of the rod's strain modes, of unit modal mass, shape (k, n).
        motion: of the nodes, of unit modal mass, world frame [1/sqrt(kg)], shape (k, K + 1, 3).
    """

    frequency: Array
    damping_ratio: Array
    strain: Array
    motion: Array


def natural_modes(rod: StrainRod, state: StrainState, loads: Loads, count: int | None = None) -> Modes:
    """Return the modes about an equilibrium under these loads, `count` of them or all.

    The damping ratio is that of the mode alone, phi' D phi / (2 omega): exact where damping is proportional to
    stiffness, else right to the square of the coupling between modes. Drag, which goes with the square of the speed,
    does not count.
    """
    layout, work = rod.layout, scratch_for(rod.layout)
    tangent = stiffness_of(layout, loads, state.strain, work)
    shape = empty_shape(layout)
    find_shape(layout, state.strain, shape)
    mass = mass_matrix(layout, shape, work)
    squares, vectors = eigh(tangent, mass)
    squares, shapes = squares[:count], vectors.T[:count]
    omega = np.sqrt(np.maximum(squares, 0.0))
    damping = np.einsum("kn,nm,km->k", shapes, layout.damping, shapes)
    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(omega > 0.0, damping / (2.0 * omega), np.nan)
    spatial = np.einsum("kn,jin->kji", shapes, shape.twist[:, :, : rod.modes])
    motion = np.cross(spatial[:, :, :3], shape.position[None]) + spatial[:, :, 3:]
    return Modes(omega / (2.0 * np.pi), ratio, shapes, motion)
