"""The log of a run: every cycle, its poses, the rod's shape at a lower rate, changes of mode."""

import shutil
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Self

from tendond.daemon.control.state import CycleState
from tendond.daemon.recording import foxglove
from tendond.daemon.recording.batch_queue import Message
from tendond.daemon.recording.channels import LOG, STATUS
from tendond.daemon.recording.cycle_entries import Cycle, CycleEntries
from tendond.daemon.recording.recorder import Counts, Recorder
from tendond.daemon.recording.run_files import CALIBRATION, CONFIG
from tendond.daemon.recording.run_metadata import run_metadata
from tendond.daemon.recording.storage.retention import Retention
from tendond.model.rods.interface import ModelRod, ModelState
from tendond.schemas.calibration import Calibration
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode, SimulatorTruth, Status
from tendond.schemas.record import CycleRecord, LoopTiming

LOOK_SECONDS = 60.0
"""Time between two checks of the room left for logs [s]."""

FILES_IN_RESERVE = 2.0
"""Free space, in files of a run, below which old logs are removed while the arm is held, too."""

HELD = (Mode.PROBE, Mode.PRETENSION, Mode.TRACKING, Mode.RELEASING)
"""Modes in which nothing but the writing of the log should occupy the disk."""


class RunLog:
    """The log of one run of the controller.

    Args:
        path: path of the MCAP file.
        config: configuration of the rig; attached to the file.
        rod: the controller's model, to draw its states.
        now: gives the time of an entry [ns]; default: wall time.
        notes: for the metadata, beside versions.
        queue: entries that may wait for the disk; default: the configuration's.
        calibration: calibration of the servos; attached as well.
        retention: retention of the logs in the folder; default: all are kept.
    """

    def __init__(
        self,
        path: Path,
        config: RigConfig,
        rod: ModelRod,
        *,
        now: Callable[[], int] | None = None,
        notes: dict[str, str] | None = None,
        queue: int | None = None,
        calibration: Calibration | None = None,
        retention: Retention | None = None,
    ) -> None:
        self.path = path
        # Wall time once, at the start: what happens to that clock later does not reach the log.
        epoch_ns = time.time_ns() - time.monotonic_ns()
        self._now = now or (lambda: epoch_ns + time.monotonic_ns())
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
        self._entries = CycleEntries(config, rod)
        self._next_status = 0  # log time from which on one more that says nothing new is written
        self._idle_ns = round(config.log.idle_period * 1e9)
        self._next_look = 0.0
        self._arm_is_held = False
        self._current = path
        self._prune_later = False
        self._removed: list[str] = []
        self.days_left: float | None = None
        """Days until there is no space for logs, or the oldest are removed; none while that is not known."""

        self._before: CycleState | None = None
        self._counts = Counts(0, 0, 0)

    def __enter__(self) -> Self:
        self._recorder.open()
        return self

    def __exit__(self, *_: object) -> None:
        self._recorder.put_all(0, self._entries.flush)
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
        self, record: CycleRecord, timing: LoopTiming | None, state: ModelState, truth: SimulatorTruth | None
    ) -> None:
        """A cycle, with the state of the model's rod; no timing where no clock ran.

        The entries are made in the recorder's thread; the loop only counts them.
        """
        cycle = Cycle(self._now(), record, self._before, timing, state, truth)
        self._recorder.put_all(self._entries.count(cycle), self._cycle_entries, cycle)

    def _cycle_entries(self, cycle: Cycle) -> list[Message]:
        """Make the entries of a cycle, and of what was done about the room for logs."""
        self._arm_is_held = cycle.record.mode in HELD
        self._look()
        entries = self._entries.take(cycle)
        while self._removed:
            line = foxglove.log_line(cycle.now, foxglove.LogLevel.INFO, self._removed.pop())
            entries.append((LOG, line, cycle.now))
        return entries

    def state(self, state: CycleState) -> None:
        """The state before the next cycle; one a second goes into the log, and one after each gap.

        It is turned into text by the recorder. While cycles are held back, it is held back with the next one.
        """
        if self._entries.is_snapshot_due(state):
            self._recorder.put_all(1, self._entries.begin, state, self._now())
        self._before = state

    def status(self, status: Status, *, changed: bool) -> None:
        """A status; a change of mode is a line for people as well."""
        now = self._now()
        self._recorder.put_all(1, self._status_entries, status, changed, now)
        if changed:
            level = foxglove.LogLevel.ERROR if status.mode is Mode.FAULT else foxglove.LogLevel.INFO
            self._recorder.put(LOG, now, foxglove.log_line(now, level, f"{status.mode.value}: {status.reason}"))

    def _status_entries(self, status: Status, changed: bool, now: int) -> list[Message]:
        """The entry of a status; while cycles are held back, one from time to time will do."""
        if not changed and self._entries.asleep and now < self._next_status:
            return []
        self._next_status = now + self._idle_ns
        return [(STATUS, status, now)]

    def _make_room(self, path: Path) -> None:
        """Remove the logs that are not kept, before a file is begun; while the arm is held, afterwards.

        A disk that has no room for two more files cannot wait for that.
        """
        self._current = path
        if self._retention is None or not self._retention.is_bounded:
            return
        with suppress(OSError):  # a folder that cannot be listed can still be written to
            free = shutil.disk_usage(path.parent).free
            self._prune_later = self._arm_is_held and free > FILES_IN_RESERVE * self._split_bytes
            if not self._prune_later:
                self._prune(self._retention)

    def _prune(self, retention: Retention) -> None:
        removed = retention.prune(self._split_bytes, keep=self._current)
        if removed:
            self._removed.append(f"removed {len(removed)} old logs, {removed[0].name} to {removed[-1].name}")

    def _look(self) -> None:
        """See now and then how much space is left; remove what could not be removed while the arm was held."""
        if self._retention is None or time.monotonic() < self._next_look:
            return
        self._next_look = time.monotonic() + LOOK_SECONDS
        with suppress(OSError):
            if self._prune_later and not self._arm_is_held:
                self._prune_later = False
                self._prune(self._retention)
            self.days_left = self._retention.disk_space().days

    def warning(self, text: str) -> None:
        """A line for people."""
        now = self._now()
        self._recorder.put(LOG, now, foxglove.log_line(now, foxglove.LogLevel.WARNING, text))

    def crash(self, trace: str) -> None:
        """Log the reason for which the controller ends before its time."""
        now = self._now()
        self._recorder.put(LOG, now, foxglove.log_line(now, foxglove.LogLevel.FATAL, trace))
