"""The paper's robot in MuJoCo, from numbers of its own: of tendond there is only its MuJoCo plant, without the rod."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.mujoco.chain import Chain, Link, Path
from tendond.drivers.mujoco.robot import MujocoRobot

Array = NDArray[np.float64]

STEEL = 7850.0
"""Density of the sphere that stands for a tip mass [kg/m^3]."""


@dataclass(frozen=True)
class Robot:
    """Parameters of the robot; the defaults are the paper's.

    Attributes:
        length: length of the backbone [m]. radius: radius of its section [m].
        youngs_modulus: [Pa]. density: [kg/m^3]. damping: Bbt of bending [N m^2 s]. drag: C of each axis [kg/m^2].
        gravity: world frame, the straight robot along +z [m/s^2].
        tendons: (x, y) of each in the section [m]. stiffness: stiffness of a tendon on a winch [N/m].
        tip_mass: mass of the body on the tip [kg].
        links: number of ball joints. step: time step of the integrator [s].
    """

    length: float = 0.5
    radius: float = 1e-3
    youngs_modulus: float = 190e9
    density: float = 17189.0
    damping: float = 0.008
    drag: float = 0.1
    gravity: tuple[float, float, float] = (-9.81, 0.0, 0.0)
    tendons: tuple[tuple[float, float], ...] = ((0.02, 0.0), (0.0, 0.02), (-0.02, 0.0), (0.0, -0.02))
    stiffness: float = 2e4
    tip_mass: float = 0.0
    links: int = 30
    step: float = 1e-3

    @property
    def bending_stiffness(self) -> float:
        """EI [N m^2]."""
        return self.youngs_modulus * math.pi * self.radius**4 / 4.0

    @property
    def mass_per_length(self) -> float:
        """Mass per length [kg/m]."""
        return self.density * math.pi * self.radius**2

    @property
    def chain(self) -> Chain:
        """The robot as a chain."""
        section = self.density * math.pi * self.radius**4 / 4.0
        drag = (self.drag,) * 3
        link = Link(self.bending_stiffness, self.damping, self.mass_per_length, section, drag)

        def path(place: tuple[float, float]) -> Path:
            return Path(lambda _: place, self.length, self.stiffness)

        tendons = tuple(path(place) for place in self.tendons)
        return Chain(self.length, (link,) * self.links, tendons, (), self.gravity, self.step)


def sphere(mass: float) -> tuple[float, float]:
    """Radius [m] and moment of inertia [kg m^2] of a steel sphere of `mass` [kg]."""
    radius = (3.0 * mass / (4.0 * math.pi * STEEL)) ** (1.0 / 3.0)
    return radius, 0.4 * mass * radius**2


class PaperRobot(MujocoRobot):
    """Robot, at rest under gravity and slack until it is driven.

    Args:
        robot: parameters.
    """

    def __init__(self, robot: Robot) -> None:
        super().__init__(robot.chain)
        self.robot = robot
        self.hang(robot.tip_mass)
        self.settle()

    def hang(self, mass: float) -> None:
        """Set the mass of the sphere on the tip to `mass` [kg]."""
        self.attach(mass, sphere(mass)[1])
