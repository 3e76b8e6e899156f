"""The log of a run: every cycle, its poses, the rod's shape at a lower rate, changes of mode."""

import time
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from pathlib import Path
from typing import NamedTuple, Self

from tendond.daemon.control.snapshot import StateSnapshot, encode_state
from tendond.daemon.control.state import CycleState
from tendond.daemon.recording import foxglove, scene
from tendond.daemon.recording.channels import (
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
from tendond.daemon.recording.recorder import CALIBRATION, CONFIG, Counts, Message, Recorder
from tendond.daemon.recording.retention import Retention
from tendond.daemon.recording.run_metadata import run_metadata
from tendond.daemon.recording.thinning import Kept, Thinning
from tendond.model.rod.rod import Rod
from tendond.model.rod.state import RodState
from tendond.schemas.base import Vector3
from tendond.schemas.calibration import Calibration
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, SimulatorTruth, Status
from tendond.schemas.record import CycleRecord, LoopTiming

SNAPSHOT_SECONDS = 1.0
"""Time between two states in the log, each of which a replay can start from [s]."""

LOOK_SECONDS = 60.0
"""Time between two checks of the room left for logs [s]."""


class _Cycle(NamedTuple):
    """Data of a cycle beside its record: log time [ns], states before and after it, and the rest.

    Attributes:
        begun: the state before it is in the log already.
    """

    now: int
    before: CycleState | None
    begun: bool
    timing: LoopTiming | None
    rod: RodState
    truth: SimulatorTruth | None


class RunLog:
    """The log of one run of the controller.

    Args:
        path: path of the MCAP file.
        config: configuration of the rig; attached to the file.
        rod: the controller's model, to draw its states.
        now: gives the time of an entry [ns]; left out: wall time.
        notes: for the metadata, beside versions.
        queue: entries that may wait for the disk; left out: the configuration's.
        calibration: calibration of the servos; attached as well.
        retention: retention of the logs in the folder; left out: all are kept.
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
        retention: Retention | None = None,
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
        self._retention = retention
        self._split_bytes = config.log.split_size * 1e6
        if retention is not None:
            self._split_bytes = retention.split_bytes(self._split_bytes)
        self._recorder = Recorder(
            path,
            {**run_metadata(config), **(notes or {})},
            attachments,
            config.log.queue if queue is None else queue,
            split_bytes=self._split_bytes,
            split_seconds=config.log.split_time,
            before_file=self._make_room,
        )
        self._thinning: Thinning[_Cycle] = Thinning(config.loop.period, config.log.idle_period)  # of that thread, too
        self._next_status = 0  # log time from which on one more that says nothing new is written
        self._idle_ns = round(config.log.idle_period * 1e9)
        self._next_look = 0.0
        self._removed: list[str] = []
        self.days_left: float | None = None
        """Until there is no room for logs, or the oldest are removed; none while that is not known."""

        self._before: tuple[CycleState | None, bool] = (None, False)
        self._trail: deque[Vector3] = deque(maxlen=scene.TRAIL_POINTS)  # of the recorder's thread
        self._counts = Counts(0, 0, 0)

    def __enter__(self) -> Self:
        self._recorder.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._recorder.put_all(self._now(), 0, self._held_back)
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
        """Reason that ended the file early; empty without one."""
        return self._recorder.error

    def rest_from(self, moment: float) -> None:
        """Leave the interpreter to the loop from then on, until a later moment is set [s, monotonic clock]."""
        self._recorder.rest_from = moment

    @property
    def summary(self) -> str:
        """Return a summary after the end: entries written and dropped."""
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
        cycle = _Cycle(now, *self._before, timing, state, truth)
        self._recorder.put_all(now, count, self._cycle_entries, record, cycle)

    def _cycle_entries(self, record: CycleRecord, cycle: _Cycle) -> list[Message]:
        """The entries of a cycle, and of those before it that were held back; none while this one is held back."""
        self._look()
        entries = [entry for kept in self._thinning.take(record, cycle) for entry in self._entries(kept)]
        while self._removed:
            line = foxglove.log_line(cycle.now, foxglove.LogLevel.INFO, self._removed.pop())
            entries.append((LOG, line, cycle.now))
        return entries

    def _held_back(self) -> list[Message]:
        """The entries of the cycles that are held back, at the end."""
        return [entry for kept in self._thinning.flush() for entry in self._entries(kept)]

    def _entries(self, kept: Kept[_Cycle]) -> Iterator[Message]:
        """Yield the entries of a cycle."""
        record, (now, before, begun, timing, state, truth) = kept.record, kept.more
        due = before is not None and before.tick % self._snapshot_period == 0 and not begun
        if before is not None and (due or kept.left_out):
            yield (STATE, _snapshot(before, kept.left_out), now)
        yield (CYCLE, record, now)
        if timing is not None:
            yield (TIMING, timing, now)
        pose = record.inputs.pose
        if pose is not None:
            yield (TIP_MEASURED, partial(foxglove.pose_in_frame, now, pose.position, pose.orientation), now)
        model = record.model
        yield (TIP_MODEL, partial(foxglove.pose_in_frame, now, model.position, model.orientation), now)
        if truth is not None:
            yield (TRUTH, truth, now)
        if record.tick % self._shape_period == 0:
            yield (ROD_SHAPE, partial(self._shape, now, record, state), now)
            yield (TRANSFORMS, partial(_frames, now, record), now)

    def _shape(self, now: int, record: CycleRecord, state: RodState) -> foxglove.SceneUpdate:
        points = self._rod.curve(state)
        tendons = scene.tendon_paths(state.rotations, points, self._rod.parameters.tendon_positions)
        self._trail.append(record.measured or record.model.position)
        return scene.rod_shape(now, record.tick, points, record.reference.position, tendons, self._trail)

    def state(self, state: CycleState) -> None:
        """The state before the next cycle; one a second goes into the log, and one after each gap.

        It is turned into text by the recorder. While cycles are held back, it is held back with the next one.
        """
        begun = state.tick % self._snapshot_period == 0 and not self._thinning.asleep
        if begun:
            self._recorder.put(STATE, self._now(), _snapshot(state))
        self._before = (state, begun)

    def status(self, status: Status, *, changed: bool) -> None:
        """A status; a change of mode is a line for people as well."""
        now = self._now()
        self._recorder.put_all(now, 1, self._status_entries, status, changed, now)
        if changed:
            level = foxglove.LogLevel.ERROR if status.mode is Mode.FAULT else foxglove.LogLevel.INFO
            self._recorder.put(LOG, now, foxglove.log_line(now, level, f"{status.mode.value}: {status.reason}"))

    def _status_entries(self, status: Status, changed: bool, now: int) -> list[Message]:
        """The entry of a status; while cycles are held back, one from time to time will do."""
        if not changed and self._thinning.asleep and now < self._next_status:
            return []
        self._next_status = now + self._idle_ns
        return [(STATUS, status, now)]

    def _make_room(self, path: Path) -> None:
        """Remove the logs that are not kept, before a file is begun."""
        if self._retention is None or not self._retention.is_bounded:
            return
        with suppress(OSError):  # a folder that cannot be listed can still be written to
            removed = self._retention.prune(self._split_bytes, keep=path)
            if removed:
                self._removed.append(f"removed {len(removed)} old logs, {removed[0].name} to {removed[-1].name}")

    def _look(self) -> None:
        """See now and then how much room is left."""
        if self._retention is not None and time.monotonic() >= self._next_look:
            self._next_look = time.monotonic() + LOOK_SECONDS
            with suppress(OSError):
                self.days_left = self._retention.room().days

    def warning(self, text: str) -> None:
        """A line for people."""
        now = self._now()
        self._recorder.put(LOG, now, foxglove.log_line(now, foxglove.LogLevel.WARNING, text))

    def crash(self, trace: str) -> None:
        """Log the reason for which the controller ends before its time."""
        now = self._now()
        self._recorder.put(LOG, now, foxglove.log_line(now, foxglove.LogLevel.FATAL, trace))


def _snapshot(state: CycleState, left_out: int = 0) -> StateSnapshot:
    return StateSnapshot(tick=state.tick, left_out=left_out, state=partial(encode_state, state))


def _frames(now: int, record: CycleRecord) -> foxglove.FrameTransforms:
    frames = {"tip_model": (record.model.position, record.model.orientation)}
    if record.inputs.pose is not None:
        frames["tip_measured"] = (record.inputs.pose.position, record.inputs.pose.orientation)
    return foxglove.frame_transforms(now, frames)
