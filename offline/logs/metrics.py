"""Metrics of a run: the paper's, of the component of the tip that bends (x, or y in plane 'yz'), and others.

Definitions for readers are in docs/metrics.md; demo, paper, robustness, plots and replay all use this module.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from tendond.offline.logs.container import LogError
from tendond.offline.logs.injections import Injection, injections, within
from tendond.offline.logs.log import LogFile
from tendond.schemas.base import Vector3
from tendond.schemas.config.control import PLANES
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord

if TYPE_CHECKING:  # the model's kernels take half a second to import
    from tendond.model.rod.static_curve import StaticCurve

Array = NDArray[np.float64]

SETTLED = 0.05
"""Half-width of the settling band, as a fraction of the step."""

RISEN = 0.9
"""Fraction of the step at which the rise ends."""

STRAIGHT = 0.1
"""Part of the target within which a run begins straight, as the paper's does, or there: it steps from zero. Chosen."""

ASIDE = 0.01
"""Part of the target's distance from the base below which it lies ahead or aside, and there is no step. Chosen."""

STEADY_SAMPLES = 20
"""Samples at the end of the run whose mean is the steady-state error."""

RIPPLE_SAMPLES = 40
"""Samples at the end of the run over which the ripple is taken."""


@dataclass(frozen=True)
class Tracking:
    """A stretch of a log that tracks, a run, one sample per cycle; sample 0 is the tip when tracking began.

    Attributes:
        ticks: the cycles' ticks, shape (k,).
        time: since the start of tracking [s], shape (k,).
        tip: measured [m], shape (k, 3). The command of one cycle shows in the next: sample i follows i commands.
        reference: reference of the tip [m], shape (k, 3).
        displacement: commanded tendon displacements [m], shape (k, n).
        tension: commanded tendon tensions [N], shape (k, n).
        target: end of the reference [m].
        axes: axes of the bending plane: index of the component that bends (0 for x, 1 for y), and 2.
        agonist: index of its tendon.
        injections: what the simulator did meanwhile; their cycles are iterations.
    """

    ticks: NDArray[np.int64]
    time: Array
    tip: Array
    reference: Array
    displacement: Array
    tension: Array
    target: Vector3
    axes: tuple[int, int]
    agonist: int
    injections: tuple[Injection, ...] = ()

    @property
    def calm(self) -> int:
        """Samples before the first injection."""
        return self.injections[0].start if self.injections else len(self.tip)

    @property
    def has_metrics(self) -> bool:
        """Whether there is a step of the component that bends, to which the metrics are relative."""
        return len(self.tip) > 0 and _bends(self.target, self.axis, float(self.tip[0, self.axis]))

    @property
    def begin(self) -> float:
        """Where the step of the component that bends begins [m]: at zero, or where the tip is, far from straight."""
        return _begin(self.target[self.axis], float(self.tip[0, self.axis]))

    @property
    def step(self) -> float:
        """Step of the component that bends, from `begin` to the target [m]; not zero where there are metrics."""
        return self.target[self.axis] - self.begin

    @property
    def axis(self) -> int:
        """Index of the component that bends."""
        return self.axes[0]


@dataclass(frozen=True)
class Metrics:
    """Metrics of k samples; an iteration is a sample's index. The first seven concern the tip's component x (or y).

    Settling, rise and both overshoots are of the samples before the first injection; all others are of the whole run.

    Attributes:
        tpl_mm: total path length, the sum of |x[i+1] - x[i]| [mm].
        settling_iterations: first iteration from which on |x - target| stays within 5 % of the step; none if the last
            sample is outside. The step is from zero to the target, as in the paper, or from where the tip is where it
            begins far from straight.
        overshoot_percent: overshoot of x over the target, relative to the step [%]; 0 without one.
        rise_iterations: first iteration with 90 % of the step; none if it is not reached.
        steady_state_error_mm: |target - mean of the last 20 samples| [mm].
        final_tip_m: last sample [m].
        final_displacement_m: last command of the agonist [m].
        settling_s: `settling_iterations` in seconds.
        path_mm: distance travelled by the tip in the plane [mm].
        path_overshoot_percent: overshoot of the target along the curve of resting tips, relative to the distance from
            its start to the target [%]; none without that curve. It shows a bend that overshoots even where x turns
            back, and x beyond the target during a slow bend is not counted.
        iae_mm_s: integral of the distance between tip and reference in the plane [mm s].
        ripple_mm: standard deviation of the tip in the plane over the last 40 samples [mm].
        tendon_rate_mm_s: root mean square of the rate of all commanded displacements [mm/s]: wear of the motors.
        peak_tension_n: largest commanded tension [N]. min_tension_n: smallest [N].
    """

    tpl_mm: float
    settling_iterations: int | None
    overshoot_percent: float
    rise_iterations: int | None
    steady_state_error_mm: float
    final_tip_m: Vector3
    final_displacement_m: float
    settling_s: float | None
    path_mm: float
    path_overshoot_percent: float | None
    iae_mm_s: float
    ripple_mm: float
    tendon_rate_mm_s: float
    peak_tension_n: float
    min_tension_n: float


def tracking(log: LogFile) -> Tracking:
    """Select the first run of a log, the first stretch of cycles that track; raises LogError, see `tracking_of`."""
    run = tracking_of(log.records, log.config, str(log.path))
    return replace(run, injections=_injected(log, _stretches(log)[0]))


def runs(log: LogFile) -> list[Tracking]:
    """Select all runs of a log: each stretch of cycles that track, and have a measured tip.

    Raises:
        LogError: there is none.
    """
    found = [
        replace(_tracking(log.records[part], log.config), injections=_injected(log, part))
        for part in _stretches(log)
        if all(record.measured is not None for record in log.records[part])
    ]
    if not found:
        tracking(log)  # says why
        raise LogError(f"{log.path}: contains no run; use another log")
    return found


