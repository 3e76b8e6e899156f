"""A whole log in memory."""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.recording import foxglove
from tendond.daemon.recording.channels import CYCLE, LOG, ROD_SHAPE, TIMING, TRUTH, Channel
from tendond.daemon.recording.entities import ROD, TICK, SceneUpdate
from tendond.offline.files import as_text
from tendond.offline.logs.container import LogError as LogError
from tendond.offline.logs.run import decode, no_cycles, open_run
from tendond.schemas.calibration import Calibration
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import SimulatorTruth
from tendond.schemas.record import CycleRecord, LoopTiming

Array = NDArray[np.float64]


SAME_INPUTS = "same inputs"
"""Metadata 'replay' of a log that was computed from the inputs of another one, 'replay_of'."""

READ: tuple[Channel[Any], ...] = (CYCLE, TIMING, ROD_SHAPE, TRUTH, LOG)


@dataclass(frozen=True)
class LogFile:
    """A run's log, in the order in which it was written.

    Attributes:
        path: the file.
        complete: true if it was finished; if not, its end is missing (writer killed, disk full).
        config: the rig's configuration.
        metadata: revision and versions, by name.
        calibration: the servos' calibration; none without servos.
        records: the cycles' records; not empty.
        timings: the loop's timings.
        shapes: tick and points of the rod, base to tip [m], shape (points, 3).
        tendons: points of each tendon, for each shape [m], shapes (k, 3).
        truth: the simulator's truth; empty on a rig.
        log_lines: the log lines for people.
        truth_ticks: the cycle beside which each of `truth` was written.
    """

    path: Path
    complete: bool
    config: RigConfig
    metadata: dict[str, str]
    calibration: Calibration | None
    records: list[CycleRecord]
    timings: list[LoopTiming]
    shapes: list[tuple[int, Array]]
    tendons: list[list[Array]]
    truth: list[SimulatorTruth]
    log_lines: list[foxglove.Log]
    truth_ticks: list[int] = field(default_factory=list)

    @property
    def name(self) -> str:
        """Name of the file, as text that can be printed in any locale."""
        return as_text(self.path.name)

    @property
    def stem(self) -> str:
        """Name of the file without its ending, as text that can be printed in any locale."""
        return as_text(self.path.stem)

    @property
    def cut(self) -> str:
        """What could be read of an unfinished log, in a sentence; empty of a finished one."""
        if self.complete:
            return ""
        last = self.records[-1]
        return (
            f"{self.name}: its end is missing (writer killed, disk full, or still running); "
            f"read {len(self.records)} cycles, up to {last.time:.2f} s"
        )

    @property
    def same_inputs_as(self) -> str:
        """Name of the log whose inputs this one was computed from; empty where the plant followed its commands."""
        return self.metadata.get("replay_of", "") if self.metadata.get("replay") == SAME_INPUTS else ""


def load(path: Path) -> LogFile:
    """Read a whole log, with all parts of a split one.

    Raises:
        LogError: no file, not an MCAP file, not a log of tendond, damaged, without configuration or cycles, or of
            another version.
    """
    models = {channel.topic: channel.model for channel in READ}
    messages: dict[str, list[Any]] = {channel.topic: [] for channel in READ}
    truth_ticks: list[int] = []
    run = open_run(path)
    for topic, message in run.messages(tuple(models)):
        messages[topic].append(decode(path, topic, models[topic], message.data))
        if topic == TRUTH.topic:
            cycles = messages[CYCLE.topic]
            truth_ticks.append(cycles[-1].tick if cycles else 0)
    if not messages[CYCLE.topic]:
        raise no_cycles(path, complete=run.complete)
    scenes = [scene_points(path, update) for update in messages[ROD_SHAPE.topic]]
    return LogFile(
        path=path,
        complete=run.complete,
        config=run.config,
        metadata=run.metadata,
        calibration=run.calibration,
        records=messages[CYCLE.topic],
        timings=messages[TIMING.topic],
        shapes=[(tick, lines[0]) for tick, lines in scenes],
        tendons=[lines[1:] for _, lines in scenes],
        truth=messages[TRUTH.topic],
        log_lines=messages[LOG.topic],
        truth_ticks=truth_ticks,
    )


def scene_points(path: Path, update: SceneUpdate) -> tuple[int, list[Array]]:
    """Return the tick of a scene, and the points of the rod and of each tendon, base to tip [m], shapes (k, 3).

    Raises:
        LogError: it has no rod.
    """
    for entity in update.entities:
        ticks = [pair.value for pair in entity.metadata if pair.key == TICK]
        if entity.id == ROD and ticks and entity.lines:
            lines = [np.array([(point.x, point.y, point.z) for point in line.points]) for line in entity.lines]
            return int(ticks[0]), lines
    raise LogError(f"{path}: a scene on '{ROD_SHAPE.topic}' has no rod; read it with the version that wrote it")
