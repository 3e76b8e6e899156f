"""Health of the loop: cycles, missed deadlines, cycle times of the last seconds."""

from collections import deque

from tendond.schemas.health import LoopHealth

WINDOW = 1000
"""Cycles that the median and p99 look back on."""


class Health:
    """Counts, and a bounded window of cycle times."""

    def __init__(self) -> None:
        self.cycles = 0
        self.missed_ticks = 0
        self.phase_locked = False
        self._work_ms: deque[float] = deque(maxlen=WINDOW)
        self._pose_wait_ms: deque[float] = deque(maxlen=WINDOW)

    def add(self, work_us: float, missed_ticks: int, pose_wait: float | None, *, phase_locked: bool) -> None:
        """Count one cycle more.

        Args:
            work_us: from its start to the command [us]. missed_ticks: before it.
            pose_wait: time for which its pose has waited [s], if known. phase_locked: it is in phase with the poses.
        """
        if pose_wait is not None:
            self._pose_wait_ms.append(pose_wait * 1e3)
        self.phase_locked = phase_locked
        self.cycles += 1
        self.missed_ticks += missed_ticks
        self._work_ms.append(work_us / 1000.0)

    def report(self, log_dropped: int, log_error: str, log_days_left: float | None = None) -> LoopHealth:
        """Return the health for the status."""
        work, waits = sorted(self._work_ms) or [0.0], sorted(self._pose_wait_ms)
        return LoopHealth(
            cycles=self.cycles,
            missed_ticks=self.missed_ticks,
            cycle_ms_median=work[len(work) // 2],
            cycle_ms_p99=work[min(len(work) - 1, int(0.99 * len(work)))],
            log_dropped=log_dropped,
            log_error=log_error,
            log_days_left=log_days_left,
            phase_locked=self.phase_locked,
            pose_wait_ms_median=waits[len(waits) // 2] if waits else None,
        )
