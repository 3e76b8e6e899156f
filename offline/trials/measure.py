"""One trial, run in lockstep, in numbers: of the simulated tip, not the measured one."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.pose.reference import PoseReference
from tendond.daemon.control.reference.spatial import SpatialReference
from tendond.daemon.control.setup import CycleSetup
from tendond.drivers.simulator.lockstep import Watched, watched_loop
from tendond.offline.logs.metrics import metrics, tracking_of
from tendond.offline.trials.paths import Trial, config_of
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

Array = NDArray[np.float64]

IDLE_CYCLES = 100
"""Disarmed, before arming: the observer sees what hangs on the tip."""

PLANAR_CYCLES = 250


@dataclass(frozen=True)
class TrialOutcome:
    """Measures of a trial; the error is the distance of tip and reference from the trajectory's beginning on.

    Attributes:
        rms_mm, worst_mm: root mean square and maximum of the error [mm].
        largest_change_n: largest change of a commanded tension from one cycle to the next, on the trajectory [N].
        min_tension_n, peak_tension_n: commanded while tracking [N].
        limited: cycles in which the command met a limit.
        mode, reason: mode and reason at the end.
        notes: changes that were made to the trajectory.
        meets: no fault, and the RMS within the goal.
        time: since tracking began [s], shape (k,). tip, reference: [m], shape (k, 3). tension: [N], shape (k, n).
        approach_time: time at which the trajectory begins [s].
    """

    rms_mm: float
    worst_mm: float
    largest_change_n: float
    min_tension_n: float
    peak_tension_n: float
    limited: int
    mode: str
    reason: str
    notes: tuple[str, ...]
    meets: bool
    time: Array
    tip: Array
    reference: Array
    tension: Array
    approach_time: float

    def as_json(self) -> dict[str, Any]:
        """Return the numbers, without those per cycle."""
        return {
            name: list(value) if isinstance(value, tuple) else value
            for name, value in vars(self).items()
            if not isinstance(value, np.ndarray)
        }


def run_trial(base: RigConfig, trial: Trial, seed: int = 0) -> TrialOutcome:
    """Run a trial to the end of its trajectory.

    Args:
        base, trial, seed: see `config_of`.

    Raises:
        TendondError: the trajectory cannot be followed, or the plant has no solution.
    """
    config = config_of(base, trial, seed)
    trajectory = CycleSetup.from_config(config).selection.reference
    assert isinstance(trajectory, SpatialReference | PoseReference)
    period = config.loop.period
    cycles = IDLE_CYCLES + math.ceil((config.pretension.duration + trajectory.arrival) / period) + 1
    trace = list(watched_loop(config, cycles, {IDLE_CYCLES: ControlAction.ARM}))
    part = [watched for watched in trace if watched.record.mode is Mode.TRACKING]
    time: Array = period * np.arange(len(part), dtype=np.float64)
    tip = np.array([watched.truth.position for watched in part])
    reference = np.array([watched.record.reference.position for watched in part])
    tension = np.array([watched.record.command.tension for watched in part])
    last = trace[-1].record
    return outcome_of(
        time=time,
        tip=tip,
        reference=reference,
        tension=tension,
        limited=sum(bool(watched.record.limited) for watched in part),
        trajectory=trajectory,
        mode=last.mode.value,
        reason=last.reason,
        goal_mm=trial.goal_mm,
    )


def outcome_of(
    *, time: Array, tip: Array, reference: Array, tension: Array, limited: int,
    trajectory: SpatialReference | PoseReference, mode: str, reason: str,
    goal_mm: float,
) -> TrialOutcome:  # fmt: skip
    """Measure a run; arguments as the attributes of `TrialOutcome`, and the largest RMS that is wanted."""
    on_trajectory = time >= trajectory.approach_time
    error = 1e3 * np.linalg.norm(tip - reference, axis=1)[on_trajectory]
    rms = float(np.sqrt(np.mean(error**2)))
    return TrialOutcome(
        rms_mm=rms,
        worst_mm=float(error.max()),
        largest_change_n=float(np.abs(np.diff(tension[on_trajectory], axis=0)).max()),
        min_tension_n=float(tension.min()),
        peak_tension_n=float(tension.max()),
        limited=limited,
        mode=mode,
        reason=reason,
        notes=trajectory.notes,
        meets=rms <= goal_mm and mode == Mode.TRACKING.value,
        time=time,
        tip=tip,
        reference=reference,
        tension=tension,
        approach_time=trajectory.approach_time,
    )


def planar_task(base: RigConfig, laws: Sequence[str]) -> dict[str, Mapping[str, float | None]]:
    """Run the configuration's own planar reference by law: settling, path lengths, rate of the tensions.

    The rate is the root mean square of all tendons' commanded changes [N/s].
    """
    found: dict[str, Mapping[str, float | None]] = {}
    for law in laws:
        values = base.model_dump()
        values["control"]["law"] = law
        values["simulator"] = {"period": base.loop.period, "rod": values["rod"]}
        values["servo"] = values["vicon"] = None
        config = check_config(values, f"law '{law}'")
        cycles = IDLE_CYCLES + math.ceil(config.pretension.duration / config.loop.period) + PLANAR_CYCLES
        trace: list[Watched] = list(watched_loop(config, cycles, {IDLE_CYCLES: ControlAction.ARM}))
        run = tracking_of([watched.record for watched in trace], config, law)
        tip = np.array([watched.truth.position for watched in trace if watched.record.mode is Mode.TRACKING])
        values_of = metrics(run, tip=tip)
        rates = np.diff(run.tension, axis=0) / config.loop.period
        found[law] = {
            "settling_iterations": values_of.settling_iterations,
            "tpl_mm": values_of.tpl_mm,
            "path_mm": values_of.path_mm,
            "steady_error_mm": values_of.steady_state_error_mm,
            "tension_rate_n_s": float(np.sqrt(np.mean(rates**2))),
        }
    return found
