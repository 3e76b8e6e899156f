"""What goes into the log, and when: every cycle, its poses, the rod's shape at a lower rate, changes of mode."""

import platform
import subprocess
import time
from collections import deque
from collections.abc import Callable
from functools import partial
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Self

import llvmlite.binding

from tendond import __version__
from tendond.daemon import foxglove
from tendond.daemon.channels import (
    CYCLE,
    LOG,
    ROD_SHAPE,
    STATE,
    STATUS,
    TIMING,
    TIP_MEASURED,
    TIP_MODEL,
    TRANSFORMS,
    TRUTH,
)
from tendond.daemon.recorder import CALIBRATION, CONFIG, Counts, Message, Recorder
from tendond.daemon.snapshot import StateSnapshot, encode_state
from tendond.daemon.state import CycleState
from tendond.model.rod import Rod
from tendond.model.rod_state import RodState
from tendond.schemas.base import Vector3
from tendond.schemas.calibration import Calibration
from tendond.schemas.config import RigConfig
from tendond.schemas.messages import Mode, SimulatorTruth, Status
from tendond.schemas.record import CycleRecord, LoopTiming

LIBRARIES = ("numpy", "numba", "llvmlite", "pydantic", "eclipse-zenoh", "mcap")

SNAPSHOT_SECONDS = 1.0
"""Between two states in the log, each of which a replay can start from."""


class Journal:
    """The log of one run of the controller.

    Args:
        path: of the MCAP file.
        config: of the rig; attached to the file.
        rod: of the controller's model, to draw its states.
        now: gives the time of an entry [ns]; left out: wall time.
        notes: for the metadata, beside versions.
        queue: entries that may wait for the disk; left out: the configuration's.
        calibration: of the servos; attached as well.
    """

    def __init__(
        self,
        path: Path,
        config: RigConfig,
        rod: Rod,
        *,
        now: Callable[[], int] | None = None,
        notes: dict[str, str] | None = None,
        queue: int | None = None,
        calibration: Calibration | None = None,
    ) -> None:
        self.path = path
        self._rod = rod
        self._shape_period = config.log.shape_period
        # Wall time once, at the start: what happens to that clock later does not reach the log.
        epoch_ns = time.time_ns() - time.monotonic_ns()
        self._now = now or (lambda: epoch_ns + time.monotonic_ns())
        self._snapshot_period = max(1, round(SNAPSHOT_SECONDS / config.loop.period))
        attachments = {CONFIG: config.model_dump_json()}
        if calibration is not None:
            attachments[CALIBRATION] = calibration.model_dump_json()
        self._recorder = Recorder(
            path,
            {**run_metadata(config), **(notes or {})},
            attachments,
            config.log.queue if queue is None else queue,
            split_bytes=config.log.split_size * 1e6,
            split_seconds=config.log.split_time,
        )
        self._trail: deque[Vector3] = deque(maxlen=foxglove.TRAIL_POINTS)  # of the recorder's thread
        self._counts = Counts(0, 0, 0)

    def __enter__(self) -> Self:
        self._recorder.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._counts = self._recorder.close()

    @property
    def dropped(self) -> int:
        """Entries that are not in the file and will not be."""
        return self._recorder.dropped

    @property
    def waiting(self) -> int:
        """Entries that wait for the disk."""
        return self._recorder.waiting

    @property
    def error(self) -> str:
        """What ended the file before its time; empty while all is well."""
        return self._recorder.error

    def rest_from(self, moment: float) -> None:
        """Leave the interpreter to the loop from then on, until a later moment is set [s, monotonic clock]."""
        self._recorder.rest_from = moment

    @property
    def summary(self) -> str:
        """After the end: what was written, and what was not."""
        put, written, dropped = self._counts
        lost = f", {dropped} dropped" if dropped else ""
        return f"{written} of {put} log entries in {self.path}{lost}" + (f" ({self.error})" if self.error else "")

    def cycle(
        self, record: CycleRecord, timing: LoopTiming | None, state: RodState, truth: SimulatorTruth | None
    ) -> None:
        """A cycle, with the state of the model's rod; no timing where no clock ran.

        The entries are made in the recorder's thread; the loop only counts them.
        """
        now = self._now()
        count = 2 + (timing is not None) + (record.inputs.pose is not None) + (truth is not None)
        if record.tick % self._shape_period == 0:
            count += 2
        self._recorder.put_all(now, count, self._entries, now, record, timing, state, truth)

    def _entries(
        self, now: int, record: CycleRecord, timing: LoopTiming | None, state: RodState, truth: SimulatorTruth | None
    ) -> list[Message]:
        """Of a cycle."""
        entries: list[Message] = [(CYCLE, record)]
        if timing is not None:
            entries.append((TIMING, timing))
        pose = record.inputs.pose
        if pose is not None:
            entries.append((TIP_MEASURED, partial(foxglove.pose_in_frame, now, pose.position, pose.orientation)))
        model = record.model
        entries.append((TIP_MODEL, partial(foxglove.pose_in_frame, now, model.position, model.orientation)))
        if truth is not None:
            entries.append((TRUTH, truth))
        if record.tick % self._shape_period == 0:
            entries.append((ROD_SHAPE, partial(self._shape, now, record, state)))
            entries.append((TRANSFORMS, partial(_frames, now, record)))
        return entries

    def _shape(self, now: int, record: CycleRecord, state: RodState) -> foxglove.SceneUpdate:
        points = self._rod.curve(state)
        tendons = foxglove.tendon_paths(state.rotations, points, self._rod.parameters.tendon_positions)
        self._trail.append(record.measured or record.model.position)
        return foxglove.rod_shape(now, record.tick, points, record.reference.position, tendons, self._trail)

    def state(self, state: CycleState) -> None:
        """The state before the next cycle; one a second goes into the log. It is turned into text by the recorder."""
        if state.tick % self._snapshot_period == 0:
            self._recorder.put(STATE, self._now(), StateSnapshot(tick=state.tick, state=partial(encode_state, state)))

    def status(self, status: Status, *, changed: bool) -> None:
        """A status; a change of mode is a line for people as well."""
        now = self._now()
        self._recorder.put(STATUS, now, status)
        if changed:
            level = foxglove.LogLevel.ERROR if status.mode is Mode.FAULT else foxglove.LogLevel.INFO
            self._recorder.put(LOG, now, foxglove.log_line(now, level, f"{status.mode.value}: {status.reason}"))

    def warning(self, text: str) -> None:
        """A line for people."""
        now = self._now()
        self._recorder.put(LOG, now, foxglove.log_line(now, foxglove.LogLevel.WARNING, text))

    def crash(self, trace: str) -> None:
        """Why the controller ends before its time."""
        now = self._now()
        self._recorder.put(LOG, now, foxglove.log_line(now, foxglove.LogLevel.FATAL, trace))


