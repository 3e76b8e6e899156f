"""The uniform, straight rod that a robot is compared with: for gains, thresholds and scales, not for its mechanics.

It has the robot's length, and of the straight, unloaded robot: the compliance of the tip under a force across it, the
first natural frequency of bending and its damping ratio, and the tip's motion by each tendon. So it is the robot
itself where that is a straight, uniform rod with tendons parallel to it.
"""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from tendond.model.errors import ParameterError
from tendond.model.rod.parameters import RodParameters
from tendond.model.strain.discretise.modes import section_at
from tendond.model.strain.kinematics import empty_shape, find_shape
from tendond.model.strain.robot import Robot
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.stepping.mass import mass_matrix
from tendond.model.strain.stepping.scratch import scratch_for
from tendond.model.strain.tendons import empty_paths, find_paths
from tendond.schemas.config.rates import CANTILEVER_MASS

Array = NDArray[np.float64]

TIP = 0.999
"""Part of the length beyond which a body counts as one on the tip."""


def equivalent_rod(rod: StrainRod) -> RodParameters:
    """Return the parameters of the uniform rod that stands for a robot.

    Raises:
        ParameterError: a tip that no force across the robot moves, or no tendons.
    """
    robot, length = rod.robot, rod.robot.length
    if not robot.tendons:
        raise ParameterError("rod.tendon: a tendon-driven rod has at least one tendon")
    moved, compliant = _by_strain(rod)
    across = robot.base[:, :2]
    yielding = across.T @ moved @ compliant @ moved.T @ across
    compliance = 0.5 * float(np.trace(yielding))
    if not (math.isfinite(compliance) and compliance > 0.0):
        raise ParameterError("rod: no force across the robot moves its tip")
    stiffness = length**3 / (3.0 * compliance)
    omega, ratio = _first_mode(robot)
    tip_mass = sum(body.mass for body in robot.bodies if body.at >= TIP * length)
    carried = 1.0 / (compliance * omega**2)  # mass on a massless cantilever of this frequency
    mass = max((carried - tip_mass) / CANTILEVER_MASS, 1e-3 * carried) / length
    radius = max(_outer_radius(robot), 1e-6)
    area, second_moment = math.pi * radius**2, math.pi * radius**4 / 4.0
    damping = 2.0 * ratio / omega * stiffness
    given = [tendon.stiffness for tendon in robot.tendons if tendon.stiffness is not None]
    return RodParameters(
        length=length,
        radius=radius,
        youngs_modulus=stiffness / second_moment,
        density=mass / area,
        bending_damping=(damping, damping, damping),
        drag=(0.0, 0.0, 0.0),
        gravity=robot.gravity,
        tendon_positions=_arms(rod, moved @ compliant, 2.0 * stiffness / length**2),
        tendon_stiffness=min(given, default=RodParameters.tendon_stiffness),
        tip_mass=tip_mass,
    )


def arm_stiffness(robot: Robot) -> tuple[float, Array, Array]:
    """Return L / int ds/EI [N m^2], and the share of that integral, shape (k,), up to arc lengths [m], shape (k,)."""
    places = np.linspace(0.0, robot.length, 201)
    inverse = np.empty(len(places))
    for index, s in enumerate(places):
        number, within = section_at(robot, float(s))
        inverse[index] = 1.0 / float(np.mean(robot.sections[number].at("bending_stiffness", within)))
    steps = 0.5 * (inverse[1:] + inverse[:-1]) * np.diff(places)
    up_to = np.concatenate(([0.0], np.cumsum(steps)))
    return robot.length / float(up_to[-1]), up_to / up_to[-1], places


def _by_strain(rod: StrainRod) -> tuple[Array, Array]:
    """Return the tip's motion by the strains, shape (3, n), and the strains by generalised forces, shape (n, n)."""
    return rod.tip_jacobian(rod.rest()), np.asarray(np.linalg.inv(rod.layout.stiffness))


def _arms(rod: StrainRod, moved: Array, factor: float) -> tuple[tuple[float, float], ...]:
    """Return the places of tendons parallel to a uniform rod that would move its tip as far, T r L^2 / 2 EI [m]."""
    paths = empty_paths(rod.layout)
    find_paths(rod.layout, np.zeros(rod.modes), paths)
    across = factor * rod.robot.base.T @ moved @ paths.gradient.T
    return tuple((float(x), float(y)) for x, y in across[:2].T)


def _first_mode(robot: Robot) -> tuple[float, float]:
    """Return circular frequency [rad/s] and damping ratio [-] of the first mode that moves the tip across the robot.

    In the reference shape, without gravity and tendons.
    """
    rod = StrainRod(replace(robot, gravity=(0.0, 0.0, 0.0), tendons=()))
    layout = rod.layout
    shape = empty_shape(layout)
    find_shape(layout, np.zeros(rod.modes), shape)
    mass = mass_matrix(layout, shape, scratch_for(layout))
    squares, vectors = eigh(layout.stiffness, mass)
    moved = rod.tip_jacobian(rod.rest()) @ vectors  # of unit modal mass
    across = np.linalg.norm(robot.base[:, :2].T @ moved, axis=0)
    first = int(np.argmax(across > 0.1 * across.max()))
    omega = math.sqrt(max(float(squares[first]), 1e-12))
    return omega, float(vectors[:, first] @ layout.damping @ vectors[:, first]) / (2.0 * omega)


def _outer_radius(robot: Robot) -> float:
    """Return the mean outer radius of the sections [m]."""
    return float(np.mean([section.fibre(0.5 * section.length) for section in robot.sections]))
