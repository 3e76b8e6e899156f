"""What travels on Zenoh: JSON, SI units, one schema version, a sequence number and a capture time in every message."""

import math
from enum import StrEnum
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, field_validator, model_validator

from tendond.schemas.base import SCHEMA_VERSION, PerTendon, Quaternion, Schema, Vector3
from tendond.schemas.config.reference import ReferenceSection

ENCODING = "application/json"
LARGEST_PAYLOAD = 65536
"""Bytes; anything larger is dropped unread."""

QUATERNION_TOLERANCE = 1e-3
"""How far a quaternion's norm may be from 1."""


class Mode(StrEnum):
    """Of the controller; `fault` lasts until the operator resets it."""

    STARTING = "starting"
    IDLE = "idle"
    PROBE = "probe"
    PRETENSION = "pretension"
    TRACKING = "tracking"
    RELEASING = "releasing"
    FAULT = "fault"


class Message(Schema):
    """Common to all that is published.

    Attributes:
        version: of the schema; another one is refused.
        seq: counts up by one per message of a publisher.
        stamp_ns: capture time [ns] on the publisher's monotonic clock; ages are taken on the receiver's.
        source: identity of the publisher for its run, for instance "vicon-3f9c2a"; empty: none. Two publishers of one
            key are told apart by it.
    """

    REQUIRED: ClassVar[frozenset[str]] = frozenset({"version"})

    version: Literal[1] = SCHEMA_VERSION
    seq: Annotated[int, Field(ge=0)]
    stamp_ns: Annotated[int, Field(ge=0)]
    source: Annotated[str, Field(max_length=64, pattern=r"^[\w.:+-]*$")] = ""

    def stamped(self, stamp_ns: int) -> Self:
        """The same with another capture time [ns]."""
        return self.trusted(**{**self.__dict__, "stamp_ns": stamp_ns})

    def named(self, source: str) -> Self:
        """The same with an identity of its publisher."""
        return self.trusted(**{**self.__dict__, "source": source})


class TipPose(Message):
    """Pose of the tip in the base's frame, from a motion-capture driver or a simulator.

    Attributes:
        position: [m].
        orientation: unit quaternion w, x, y, z, body to world.
        valid: false while the tip is occluded; the pose is then the last one seen.
    """

    REQUIRED: ClassVar[frozenset[str]] = frozenset({"version", "valid"})

    position: Vector3
    orientation: Quaternion
    valid: bool = True

    @field_validator("orientation")
    @classmethod
    def _unit(cls, value: Quaternion) -> Quaternion:
        norm = math.sqrt(sum(component * component for component in value))
        if abs(norm - 1.0) > QUATERNION_TOLERANCE:
            raise ValueError(f"is no unit quaternion (norm {norm:.6g})")
        return value


class TendonCommand(Message):
    """What the servos (or the simulator) are to do.

    Attributes:
        pose_seq: sequence number of the newest pose that the controller had seen; none before the first.
        displacement: of each tendon's end, from the straight robot, positive when pulled [m]; zero while disarmed.
        tension: that the model expects with it [N].
        armed: false: torque off, tendons slack.
    """

    pose_seq: int | None
    displacement: PerTendon
    tension: PerTendon
    armed: bool


class TendonState(Message):
    """What the servos (or the simulator) report.

    Attributes:
        displacement: of each tendon's end [m].
        tension: measured or estimated [N].
        fault: of a servo, in words; empty when there is none.
    """

    displacement: PerTendon
    tension: PerTendon
    fault: str = ""


class ServoHealth(Message):
    """How the servo driver and its serial bus do, once a second; counts are since the driver's start.

    Attributes:
        reads: of all servos, tried.
        lost: of those, without an answer or with a damaged one.
        late: answers that came after their question was given up.
        late_by: the latest of them, after its question [s].
        round_trip: from the question to all servos to the last byte of their answer, median of the last second [s].
        round_trip_max: the longest of them [s].
        phase: of the driver, in words.
        load: of each servo, of its stall torque [-]; signed as the servo reports it.
    """

    reads: Annotated[int, Field(ge=0)]
    lost: Annotated[int, Field(ge=0)]
    late: Annotated[int, Field(ge=0)]
    late_by: Annotated[float, Field(ge=0.0)]
    round_trip: Annotated[float, Field(ge=0.0)]
    round_trip_max: Annotated[float, Field(ge=0.0)]
    phase: str
    load: PerTendon


