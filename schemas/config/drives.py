"""[drives]: CiA 402 drives on a CAN bus, in place of Dynamixel servos; their limits are those of [servo]."""

from typing import Annotated, Literal

from pydantic import Field, field_validator

from tendond.schemas.base import Schema
from tendond.schemas.config.control import LimitsSection
from tendond.schemas.config.servo import ServoSection


class DrivesSection(Schema):
    """[drives]: CiA 402 drives on a CAN bus, in place of Dynamixel servos; their limits are those of [servo]."""

    interface: str = Field("socketcan", description="python-can's name of the CAN adapter's interface")
    channel: str = Field("can0", description="channel of the adapter: a network interface, a serial port")
    bitrate: Annotated[
        int,
        Field(ge=10_000, le=1_000_000, description="bit rate, where the driver sets it: not with socketcan [bit/s]"),
    ] = 1_000_000
    nodes: tuple[Annotated[int, Field(ge=1, le=127)], ...] = Field(
        (), description="node ids of the drives, in the order of the tendons; default: 1, 2, 3 and so on"
    )
    host_node: Annotated[int, Field(ge=1, le=127, description="node id of the driver, of which no drive may be")] = 127
    counts_per_turn: Annotated[
        int, Field(ge=16, le=2**24, description="counts of Position actual value in a turn of the spool")
    ]
    rated_torque: Annotated[
        float, Field(gt=0.0, le=1000.0, description="Motor rated torque (0x6076), at the spool: with the gear [N m]")
    ]
    torque_max: Annotated[
        float, Field(gt=0.0, le=3.0, description="largest Max torque (0x6072), as a fraction of the rated torque [-]")
    ] = 1.0
    current_max: Annotated[
        float,
        Field(
            ge=0.0, le=3.0, description="Max current (0x6073), as a fraction of the rated current [-]; 0: the drive's"
        ),
    ] = 0.0
    heartbeat: Annotated[
        float,
        Field(
            ge=0.02, le=2.0, description="time without a heartbeat of the driver after which a drive stops itself [s]"
        ),
    ] = 0.1
    reply_timeout: Annotated[
        float, Field(ge=0.001, le=0.1, description="time after SYNC within which all drives reply [s]")
    ] = 0.005
    enable_time: Annotated[
        float, Field(ge=0.05, le=5.0, description="time within which the drives switch their torque on or off [s]")
    ] = 1.0
    stop: Literal["release", "hold"] = Field(
        "release", description="what a drive does after its quick stop: no torque, or standing still with torque"
    )

    @field_validator("nodes")
    @classmethod
    def _different(cls, value: tuple[int, ...]) -> tuple[int, ...]:
        if len(set(value)) != len(value):
            raise ValueError("two tendons have the same drive")
        return value

    def node_ids(self, tendons: int) -> tuple[int, ...]:
        """Return the node id of each tendon's drive."""
        return self.nodes or tuple(range(1, tendons + 1))


def strongest_tension(drives: DrivesSection, servo: ServoSection) -> float:
    """Return the largest tension of a tendon by the drives' torque and the largest load [N]."""
    return min(drives.torque_max, servo.load_max) * drives.rated_torque / servo.spool_radius


def with_drive_limits(
    limits: LimitsSection, own: LimitsSection, drives: DrivesSection, servo: ServoSection
) -> LimitsSection:
    """Return the limits with those of the drives where none are set, and where the drives' are narrower.

    Args:
        limits: limits of the configuration.
        own: the same, with the robot's own rates.
        drives: [drives]. servo: [servo].
    """
    changes = {}
    if limits.displacement_rate == 0.0:
        changes["displacement_rate"] = min(own.displacement_rate, servo.displacement_rate)
    narrower = {
        "displacement_min": max(limits.displacement_min, servo.displacement_min),
        "displacement_max": min(limits.displacement_max, servo.displacement_max),
        "tension_max": min(limits.tension_max, strongest_tension(drives, servo)),
    }
    changes |= {name: value for name, value in narrower.items() if name not in limits.model_fields_set}
    return limits.model_copy(update=changes)


def drive_objections(
    drives: DrivesSection,
    servo: ServoSection | None,
    tendons: int,
    tension_max: float,
    displacements: tuple[float, float],
) -> list[str]:
    """List what the drives cannot meet.

    Args:
        drives: [drives].
        servo: [servo].
        tendons: number of the rod's tendons.
        tension_max: limits.tension_max [N].
        displacements: limits.displacement_min and displacement_max [m].
    """
    if servo is None:
        return ["[drives] needs [servo] with the limits of the driver: write [servo], with servo.spool_radius"]
    wrong = []
    nodes = drives.node_ids(tendons)
    if len(nodes) != tendons:
        wrong.append(f"drives.nodes has {len(nodes)} drives, but the rod has {tendons} tendons")
    if drives.host_node in nodes:
        wrong.append(f"drives.host_node = {drives.host_node} is the node id of a drive: write another")
    if drives.heartbeat < 3.0 * servo.period:
        wrong.append(
            f"drives.heartbeat = {drives.heartbeat:g} s must be at least three times servo.period ="
            f" {servo.period:g} s, or the drives stop between two cycles"
        )
    if drives.reply_timeout >= servo.period:
        wrong.append(
            f"drives.reply_timeout = {drives.reply_timeout:g} s must be below servo.period = {servo.period:g} s"
        )
    strongest = strongest_tension(drives, servo)
    if tension_max > strongest:
        wrong.append(
            f"limits.tension_max = {tension_max:g} N: drives.rated_torque, with the smaller of drives.torque_max and"
            f" servo.load_max, on a spool of {servo.spool_radius:g} m make {strongest:.1f} N"
        )
    low, high = displacements
    if low < servo.displacement_min or high > servo.displacement_max:
        wrong.append(
            f"limits.displacement_min and displacement_max, {low:g} to {high:g} m, are beyond those of [servo],"
            f" {servo.displacement_min:g} to {servo.displacement_max:g} m"
        )
    return wrong
