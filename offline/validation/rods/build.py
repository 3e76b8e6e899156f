"""A robot of the general rod from a design and the values of its parameters."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from tendond.model.strain import Body, Robot, Section, Tendon
from tendond.offline.validation.rods.design import Design

Array = NDArray[np.float64]

GRAVITY = 9.81
BENDING_MODES = 3
"""Polynomials of a section's bending about each axis; torsion and stretch have one."""


@dataclass(frozen=True)
class Measured:
    """A robot, with what a camera and servos add to it.

    Attributes:
        robot: in the camera's frame, EI = 1 N m^2. marker: from the tip, the tip's frame [m], shape (3,).
        zero: command at which each tendon's path has the length of the straight robot [m], shape (m,).
        spool: displacement of a tendon per command [-].
        backlash: half of the play between a command and its tendon [m]. friction: of tendons on their guides [-].
        yielding: share of the backbone's stiffness that yields [-], at yield_curvature [1/m].
    """

    robot: Robot
    marker: Array
    zero: Array
    spool: float
    backlash: float
    friction: float
    yielding: float
    yield_curvature: float


def build(design: Design, values: dict[str, float]) -> Measured:
    """Return the robot of these values."""
    sections = range(len(design.lengths))
    lengths = [values[f"length_{i}"] for i in sections]
    length, radius = sum(lengths), values["radius"]
    weight = np.array([values[f"weight_{axis}"] for axis in "xyz"])
    size = float(np.linalg.norm(weight))
    gravity = GRAVITY * weight / size if size > 0.0 else np.zeros(3)
    parts = []
    for i in sections:
        bending = values.get(f"stiffening_{i}", 1.0)
        parts.append(
            Section(
                lengths[i],
                (bending, bending * values["anisotropy"]),
                bending * values["torsion"],
                bending * values["axial_stiffness"] / radius**2,
                max(size, 1e-9) / (GRAVITY * length**3),
                1e-9,
                curvature=(values[f"curvature_x_{i}"], values[f"curvature_y_{i}"], 0.0),
                bending_modes=BENDING_MODES,
                torsion_modes=1,
                stretch_modes=1,
            )
        )
    ends = np.cumsum(lengths)
    tendons = []
    for i, (end, angle) in enumerate(zip(design.ends, design.angles, strict=True)):
        own, turn = radius * values[f"radius_{i}"], angle + values[f"angle_{i}"]
        stiffness = values["tendon_stiffness"] * values.get(f"tendon_stiffness_{end}", 1.0) / (radius**2 * length)
        tendons.append(Tendon(float(ends[end]), (own * math.cos(turn), own * math.sin(turn)), stiffness))
    bodies = (Body(length, max(values["tip_weight"], 1e-9) * size / (GRAVITY * length**2)),) if size > 0.0 else ()
    turned = Rotation.from_rotvec([values[f"base_turn_{axis}"] for axis in "xyz"]).as_matrix()
    robot = Robot(
        tuple(parts), tuple(tendons), bodies, (float(gravity[0]), float(gravity[1]), float(gravity[2])),
        design.up @ turned, (values["base_x"], values["base_y"], values["base_z"]),
    )  # fmt: skip
    count = range(len(design.ends))
    return Measured(
        robot,
        np.array([values[f"marker_{axis}"] for axis in "xyz"]),
        np.array([values[f"zero_{i}"] for i in count]),
        values["spool"],
        values["backlash"],
        values["friction"],
        1.0 - 1.0 / (1.0 + values["yielding"]),
        values["yield_curvature"],
    )
