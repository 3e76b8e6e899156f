"""The general rod through a recording, with many sets of parameters at once: the lanes of one batch."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ConvergenceError, ParameterError
from tendond.model.rod.tip_body import ball_inertia
from tendond.model.strain.batch import RodBatch
from tendond.model.strain.describe.configured import robot_from_section
from tendond.model.strain.robot import Body, Robot
from tendond.model.strain.rod import StrainRod
from tendond.model.strain.state import StrainState
from tendond.offline.identification.configured import section_with
from tendond.offline.identification.geometry import base_shift, base_turn
from tendond.offline.identification.recordings.recording import Recording
from tendond.offline.identification.simulation.motion import SimulationError, TipMotion, shown
from tendond.schemas.assumed_rig import TENDON_STIFFNESS

Array = NDArray[np.float64]

MASS_MIN = 1e-9
"""Mass of a tip's body [kg] that stands for none: lanes of a batch have the same bodies."""


def general_motions(
    recording: Recording, sets: Sequence[Mapping[str, float]], starts: Array, ends: Array, step: float
) -> list[TipMotion]:
    """Simulate the motion of a rod for each set of parameters.

    Loads are held over a step, so the ends are those in its middle.

    Args:
        recording: the recording. sets: values of all parameters, by name; N of them.
        starts: displacements in which each rests before [m], shape (N, n).
        ends: displacements of the tendons' ends in the middle of each `step` [s] [m], shape (k, N, n).

    Raises:
        SimulationError: no solution; with the time.
    """
    try:
        robots = [robot_with(recording, values) for values in sets]
        if any(tendon.friction > 0.0 for robot in robots for tendon in robot.tendons):
            pairs = enumerate(zip(robots, sets, strict=True))
            return [
                _rubbing_motion(recording, robot, values, starts[i], ends[:, i], step) for i, (robot, values) in pairs
            ]
        batch = RodBatch(robots, step)
    except ParameterError as error:
        raise SimulationError(f"{recording.path}: {error}") from error
    first = np.empty((len(sets), 3))
    for index, robot in enumerate(robots):
        rod = StrainRod(robot, step)
        rest = _rest(recording, rod, starts[index])
        batch.strain[index] = rest.strain
        first[index] = rod.tip(rest)[0]
    try:
        track = batch.follow(displacement=ends, steps=len(ends))
    except ConvergenceError as error:
        text = "; ".join(shown(values) for values in sets)
        raise SimulationError(f"{recording.path}: the rod has no solution with {text}: {error}") from error
    stiffness = np.array([[tendon.stiffness for tendon in robot.tendons] for robot in robots])
    tensions = np.maximum(0.0, stiffness * (ends - track.displacement))
    return [
        TipMotion(step, 0.0, np.vstack([first[i], track.tip[:, i]]), tensions[:, i].copy()) for i in range(len(sets))
    ]


def _rubbing_motion(
    recording: Recording, robot: Robot, values: Mapping[str, float], start: Array, ends: Array, step: float
) -> TipMotion:
    """Simulate the motion of one rod whose tendons rub, see `general_motions`; ends of shape (k, n)."""
    rod = StrainRod(robot, step)
    state = _rest(recording, rod, start)
    tips, tensions = np.empty((len(ends) + 1, 3)), np.empty(ends.shape)
    tips[0] = rod.tip(state)[0]
    for k, row in enumerate(ends):
        try:
            state = rod.step(state, rod.loads(displacement=row))
        except ConvergenceError as error:
            at = f"no solution at {step * k:.2f} s with {shown(values)}"
            raise SimulationError(f"{recording.path}: the rod has {at}: {error}") from error
        tips[k + 1] = rod.tip(state)[0]
        tensions[k] = tensions_at(rod, state, row)
    return TipMotion(step, 0.0, tips, tensions)


def _rest(recording: Recording, rod: StrainRod, ends: Array) -> StrainState:
    try:
        return rod.solve_static(rod.loads(displacement=ends))
    except ConvergenceError as error:
        raise SimulationError(f"{recording.path}: the rod has no rest to start from: {error}") from error


def tensions_at(rod: StrainRod, state: StrainState, ends: Array) -> Array:
    """Return the tensions at the servos' ends of the tendons, whose ends are at these displacements [m], shape (n,)."""
    found = np.maximum(0.0, rod.layout.tendon_stiffness * (ends - rod.displacements(state)))
    if state.pulls is not None:
        found[np.flatnonzero(rod.layout.friction > 0.0)] = state.pulls[:, 0]
    return np.asarray(found)


def robot_with(recording: Recording, values: Mapping[str, float]) -> Robot:
    """Return the recorded robot with these values, elastic tendons, and the known weight on its tip.

    Poses and gravity are in the frame of the configured base, in which the fitted one is shifted and turned.
    """
    with_body = {**values, "tip_mass": max(values["tip_mass"], MASS_MIN)}
    robot = robot_from_section(section_with(recording.config.rod, with_body))
    tendons = tuple(replace(one, stiffness=one.stiffness or TENDON_STIFFNESS) for one in robot.tendons)
    weight = recording.weight
    hung = (Body(robot.length, weight, ball_inertia(weight)),) if weight > 0.0 else ()
    return replace(
        robot, tendons=tendons, bodies=(*robot.bodies, *hung),
        base=base_turn(values).as_matrix(), origin=base_shift(values),
    )  # fmt: skip
