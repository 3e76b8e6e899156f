"""A log of the closed loop in lockstep, with nominal times instead of a clock's."""

from collections.abc import Mapping
from pathlib import Path

from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState
from tendond.daemon.errors import DaemonError
from tendond.daemon.recording.run_log import RunLog
from tendond.drivers.simulator.lockstep import watched_loop
from tendond.schemas.calibration import Calibration
from tendond.schemas.record import CycleInputs, CycleRecord
from tendond.schemas.requests import ControlAction

EPOCH_NS = 1_000_000_000
"""Log time of the first cycle [ns]."""

QUEUE = 10_000_000
"""Entries that may be queued for the disk: there is no real time here, and no entry may be lost."""


class OfflineRunLog(RunLog):
    """A run_log whose time, `at` [ns], is set by hand.

    Args:
        path: the MCAP file.
        setup: the controller's setup.
        notes: metadata to add beside versions.
        calibration: the servos' calibration, if the log has one.
    """

    def __init__(
        self,
        path: Path,
        setup: CycleSetup,
        notes: dict[str, str] | None = None,
        calibration: Calibration | None = None,
    ) -> None:
        self.at = EPOCH_NS
        super().__init__(
            path, setup.config, setup.rod, now=lambda: self.at, notes=notes, queue=QUEUE, calibration=calibration
        )

    def check(self) -> None:
        """Check the log once it is closed.

        Raises:
            DaemonError: not all is in the file.
        """
        if self.error or self.dropped:
            raise DaemonError(f"the new log is not whole: {self.summary}")


def record_lockstep(
    setup: CycleSetup,
    cycles: int,
    requests: Mapping[int, ControlAction | CycleInputs],
    path: Path,
    notes: dict[str, str] | None = None,
    calibration: Calibration | None = None,
) -> list[CycleRecord]:
    """Run controller and simulated plant into a new log; see `watched_loop`.

    Raises:
        ConvergenceError: the plant has no solution. DaemonError: the log is not whole.
    """
    period_ns = round(setup.config.loop.period * 1e9)
    newest: list[CycleState] = []
    records = []
    with OfflineRunLog(path, setup, notes, calibration) as run_log:
        for watched in watched_loop(setup.config, cycles, requests, see_state=newest.append, probe=True):
            if len(newest) == 2:  # the one before the first cycle, too
                run_log.state(newest[0])
            state = newest[-1]
            newest[:] = [state]
            run_log.at = EPOCH_NS + watched.record.tick * period_ns
            run_log.cycle(watched.record, None, state.rod, watched.truth)
            run_log.state(state)
            records.append(watched.record)
    run_log.check()
    return records
