"""Messages on Zenoh: JSON, SI units, with schema version, sequence number and capture time."""

import math
from enum import StrEnum
from typing import Annotated, ClassVar, Literal, Self

from pydantic import Field, JsonValue, field_validator

from tendond.schemas.base import SCHEMA_VERSION, PerTendon, PerTendonOrNone, Quaternion, Schema, Vector3, is_empty
from tendond.schemas.health import FilterHealth, LoopHealth, SensorHealth

ENCODING = "application/json"
LARGEST_PAYLOAD = 65536
"""Largest accepted payload [bytes]; larger ones are dropped unread."""

QUATERNION_TOLERANCE = 1e-3
"""Largest deviation of a quaternion's norm from 1."""


class Mode(StrEnum):
    """Mode of the controller; `fault` lasts until the operator resets it."""

    STARTING = "starting"
    IDLE = "idle"
    PROBE = "probe"
    PRETENSION = "pretension"
    TRACKING = "tracking"
    RELEASING = "releasing"
    FAULT = "fault"


ACTIVE = (Mode.PROBE, Mode.PRETENSION, Mode.TRACKING)
"""Modes in which the controller asks for tension."""


class Message(Schema):
    """Fields common to all published messages.

    Attributes:
        version: version of the schema; another one is refused.
        seq: counts up by one per message of a publisher.
        stamp_ns: capture time [ns] on the publisher's monotonic clock; ages are taken on the receiver's.
        source: identity of the publisher for its run, for instance "vicon-3f9c2a"; empty: none. It distinguishes
            two publishers of one key.
    """

    REQUIRED: ClassVar[frozenset[str]] = frozenset({"version"})

    version: Literal[1] = SCHEMA_VERSION
    seq: Annotated[int, Field(ge=0)]
    stamp_ns: Annotated[int, Field(ge=0)]
    source: Annotated[str, Field(max_length=64, pattern=r"^[\w.:+-]*$")] = ""

    def stamped(self, stamp_ns: int) -> Self:
        """Return the message with another capture time [ns]."""
        return self.trusted(**{**self.__dict__, "stamp_ns": stamp_ns})

    def named(self, source: str) -> Self:
        """Return the message with the identity of its publisher."""
        return self.trusted(**{**self.__dict__, "source": source})


class TipPose(Message):
    """Pose of the tip in the base's frame, from a motion-capture driver or a simulator.

    Attributes:
        position: [m].
        orientation: unit quaternion w, x, y, z, body to base.
        valid: false while the tip is occluded; the pose is then the last valid one.
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
            raise ValueError(f"is not a unit quaternion (norm {norm:.6g})")
        return value


class TendonCommand(Message):
    """Command to the servos or the simulator.

    Attributes:
        pose_seq: sequence number of the newest pose that the controller had received; none before the first.
        displacement: displacement of each tendon from the straight robot, positive if pulled [m]; zero while disarmed.
        tension: expected by the model with it [N].
        armed: false: torque off, tendons slack.
    """

    pose_seq: int | None
    displacement: PerTendon
    tension: PerTendon
    armed: bool


class TendonState(Message):
    """Report of the servos or the simulator.

    Attributes:
        displacement: displacement of each tendon's end [m].
        tension: measured or estimated [N].
        fault: fault of a servo, in words; empty when there is none.
    """

    displacement: PerTendon
    tension: PerTendon
    fault: str = ""


class SensorReading(Message):
    """Reading of a sensor beside the pose, as `[[sensors]]` describes its rows.

    Attributes:
        rows: numbers of each place, in the order of the configuration, SI; null for one that is not seen.
    """

    rows: Annotated[tuple[Annotated[tuple[float, ...], Field(max_length=7)] | None, ...], Field(max_length=64)]


class ServoHealth(Message):
    """State of the servo driver and its serial bus, once a second; counts are since the driver's start.

    Attributes:
        reads: reads of all servos.
        lost: reads without a reply, or with a damaged one.
        late: replies that came after their timeout.
        late_by: largest delay of those, from the request [s].
        round_trip: time from the request to the last byte of the reply, median of the last second [s].
        round_trip_max: longest round trip of the last second [s].
        phase: phase of the driver, in words.
        load: load of each servo as a fraction of its stall torque [-]; signed as the servo reports it.
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
    """True state of the simulated rod; logged and plotted, never an input.

    Attributes:
        position: position of the tip [m].
        velocity: velocity of the tip [m/s].
        displacement: displacement of each tendon [m].
        tension: tension in each tendon [N].
        tip_force: external, with the weight of what hangs on the tip but not its inertia, in the base's frame [N].
        rod: keys of [simulator.rod] that describe the robot, once a second; left out of the others and of the log.
        injected: names of the loads and faults that act beside the robot's own weight, such as "impact"; left out
            where there are none.
    """

    position: Vector3
    velocity: Vector3
    displacement: PerTendon
    tension: PerTendon
    tip_force: Vector3
    rod: dict[str, JsonValue] = Field(default_factory=dict, exclude_if=is_empty)
    injected: Annotated[tuple[str, ...], Field(max_length=32, exclude_if=is_empty)] = ()


class TunedValue(Schema):
    """Value of a tuned key, in the key's unit.

    Attributes:
        value: in use. wanted: to which it moves. configured: of the configuration.
    """

    value: float
    wanted: float
    configured: float

    @property
    def in_words(self) -> str:
        """Describe it in a few words."""
        moving = "" if self.value == self.wanted else f", moves to {self.wanted:g}"
        return f"{self.value:g} (configured {self.configured:g}{moving})"


class Status(Message):
    """The controller's state, each second and on change.

    Attributes:
        rig: name.
        mode: see `Mode`.
        reason: reason of a fault, a refusal, or of the last change of mode.
        tick: index of the cycle.
        law, feedback: names of those in use.
        tip: measured position in use [m]; none before the first pose.
        target: target of the reference [m].
        tension: commanded [N]; tension_estimate: estimate of the applied tension, the model's input [N].
        tip_tension: the same where the tendons are fixed to the robot [N]; left out where none of the model rubs.
        displacement: commanded [m].
        rejected: inputs dropped since the start, by reason.
        sources: publishers in use, by key, and others that were received recently.
        sensors: readings of the configured sensors, by name; left out where there is none.
        filter: of an observer of kind 'kalman'; left out of others.
        safety: constraint of [safety] that alters the command in this cycle, and by how much; left out where none does.
        refused: reason why no pose or message is used, with the first malformed field; empty where all are used.
        tuned: tuned keys of the configuration; left out where all are as configured.
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
    tip_tension: PerTendonOrNone = Field((), exclude_if=is_empty)
    displacement: PerTendon
    rejected: dict[str, int]
    sources: dict[str, tuple[str, ...]] = Field(default_factory=dict)
    sensors: dict[str, SensorHealth] = Field(default_factory=dict, exclude_if=is_empty)
    filter: FilterHealth | None = Field(None, exclude_if=lambda value: value is None)
    safety: str = Field("", exclude_if=is_empty)
    refused: str = ""
    tuned: dict[str, TunedValue] = Field(default_factory=dict, exclude_if=is_empty)
    loop: LoopHealth
