"""The run of a point, and its measures."""

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from tendond.daemon.control.reference.planar import PLANES
from tendond.drivers.simulator.lockstep import Watched, watched_loop
from tendond.model.errors import ConvergenceError
from tendond.model.rod.static_curve import StaticCurve, static_curve
from tendond.model.rods.selection import RodSource, source_of
from tendond.offline.logs.metrics import metrics, tracking_of
from tendond.offline.robustness.alarms import judge_alarm
from tendond.offline.robustness.plants import IDLE_CYCLES, IMPACT_CYCLES, TRACKING_CYCLES, impact_tick, rig_of
from tendond.offline.robustness.points import Point
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.robot import RodSection
from tendond.schemas.messages import Mode
from tendond.schemas.requests import ControlAction

SETTLING_GOAL = 45
"""Maximum iterations to settle, in addition to the cost of the rate limit."""


RIPPLE_GOAL_MM = 0.1


ROUNDING = 1e-9
"""Tolerance of the bounds of a tension [N]."""


LAST_SAMPLES = 20
"""Last samples of a stretch: a tip that is not within the band in all of them has not settled; the error of the
estimated force is the largest of theirs."""


@dataclass(frozen=True)
class PointResult:
    """Result of a point; the CSV's columns after the point's own. The tip is the simulated one, not the measured.

    Attributes:
        settling_iterations: cycles until x stays within 5 % of the target; none if it never does, or faults before.
        rate_cost_iterations: cycles before it settled in which the command was at its displacement rate, up to
            those that the tendon's whole travel takes at that rate.
        overshoot_percent ... steady_error_mm: see `offline.logs.metrics`; none without a cycle of tracking.
        open_loop_error_mm: steady error under the nominal run's commands, see `open_loop`; none if not asked for.
        min_tension_n, peak_tension_n: commanded, from arming to the end, and true, until an impact.
        force_error_n: largest |estimated - true force on the tip| of the last cycles before any impact; none without
            a force observer.
        impact_settling_iterations: cycles to settle from the impact's end; none without an impact, or if it never does.
        impact_rate_cost_iterations: see above, after the impact.
        mode: mode at the end. reason: reason of a fault, or why the plant has no solution, which counts as one.
        alarm: 'true' or 'false' where a fault ended the run, by `alarms.judge_alarm`; else empty.
        settles, smooth, bounded, recovers: parts of the goal. meets: all of them, and no fault.
    """

    settling_iterations: int | None = None
    rate_cost_iterations: int = 0
    overshoot_percent: float | None = None
    path_overshoot_percent: float | None = None
    tpl_mm: float | None = None
    ripple_mm: float | None = None
    rise_iterations: int | None = None
    steady_error_mm: float | None = None
    open_loop_error_mm: float | None = None
    min_tension_n: float | None = None
    peak_tension_n: float | None = None
    force_error_n: float | None = None
    impact_settling_iterations: int | None = None
    impact_rate_cost_iterations: int = 0
    mode: str = ""
    reason: str = ""
    alarm: str = ""
    settles: bool = False
    smooth: bool = False
    bounded: bool = False
    recovers: bool = False
    meets: bool = False


RESULT_COLUMNS = tuple(field.name for field in fields(PointResult))


def evaluate(base: RigConfig, point: Point, seed: int, model: RodSection | None = None) -> PointResult:
    """Run a point and measure it.

    Args:
        base, point, seed, model: see `rig_of`.
    """
    config = rig_of(base, point, seed, model)
    impact = impact_tick(base)
    trace: list[Watched] = []
    reason = ""
    try:
        for watched in watched_loop(
            config, impact + (IMPACT_CYCLES if point.impact_n else 0), {IDLE_CYCLES: ControlAction.ARM}
        ):
            trace.append(watched)
    except ConvergenceError as error:
        reason = f"the plant has no solution: {error}"
    mode = trace[-1].record.mode if trace and not reason else Mode.FAULT
    if mode is not Mode.TRACKING and not reason:
        reason = trace[-1].record.reason
    fault = next((watched.record.tick for watched in trace if watched.record.mode is Mode.FAULT), None)
    alarm = "" if fault is None else judge_alarm(config, IDLE_CYCLES, fault)
    result = _tracked(config, point, trace, impact, PointResult(mode=str(mode), reason=reason, alarm=alarm))
    recovers = True
    if point.impact_n and len(trace) > impact:
        ended = impact + max(1, math.ceil(point.impact_ms / 1e3 / base.loop.period - 1e-9))
        settling, cost = _settling(config, trace[ended:], IMPACT_CYCLES - (ended - impact))
        recovers = settling is not None and settling <= SETTLING_GOAL + cost
        result = replace(result, impact_settling_iterations=settling, impact_rate_cost_iterations=cost)
    meets = result.settles and result.smooth and result.bounded and recovers and mode is Mode.TRACKING
    return replace(result, recovers=recovers and mode is Mode.TRACKING, meets=meets)


