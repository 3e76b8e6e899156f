"""A run of the loop in numbers: of the true tip, not of the measured one."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.simulator.lockstep import watched_loop
from tendond.model.errors import ConvergenceError
from tendond.offline.estimator.loop.cases import KINDS, Kind, Plant, config_of
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]

IDLE = 0.5
"""Time before arming [s]."""

TRACKING = 8.0
"""Time of tracking that is measured: motion, a circle in space, and rest [s]."""

LAST = 1.0
"""Time at the end by which rest is judged [s]."""

ARMING = 10.0
"""Longest time from arming to tracking [s]."""

SWING = 1e-3
"""Swing of a resting tip that is one [m]: ten standard deviations of a camera's noise."""

NEARLY = 1.05
"""Ratio of two errors from which on one is the larger."""


@dataclass(frozen=True)
class LoopRun:
    """One law on one plant with one observer.

    Attributes:
        plant, law, kind: the run.
        motion: RMS distance of the true tip from the reference, all of tracking but the last second [m].
        rest: its mean in the last second [m]. swing: largest peak to peak of a coordinate of the tip there [m].
        reason: of a fault; empty without one.
    """

    plant: str
    law: str
    kind: Kind
    motion: float
    rest: float
    swing: float
    reason: str = ""


def run_loop(plant: Plant, law: str, kind: Kind, seed: int = 0, tracking: float = TRACKING) -> LoopRun:
    """Run a law on a plant; `tracking`: time of it [s].

    Raises:
        TendondError: the reference cannot be followed.
    """
    config = config_of(plant, law, kind, seed)
    period, nan = config.loop.period, math.nan
    idle, count = round(IDLE / period), round(tracking / period)
    tips, wanted, reason = [], [], ""
    try:
        for one in watched_loop(config, idle + count + round(ARMING / period), {idle: ControlAction.ARM}):
            record = one.record
            if record.mode is Mode.TRACKING:
                tips.append(one.truth.position)
                wanted.append(record.reference.position)
            elif tips or record.mode is Mode.FAULT:
                reason = record.reason
                break
            if len(tips) == count:
                break
    except ConvergenceError as failure:
        reason = f"the plant has no solution: {failure}"
    if len(tips) < count:
        return LoopRun(plant.name, law, kind, nan, nan, nan, reason or "tracking did not begin")
    tip, last = np.array(tips), round(LAST / period)
    error = np.linalg.norm(tip - np.array(wanted), axis=1)
    return LoopRun(
        plant.name, law, kind,
        motion=_rms(error[:-last]), rest=float(np.mean(error[-last:])), swing=float(np.ptp(tip[-last:], axis=0).max()),
        reason=reason,
    )  # fmt: skip


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def pairs(runs: Sequence[LoopRun]) -> list[tuple[LoopRun, LoopRun]]:
    """Return the runs of each law and plant: with fixed gains, and with the filter."""
    by_name = {(one.plant, one.law, one.kind): one for one in runs}
    fixed, kalman = KINDS
    return [
        (one, by_name[one.plant, one.law, kalman])
        for one in runs
        if one.kind == fixed and (one.plant, one.law, kalman) in by_name
    ]


HEADING = (
    "| plant | law | in motion [mm] | with fixed gains | at rest | with fixed gains | swing | with fixed gains"
    " | |\n| --- | --- | --- | --- | --- | --- | --- | --- | --- |"
)


def markdown(runs: Sequence[LoopRun]) -> str:
    """Write the table; lengths in millimetres, the filter's first."""
    return "\n".join([HEADING, *(_row(fixed, known) for fixed, known in pairs(runs))])


def _row(fixed: LoopRun, known: LoopRun) -> str:
    numbers = [f"{1e3 * getattr(one, name):.2f}" for name in ("motion", "rest", "swing") for one in (known, fixed)]
    faults = [f"{one.kind}: {one.reason}" for one in (known, fixed) if one.reason]
    return f"| {' | '.join((known.plant, known.law, *numbers, '; '.join(faults) or verdict(fixed, known)))} |"


def verdict(fixed: LoopRun, known: LoopRun) -> str:
    """Say which of the two follows the motion more closely."""
    if known.motion > NEARLY * fixed.motion:
        return "worse"
    return "better" if fixed.motion > NEARLY * known.motion else "alike"


def missed(runs: Sequence[LoopRun]) -> list[str]:
    """Name the runs in which the filter's loop ends in a fault, or swings, where that with fixed gains does neither."""
    return [
        f"{known.law} on {known.plant}: {known.reason or 'swings'}"
        for fixed, known in pairs(runs)
        if not fixed.reason and (known.reason or known.swing > max(SWING, 2.0 * fixed.swing))
    ]
