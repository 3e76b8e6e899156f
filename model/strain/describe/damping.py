"""Damping from damping ratios of the first bending mode, by the eigenproblem of the robot itself.

Kelvin and Voigt's law with one time constant, Bbt = tau Kbt, damps each mode of bending with the ratio tau omega / 2:
the free robot M z'' + tau K z' + K z = 0 decouples in its modes (L. Meirovitch, Fundamentals of Vibrations, 2001,
section 7.15). So tau = 2 zeta / omega_1, omega_1 the first natural frequency of the clamped robot with its bodies, in
its reference shape, without gravity and tendons. Where sections have different ratios, each section's tau is its own,
and the mode's ratio is the mean of theirs, weighted with the elastic energy that the mode has in each.
"""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from tendond.model.strain.describe.profile import Factor, PropertyProfile, combined
from tendond.model.strain.describe.section import Section
from tendond.model.strain.discretise.modes import BENDING_X, BENDING_Y
from tendond.model.strain.kinematics import empty_shape, find_shape
from tendond.model.strain.layout import lay_out
from tendond.model.strain.robot import Robot
from tendond.model.strain.stepping.mass import mass_matrix
from tendond.model.strain.stepping.scratch import scratch_for

Array = NDArray[np.float64]


def with_damping_ratios(robot: Robot, ratios: Sequence[float | None]) -> Robot:
    """Return the robot with the damping of bending and torsion that gives its first bending mode these ratios.

    Args:
        robot: whose other damping stays.
        ratios: of each section [-]; none: the section keeps its own damping.
    """
    if all(ratio is None for ratio in ratios):
        return robot
    omega = 2.0 * math.pi * first_bending_frequency(robot)
    sections = [
        section if ratio is None else _damped(section, 2.0 * ratio / omega)
        for section, ratio in zip(robot.sections, ratios, strict=True)
    ]
    return replace(robot, sections=tuple(sections))


def first_bending_frequency(robot: Robot) -> float:
    """Return the first natural frequency of bending in the reference shape, without gravity and tendons [Hz]."""
    layout = lay_out(replace(robot, gravity=(0.0, 0.0, 0.0), tendons=()))
    shape = empty_shape(layout)
    find_shape(layout, np.zeros(len(layout.component)), shape)
    squares, vectors = eigh(layout.stiffness, mass_matrix(layout, shape, scratch_for(layout)))
    frequencies = np.sqrt(np.maximum(squares, 0.0)) / (2.0 * math.pi)
    bending = np.isin(layout.component, (BENDING_X, BENDING_Y))
    for frequency, mode in zip(frequencies, vectors.T, strict=True):
        energy = mode @ layout.stiffness @ mode
        if mode[bending] @ layout.stiffness[np.ix_(bending, bending)] @ mode[bending] > 0.5 * energy:
            return float(frequency)
    return float(frequencies[0])


def _damped(section: Section, time: float) -> Section:
    """The section with Bbt = time (EI, EI, GJ)."""
    parts = [section.profile(name) for name in ("bending_stiffness", "torsion_stiffness")]
    damping: PropertyProfile = combined(Factor(time), *parts)
    if damping.knots:
        return replace(section, tables={**section.tables, "bending_damping": damping})
    tables = {name: table for name, table in section.tables.items() if name != "bending_damping"}
    x, y, z = damping(0.0)
    return replace(section, bending_damping=(x, y, z), tables=tables)
