"""Stiffness and damping of the strain modes."""

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.discretise.modes import BENDING_X, BENDING_Y, SHEAR_X, SHEAR_Y, STRETCH, TORSION, ModeTable
from tendond.model.strain.discretise.quadrature import pieces
from tendond.model.strain.robot import Robot

Array = NDArray[np.float64]

MODULI = {
    BENDING_X: (("bending_stiffness", 0), ("bending_damping", 0)),
    BENDING_Y: (("bending_stiffness", 1), ("bending_damping", 1)),
    TORSION: (("torsion_stiffness", 0), ("bending_damping", 2)),
    SHEAR_X: (("shear_stiffness", 0), ("shear_damping", 0)),
    SHEAR_Y: (("shear_stiffness", 0), ("shear_damping", 0)),
    STRETCH: (("axial_stiffness", 0), ("axial_damping", 0)),
}
"""Stiffness and damping of each component of the strain: property of the section, and which of its values."""


def find_elasticity(robot: Robot, modes: ModeTable) -> tuple[Array, Array]:
    """Stiffness and damping of the modes, shape (n, n): integrals of Phi' (stiffness, damping)(s) Phi.

    Diagonal in a uniform section; full in each component of one with tables.
    """
    found = np.zeros((2, modes.count, modes.count))
    for number, section in enumerate(robot.sections):
        for component, names in MODULI.items():
            chosen = [mode for mode in range(*modes.ranges[number]) if modes.component[mode] == component]
            for out, (name, index) in zip(found, names, strict=True):
                if name not in section.tables:
                    for mode in chosen:
                        norm = section.length / (2.0 * int(modes.order[mode]) + 1.0)
                        out[mode, mode] = section.at(name, 0.0)[index] * norm
                    continue
                for s, weight in pieces(section, name):
                    values = modes.values(number, s / section.length)[chosen]
                    out[np.ix_(chosen, chosen)] += weight * section.at(name, s)[index] * np.outer(values, values)
    return found[0], found[1]
