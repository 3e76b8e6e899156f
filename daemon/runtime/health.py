"""Health of the loop: cycles, missed deadlines, cycle times of the last seconds."""

from collections import deque

from tendond.schemas.messages import LoopHealth

WINDOW = 1000
"""Cycles that the median and p99 look back on."""


class Health:
    """Counts, and a bounded window of cycle times."""

    def __init__(self) -> None:
        self.cycles = 0
        self.missed_ticks = 0
        self._work_ms: deque[float] = deque(maxlen=WINDOW)

    def add(self, work_us: float, missed_ticks: int) -> None:
        """One cycle more."""
        self.cycles += 1
        self.missed_ticks += missed_ticks
        self._work_ms.append(work_us / 1000.0)

    def report(self, log_dropped: int, log_error: str, log_days_left: float | None = None) -> LoopHealth:
        """Return the health for the status."""
        work = sorted(self._work_ms) or [0.0]
        return LoopHealth(
            cycles=self.cycles,
            missed_ticks=self.missed_ticks,
            cycle_ms_median=work[len(work) // 2],
            cycle_ms_p99=work[min(len(work) - 1, int(0.99 * len(work)))],
            log_dropped=log_dropped,
            log_error=log_error,
            log_days_left=log_days_left,
        )
