"""Kinds of runs of the study of contacts."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from tendond.model.strain.describe.configured import described
from tendond.model.strain.robot import Robot

Array = NDArray[np.float64]

PERIOD = 0.01
"""Period of the cycle, and of the camera [s]."""

POSITION, ORIENTATION = 1e-4, 2e-3
"""Noise of a camera: of a position [m], and of an orientation from markers 5 cm apart [rad]."""

ROBOTS = {"paper": "paper", "two sections": "rao-2021"}
"""Robots by name, and their presets."""

FORCES = (0.1, 0.2, 0.5)
"""Forces on the paper's robot [N]; on another one, as large for its stiffness over its length squared."""

PAPER_UNIT = 0.6
"""EI/L^2 of the paper's robot [N]."""

MARKERS = (0.3, 0.6, 0.8)
"""Arc lengths of markers on the body, as parts of the length."""

BEND = 0.8
"""Largest bend that a tendon's tension makes by itself [rad]."""

START, KNOT = 0.5, 0.8
"""Time at rest at the beginning, and between the random tensions that the arm moves through [s]."""


@dataclass(frozen=True)
class Case:
    """A kind of run.

    Attributes:
        robot: key of `ROBOTS`. moving: its tensions change all the time; else they rest after a second.
        force: of the contact on the paper's robot [N], see `FORCES`; 0: there is none.
        markers: whether markers on the body are measured as well. friction: range of it, unknown to the model.
        stiffness: largest relative difference of E.
    """

    robot: str
    moving: bool
    force: float
    markers: bool = False
    friction: tuple[float, float] = (0.05, 0.3)
    stiffness: float = 0.1

    @property
    def name(self) -> str:
        """It in words."""
        parts = [
            self.robot,
            "moving" if self.moving else "resting",
            f"{self.force:g} N" if self.force else "no contact",
        ]
        parts += ["3 markers"] if self.markers else []
        parts += ["without friction"] if self.friction[1] == 0.0 else []
        return ", ".join(parts)


def contact_cases() -> list[Case]:
    """Return the cases with a contact."""
    cases = [Case("paper", moving, force) for moving in (False, True) for force in FORCES]
    cases += [Case("paper", moving, 0.2, markers=True) for moving in (False, True)]
    cases += [Case("paper", moving, 0.2, friction=(0.0, 0.0)) for moving in (False, True)]
    return cases + [Case("two sections", moving, force) for moving in (False, True) for force in (0.2, 0.5)]


def free_cases() -> list[Case]:
    """Return those without."""
    return [Case(robot, moving, 0.0) for robot in ROBOTS for moving in (False, True)]


def robot_of(case: Case) -> Robot:
    """Return the robot as the model has it: its tendons do not rub."""
    robot, _ = described(ROBOTS[case.robot])
    return replace(robot, tendons=tuple(replace(one, friction=0.0) for one in robot.tendons))


def tensions_of(case: Case, rng: np.random.Generator, cycles: int, largest: Array) -> Array:
    """Return the tensions of each cycle [N], shape (cycles, m), up to `largest`, shape (m,)."""
    time = np.arange(cycles) * PERIOD
    if not case.moving:
        goal = rng.uniform(0.0, 1.0, len(largest)) * largest
        return np.asarray(goal * np.clip(time - START, 0.0, 1.0)[:, None])
    knots = max(3, int(cycles * PERIOD / KNOT) + 2)
    at = np.linspace(START, cycles * PERIOD, knots)
    pulls = [
        PchipInterpolator(at, np.r_[0.0, rng.uniform(0.0, most, knots - 1)])(np.maximum(time, START))
        for most in largest
    ]
    return np.asarray(np.stack(pulls, axis=1))
