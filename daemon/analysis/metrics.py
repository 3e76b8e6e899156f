"""Metrics of a run as in the paper's tables, of the component of the tip that bends: x, or y in plane 'yz'."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.analysis.log import Log, LogError
from tendond.schemas.base import Vector3
from tendond.schemas.messages import Mode

Array = NDArray[np.float64]

SETTLED = 0.05
"""Of the target, either side of it: within this band the tip has settled."""

RISEN = 0.9
"""Of the target: here the rise ends."""

STEADY_SAMPLES = 20
"""At the end of the run, that the steady-state error is the mean of."""


@dataclass(frozen=True)
class Tracking:
    """The first stretch of a log that tracks, one sample per cycle; sample 0 is the tip when tracking began.

    Attributes:
        ticks: of the cycles, shape (k,).
        time: since the start of tracking [s], shape (k,).
        tip: measured [m], shape (k, 3). The command of one cycle shows in the next: sample i follows i commands.
        reference: where the tip should have been [m], shape (k, 3).
        displacement: of the agonist, commanded in the cycle [m], shape (k,).
        target: where the reference ends [m].
        axis: of the component that bends, 0 for x or 1 for y.
    """

    ticks: NDArray[np.int64]
    time: Array
    tip: Array
    reference: Array
    displacement: Array
    target: Vector3
    axis: int


@dataclass(frozen=True)
class Metrics:
    """Of the component x of the tip (or y), k samples; an iteration is the index of a sample.

    Attributes:
        tpl_mm: total path length, the sum of |x[i+1] - x[i]| [mm].
        settling_iterations: first iteration from which on |x - target| stays within 5 % of the target; none if the last
            sample is outside.
        overshoot_percent: how far x goes beyond the target, of the target [%]; 0 if it does not.
        rise_iterations: first iteration with 90 % of the target; none if there is none.
        steady_state_error_mm: |target - mean of the last 20 samples| [mm].
        final_tip_m: last sample [m].
        final_displacement_m: of the agonist, last command [m].
    """

    tpl_mm: float
    settling_iterations: int | None
    overshoot_percent: float
    rise_iterations: int | None
    steady_state_error_mm: float
    final_tip_m: Vector3
    final_displacement_m: float


def tracking(log: Log) -> Tracking:
    """The first stretch of cycles in mode 'tracking'.

    Raises:
        LogError: there is none, or the target's bending component is zero, which the metrics are relative to.
    """
    start = next((i for i, record in enumerate(log.records) if record.mode is Mode.TRACKING), None)
    if start is None:
        raise LogError(f"{log.path}: holds no cycle in mode 'tracking'; arm the controller while it records")
    end = next((i for i, record in enumerate(log.records[start:], start) if record.mode is not Mode.TRACKING), None)
    records = log.records[start:end]
    axis = 0 if log.config.control.plane == "xz" else 1
    target = log.config.reference.target
    if target[axis] == 0.0:
        raise LogError(
            f"{log.path}: reference.target is 0 in {'xy'[axis]}, which the metrics are relative to; use another log"
        )
    tip = [record.measured for record in records]
    if None in tip:
        raise LogError(f"{log.path}: holds tracking cycles without a measured tip; use another log")
    return Tracking(
        ticks=np.array([record.tick for record in records]),
        time=np.array([record.time - records[0].time for record in records]),
        tip=np.array(tip),
        reference=np.array([record.reference.position for record in records]),
        displacement=np.array([record.command.displacement[log.config.control.agonist] for record in records]),
        target=target,
        axis=axis,
    )


def metrics(tip: Array, target: Vector3, displacement: Array, axis: int = 0) -> Metrics:
    """The paper's metrics; see `Metrics` for their definitions.

    Args:
        tip: one sample per iteration [m], shape (k, 3), k >= 1.
        target: [m]; its component `axis` is not zero.
        displacement: of the agonist [m], shape (k,).
        axis: of the component.
    """
    # As a part of the target: a target on the negative side is no different.
    progress = tip[:, axis] / target[axis]
    outside = np.flatnonzero(np.abs(progress - 1.0) > SETTLED)
    risen = np.flatnonzero(progress >= RISEN)
    settling = int(outside[-1]) + 1 if outside.size else 0
    scale_mm = 1000.0 * math.fabs(target[axis])
    x, y, z = (float(value) for value in tip[-1])
    return Metrics(
        tpl_mm=1000.0 * float(np.abs(np.diff(tip[:, axis])).sum()),
        settling_iterations=settling if settling < len(tip) else None,
        overshoot_percent=100.0 * max(0.0, float(progress.max()) - 1.0),
        rise_iterations=int(risen[0]) if risen.size else None,
        steady_state_error_mm=scale_mm * math.fabs(1.0 - float(progress[-STEADY_SAMPLES:].mean())),
        final_tip_m=(x, y, z),
        final_displacement_m=float(displacement[-1]),
    )