def tracking_of(records: Sequence[CycleRecord], config: RigConfig, source: str) -> Tracking:
    """Select the first stretch of cycles that track.

    Args:
        records: records of consecutive cycles.
        config: the configuration that they ran with.
        source: their origin, for messages.

    Raises:
        LogError: no cycle tracks, or the target's bending component, to which the metrics are relative, is zero.
    """
    start = next((i for i, record in enumerate(records) if record.mode is Mode.TRACKING), None)
    if start is None:
        raise LogError(f"{source}: contains no cycle in mode 'tracking'; arm the controller while it records")
    end = next((i for i, record in enumerate(records[start:], start) if record.mode is not Mode.TRACKING), None)
    part = records[start:end]
    axis = PLANES[config.control.plane][0]
    if any(record.measured is None for record in part):
        raise LogError(f"{source}: holds tracking cycles without a measured tip; use another log")
    run = _tracking(part, config)
    if not run.has_metrics:
        raise LogError(
            f"{source}: the tip goes nowhere in {'xy'[axis]}, which the metrics are relative to; use another log"
        )
    return run


def _begin(target: float, first: float) -> float:
    return 0.0 if min(abs(first), abs(first - target)) <= STRAIGHT * abs(target) else first


def _bends(target: Vector3, axis: int, first: float) -> bool:
    return abs(target[axis] - _begin(target[axis], first)) > ASIDE * math.hypot(*target)


def _tracking(part: Sequence[CycleRecord], config: RigConfig) -> Tracking:
    return Tracking(
        ticks=np.array([record.tick for record in part]),
        time=np.array([record.time - part[0].time for record in part]),
        tip=np.array([record.measured for record in part]),
        reference=np.array([record.reference.position for record in part]),
        displacement=np.array([record.command.displacement for record in part]),
        tension=np.array([record.command.tension for record in part]),
        target=part[0].reference.target,
        axes=PLANES[config.control.plane],
        agonist=config.control.agonist,
    )


def _stretches(log: LogFile) -> list[slice]:
    """Find the records of each run: consecutive ones that track."""
    found: list[slice] = []
    for i, record in enumerate(log.records):
        if record.mode is Mode.TRACKING:
            start = found.pop().start if found and found[-1].stop == i else i
            found.append(slice(start, i + 1))
    return found


def _injected(log: LogFile, part: slice) -> tuple[Injection, ...]:
    first, last = log.records[part.start].tick, log.records[part.stop - 1].tick
    return within(injections(log.truth_ticks, log.truth), first, last)


def metrics(run: Tracking, curve: "StaticCurve | None" = None, tip: Array | None = None) -> Metrics:
    """Compute the metrics of a run; see `Metrics` for their definitions.

    Args:
        run: the samples; not empty.
        curve: curve of resting tips, for the overshoot along it.
        tip: positions to use instead of the measured ones, for instance a simulator's truth [m], shape (k, 3).
    """
    tip = run.tip if tip is None else tip
    axis, axes, target = run.axis, list(run.axes), run.target
    progress = (tip[:, axis] - run.begin) / run.step  # a step to the negative side is no different
    calm = progress[: run.calm]
    outside = np.flatnonzero(np.abs(calm - 1.0) > SETTLED)
    risen = np.flatnonzero(calm >= RISEN)
    settling = int(outside[-1]) + 1 if outside.size else 0
    settled = settling < len(calm)
    scale_mm = 1000.0 * math.fabs(run.step)
    x, y, z = (float(value) for value in tip[-1])
    period = float(run.time[1] - run.time[0]) if len(tip) > 1 else 0.0
    plane = tip[:, axes]
    rates = np.diff(run.displacement, axis=0) / period if period > 0.0 else np.zeros((1, 1))
    return Metrics(
        tpl_mm=1000.0 * float(np.abs(np.diff(tip[:, axis])).sum()),
        settling_iterations=settling if settled else None,
        overshoot_percent=100.0 * max(0.0, float(calm.max()) - 1.0),
        rise_iterations=int(risen[0]) if risen.size else None,
        steady_state_error_mm=scale_mm * math.fabs(1.0 - float(progress[-STEADY_SAMPLES:].mean())),
        final_tip_m=(x, y, z),
        final_displacement_m=float(run.displacement[-1, run.agonist]),
        settling_s=float(run.time[settling]) if settled else None,
        path_mm=1000.0 * float(np.linalg.norm(np.diff(plane, axis=0), axis=1).sum()),
        path_overshoot_percent=None
        if curve is None
        else _path_overshoot(plane[: run.calm], np.array(target)[axes], curve),
        iae_mm_s=1000.0 * period * float(np.linalg.norm(plane - run.reference[:, axes], axis=1).sum()),
        ripple_mm=1000.0 * float(np.linalg.norm(plane[-RIPPLE_SAMPLES:].std(axis=0))),
        tendon_rate_mm_s=1000.0 * float(np.sqrt(np.mean(rates**2))),
        peak_tension_n=float(run.tension.max()),
        min_tension_n=float(run.tension.min()),
    )


def _path_overshoot(plane: Array, target: Array, curve: "StaticCurve") -> float:
    """Overshoot along the curve, relative to the path length from the first sample to the target [%]."""
    arcs = curve.nearest(np.vstack([plane, target]))
    length = arcs[-1] - arcs[0]
    return 100.0 * max(0.0, float((arcs[:-1].max() - arcs[-1]) / length)) if length > 0.0 else 0.0
