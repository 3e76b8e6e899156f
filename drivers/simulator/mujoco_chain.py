"""The chain of a MuJoCo plant from the configured robot: its parameters, none of the rod model's mechanics."""

import math

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.mujoco.chain import Chain, Link, Path, Weight
from tendond.model.errors import ParameterError
from tendond.model.rod.parameters import RodParameters
from tendond.model.strain.discretise.modes import section_at
from tendond.model.strain.robot import Robot, Tendon

Array = NDArray[np.float64]

LINKS = 30
"""Ball joints: the tip of the paper's robot, bent by 20 N, is then within 0.1 % of its length of an elastica's
(`pytest tests/plants/test_mujoco_robot.py`)."""

SAMPLES = 8
"""Places within the length of rod for which a joint stands, at which tables of a section are read."""

ALIKE = 1e-6
"""Relative difference of two stiffnesses that counts as none."""


def chain_of(robot: Robot, step: float = 1e-3) -> Chain:
    """Return the chain of a robot.

    Args:
        robot: by `model.strain.describe.configured`, in its base's frame. step: of the integrator [s].

    Raises:
        ParameterError: what a chain of ball joints cannot be: bent without load, another stiffness about x than about
            y, tendons that wind round the rod, or that rub.
    """
    _check(robot)
    h = robot.length / LINKS
    links = tuple(_link(robot, h * (index + (np.arange(SAMPLES) + 0.5) / SAMPLES)) for index in range(LINKS))
    tendons = tuple(
        Path(one.at, one.end, one.stiffness or RodParameters.tendon_stiffness, one.holes) for one in robot.tendons
    )
    weights = tuple(Weight(one.at, one.mass, one.inertia, one.offset) for one in robot.bodies)
    return Chain(robot.length, links, tendons, weights, robot.gravity, step)


def _link(robot: Robot, places: Array) -> Link:
    """Return the joint that stands for a stretch of rod: compliance and damping as of all of it in series."""
    compliance, lag, mass, inertia = 0.0, 0.0, 0.0, 0.0
    drag = np.zeros(3)
    for s in places.tolist():
        number, at = section_at(robot, s)
        section = robot.sections[number]
        stiffness = float(section.at("bending_stiffness", at)[0])
        compliance += 1.0 / stiffness / len(places)
        lag += float(section.at("bending_damping", at)[0]) / stiffness / len(places)
        mass += float(section.at("mass_per_length", at)[0]) / len(places)
        inertia += 0.5 * float(section.at("polar_inertia", at)[0]) / len(places)
        drag += section.at("drag", at) / len(places)
    x, y, z = drag.tolist()
    return Link(1.0 / compliance, lag / compliance, mass, inertia, (x, y, z))


def _check(robot: Robot) -> None:
    """Refuse what a chain cannot be.

    Raises:
        ParameterError: see `chain_of`.
    """
    remedy = "; set simulator.solver = 'general', or leave --plant out"
    for index, section in enumerate(robot.sections):
        for s in np.linspace(0.0, section.length, 5).tolist():
            about_x, about_y = section.at("bending_stiffness", s).tolist()
            if abs(about_x - about_y) > ALIKE * about_x:
                raise ParameterError(
                    f"rod.section[{index}].bending_stiffness: another about x than about y, but a joint of the MuJoCo"
                    f" plant has one{remedy}"
                )
            if np.any(section.at("curvature", s)):
                raise ParameterError(
                    f"rod.section[{index}].precurvature: the MuJoCo plant is straight without load{remedy}"
                )
    for index, tendon in enumerate(robot.tendons):
        if tendon.friction > 0.0:
            raise ParameterError(f"rod.tendon_friction: tendon {index}: the MuJoCo plant has none{remedy}")
        if _winds(tendon):
            raise ParameterError(
                f"rod.tendon[{index}]: winds round the rod and twists it, but the MuJoCo plant's torsion is as stiff as"
                f" its bending{remedy}"
            )


def _winds(tendon: Tendon) -> bool:
    """Return whether a tendon leaves the plane through the rod's axis in which it begins."""
    places = [tendon.at(s) for s in np.linspace(0.0, tendon.end, 9).tolist()]
    (x, y), reach = places[0], max(math.hypot(*one) for one in places)
    return any(abs(x * b - y * a) > 1e-9 * reach**2 for a, b in places)
