"""[servo]: Dynamixel bus, spools, and the servo driver's own limits."""

import math
from collections.abc import Mapping
from typing import Annotated, Any, Literal

from pydantic import Field, field_validator, model_validator

from tendond.schemas.assumed_rig import SERVO_RATE
from tendond.schemas.base import Schema
from tendond.schemas.config.ranges import NotNegative, Positive
from tendond.schemas.motors import MOTORS, XL430_W250, Motor

BAUD_RATES = (9600, 57600, 115200, 1_000_000, 2_000_000, 3_000_000, 4_000_000, 4_500_000)
WATCHDOG_UNIT = 0.02
"""Unit of the servo's Bus Watchdog [s]."""


RADIUS = 0.015
"""Default radius of the spools [m]."""

PROFILE_SHARE = 5.9 / XL430_W250.velocity_limit
"""Default profile velocity, as a fraction of the factory's Velocity Limit: that of the XL430's default."""

HEAT_MARGIN = 4.0
"""Degrees by which the default temperature_max is below the factory's Temperature Limit."""


def _defaults(motor: Motor, radius: float) -> dict[str, float]:
    """Return the defaults that depend on the model; those of the XL430 are in the fields.

    Args:
        motor: ratings of the model.
        radius: of the spools [m].
    """
    low, high = motor.voltage
    velocity = math.floor(100.0 * PROFILE_SHARE * motor.velocity_limit) / 100.0
    return {
        "profile_velocity": velocity,
        "displacement_rate": min(SERVO_RATE, math.floor(1e3 * radius * min(velocity, motor.no_load_speed)) / 1e3),
        "profile_acceleration": min(200.0, math.floor(10.0 * motor.acceleration_limit) / 10.0)
        if math.isfinite(motor.acceleration_limit)
        else 200.0,
        "temperature_max": motor.temperature_limit - HEAT_MARGIN,
        "voltage_min": max(low, 0.85 * motor.rated_volts),
        "voltage_max": min(high, 1.2 * motor.rated_volts),
    }


class ServoSection(Schema):
    """[servo]: Dynamixel bus, spools, and the servo driver's own limits."""

    model: Literal[
        "XL430-W250-T",
        "XL330-M077",
        "XL330-M288",
        "XC330-M288",
        "XC330-T288",
        "XC430-W150",
        "XC430-W240",
        "XM430-W210",
        "XM430-W350",
        "XM540-W150",
        "XM540-W270",
        "PH42-020-S300",
        "PH54-100-S500",
    ] = Field(
        "XL430-W250-T",
        description="model of the servos, all of one; profile_velocity, profile_acceleration, displacement_rate,"
        " temperature_max, voltage_min and voltage_max have other defaults for others",
    )
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
        RADIUS
    )
    period: Annotated[float, Field(ge=0.002, le=0.1, description="period of the driver's cycle [s]")] = 0.01
    reply_timeout: Annotated[
        float, Field(ge=0.001, le=1.0, description="timeout of a servo's reply, beyond its time on the wire [s]")
    ] = 0.004
    fast_read: bool = Field(True, description="use Fast Sync Read; false for firmware without it")
    profile_velocity: Annotated[float, Field(gt=0.0, le=50.0, description="Profile Velocity of the servos [rad/s]")] = (
        5.9
    )
    profile_acceleration: Annotated[
        float, Field(ge=0.0, le=12000.0, description="Profile Acceleration of the servos [rad/s^2]; 0: no limit")
    ] = 200.0
    current_limit: Annotated[
        float,
        Field(
            ge=0.0,
            le=20.0,
            description="largest current of a servo, its Goal Current [A]: an X series servo that has it is then in"
            " Current-based Position Control Mode; 0: none, the P series has its largest load's in any case",
        ),
    ] = 0.0
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
    voltage_min: Annotated[float, Field(ge=3.0, le=35.0, description="smallest supply voltage [V]")] = 9.5
    voltage_max: Annotated[float, Field(ge=3.0, le=35.0, description="largest supply voltage [V]")] = 13.0
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

    @model_validator(mode="before")
    @classmethod
    def _of_model(cls, values: Any) -> Any:
        """Fill in the defaults of another model than the XL430."""
        motor = MOTORS.get(values.get("model", "")) if isinstance(values, Mapping) else None
        if motor is None or motor is XL430_W250:
            return values
        radius = values.get("spool_radius", RADIUS)
        usable = isinstance(radius, int | float) and 0.0 < radius <= 0.2  # else its own field says what is wrong
        return {**_defaults(motor, radius if usable else RADIUS), **values}

    @property
    def motor(self) -> Motor:
        """Ratings of the model."""
        return MOTORS[self.model]

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
        if objection := self._motor_objection():
            raise ValueError(objection)
        return self

    def _motor_objection(self) -> str:
        """Explain what the model cannot do; empty where it can."""
        motor = self.motor
        if self.profile_velocity > motor.velocity_limit:
            return (
                f"profile_velocity = {self.profile_velocity:g} rad/s is above the servos' Velocity Limit as 'tendond"
                f" servo setup' leaves it: {motor.velocity_limit:.4g} rad/s"
            )
        if self.profile_acceleration > motor.acceleration_limit:
            return (
                f"profile_acceleration = {self.profile_acceleration:g} rad/s^2 is above the Acceleration Limit of the"
                f" {motor.name} as 'tendond servo setup' leaves it: {motor.acceleration_limit:.4g} rad/s^2"
            )
        if self.baudrate > motor.baud_max:
            return f"baudrate = {self.baudrate}: the {motor.name} has at most {motor.baud_max} bit/s"
        low, high = motor.voltage
        if self.model != XL430_W250.name and not low <= self.voltage_min < self.voltage_max <= high:
            return (
                f"voltage_min = {self.voltage_min:g} V and voltage_max = {self.voltage_max:g} V: the {motor.name} has a"
                f" supply of {low:g} to {high:g} V"
            )
        if self.current_limit and not motor.limits_current:
            able = ", ".join(name for name, one in MOTORS.items() if one.limits_current)
            return f"current_limit: the {motor.name} does not measure its current; remove it, or use one of {able}"
        if self.current_limit > motor.current_max:
            return (
                f"current_limit = {self.current_limit:g} A is above the Current Limit of the {motor.name},"
                f" {motor.current_max:.4g} A"
            )
        return ""

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
