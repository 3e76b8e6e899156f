"""What is uncertain, and by how much: standard deviations of measurements, loads, tensions and stiffness."""

import math
from dataclasses import dataclass

from tendond.model.rod.parameters import RodParameters

LOAD_RATE = 0.02
"""Drift of a load in a second, in EI/L^2."""

LOAD_JUMP = 1.0
"""Load that comes at once, in EI/L^2: it bends a straight rod's tip by a third of its length."""

LOAD_START = 0.5
"""Load that may be there from the start, likewise."""

TENSION_FLOOR = 0.002
"""Error of a tension beside its share, in EI/(L r): a camera's noise seen at the tip."""

UNMODELLED = 4e-5
"""Error of a place on the robot by modes that have no errors of their own, in the robot's length."""

SHAPE_START = 0.02
"""Bend of each strain mode that a model's rest may be wrong by [rad]."""


@dataclass(frozen=True)
class Noise:
    """Standard deviations of what the model does not know.

    Attributes:
        position: of the measured tip, each coordinate [m]. orientation: of it about each axis [rad]; 0: it is not used.
        load_start: of the force on the tip at the start [N]; load_rate: of its drift [N/s^0.5]; load_jump: of one that
            comes at once [N].
        tension_share: of a tendon's tension, relative to it [-]; tension_floor: of a tension beside that [N];
            tension_time: over which these errors change [s].
        stiffness: of the robot's stiffness, relative to it [-]; 0: it is known.
        tip_mass: of the mass on the tip [kg]; 0: it is known.
        unmodelled: of any place on the robot, by what the errors do not tell [m].
        shape: of the strains at the start, bend of a mode over the robot's length [rad].
    """

    position: float
    orientation: float
    load_start: float
    load_rate: float
    load_jump: float
    tension_share: float
    tension_floor: float
    tension_time: float
    stiffness: float
    unmodelled: float = 0.0
    shape: float = SHAPE_START
    tip_mass: float = 0.0


def noise_of(
    rod: RodParameters,
    position: float,
    orientation: float,
    tension_share: float,
    tension_time: float,
    stiffness: float,
    tip_mass: float = 0.0,
) -> Noise:
    """Return the noise of a robot; arguments as the attributes of `Noise`, loads and tensions by its stiffness."""
    load = rod.bending_stiffness / rod.length**2
    arm = max(math.hypot(*place) for place in rod.tendon_positions)
    return Noise(
        position=position,
        orientation=orientation,
        load_start=LOAD_START * load,
        load_rate=LOAD_RATE * load,
        load_jump=LOAD_JUMP * load,
        tension_share=tension_share,
        tension_floor=TENSION_FLOOR * rod.bending_stiffness / (rod.length * arm),
        tension_time=tension_time,
        stiffness=stiffness,
        unmodelled=UNMODELLED * rod.length,
        tip_mass=tip_mass,
    )
