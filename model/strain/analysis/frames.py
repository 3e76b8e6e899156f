"""Strain, frames, tendon paths and stress at any place of a robot."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from tendond.model.errors import ParameterError
from tendond.model.strain.discretise.modes import ModeTable, section_at
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.model.strain.twists import COMMUTATOR

Array = NDArray[np.float64]


def places(rod: StrainRod, s: Sequence[float] | Array | None, count: int = 101) -> Array:
    """Return arc lengths to look at [m]: those given, or `count` evenly spaced ones.

    Raises:
        ParameterError: one does not lie on the backbone.
    """
    length = rod.robot.length
    found = np.linspace(0.0, length, count) if s is None else np.atleast_1d(np.asarray(s, dtype=np.float64))
    if found.size == 0 or not np.all((found >= 0.0) & (found <= length * (1.0 + 1e-9))):
        raise ParameterError(f"s: all must lie on the backbone, in 0..{length:g} m")
    return found


def strain_at(rod: StrainRod, state: StrainState, s: Sequence[float] | Array | None = None) -> Array:
    """Return the strain (u [1/m], v [-]) at arc lengths, body frame, shape (len(s), 6)."""
    table = ModeTable(rod.robot)
    return np.array([_strain(rod, table, state.strain, float(one)) for one in places(rod, s)])


def frames(rod: StrainRod, state: StrainState, s: Sequence[float] | Array | None = None) -> Array:
    """Return homogeneous transforms, body to world, at arc lengths [m], shape (len(s), 4, 4).

    From the node before each place by one step of the kernels' own scheme: at the nodes they are the kernels' to
    rounding.
    """
    shape, table = rod.shape(state), ModeTable(rod.robot)
    nodes = np.concatenate(([0.0], np.cumsum(rod.layout.step)))
    found = np.zeros((len(at := places(rod, s)), 4, 4))
    for out, one in zip(found, at, strict=True):
        k = min(int(np.searchsorted(nodes, one, side="right")) - 1, len(nodes) - 2)
        out[:3, :3], out[:3, 3], out[3, 3] = shape.rotation[k].reshape(3, 3), shape.position[k], 1.0
        step = one - nodes[k]
        if step > 0.0:
            offset = step / (2.0 * math.sqrt(3.0))
            middle = nodes[k] + 0.5 * step
            first, last = (_hat(_strain(rod, table, state.strain, middle + part)) for part in (-offset, offset))
            magnus = 0.5 * step * (first + last) + COMMUTATOR * step**2 * (first @ last - last @ first)
            out[:] = out @ expm(magnus)
    return found


def tendon_path(rod: StrainRod, state: StrainState, tendon: int, s: Sequence[float] | Array | None = None) -> Array:
    """Return points of a tendon, world frame [m], at arc lengths of the backbone up to where it ends, shape (k, 3)."""
    one = rod.robot.tendons[tendon]
    at = places(rod, s)
    at = np.append(at[at < one.end], one.end) if s is None else at[at <= one.end * (1.0 + 1e-9)]
    poses = frames(rod, state, at)
    local = np.array([(*one.at(float(here)), 0.0, 1.0) for here in at])
    return np.asarray(np.einsum("kij,kj->ki", poses, local)[:, :3])


@dataclass(frozen=True)
class Strength:
    """Strain and stress of the backbone's outermost fibres, k places.

    Attributes:
        s: arc lengths [m], shape (k,).
        strain: largest over the cross-section, of stretch and bending together [-], shape (k,).
        stress: axial, of that fibre [Pa]; shear: of twist [Pa]; mises: both by von Mises [Pa]; shape (k,) each.
    """

    s: Array
    strain: Array
    stress: Array
    shear: Array
    mises: Array


def strength(rod: StrainRod, state: StrainState, s: Sequence[float] | Array | None = None) -> Strength:
    """Return strain and stress along the backbone, of round wires and tubes of one material.

    With the outer radius r: strain |v3 - 1| + r |u - u*|, stress E times that. E is EA / A with the area of the tube
    that has r, EI and EA: 4 EI / EA = r^2 + r_i^2. Precurvature counts as free of stress.
    """
    at = places(rod, s)
    rows = []
    for one, here in zip(at, strain_at(rod, state, at), strict=True):
        number, within = section_at(rod.robot, float(one))
        section = rod.robot.sections[number]
        u = here[:3] - section.at("curvature", within)
        radius = section.fibre(within)
        EI, EA = float(np.max(section.at("bending_stiffness", within))), float(section.at("axial_stiffness", within)[0])
        GJ = float(section.at("torsion_stiffness", within)[0])
        area = 2.0 * math.pi * max(radius**2 - 2.0 * EI / EA, 1e-6 * radius**2)
        polar = area * 2.0 * EI / EA
        strain = abs(here[5] - 1.0) + radius * math.hypot(u[0], u[1])
        stress, shear = EA / area * strain, GJ / polar * radius * abs(u[2])
        rows.append((strain, stress, shear, math.sqrt(stress**2 + 3.0 * shear**2)))
    columns = np.array(rows).T
    return Strength(at, columns[0], columns[1], columns[2], columns[3])


def bend(rod: StrainRod, state: StrainState) -> float:
    """Return by how much the backbone bends in all, the integral of the curvature [rad]."""
    at = places(rod, None, 201)
    u = strain_at(rod, state, at)[:, :2]
    return float(np.trapezoid(np.hypot(u[:, 0], u[:, 1]), at))


def _strain(rod: StrainRod, table: ModeTable, q: Array, s: float) -> Array:
    number, within = section_at(rod.robot, s)
    section = rod.robot.sections[number]
    found = np.array((*section.at("curvature", within), 0.0, 0.0, 1.0))
    np.add.at(found, rod.layout.component, table.values(number, within / section.length) * q)
    return found


def _hat(strain: Array) -> Array:
    """Twist as a 4 x 4 matrix."""
    x, y, z, a, b, c = strain
    return np.array([[0.0, -z, y, a], [z, 0.0, -x, b], [-y, x, 0.0, c], [0.0, 0.0, 0.0, 0.0]])
