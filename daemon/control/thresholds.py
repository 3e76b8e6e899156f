"""Fault thresholds of a configuration in cycles: the only place where seconds become counts."""

from dataclasses import dataclass

from tendond.daemon.control.commissioning.averages import REST_BLOCK_SECONDS
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.safety.section import SafetySection


@dataclass(frozen=True)
class Thresholds:
    """Fault thresholds of [faults] and [limits] in cycles, 1 or more.

    Attributes:
        pose_timeout: age of the newest pose.
        rejected_time: duration of rejected poses only.
        teleport_time, frozen_time, slack_time: time from the first report to the newest one, all of them bad.
        solver_timeout: duration without a solution of the model.
        overrun_time: missed deadlines in a row.
        tendon_timeout: age of the newest tendon state.
        mismatch_time: duration of a model far from the measurement.
        limit_time: duration at a limit.
        source_time: time for which another publisher is remembered.
        unsafe_time: duration without a command that keeps the constraints.
        rest_block: length of the blocks whose mean is a rest.
    """

    pose_timeout: int
    rejected_time: int
    teleport_time: int
    solver_timeout: int
    overrun_time: int
    tendon_timeout: int
    frozen_time: int
    mismatch_time: int
    slack_time: int
    limit_time: int
    source_time: int
    rest_block: int
    unsafe_time: int

    @staticmethod
    def from_config(config: RigConfig) -> "Thresholds":
        """Convert the seconds of a configuration at its loop's period."""
        faults, period = config.faults, config.loop.period
        return Thresholds(
            pose_timeout=cycles(faults.pose_timeout, period),
            rejected_time=cycles(faults.rejected_time, period),
            teleport_time=cycles(faults.teleport_time, period),
            solver_timeout=cycles(faults.solver_timeout, period),
            overrun_time=cycles(faults.overrun_time, period),
            tendon_timeout=cycles(faults.tendon_timeout, period),
            frozen_time=cycles(faults.frozen_time, period),
            mismatch_time=cycles(faults.mismatch_time, period),
            slack_time=cycles(faults.slack_time, period),
            limit_time=cycles(config.limits.limit_time, period),
            source_time=cycles(faults.source_time, period),
            rest_block=cycles(REST_BLOCK_SECONDS, period),
            unsafe_time=cycles((config.safety or SafetySection()).hold_time, period),
        )


def cycles(seconds: float, period: float) -> int:
    """Number of whole cycles nearest to a time [s], at least one."""
    return max(1, round(seconds / period))
