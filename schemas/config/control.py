"""[loop], [control], [limits], [faults]: how the robot is controlled, and its limits."""

from typing import Annotated, Literal

from pydantic import Field, JsonValue, model_validator

from tendond.schemas.base import Schema
from tendond.schemas.config.ranges import NotNegative, Positive
from tendond.schemas.config.tunable import tunable, tunable_while_idle


class LoopSection(Schema):
    """[loop]: the fixed-rate loop of the controller."""

    period: Annotated[
        float, Field(ge=0.001, le=0.1, description="period of the cycle, and time step of the model [s]")
    ] = 0.01
    priority: Annotated[
        int, Field(ge=0, le=98, description="real-time priority of the loop (SCHED_FIFO), where permitted; 0: none")
    ] = 50
    cpu: Annotated[int, Field(ge=0, le=4095)] | None = Field(
        None, description="processor to which the loop is bound; default: any"
    )
    speculate: bool = Field(
        True, description="compute each cycle shortly before its deadline, and again if a message arrives after that"
    )
    phase_lock: bool = Field(
        True, description="move the phase of the loop, not its rate, to that of the poses: each is used as it arrives"
    )
    lock_memory: bool = Field(True, description="lock the process in memory, where permitted")


PLANES = {"xz": (0, 2), "yz": (1, 2)}
"""World axes of a bending plane: across the straight rod, and along it."""


class ControlSection(Schema):
    """[control]: the control law, its inputs, and the parameters of each law."""

    law: str = Field(
        "backstepping",
        description="name of a registered law; default: backstepping; sensitivity for a robot that would swing: of"
        " sections, lightly damped, or with a heavy tip",
    )
    solver: Literal["shooting", "general"] | None = Field(
        None,
        description="rod of the model; shooting: the paper's; general: sections, any routing, light damping; default:"
        " shooting where it describes the robot, its damping ratio is 5 % or more, and it hardly sags by its weight",
    )
    feedback: Literal["observer", "direct"] = Field(
        "observer",
        description="inputs of the law; observer: velocity and acceleration of the model; direct: differences of"
        " the measured tip",
    )
    plane: Literal["xz", "yz"] = Field("xz", description="plane in which the robot bends")
    agonist: Annotated[int, Field(ge=0, le=15, description="index of the tendon that bends towards +x (or +y)")] = 0
    antagonist: Annotated[int, Field(ge=0, le=15)] | None = Field(
        None, description="index of the opposing tendon; default: the law pulls one tendon only"
    )
    sampled: bool = Field(
        True,
        description="limit the tension to what removes a velocity error in one cycle; false: the law as published",
    )
    rules: Literal[1, 2] = Field(
        2,
        description="version of what follows from a configuration by itself; 1: targets and gains as in logs that were"
        " recorded before there was this key",
    )
    laws: dict[str, dict[str, JsonValue]] = Field(
        {}, description="parameters by law, for instance alpha1 and alpha2 in [control.laws.backstepping]"
    )


LIMIT_RATE = 0.2
"""Largest relative rate of a limit's change while armed [1/s]: 12 N/s of the default tension_max, a fifth of the
rate at which tendons are released: a lowered limit takes the command down more slowly than a stop does."""


class LimitsSection(Schema):
    """[limits]: limits of every command; the servo driver checks its own as well."""

    tension_min: NotNegative = Field(0.0, description="smallest tension of a tendon that the law pulls [N]")
    tension_max: Annotated[
        float,
        Field(
            gt=0.0,
            le=500.0,
            description="largest tension of a tendon [N]; default with [servo]: no more than servo.load_max",
            json_schema_extra=tunable(LIMIT_RATE, lower_only=True),
        ),
    ] = 60.0
    tension_rate: NotNegative = Field(
        0.0,
        description="largest rate of the tension [N/s]; 0: derived, twice what the rod's first natural frequency"
        " can follow",
        json_schema_extra=tunable(LIMIT_RATE, lower_only=True),
    )
    displacement_min: Annotated[
        float,
        Field(
            le=0.0,
            ge=-1.0,
            description="smallest displacement of a tendon [m]; default with [servo]: within servo.displacement_min",
        ),
    ] = -0.12
    displacement_max: Annotated[
        float,
        Field(
            ge=0.0,
            le=1.0,
            description="largest displacement of a tendon [m]; default with [servo]: within servo.displacement_max",
            json_schema_extra=tunable_while_idle(lower_only=True),
        ),
    ] = 0.12
    displacement_rate: NotNegative = Field(
        0.0,
        description="largest rate of the displacement [m/s]; 0: derived, as tension_rate; with [servo] no faster than"
        " the servos",
        json_schema_extra=tunable(LIMIT_RATE, lower_only=True),
    )
    input_gain_min: Annotated[float, Field(gt=0.0, le=1e3)] = Field(
        1.0,
        description="smallest input gain b_c that the laws divide by [m/s^2/N]; b_c vanishes as the rod straightens",
    )
    slack: Annotated[float, Field(ge=0.0, le=0.05)] = Field(
        0.0,
        description="extra length given to a tendon without tension, beyond the model's [m]",
        json_schema_extra=tunable_while_idle(),
    )
    release_rate: Positive = Field(60.0, description="rate at which the tension is released [N/s]")
    limit_time: Positive = Field(1.0, description="time at a limit after which the command is a fault [s]")

    @model_validator(mode="after")
    def _ordered(self) -> "LimitsSection":
        if self.tension_min >= self.tension_max:
            raise ValueError("tension_min must be below tension_max")
        return self


