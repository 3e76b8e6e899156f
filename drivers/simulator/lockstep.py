"""Controller and simulated plant in one process, cycle by cycle: faster than real time, and the same every time."""

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.cycle import step
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, initial_state
from tendond.drivers.simulator.plant import Plant
from tendond.drivers.simulator.rods import plant_rod
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import SensorReading, SimulatorTruth, TendonCommand, TendonState, TipPose
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Watched:
    """Record of one cycle, and the plant as that cycle measured it.

    Attributes:
        record: record of the cycle.
        truth: true state of the plant.
        shape: points of the plant's backbone from base to tip [m], shape (points, 3).
    """

    record: CycleRecord
    truth: SimulatorTruth
    shape: Array


@dataclass(frozen=True)
class Wires:
    """Faults between plant and controller.

    Attributes:
        pose: pose of a tick, from the plant's; none where none arrives.
        readings: readings of a tick, by sensor, from the plant's.
        command: command that reaches the plant. report: report of the tendons that reaches the controller.
    """

    pose: Callable[[int, TipPose | None], TipPose | None] = lambda _, pose: pose
    readings: Callable[[int, dict[str, SensorReading]], dict[str, SensorReading]] = lambda _, readings: readings
    command: Callable[[TendonCommand], TendonCommand] = lambda command: command
    report: Callable[[TendonState], TendonState] = lambda report: report


STRAIGHT = Wires()


def closed_loop(config: RigConfig, cycles: int, requests: dict[int, ControlAction]) -> Iterator[CycleRecord]:
    """Run the closed loop and yield each cycle's record.

    Args:
        config: configuration; the plant takes whole steps of about `simulator.period` in each cycle.
        cycles: to run.
        requests: requests of the operator, by tick.

    Raises:
        ConvergenceError: the plant has no solution.
    """
    for watched in watched_loop(config, cycles, requests):
        yield watched.record


def watched_loop(
    config: RigConfig,
    cycles: int,
    requests: Mapping[int, ControlAction | CycleInputs],
    points: int = 0,
    see_state: Callable[[CycleState], None] | None = None,
    *,
    probe: bool = False,
    wires: Wires = STRAIGHT,
) -> Iterator[Watched]:
    """Run the closed loop as `closed_loop` does, and yield the plant beside each record; `points` of its shape.

    A request may be given as the inputs of a recorded cycle, with all that the operator said.

    `see_state` is called with the controller's state before the first cycle and after each. `probe`: the tendons are
    probed at the first arming, if the configuration asks for it; experiments begin without. `wires` lie between plant
    and controller.
    """
    if not probe:
        config = without_probe(config)
    setup = CycleSetup.from_config(config)
    state = initial_state(setup)
    if see_state is not None:
        see_state(state)
    steps = max(1, round(config.loop.period / config.simulator.period))
    plant = Plant(config, plant_rod(config.simulator, config.loop.period / steps))
    for tick in range(cycles):
        pose, tendon_state, truth = plant.observe(stamp_ns=round(tick * config.loop.period * 1e9))
        pose, tendon_state = wires.pose(tick, pose), wires.report(tendon_state)
        asked = requests.get(tick)
        if not isinstance(asked, CycleInputs):
            asked = CycleInputs(request=asked)
        arrived: dict[str, Any] = {"pose": pose, "tendon_state": tendon_state, "unreadable": {}, "missed_ticks": 0}
        arrived["pose_lag"] = None if pose is None else tick * config.loop.period - pose.stamp_ns * 1e-9
        arrived["readings"] = readings = wires.readings(tick, plant.readings)
        arrived["reading_lags"] = {
            name: tick * config.loop.period - one.stamp_ns * 1e-9 for name, one in readings.items()
        }
        inputs = asked.model_copy(update=arrived)
        state, command, record = step(setup, state, inputs)
        if see_state is not None:
            see_state(state)
        yield Watched(record, truth, plant.shape(points) if points else np.zeros((0, 3)))
        plant.step(wires.command(command))
        for _ in range(steps - 1):
            plant.step(None)


def without_probe(config: RigConfig) -> RigConfig:
    """Return the same rig, whose tendons are not probed: for experiments that begin with the first cycle."""
    section = config.commissioning.model_copy(update={"probe": False})
    return config.model_copy(update={"commissioning": section})


def open_loop(config: RigConfig, commands: Iterable[TendonCommand]) -> Iterator[tuple[TendonState, SimulatorTruth]]:
    """Run the plant alone under commands, one each `simulator.period`; yield tendon state and truth after each.

    Raises:
        ConvergenceError: the plant has no solution.
    """
    plant = Plant(config, plant_rod(config.simulator, config.simulator.period))
    for command in commands:
        plant.step(command)
        _, state, truth = plant.observe(stamp_ns=0)
        yield state, truth
