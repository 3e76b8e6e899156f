"""A recording for a fit: commands, reports of the servos and poses on one time axis."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.errors import DaemonError
from tendond.offline.files import as_text
from tendond.schemas.config.rig import RigConfig

Array = NDArray[np.float64]


Drive = Literal["measured", "command"]
"""Source of the tendons' ends: the servos' reports, or the commands."""


class DataError(DaemonError):
    """Error of a log that a fit cannot use."""


@dataclass(frozen=True)
class Recording:
    """A log from a rest of the arm on, as used by a fit; times in seconds from that rest's beginning.

    Attributes:
        path: the log.
        config: the rig's configuration when it was recorded.
        weight: known mass fixed to the tip, beside the rod's own tip_mass [kg]; zero: none.
        period: period of the cycle [s].
        times: times of the cycles' commands, shape (k,).
        armed: true where the command is armed, shape (k,).
        command: commanded displacements [m], shape (k, n).
        report_times: times of the servos' reports, shape (r,). reported: displacements [m], shape (r, n).
        pulled: tensions [N], shape (r, n).
        pose_times: times at which the poses arrived, corrected for their jitter, shape (m,).
        position: measured tip positions [m], shape (m, 3).
        noise: noise of a coordinate [m], from differences of the poses.
        cycles: cycles in the whole log. hidden: those without a usable pose.
        limited: fraction of the armed cycles with the command at a limit. missed: missed deadlines.
        fault: reason of the fault in which the log ended; empty without one.
        ideal_drive: true if a simulator imposed the tensions, without servos between.
    """

    path: Path
    config: RigConfig
    weight: float
    period: float
    times: Array
    armed: NDArray[np.bool_]
    command: Array
    report_times: Array
    reported: Array
    pulled: Array
    pose_times: Array
    position: Array
    noise: float
    cycles: int
    hidden: int
    limited: float
    missed: int
    fault: str
    ideal_drive: bool = False

    @property
    def name(self) -> str:
        """Name of the file, for tables."""
        return as_text(self.path.name)

    @property
    def duration(self) -> float:
        """Time from the first rest to the end [s]."""
        return float(self.times[-1])

    @property
    def has_reports(self) -> bool:
        """True if the servos reported in nearly all armed cycles."""
        return len(self.report_times) > 0.9 * len(self.times)
