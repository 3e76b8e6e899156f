"""The figures by which a robot is known: mass, modes at rest, sag, bend and strain at the largest tension."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError
from tendond.model.strain.analysis.frames import bend, strength
from tendond.model.strain.analysis.modes import natural_modes
from tendond.model.strain.describe.section import Section
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState

Array = NDArray[np.float64]

LOAD_STEPS = 6
"""Equilibria from no tension to the largest one, each the start of the next."""


@dataclass(frozen=True)
class Pull:
    """One tendon at the largest tension, the others without.

    Attributes:
        tendon: index. bend: of the whole backbone [rad]. displacement: shortening of the tendon's path [m].
        strain: largest of any fibre [-]. tip: [m], shape (3,).
        tension: at which the equilibrium was found [N]; below the largest one where it was lost before that.
    """

    tendon: int
    bend: float
    displacement: float
    strain: float
    tip: Array
    tension: float


@dataclass(frozen=True)
class Summary:
    """Figures of a robot.

    Attributes:
        length: [m]. mass: backbone and bodies [kg]. bodies: mass of the bodies alone [kg].
        sag: distance of the resting tip from that of the reference shape, under gravity alone [m].
        rest_strain: largest strain of that rest [-].
        stability: smallest eigenvalue of the tangent stiffness at rest, relative to the unloaded robot's [-].
        frequency: of the first modes at rest, undamped [Hz]. damping_ratio: theirs [-].
        time_constant: in which the slowest of them decays by e at last [s]; inf without damping.
        pulls: one per tendon.
    """

    length: float
    mass: float
    bodies: float
    sag: float
    rest_strain: float
    stability: float
    frequency: Array
    damping_ratio: Array
    time_constant: float
    pulls: tuple[Pull, ...]


def summarise(rod: StrainRod, tension_max: float, modes: int = 6) -> Summary:
    """Return a robot's figures.

    Args:
        rod: the robot.
        tension_max: largest tension of a tendon [N].
        modes: number of modes at rest.

    Raises:
        ConvergenceError: the robot has no equilibrium under gravity.
    """
    robot, free = rod.robot, rod.loads()
    rest = rod.solve_static(free)
    found = natural_modes(rod, rest, free, modes)
    spread = sum(section.length * _mean(section, "mass_per_length") for section in robot.sections)
    bodies = sum(body.mass for body in robot.bodies)
    return Summary(
        length=robot.length,
        mass=spread + bodies,
        bodies=bodies,
        sag=float(np.linalg.norm(rod.tip(rest)[0] - rod.tip(rod.rest())[0])),
        rest_strain=float(strength(rod, rest).strain.max()),
        stability=rod.stability(rest, free),
        frequency=found.frequency,
        damping_ratio=found.damping_ratio,
        time_constant=max(_decay(f, z) for f, z in zip(found.frequency, found.damping_ratio, strict=True)),
        pulls=tuple(_pull(rod, rest, index, tension_max) for index in range(len(robot.tendons))),
    )


def _mean(section: Section, name: str) -> float:
    return float(np.mean([section.at(name, s)[0] for s in np.linspace(0.0, section.length, 201)]))


def _decay(frequency: float, ratio: float) -> float:
    """Time constant of the slower root of x'' + 2 ratio omega x' + omega^2 x = 0 [s]."""
    omega = 2.0 * math.pi * frequency
    if omega == 0.0 or not ratio > 0.0:
        return math.inf
    slow = ratio if ratio < 1.0 else 1.0 / (ratio + math.sqrt(ratio * ratio - 1.0))
    return 1.0 / (slow * omega)


def _pull(rod: StrainRod, rest: StrainState, tendon: int, tension_max: float) -> Pull:
    state, reached = rest, 0.0
    for part in np.linspace(0.0, 1.0, LOAD_STEPS + 1)[1:]:
        tension = np.zeros(len(rod.robot.tendons))
        tension[tendon] = part * tension_max
        try:
            state = rod.solve_static(rod.loads(tension), state)
        except ConvergenceError:
            break
        reached = float(part * tension_max)
    return Pull(
        tendon,
        bend(rod, state),
        float(rod.displacements(state)[tendon]),
        float(strength(rod, state).strain.max()),
        rod.tip(state)[0],
        reached,
    )
