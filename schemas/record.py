"""Record of one cycle: everything needed to replay it and to plot it."""

from typing import Annotated, Literal

from pydantic import AliasChoices, Field

from tendond.schemas.base import PerTendon, PerTendonOrNone, Quaternion, Schema, Vector3, is_empty
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.messages import Mode, SensorReading, TendonCommand, TendonState, TipPose
from tendond.schemas.requests import ControlAction

Covariance = tuple[float, float, float, float, float, float]
"""Upper half of a symmetric matrix, row by row: xx, xy, xz, yy, yz, zz."""

RECORD_VERSION: Literal[2] = 2
"""Version 1 had `tension` for `tension_estimate`, and no `law_state`; it is still read."""


class CycleInputs(Schema):
    """Inputs of a cycle.

    Attributes:
        pose: the newest one that arrived since the last cycle, if any did.
        tendon_state: likewise.
        request: request of the operator, if there is one; law, reference, settings, jog: its subject;
            settings and jog are left out where there are none.
        unreadable: payloads that arrived since the last cycle and were no messages: how many, by reason.
        unreadable_detail: wrong field of the first of those, and its defect.
        others: further publishers received since the last cycle, by key: their newest identity. "controller" is
            another controller of this rig.
        missed_ticks: deadlines skipped just before this cycle.
        pose_lag: arrival of the pose by the receiver's clock minus its `stamp_ns` [s]; none where no clock ran.
        readings: the newest one of each sensor that arrived since the last cycle, by the sensor's name; reading_lags:
            of these as `pose_lag` [s]. Both are left out where there is none.
    """

    pose: TipPose | None = None
    tendon_state: TendonState | None = None
    request: ControlAction | None = None
    law: str | None = None
    reference: ReferenceSection | None = None
    unreadable: dict[str, int] = Field(default_factory=dict)
    unreadable_detail: str = ""
    others: dict[str, str] = Field(default_factory=dict)
    missed_ticks: Annotated[int, Field(ge=0)] = 0
    pose_lag: float | None = None
    readings: dict[str, SensorReading] = Field(default_factory=dict, exclude_if=is_empty)
    reading_lags: dict[str, float] = Field(default_factory=dict, exclude_if=is_empty)
    settings: dict[str, float] = Field(default_factory=dict, exclude_if=is_empty)
    jog: float | None = Field(None, exclude_if=lambda value: value is None)


class ReferencePoint(Schema):
    """Reference of the tip: position [m], velocity [m/s], acceleration [m/s^2], in the base's frame.

    Attributes:
        target: end of the reference [m].
    """

    position: Vector3
    velocity: Vector3
    acceleration: Vector3
    target: Vector3


class TipEstimate(Schema):
    """Law inputs.

    Attributes:
        position: X1 [m]. velocity: X2 [m/s]. acceleration: [m/s^2], at the tensions now applied. In the base's frame.
    """

    position: Vector3
    velocity: Vector3
    acceleration: Vector3


class ContactEstimate(Schema):
    """A force on the body that the estimator found; in the base's frame.

    Attributes:
        place: arc length from the base [m]. first_place, last_place: ends of those that the data do not exclude [m].
        force: [N]. force_deviation: standard deviation of each component [N].
        statistic: twice the log of the likelihood ratio to no contact [-].
        onset: cycle of the estimator in which it began. settled: it is not weighed again with more data.
    """

    place: float
    first_place: float
    last_place: float
    force: Vector3
    force_deviation: Vector3
    statistic: float
    onset: float
    settled: bool


class FilterEstimate(Schema):
    """What an observer of kind 'kalman' knows, and how sure it is; in the base's frame.

    Attributes:
        tip_covariance: of the model's tip, xx, xy, xz, yy, yz, zz [m^2]; force_covariance: of the force on it [N^2].
        tension_error: of the tensions that act, beside `tension_estimate` [N]; tension_deviation: its standard
            deviation [N].
        bend_error: bending moments along each section, about x and y, at its end [N m].
        stiffness: of the robot, relative to that configured [-]; stiffness_deviation: its standard deviation [-].
        tip_mass: on the tip beside that configured [kg]; tip_mass_deviation: its standard deviation [kg]; left out
            where it is taken as known.
        consistency: mean square of the innovations over a second, in units of their expected spread [-]; 1 is right.
        load_tick: cycle at which a load was last taken to have come at once; none: none was.
        contact: force on the body that was found; left out where there is none, or none is sought.
    """

    tip_covariance: Covariance
    force_covariance: Covariance
    tension_error: PerTendon
    tension_deviation: PerTendon
    bend_error: tuple[float, ...]
    stiffness: float
    stiffness_deviation: float
    consistency: float
    load_tick: int | None
    contact: ContactEstimate | None = Field(None, exclude_if=lambda value: value is None)
    tip_mass: float | None = Field(None, exclude_if=lambda value: value is None)
    tip_mass_deviation: float | None = Field(None, exclude_if=lambda value: value is None)


