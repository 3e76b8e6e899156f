"""State of the controller between two cycles, which each cycle replaces."""

from dataclasses import dataclass, field
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.commissioning.averages import RESTLESS, RestWatch
from tendond.daemon.control.commissioning.jump import JumpWatch
from tendond.daemon.control.commissioning.probe import Probe
from tendond.daemon.control.commissioning.tracking import TrackingWatch
from tendond.daemon.control.estimation.moving_base import BasePose
from tendond.daemon.control.jog.jog import Jog
from tendond.daemon.control.law_state import LawState
from tendond.daemon.control.selection import Selection
from tendond.daemon.control.sensors import UNHEARD, Reading, SensorTrack
from tendond.daemon.control.servos import ServoMotion
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.snapshot import LEFT_OUT_IF_EMPTY
from tendond.daemon.control.sources import Sources
from tendond.daemon.control.tuning.tuning import UNTUNED, Tuning
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.estimation.observer import ObserverState, start_observer
from tendond.model.rod.tip import Tip
from tendond.model.rods.general import GeneralState
from tendond.model.rods.interface import ModelState
from tendond.schemas.keys import sensor_topic
from tendond.schemas.messages import Mode, TendonState, TipPose

Array = NDArray[np.float64]
T = TypeVar("T")


def changed(old: T, **changes: Any) -> T:
    """Return a changed copy as `dataclasses.replace` does, in a tenth of its time; for classes without own initialiser.

    A cycle makes a dozen of these copies, of twenty fields each.
    """
    new = object.__new__(type(old))
    new.__dict__.update(old.__dict__)
    new.__dict__.update(changes)
    return new


@dataclass(frozen=True)
class BadCycles:
    """Number of cycles for which something has been wrong; the fault table's thresholds apply to these.

    What is judged by reports (rejected, teleports, equal_poses, mismatches, slack) counts the cycles from the first bad
    report to the newest one, the first as one: a slow camera is judged by the same time as a fast one.

    Attributes:
        disorder: cycles during which poses have arrived out of order, beside others that are used.
        objection: reason of the newest rejected pose.
        since_pose: cycles since a pose arrived, used or not.
        limits: names of those that the newest command met.
        unsafe: cycles for which no command has kept the constraints of [safety].
    """

    rejected: int = 0
    teleports: int = 0
    missed_ticks: int = 0
    solver_failures: int = 0
    limited: int = 0
    equal_poses: int = 0
    occluded: int = 0
    mismatches: int = 0
    slack: int = 0
    odd_reports: int = 0
    objection: str = ""
    since_pose: int = 0
    disorder: int = 0
    since_disorder: int = 0
    unsafe: int = 0
    limits: tuple[str, ...] = ()


@dataclass(frozen=True)
class PoseAge:
    """Age of the newest pose by its stamp.

    Attributes:
        stamp_ns: stamp of that pose [ns]. seconds: its age when it was used [s].
        lag_min: smallest difference of the two clocks so far, that of a pose without delay [s].
        too_old: cycles for which poses have been too old.
    """

    stamp_ns: int = -1
    seconds: float = 0.0
    lag_min: float = 1e18
    too_old: int = 0


@dataclass(frozen=True)
class TipCorrection:
    """Learned correction of the model's tip (`model.estimation.residual`).

    Attributes:
        held: state of each tendon's play [m], shape (n,). shift: of the tip [m], shape (3,).
    """

    held: Array
    shift: Array


YOUNG, STILL, UNWATCHED = PoseAge(), JumpWatch(), TrackingWatch()


