"""The error that the feedback removes: each plant under the tendon commands of the nominal run, all plants at once.

The nominal run is the closed loop of a law on the robot of its model. Its commands, played back on the other plants
without feedback, leave the tip where stiffness, loads and friction put it. Plants are general rods here; what a point
has beside its plant, such as delay and noise of the poses, plays no part.
"""

import os
from collections.abc import Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.simulator.lockstep import watched_loop
from tendond.drivers.simulator.rods import plant_robot
from tendond.drivers.simulator.servo import SimulatedActuators
from tendond.model.errors import ConvergenceError
from tendond.model.strain.batch import RodBatch
from tendond.model.strain.robot import Body, Robot
from tendond.model.strain.rod import StrainRod
from tendond.offline.logs.metrics import Tracking, metrics, tracking_of
from tendond.offline.robustness.evaluate import PointResult
from tendond.offline.robustness.plants import IDLE_CYCLES, impact_tick, rig_of
from tendond.offline.robustness.points import FEEDBACKS, Point
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, TendonCommand
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]

LANES = 500
"""Maximum number of plants at once, for their commands and tips to take 20 MB of memory."""


@dataclass(frozen=True)
class NominalRun:
    """A run of the closed loop on the robot of its model.

    Attributes:
        config: of controller and plant. commands: of its cycles. track: its cycles of tracking.
    """

    config: RigConfig
    commands: tuple[TendonCommand, ...]
    track: Tracking


def nominal_run(base: RigConfig, law: str, drive: str) -> NominalRun | None:
    """Run the nominal point of a law and a drive up to where impacts begin; none if it does not track to its end."""
    config = by_general_rod(rig_of(base, Point("", law, FEEDBACKS[0], drive=drive), 0))
    try:
        trace = list(watched_loop(config, impact_tick(base), {IDLE_CYCLES: ControlAction.ARM}))
    except ConvergenceError:
        return None
    records = [watched.record for watched in trace]
    if records[-1].mode is not Mode.TRACKING:
        return None
    return NominalRun(config, tuple(one.command for one in records), tracking_of(records, config, f"law {law}"))


def by_general_rod(config: RigConfig) -> RigConfig:
    """Return the same rig, whose simulated plant is the general rod."""
    return config.model_copy(update={"simulator": config.simulator.model_copy(update={"solver": "general"})})


def with_open_loop(
    base: RigConfig, rows: Iterable[tuple[Point, PointResult]], threads: int | None = None
) -> list[tuple[Point, PointResult]]:
    """Return points and results with `open_loop_error_mm`; none where the law's nominal run does not track.

    Args:
        base: the controller's configuration.
        rows: points and results.
        threads: that step the plants; default: one a core.

    Raises:
        ConvergenceError: a plant has no rest.
    """
    rows = list(rows)
    plants: dict[tuple[str, str], dict[Point, Point]] = {}
    for point, _ in rows:
        plants.setdefault((point.law, point.drive), {}).setdefault(plant_of(point), point)
    found: dict[Point, float] = {}
    for (law, drive), own in plants.items():
        run = nominal_run(base, law, drive)
        if run is None:
            continue
        for first in range(0, len(own), LANES):
            part = list(own)[first : first + LANES]
            tips = open_loop_tips(run, [rig_of(base, plant, 0) for plant in part], threads)
            for plant, tip in zip(part, np.moveaxis(tips, 1, 0), strict=True):
                found[plant] = metrics(run.track, tip=tip[run.track.ticks]).steady_state_error_mm
    return [(point, replace(result, open_loop_error_mm=found.get(plant_of(point)))) for point, result in rows]


def plant_of(point: Point) -> Point:
    """Return the point with its plant and drive alone: points with the same one have the same error in open loop."""
    return Point(
        "", point.law, FEEDBACKS[0], lag_factor=point.lag_factor, youngs_factor=point.youngs_factor,
        bending_damping_factor=point.bending_damping_factor, drag_factor=point.drag_factor, load_g=point.load_g,
        drive=point.drive,
    )  # fmt: skip


def open_loop_tips(run: NominalRun, configs: Sequence[RigConfig], threads: int | None = None) -> Array:
    """Return the tips of plants under the commands of a run, at the beginning of each cycle [m], shape (k, N, 3).

    Args:
        run: the nominal one.
        configs: of the plants, N of them, driven as it is: simulated robot, mass on its tip, servos.
        threads: that step them; default: one a core.

    Raises:
        ConvergenceError: a plant has no rest.
    """
    robots, period = [_loaded(config) for config in configs], run.config.loop.period
    workers = min(threads or len(os.sched_getaffinity(0)), len(robots))
    batch = RodBatch(robots, period, workers)
    tips = np.empty((len(run.commands), len(robots), 3))
    for lane, robot in enumerate(robots):
        rod = StrainRod(robot, period)
        rest = rod.solve_static(rod.loads())
        batch.set_state(lane, rest)
        tips[0, lane] = rod.tip(rest)[0]
    armed = next(index for index, command in enumerate(run.commands) if command.armed)
    before, after = run.commands[:armed], run.commands[armed:-1]
    slack = np.zeros(len(robots[0].tendons))
    with ThreadPoolExecutor(workers) as pool:
        idle = batch.follow(tension=slack, steps=len(before), run=pool.map)
        tips[1 : armed + 1] = idle.tip
        if run.config.simulator.drive == "displacement":
            stood = idle.displacement[-1]
            ends = [_ends(config, place, after) for config, place in zip(configs, stood, strict=True)]
            track = batch.follow(displacement=np.stack(ends, axis=1), steps=len(after), run=pool.map)
        else:
            pulls = [_tensions(config, after) for config in configs]
            track = batch.follow(tension=np.stack(pulls, axis=1), steps=len(after), run=pool.map)
    tips[armed + 1 :] = track.tip
    return tips


def _loaded(config: RigConfig) -> Robot:
    """Return the simulated robot with the mass on its tip, as `drivers.simulator.plant.Plant` has it."""
    robot = plant_robot(config.simulator)
    return replace(robot, bodies=(*robot.bodies, Body(robot.length, config.simulator.weight.mass)))


def _tensions(config: RigConfig, commands: Sequence[TendonCommand]) -> Array:
    """Return the tensions by which servos pull under commands of tension [N], shape (k, m), as steps hold them."""
    servos = SimulatedActuators(config.simulator.servo, config.loop.period, np.zeros(len(commands[0].tension)))
    largest = config.limits.tension_max
    moved = [servos.follow_tension(np.clip(one.tension, 0.0, largest)) for one in commands]
    return _held(config, moved)


def _ends(config: RigConfig, stood: Array, commands: Sequence[TendonCommand]) -> Array:
    """Return the displacements of tendons' ends that stood at `stood`, under commands of displacement [m], (k, m)."""
    servos = SimulatedActuators(config.simulator.servo, config.loop.period, stood)
    limits, no_load = config.limits, np.zeros_like(stood)
    goals = (np.clip(one.displacement, limits.displacement_min, limits.displacement_max) for one in commands)
    return _held(config, [servos.follow_displacement(goal, no_load) for goal in goals])


def _held(config: RigConfig, moved: Sequence[tuple[Array, Array]]) -> Array:
    """Return what steps hold of means and ends, shape (k, m): the end's of tendons that rub, see `GeneralPlantRod`."""
    rubbing = [tendon.friction > 0.0 for tendon in plant_robot(config.simulator).tendons]
    return np.array([np.where(rubbing, end, mean) for mean, end in moved])
