"""[servo]: Dynamixel bus, spools, and the servo driver's own limits."""

import math
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from tendond.schemas.assumed_rig import SERVO_RATE
from tendond.schemas.base import Schema
from tendond.schemas.config.ranges import NotNegative, Positive

BAUD_RATES = (9600, 57600, 115200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
RATED_VOLTS = 11.1
"""Voltage at which the manual gives stall torque and no-load speed, which are proportional to it [V]."""

STALL_TORQUE = 1.4
"""Stall torque of the XL430-W250-T at 11.1 V [N m] (ROBOTIS e-Manual)."""

NO_LOAD_SPEED = 57.0 * 2.0 * math.pi / 60.0
"""No-load speed of the XL430-W250-T at 11.1 V [rad/s] (ROBOTIS e-Manual)."""

VELOCITY_LIMIT = 265 * 0.229 * 2.0 * math.pi / 60.0
"""Factory value of the XL430-W250-T's Velocity Limit [rad/s] (ROBOTIS e-Manual); 'tendond servo setup' keeps it."""

WATCHDOG_UNIT = 0.02
"""Unit of the servo's Bus Watchdog [s]."""


class ServoSection(Schema):
    """[servo]: Dynamixel bus, spools, and the servo driver's own limits."""

    port: str = Field("/dev/ttyUSB0", description="serial port of the bus")
    baudrate: Literal[9600, 57600, 115200, 1000000, 2000000, 3000000, 4000000, 4500000] = Field(
        1_000_000, description="baud rate of the bus [bit/s]"
    )
    ids: tuple[Annotated[int, Field(ge=0, le=252)], ...] = Field(
        (), description="ids of the servos, in the order of the tendons; default: 1, 2, 3 and so on"
    )
    calibration: str = Field(
        "calibration.json", description="calibration file with zeros, signs and spools, relative to this file"
    )
    spool_radius: Annotated[float, Field(gt=0.0, le=0.2, description="radius of the spools before calibration [m]")] = (
        0.015
    )
    period: Annotated[float, Field(ge=0.002, le=0.1, description="period of the driver's cycle [s]")] = 0.01
    reply_timeout: Annotated[
        float, Field(ge=0.001, le=1.0, description="timeout of a servo's reply, beyond its time on the wire [s]")
    ] = 0.004
    fast_read: bool = Field(True, description="use Fast Sync Read; false for firmware without it")
    profile_velocity: Annotated[float, Field(gt=0.0, le=24.0, description="Profile Velocity of the servos [rad/s]")] = (
        5.9
    )
    profile_acceleration: Annotated[
        float, Field(ge=0.0, le=12000.0, description="Profile Acceleration of the servos [rad/s^2]; 0: no limit")
    ] = 200.0
    watchdog: Annotated[
        float,
        Field(
            ge=0.04, le=2.5, description="silence on the bus after which a servo stops by itself, its Bus Watchdog [s]"
        ),
    ] = 0.2
    displacement_min: Annotated[
        float, Field(le=0.0, ge=-1.0, description="smallest displacement of a tendon [m]")
    ] = -0.08
    displacement_max: Annotated[float, Field(ge=0.0, le=1.0, description="largest displacement of a tendon [m]")] = 0.08
    displacement_rate: Annotated[float, Field(gt=0.0, le=5.0, description="largest rate of the displacement [m/s]")] = (
        SERVO_RATE
    )
    load_max: Annotated[
        float, Field(gt=0.0, le=1.0, description="largest load of a servo, as a fraction of its stall torque [-]")
    ] = 0.7
    load_time: Annotated[float, Field(gt=0.0, le=10.0, description="time beyond load_max that is a fault [s]")] = 0.3
    tension_margin: Annotated[
        float,
        Field(
            ge=1.0,
            le=5.0,
            description="largest load of a servo, as a multiple of limits.tension_max, where load_max is not less"
            " [-]; the load"
            " is inferred from the motor's output and includes gears and friction",
        ),
    ] = 1.5
    following_error: Annotated[
        float, Field(gt=0.0, le=0.1, description="largest distance of a tendon from its goal [m]")
    ] = 0.01
    following_time: Annotated[
        float, Field(gt=0.0, le=10.0, description="time beyond following_error that is a fault [s]")
    ] = 0.3
    temperature_max: Annotated[
        float, Field(gt=0.0, le=80.0, description="largest temperature of a servo [degree Celsius]")
    ] = 68.0
    voltage_min: Annotated[float, Field(ge=6.0, le=14.0, description="smallest supply voltage [V]")] = 9.5
    voltage_max: Annotated[float, Field(ge=6.0, le=14.8, description="largest supply voltage [V]")] = 13.0
    command_timeout: Annotated[
        float, Field(ge=0.02, le=2.0, description="time without a command after which the goals are held [s]")
    ] = 0.1
    hold_time: Annotated[
        float,
        Field(ge=0.0, le=60.0, description="time for which the goals are held, before the driver stops sending [s]"),
    ] = 1.0
    silent_reads: Annotated[int, Field(ge=1, le=100, description="reads in a row without a reply that are a fault")] = 5
    fault_hold: Annotated[
        float, Field(ge=0.0, le=10.0, description="time for which all tendons stand still after a fault [s]")
    ] = 0.3
    release_rate: Annotated[
        float, Field(gt=0.0, le=1.0, description="rate at which the tendons are released [m/s]")
    ] = 0.05
    release_time: Annotated[
        float,
        Field(
            gt=0.0, le=10.0, description="duration of a release after which the torque is switched off in any case [s]"
        ),
    ] = 4.0
    home_window: Annotated[
        float,
        Field(
            gt=0.0,
            le=0.2,
            description="largest distance of a tendon from its zero at which the torque may be switched on [m]",
        ),
    ] = 0.01
    pretension_load: Annotated[
        float,
        Field(
            gt=0.0, le=0.5, description="load at which a tendon counts as taut, as a fraction of the stall torque [-]"
        ),
    ] = 0.06
    pretension_reach: NotNegative = Field(
        0.03, description="largest slack that is taken up in search of pretension_load [m]"
    )
    slow_rate: Positive = Field(0.01, description="rate of homing, pretension and calibration [m/s]")

    @field_validator("ids")
    @classmethod
    def _different(cls, value: tuple[int, ...]) -> tuple[int, ...]:
        if len(set(value)) != len(value):
            raise ValueError("two tendons have the same servo")
        return value

    @model_validator(mode="after")
    def _consistent(self) -> "ServoSection":
        if self.voltage_min >= self.voltage_max:
            raise ValueError("voltage_min must be below voltage_max")
        if self.watchdog < 2.0 * self.period:
            raise ValueError("watchdog must be at least two periods, or the servos stop between two cycles")
        if self.home_window > self.displacement_max:
            raise ValueError("home_window is above displacement_max")
        if objection := self.turn_objection(self.spool_radius, "spool_radius"):
            raise ValueError(objection)
        if self.profile_velocity > VELOCITY_LIMIT:
            raise ValueError(
                f"profile_velocity = {self.profile_velocity:g} rad/s is above the servos' Velocity Limit as 'tendond"
                f" servo setup' leaves it: {VELOCITY_LIMIT:.4g} rad/s"
            )
        return self

    def turn_objection(self, spool_radius: float, name: str) -> str:
        """Explain why a rebooted servo would not know where its tendon is; empty where it would.

        Args:
            spool_radius: spool radius of the spool [m].
            name: name of that radius, for the message.
        """
        turn = 2.0 * math.pi * spool_radius
        if self.home_window >= 0.5 * turn:
            return "home_window is half a turn of the spool or more: after power-up a servo knows no turns"
        for name_of, travel in (
            ("displacement_max", self.displacement_max),
            ("displacement_min", -self.displacement_min),
        ):
            if travel + self.home_window >= turn:
                sign = "-" if name_of.endswith("min") else ""
                return (
                    f"{name_of} = {sign}{travel:g} m and home_window = {self.home_window:g} m together are more than a"
                    f" turn of the spool, {turn:.4g} m at {name} = {spool_radius:g} m: a servo that is rebooted would"
                    " not know its turn; take a larger spool or a shorter travel"
                )
        return ""

    def servo_ids(self, tendons: int) -> tuple[int, ...]:
        """Return the id of each tendon's servo."""
        return self.ids or tuple(range(1, tendons + 1))


def fastest_rate(section: ServoSection) -> float:
    """Largest rate of a tendon that the servos can reach [m/s]: their own limit, their profile, the motor's speed."""
    return min(section.displacement_rate, min(section.profile_velocity, NO_LOAD_SPEED) * section.spool_radius)


def strongest_tension(section: ServoSection) -> float:
    """Largest tension that the servos may pull with [N]."""
    return STALL_TORQUE * section.load_max / section.spool_radius


def speed_line(section: ServoSection | None, volts: float) -> tuple[float, float]:
    """Return the tension at which a servo stands [N], and its tendon's speed without load [m/s], at a voltage [V].

    Both are proportional to the voltage (ROBOTIS e-Manual, XL430-W250, Performance Graph); zeros for 0 V, no limit.
    """
    radius = (section or ServoSection()).spool_radius
    share = volts / RATED_VOLTS
    return STALL_TORQUE * share / radius, NO_LOAD_SPEED * share * radius


def servo_objections(
    section: ServoSection,
    tendons: int,
    tension_max: float,
    displacement_rate: float,
    displacement_min: float,
    displacement_max: float,
) -> list[str]:
    """Name the controller's limits that the servos cannot meet, one line each.

    Args:
        section: [servo].
        tendons: tendons of the rod.
        tension_max: that of [limits] [N].
        displacement_rate: displacement rate of [limits] [m/s].
        displacement_min: displacement min of [limits] [m].
        displacement_max: displacement max of [limits] [m].
    """
    objections = []
    if section.ids and len(section.ids) != tendons:
        objections.append(f"servo.ids has {len(section.ids)} servos, rod.tendon_positions {tendons} tendons")
    strongest = strongest_tension(section)
    if tension_max > strongest:
        objections.append(
            f"limits.tension_max = {tension_max:g} N is more than the servos may pull: {STALL_TORQUE:g} N m stall "
            f"torque, servo.load_max of it, on servo.spool_radius make {strongest:.1f} N"
        )
    fastest = fastest_rate(section)
    if displacement_rate > fastest * (1.0 + 1e-9):
        objections.append(
            f"limits.displacement_rate = {displacement_rate:g} m/s is faster than the servos: {fastest:.4g} m/s by"
            " servo.displacement_rate, servo.profile_velocity and the manual's 57 rpm on servo.spool_radius"
        )
    for name, limit, own, outside in (
        ("min", displacement_min, section.displacement_min, displacement_min < section.displacement_min),
        ("max", displacement_max, section.displacement_max, displacement_max > section.displacement_max),
    ):
        if outside:
            objections.append(
                f"limits.displacement_{name} = {limit:g} m is outside servo.displacement_{name} = {own:g} m:"
                " the servo driver would take it for a fault"
            )
    return objections
