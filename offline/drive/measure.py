"""The circle on one chain, in numbers: error of the true tip, and what commands and tensions do at rest."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.pose.reference import PoseReference
from tendond.daemon.control.reference.spatial import SpatialReference
from tendond.daemon.control.setup import CycleSetup
from tendond.drivers.dynamixel.calibration import Calibration, TendonCalibration
from tendond.drivers.simulator.lockstep import STRAIGHT, Watched, watched_loop
from tendond.drivers.wired.rig import without_servos
from tendond.offline.drive.cases import Case, config_of
from tendond.offline.drive.wires import ServoWires
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]

IDLE_CYCLES = 60
REST_SECONDS = 2.0
"""Rest after the circle; the second half of it is measured [s]."""

KEEPS_TAUT = "tension min"
"""Limit that a command may meet at any time: it keeps a tendon taut."""


@dataclass(frozen=True)
class DriveOutcome:
    """Measures of a chain; NaN where it did not come to rest.

    Attributes:
        mode: at the end. reason: of it.
        rms_mm, worst_mm: root mean square and maximum of tip to reference along the circle [mm].
        late_ms: delay of the tip behind the reference that fits best along the circle [ms].
        change_n: largest change of a commanded tension in a cycle, along the circle [N].
        chatter_command_n, chatter_n: root mean square of the second difference at rest, of the commanded and of the
            true tensions [N].
        swing_mm: largest peak to peak of the true tip's coordinates at rest [mm].
        limited: share of the cycles in which a command met a limit of tension or displacement [-].
    """

    mode: str
    reason: str
    rms_mm: float = math.nan
    worst_mm: float = math.nan
    late_ms: float = math.nan
    change_n: float = math.nan
    chatter_command_n: float = math.nan
    chatter_n: float = math.nan
    swing_mm: float = math.nan
    limited: float = math.nan


def run_case(case: Case, period: float = 4.0) -> DriveOutcome:
    """Run the circle of 250 mm in `period` [s] on a chain.

    Raises:
        TendondError: the circle cannot be followed, or the plant has no solution.
    """
    config = config_of(case, period)
    trajectory = CycleSetup.from_config(config).selection.reference
    assert isinstance(trajectory, SpatialReference | PoseReference)
    seconds = config.pretension.duration + trajectory.arrival + REST_SECONDS
    cycles = IDLE_CYCLES + math.ceil(seconds / config.loop.period) + 1
    wires = STRAIGHT
    if case.emulated:
        wires, config = emulated_wires(config).wires, without_servos(config)
    trace = list(watched_loop(config, cycles, {IDLE_CYCLES: ControlAction.ARM}, wires=wires))
    return measure(trace, config.loop.period, trajectory)


def emulated_wires(config: RigConfig) -> ServoWires:
    """Return emulated servos of a configuration with [servo], one for each tendon."""
    section = config.servo
    assert section is not None
    tendons = tuple(
        TendonCalibration(servo=identifier, zero=2048, sign=1, spool_radius=section.spool_radius)
        for identifier in section.servo_ids(len(config.rod.tendon_positions))
    )
    calibration = Calibration(rig=config.rig.name, date="2026-01-01T00:00:00+00:00", tendons=tendons)
    return ServoWires(section, calibration, config.loop.period)


def measure(trace: list[Watched], period: float, trajectory: SpatialReference | PoseReference) -> DriveOutcome:
    """Measure a run to the end of the rest after its trajectory."""
    last = trace[-1].record
    part = [one for one in trace if one.record.mode is Mode.TRACKING]
    time = period * np.arange(len(part))
    tip = np.array([one.truth.position for one in part])
    reference = np.array([one.record.reference.position for one in part])
    wanted = np.array([one.record.command.tension for one in part])
    true = np.array([one.truth.tension for one in part])
    circle = (time >= trajectory.approach_time) & (time <= trajectory.arrival)
    rest = time >= trajectory.arrival + 0.5 * REST_SECONDS
    if not rest.any():
        return DriveOutcome(last.mode.value, last.reason)
    error = 1e3 * np.linalg.norm(tip - reference, axis=1)[circle]
    velocity = np.gradient(reference, period, axis=0)[circle]
    behind = (reference - tip)[circle]
    limits = [any(name != KEEPS_TAUT for name in one.record.limited) for one in part]
    return DriveOutcome(
        rms_mm=_rms(error),
        worst_mm=float(error.max()),
        late_ms=1e3 * float(np.sum(velocity * behind) / np.sum(velocity**2)),
        change_n=float(np.abs(np.diff(wanted[circle], axis=0)).max()),
        chatter_command_n=_rms(np.diff(wanted[rest], 2, axis=0)),
        chatter_n=_rms(np.diff(true[rest], 2, axis=0)),
        swing_mm=1e3 * float(np.ptp(tip[rest], axis=0).max()),
        limited=float(np.mean(limits)),
        mode=last.mode.value,
        reason=last.reason,
    )


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))