class FaultsSection(Schema):
    """[faults]: thresholds and times beyond which the tendons are released."""

    pose_timeout: Annotated[
        float, Field(gt=0.0, le=10.0, description="time without a new pose that is a fault [s]")
    ] = 0.2
    rejected_time: Positive = Field(0.2, description="time in which all poses are rejected that is a fault [s]")
    tip_speed_max: Positive = Field(
        20.0,
        description="largest speed of the tip between two poses [m/s]; more is a teleport: a push of 10 N moves"
        " the paper's robot at 17 m/s",
    )
    teleport_margin: NotNegative = Field(0.02, description="allowed jump of a pose beyond tip_speed_max [m]")
    teleport_time: Positive = Field(0.05, description="time of successive teleports that is a fault [s]")
    solver_timeout: NotNegative = Field(
        0.05, description="time without a solution of the model that is a fault [s]; the last state is kept until then"
    )
    overrun_time: Positive = Field(0.1, description="time of deadlines missed in a row that is a fault [s]")
    tendon_timeout: Annotated[
        float,
        Field(gt=0.0, le=60.0, description="time without a tendon state, after the first one, that is a fault [s]"),
    ] = 0.5
    frozen_time: Positive = Field(0.2, description="time of new poses equal to the last bit that is a fault [s]")
    source_time: Positive = Field(
        1.0, description="silence after which another publisher or controller counts as gone [s]"
    )
    frozen_distance: Positive = Field(
        0.01, description="distance travelled by the model's tip meanwhile, for equal poses to be a fault [m]"
    )
    mismatch: Annotated[
        float,
        Field(gt=0.0, description="largest distance of model and measured tip, as a fraction of the rod's length [-]"),
    ] = 0.3
    mismatch_time: Positive = Field(1.0, description="time beyond mismatch that is a fault [s]")
    inconsistency: Positive = Field(
        25.0,
        description="largest mean square, over a second, of what is measured beside what an observer of kind 'kalman'"
        " expects, in units of its own spread [-]; 1 is right",
    )
    slack_fraction: Annotated[float, Field(ge=0.0, le=1.0)] = Field(
        0.2, description="smallest reported tension of a tendon, as a fraction of the model's [-]; 0: not monitored"
    )
    slack_tension: Positive = Field(5.0, description="tension of the model above which slack_fraction is monitored [N]")
    slack_time: Positive = Field(0.2, description="time below slack_fraction that is a fault [s]")
    tracking_error: Positive = Field(
        0.07, description="largest distance of the tip from a resting reference, as a fraction of the rod's length [-]"
    )
    tracking_time: Positive = Field(1.5, description="time beyond tracking_error that is a fault [s]")
    swing: Positive = Field(
        0.01,
        description="amplitude of a sustained oscillation of the tip that is a fault, as a fraction of the rod's"
        " length [-]",
    )
    tension_swing: Positive = Field(
        0.15,
        description="amplitude of a sustained oscillation of the command that is a fault, as a fraction of"
        " limits.tension_max [-]",
    )
    orientation: Positive = Field(
        0.8,
        description="largest angle between the measured tip and the model's at the same position [rad]; not"
        " monitored where commissioning.orientation is 3.2",
    )
    orientation_time: Positive = Field(1.0, description="time beyond orientation that is a fault [s]")
    jump: Positive = Field(
        0.02, description="largest jump of a resting tip between two poses, as a fraction of the rod's length [-]"
    )
    load_margin: Positive = Field(
        0.25,
        description="allowed excess of a reported tension over limits.tension_max, or over twice the model's, as a"
        " fraction of limits.tension_max [-]",
    )
    report_time: Positive = Field(
        0.1,
        description="time of reports beyond load_margin, or far beyond the displacement limits, that is a fault [s]",
    )
    pose_age: Positive = Field(0.05, description="largest age of a pose beyond observer.delay, by its stamp [s]")
    age_time: Positive = Field(0.2, description="time of poses that are all older that is a fault [s]")
