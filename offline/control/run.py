"""One case, run in lockstep, in numbers: of the simulated tip, not of the measured one."""

import math
import time
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.cycle import respond
from tendond.daemon.control.pose.pose import Pose, miss, rotation_to
from tendond.daemon.control.pose.reference import PoseReference
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState
from tendond.drivers.simulator.lockstep import Watched, watched_loop, without_probe
from tendond.model.rods.general import GeneralRod, GeneralState
from tendond.offline.control.cases import REST, Case
from tendond.offline.trials.sections import BACKBONE_POINTS, end_direction
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]

ARMED = 50
"""Cycle of arming."""

SETTLED = 2.0
"""Distance from the target within which the tip has settled [mm]."""

TIMED = 150
"""Last cycles that are computed again for their time."""


@dataclass(frozen=True)
class Outcome:
    """Measures of a run; the error is the distance of tip and reference from the trajectory's beginning on.

    Attributes:
        rms_mm, worst_mm, end_mm: of the error [mm]; the last one at the end.
        rms_degrees: of the angle between the directions of tip and reference; none: none is prescribed.
        settling_s: time from which on the tip is within 2 mm of the target, of tasks that end at one [s]; none: not.
        ripple_n: mean change of a tension from cycle to cycle in the last half second [N].
        violations: cycles in which the command met a limit but the smallest tension.
        cycle_ms, slow_ms: median and 99th percentile of a cycle's processor time [ms]; steps: the latter over a
            step of the model.
        fault: reason of a fault; empty without.
    """

    rms_mm: float
    worst_mm: float
    end_mm: float
    rms_degrees: float | None
    settling_s: float | None
    ripple_n: float
    violations: int
    cycle_ms: float
    slow_ms: float
    steps: float
    fault: str


def run(case: Case, seconds: float | None = None) -> Outcome:
    """Run a case to the end of its reference, or for a time [s] since tracking began.

    Raises:
        TendondError: the reference cannot be followed, or the plant has no solution.
    """
    config, wires = case.wired(without_probe(case.config()))
    reference = CycleSetup.from_config(config).selection.reference
    begin = float(getattr(reference, "approach_time", 0.0))
    lasting = reference.arrival + (REST if begin == 0.0 else 0.0) if seconds is None else seconds
    cycles = ARMED + math.ceil((config.pretension.duration + lasting) / case.period) + 1
    states: list[CycleState] = []
    trace = list(watched_loop(config, cycles, {ARMED: ControlAction.ARM}, BACKBONE_POINTS, states.append, wires=wires))
    part = [one for one in trace if one.record.mode is Mode.TRACKING]
    last = trace[-1].record
    fault = "" if last.mode is Mode.TRACKING else last.reason
    if not part:
        return Outcome(math.nan, math.nan, math.nan, None, None, math.nan, 0, math.nan, math.nan, math.nan, fault)
    error = 1e3 * np.linalg.norm(_tips(part) - np.array([one.record.reference.position for one in part]), axis=1)
    since: Array = case.period * np.arange(len(part), dtype=np.float64)
    counted = since >= begin if (since >= begin).any() else since >= 0.0
    kept = error[counted]
    tension = np.array([one.record.command.tension for one in part])
    half = round(0.5 / case.period)
    times, step = _times(config, states[-TIMED - 1 : -1], trace[-TIMED:])
    return Outcome(
        rms_mm=float(np.sqrt(np.mean(kept**2))),
        worst_mm=float(kept.max()),
        end_mm=float(error[-1]),
        rms_degrees=_turned(part, reference, since, counted),
        settling_s=_settling(part, since) if begin == 0.0 else None,
        ripple_n=float(np.abs(np.diff(tension[-half:], axis=0)).mean()),
        violations=sum(any(name != "tension min" for name in one.record.limited) for one in part),
        cycle_ms=1e3 * float(np.median(times)),
        slow_ms=1e3 * float(np.percentile(times, 99)),
        steps=float(np.percentile(times, 99)) / step,
        fault=fault,
    )


def _tips(part: list[Watched]) -> Array:
    return np.array([one.truth.position for one in part])


def _turned(part: list[Watched], reference: object, since: Array, counted: NDArray[np.bool_]) -> float | None:
    """Return the root mean square angle from the reference's direction [degrees]; none where it has none."""
    if not isinstance(reference, PoseReference) or reference.counts == "position":
        return None
    angles = []
    for index in np.flatnonzero(counted).tolist():
        one = part[index]
        pose = Pose(np.array(one.truth.position), rotation_to(end_direction(one.shape)))
        angles.append(math.degrees(miss(pose, reference.pose(float(since[index])).pose, "direction").angle))
    return float(np.sqrt(np.mean(np.square(angles))))


def _settling(part: list[Watched], since: Array) -> float | None:
    """Return the time after which the tip stays within `SETTLED` of its target [s]."""
    away = 1e3 * np.linalg.norm(_tips(part) - np.array([one.record.reference.target for one in part]), axis=1)
    outside = np.flatnonzero(away > SETTLED)
    if len(outside) == 0:
        return 0.0
    return None if outside[-1] == len(part) - 1 else float(since[outside[-1] + 1])


def _times(config: RigConfig, states: list[CycleState], trace: list[Watched]) -> tuple[Array, float]:
    """Compute cycles again, and return their processor times [s], and that of a step of the model in their middle."""
    setup = CycleSetup.from_config(config)
    times, steps = [], []
    for state, one in zip(states, trace, strict=True):
        start = time.thread_time()
        respond(setup, state, one.record.inputs)
        times.append(time.thread_time() - start)
        if isinstance(setup.rod, GeneralRod) and isinstance(state.rod, GeneralState):
            start = time.thread_time()
            setup.rod.step(state.rod, state.tension_estimate)
            steps.append(time.thread_time() - start)
    return np.array(times), float(np.median(steps)) if steps else math.nan