class ObserverEstimate(Schema):
    """Output of the observer, from the difference between model and measurement; in the base's frame.

    Attributes:
        innovation: measured tip minus the model's of the same time [m]; the last one while no pose comes.
        force: estimated on the tip, beside the rod's own weight [N]; zero with the offset observer.
        pull: force on the model's tip that moves it to the measured one [N].
        offset: added to the model's tip [m]; zero with the force observer.
        residual: learned correction, added to the model's tip [m]; left out where none is configured.
        filter: of an observer of kind 'kalman'; left out of others.
    """

    innovation: Vector3
    force: Vector3
    pull: Vector3
    offset: Vector3
    residual: Vector3 | None = Field(None, exclude_if=lambda value: value is None)
    filter: FilterEstimate | None = Field(None, exclude_if=lambda value: value is None)


class ModelState(Schema):
    """The controller's rod after the cycle.

    Attributes:
        position: position of its tip [m], in the base's frame. orientation: orientation of its tip, w, x, y, z.
        residual: norm of force and moment missing at the tip [N, N m].
        marches: along the rod that the solution took.
        error: reason for which there is no new solution; empty when there is one.
    """

    position: Vector3
    orientation: Quaternion
    residual: float
    marches: int
    error: str = ""


class Intervention(Schema):
    """What the safety filter did to a command.

    Attributes:
        constraint: name of the constraint that is nearest to its limit. distance: of it along the motion that follows
            the command, less the margins [m], of strain [-]; below zero: within them.
        altered: largest change of a tension [N]. kept: false where no command keeps all constraints.
    """

    constraint: str
    distance: float
    altered: float
    kept: bool


class CycleRecord(Schema):
    """One cycle.

    Attributes:
        version: version of the schema.
        tick: index of the cycle.
        time: nominal time since the first cycle [s].
        mode: after the cycle. reason: of it.
        reply: reply to the operator's request, if there was one; accepted: true if it was carried out.
        inputs: inputs of the cycle.
        rejected: inputs that it did not use, and why.
        pose_age: cycles since the pose in use arrived; none before the first.
        measured: tip position in use [m]; none before the first.
        reference: point at which the tip should be.
        observer: difference between model and measurement.
        estimate: input of the law; none while no law runs.
        terms: intermediate results of the law by name, SI.
        law_state: numbers in the state that the law keeps between cycles, by name; empty for a law without one.
        wanted: tensions that the law asked for, before limits [N]; none while no law runs.
        tension_estimate: tensions that the actuators are estimated to apply, and the model is given [N].
        tip_tension: tensions where the tendons are fixed to the robot, by the friction in the model [N]; left out where
            none of its tendons rubs: they are `tension_estimate`.
        law: name of the law in use.
        limited: limits that the command met.
        safety: what the safety filter did; left out where it did nothing.
        tuned: values in use of the tuned keys of the configuration; left out where all are as configured.
        model: the rod after the cycle.
        command: command that was published.
    """

    version: Literal[1, 2] = RECORD_VERSION
    tick: int
    time: float
    mode: Mode
    reason: str
    reply: str = ""
    accepted: bool = False
    inputs: CycleInputs
    rejected: tuple[str, ...]
    pose_age: int | None
    measured: Vector3 | None
    reference: ReferencePoint
    observer: ObserverEstimate
    estimate: TipEstimate | None
    terms: dict[str, float | tuple[float, ...]]
    law_state: dict[str, float | tuple[float, ...]] = Field(default_factory=dict)
    wanted: PerTendon | None
    tension_estimate: Annotated[PerTendon, Field(validation_alias=AliasChoices("tension_estimate", "tension"))]
    tip_tension: PerTendonOrNone = Field((), exclude_if=is_empty)
    law: str = ""
    limited: tuple[str, ...]
    safety: Intervention | None = Field(None, exclude_if=lambda value: value is None)
    tuned: dict[str, float] = Field(default_factory=dict, exclude_if=is_empty)
    model: ModelState
    command: TendonCommand


class LoopTiming(Schema):
    """Timing of a cycle.

    Attributes:
        tick: index of the cycle.
        lateness_us: wake-up after the deadline [us]; negative where the expected pose was there before it.
        work_us: time from wake-up to the command handed to Zenoh [us].
        missed_ticks: skipped before it.
        ahead: the command had been worked out shortly before the deadline; nothing else came in until then.
        speculation_us: time taken before the deadline to work it out, or by a trial of it [us].
        pose_wait_us: from the arrival of the newest pose to the wake-up [us]; none without one, or if it was not seen.
        phase_locked: the deadline follows the phase of the poses.
    """

    tick: int
    lateness_us: float
    work_us: float
    missed_ticks: int
    ahead: bool = False
    speculation_us: Annotated[float, Field(validation_alias=AliasChoices("speculation_us", "rehearsal_us"))] = 0.0
    pose_wait_us: float | None = None
    phase_locked: bool = False