def _frames(now: int, record: CycleRecord) -> foxglove.FrameTransforms:
    frames = {"tip_model": (record.model.position, record.model.orientation)}
    if record.inputs.pose is not None:
        frames["tip_measured"] = (record.inputs.pose.position, record.inputs.pose.orientation)
    return foxglove.frame_transforms(now, frames)


def run_metadata(config: RigConfig) -> dict[str, str]:
    """Whose log this is, and of which code: revision and versions."""
    versions = {}
    for name in LIBRARIES:
        try:
            versions[name] = version(name)
        except PackageNotFoundError:
            versions[name] = "unknown"
    return {
        "rig": config.rig.name,
        "tendond": __version__,
        "revision": _revision(),
        "python": platform.python_version(),
        "machine": f"{platform.system()} {platform.machine()}",
        "cpu": llvmlite.binding.get_host_cpu_name(),  # compiled code, and so the last bit, is the processor's own
        **versions,
    }


def _revision() -> str:
    """Of the working copy that runs, if it is one."""
    try:
        result = subprocess.run(
            ["git", "describe", "--always", "--dirty", "--abbrev=12"],
            cwd=Path(__file__).resolve().parent,
            capture_output=True,
            text=True,
            timeout=2.0,
            check=True,
        )
    except (OSError, subprocess.SubprocessError):
        return "unknown"
    return result.stdout.strip()