class SimulatorTruth(Message):
    """What the simulated rod really does; nobody's input, only logged and plotted.

    Attributes:
        position: of the tip [m].
        velocity: of the tip [m/s].
        displacement: of each tendon [m].
        tension: in each tendon [N].
        tip_force: external, with the weight of what hangs on the tip but not its inertia, world frame [N].
    """

    position: Vector3
    velocity: Vector3
    displacement: PerTendon
    tension: PerTendon
    tip_force: Vector3


class LoopHealth(Schema):
    """Of the fixed-rate loop since its start.

    Attributes:
        cycles: done.
        missed_ticks: deadlines that passed before the loop was ready for them; skipped, never made up.
        cycle_ms_median, cycle_ms_p99: time from wake-up to command [ms], over the last seconds; work done before the
            deadline is not in it.
        log_dropped: log entries that did not fit the recorder's queue.
        log_error: what ended the log, if anything did.
        log_days_left: until there is no room for logs, or the oldest are removed, as they have grown in the last days;
            none while that is not known.
    """

    cycles: int
    missed_ticks: int
    cycle_ms_median: float
    cycle_ms_p99: float
    log_dropped: int
    log_error: str = ""
    log_days_left: float | None = None


class Status(Message):
    """The controller's state, each second and on change.

    Attributes:
        rig: name.
        mode: see `Mode`.
        reason: of a fault, a refusal, or of the last change of mode.
        tick: of the cycle.
        law, feedback: in use.
        tip: as the controller sees it [m]; none before the first pose.
        target: of the reference [m].
        tension: commanded [N]; tension_estimate: that the actuators are estimated to apply, and the model is given [N].
        displacement: commanded [m].
        rejected: inputs dropped since the start, by reason.
        sources: publishers that are followed, by key, and others that were heard just now.
        refused: why no pose or message is used, in one line with the first malformed field; empty where all is used.
        loop: timing and log.
    """

    rig: str
    mode: Mode
    reason: str
    tick: int
    law: str
    feedback: str
    tip: Vector3 | None
    target: Vector3
    tension: PerTendon
    tension_estimate: PerTendon = ()
    displacement: PerTendon
    rejected: dict[str, int]
    sources: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    refused: str = ""
    loop: LoopHealth


class ControlAction(StrEnum):
    """What an operator can ask for; each is a queryable of its own, `<rig>/control/<action>`."""

    ARM = "arm"
    PROBE = "probe"
    STOP = "stop"
    RESET = "reset"
    STATUS = "status"
    REFERENCE = "reference"
    LAW = "law"


class ControlRequest(Schema):
    """A request by an operator.

    Attributes:
        action: what is asked for.
        law: to select, with the action `law`.
        reference: to set, with the action `reference`; its samples in it, not in a file.
        controller: identity of the controller that it is meant for, as its status has it; empty: of any.
        deadline_ns: time on that controller's monotonic clock [ns], the one of its status' `stamp_ns`, after which the
            sender has given up: the request is then refused. Without one, a request that may have waited for half a
            second is refused. A stop is carried out however late it comes.
    """

    REQUIRED: ClassVar[frozenset[str]] = frozenset({"version"})

    version: Literal[1] = SCHEMA_VERSION
    action: ControlAction
    law: Annotated[str, Field(max_length=64)] | None = None
    reference: ReferenceSection | None = None
    controller: Annotated[str, Field(max_length=64)] = ""
    deadline_ns: Annotated[int, Field(ge=0)] | None = None

    @model_validator(mode="after")
    def _fits(self) -> "ControlRequest":
        if (self.law is not None) != (self.action is ControlAction.LAW):
            raise ValueError("a law goes with the action 'law'")
        if (self.reference is not None) != (self.action is ControlAction.REFERENCE):
            raise ValueError("a reference goes with the action 'reference'")
        if self.reference is not None and self.reference.kind == "samples" and not self.reference.samples:
            raise ValueError("the samples are missing: a file's name means nothing to another process")
        return self


class ControlReply(Schema):
    """The answer: done, or why not.

    Attributes:
        done: the request was carried out.
        message: what was done, or why not, in one line.
        status: of the controller after it.
    """

    version: Literal[1] = SCHEMA_VERSION
    done: bool
    message: str
    status: Status | None = None