@dataclass(frozen=True)
class CycleState:
    """State of the controller between two cycles.

    Attributes:
        tick: index of the next cycle.
        mode, reason: see `Mode`; mode_since: tick at which the mode was entered.
        rod: state of the model.
        tip: tip of that rod.
        observer: state of the tip observer, or of the estimator in its place.
        selection: law and reference in use.
        pose: newest admitted pose; pose_age: cycles since it arrived.
        previous_position: position of the pose before it [m], shape (3,); pose_interval: cycles between the two.
        path_length: distance the model's tip has travelled since the measured tip last changed [m].
        tendon_state: newest report of the tendons; tendon_age: cycles since it arrived;
            tendon_interval: cycles between it and the one before.
        tension_estimate: tension that the actuators are estimated to apply [N], shape (n,).
        tension_command: tension last commanded [N], shape (n,).
        displacement_estimate: displacement that the actuators are estimated to hold [m], shape (n,).
        displacement_command: displacement last commanded [m], shape (n,).
        servo_motion: estimated motion of the servos; none where they have but a lag.
        reference_offset: shift of the reference along the straight rod [m], where that is not part of the target.
        release_pending: the tendons are being released, and the rate limit still holds the displacement back.
        sources: publishers in use.
        bad_cycles: durations of what is wrong.
        rejected: inputs dropped since the start, by reason.
        rest_watch: averages of the tip while no tendon is under tension.
        probe: the running or the last probe; commissioned: one has passed and nothing has changed since.
        stamp_age: age of the pose by its stamp. jump_watch: jumps of the measured tip. tracking_watch: tip against
            reference.
        law_state: state that the law keeps while it tracks; none for a law without one.
        correction: learned correction of the model's tip; none where none is configured.
        sensors: what is known of each configured sensor beside the pose, by name.
        readings: those of them that were admitted in this cycle, markers in the base's frame.
        base: measured poses of a moving base, the youngest first. published: position of the newest admitted pose as it
            came [m], where it has been taken into that base's frame.
        jog: motion of the target by hand; none where the reference goes its own way.
        tuning: tuned gains and limits.
        unreadable: field of the first malformed message and what was wrong with it; empty without one.
    """

    tick: int
    mode: Mode
    reason: str
    mode_since: int
    rod: ModelState
    tip: Tip
    observer: ObserverState | EstimatorState
    selection: Selection
    pose: TipPose | None
    pose_age: int | None
    previous_position: Array | None
    pose_interval: int
    tendon_state: TendonState | None
    tension_estimate: Array
    tension_command: Array
    displacement_estimate: Array
    displacement_command: Array
    servo_motion: ServoMotion | None = None
    reference_offset: float = 0.0
    path_length: float = 0.0
    tendon_age: int = 0
    tendon_interval: int = 1
    release_pending: bool = False
    sources: Sources = field(default_factory=lambda: Sources({}, {}))
    bad_cycles: BadCycles = BadCycles()
    rejected: dict[str, int] = field(default_factory=dict)
    unreadable: str = ""
    rest_watch: RestWatch = RESTLESS
    probe: Probe | None = None
    commissioned: bool = False
    stamp_age: PoseAge = YOUNG
    jump_watch: JumpWatch = STILL
    tracking_watch: TrackingWatch = UNWATCHED
    law_state: LawState | None = None
    correction: TipCorrection | None = None
    sensors: dict[str, SensorTrack] = field(default_factory=dict, metadata=LEFT_OUT_IF_EMPTY)
    readings: tuple[Reading, ...] = field(default=(), metadata=LEFT_OUT_IF_EMPTY)
    base: tuple[BasePose, ...] = field(default=(), metadata=LEFT_OUT_IF_EMPTY)
    published: tuple[float, ...] = field(default=(), metadata=LEFT_OUT_IF_EMPTY)
    jog: Jog | None = field(default=None, metadata=LEFT_OUT_IF_EMPTY)
    tuning: Tuning = field(default=UNTUNED, metadata=LEFT_OUT_IF_EMPTY)


def followed_sources(state: CycleState) -> dict[str, str]:
    """Return the identity of the publisher in use, by topic."""
    found = {topic: source.name for topic, source in state.sources.followed.items()}
    readings = {sensor_topic(name): track.source for name, track in state.sensors.items()}
    return found | {topic: source for topic, source in readings.items() if source is not None}


def started_observer(setup: CycleSetup, rod: ModelState, tip: Tip) -> ObserverState | EstimatorState:
    """Return the observer, or the estimator in its place, of a model that rests."""
    if setup.estimator is not None and isinstance(rod, GeneralState):
        return setup.estimator.start(rod)
    return start_observer(setup.observer, tip.position)


def initial_state(setup: CycleSetup) -> CycleState:
    """Disarmed, slack, the model at rest under gravity.

    Raises:
        ConvergenceError: the model has no such rest.
    """
    n = setup.rod.parameters.tendon_count
    rod = setup.rod.solve_static(np.zeros(n))
    tip = setup.rod.tip(rod)
    return CycleState(
        tick=0,
        mode=Mode.STARTING,
        reason="starting",
        mode_since=0,
        rod=rod,
        tip=tip,
        observer=started_observer(setup, rod, tip),
        selection=setup.selection,
        pose=None,
        pose_age=None,
        previous_position=None,
        pose_interval=1,
        tendon_state=None,
        tension_estimate=np.zeros(n),
        tension_command=np.zeros(n),
        displacement_estimate=np.zeros(n),
        displacement_command=np.zeros(n),
        sensors=dict.fromkeys(setup.sensors, UNHEARD),
    )