def _tracked(
    config: RigConfig, point: Point, trace: Sequence[Watched], impact: int, result: PointResult
) -> PointResult:
    """Return `result` with the measures up to the cycle `impact`, and the commanded tensions of all."""
    part = [watched for watched in trace[:impact] if watched.record.mode is Mode.TRACKING]
    if not part:
        return result
    run = tracking_of([watched.record for watched in trace[:impact]], config, str(point))
    tip = np.array([watched.truth.position for watched in part])
    control = config.control
    curve = _curve(source_of(config), control.agonist, control.plane, config.limits.tension_max)
    values = metrics(run, curve, tip=tip)
    settling, cost = _settling(config, part, TRACKING_CYCLES)
    commanded = np.array([watched.record.command.tension for watched in trace[IDLE_CYCLES:]])
    pulled = np.array([watched.truth.tension for watched in trace[IDLE_CYCLES:impact]])
    lowest, peak = min(commanded.min(), pulled.min()), max(commanded.max(), pulled.max())
    force_error = None
    if point.feedback == "force":
        force_error = max(
            float(np.linalg.norm(np.subtract(watched.record.observer.force, watched.truth.tip_force)))
            for watched in part[-LAST_SAMPLES:]
        )
    return replace(
        result,
        settling_iterations=settling,
        rate_cost_iterations=cost,
        overshoot_percent=values.overshoot_percent,
        path_overshoot_percent=values.path_overshoot_percent,
        tpl_mm=values.tpl_mm,
        ripple_mm=values.ripple_mm,
        rise_iterations=values.rise_iterations,
        steady_error_mm=values.steady_state_error_mm,
        min_tension_n=float(lowest),
        peak_tension_n=float(peak),
        force_error_n=force_error,
        settles=settling is not None and settling <= SETTLING_GOAL + cost,
        smooth=values.ripple_mm < RIPPLE_GOAL_MM,
        bounded=bool(lowest >= -ROUNDING and peak <= config.limits.tension_max + ROUNDING),
    )


@functools.lru_cache(maxsize=4)
def _curve(rod: RodSource, agonist: int, plane: str, tension_max: float) -> StaticCurve:
    """Compute the reference's curve of resting tips: many points have the same one."""
    return static_curve(rod.rod(), agonist, tension_max, PLANES[plane])


def _settling(config: RigConfig, part: Sequence[Watched], cycles: int) -> tuple[int | None, int]:
    """Measure the true tip's settling in a stretch that should track for `cycles`, and the cost of the rate limit."""
    tracked = [watched for watched in part if watched.record.mode is Mode.TRACKING]
    if len(tracked) < cycles:
        return None, 0
    records = [watched.record for watched in tracked]
    run = tracking_of(records, config, "robustness")
    tip = np.array([watched.truth.position for watched in tracked])
    settling = metrics(run, tip=tip).settling_iterations
    if settling is not None and settling > cycles - LAST_SAMPLES:
        settling = None
    until = len(records) if settling is None else settling
    stood = sum("displacement rate" in record.limited for record in records[:until])
    travel = np.abs(run.displacement[-1] - run.displacement[0]).max()
    return settling, min(stood, math.ceil(travel / (config.limits.displacement_rate * config.loop.period)))
