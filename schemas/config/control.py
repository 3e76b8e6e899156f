"""[loop], [control], [observer], [limits], [pretension], [faults]: how the robot is controlled, within what bounds."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from tendond.schemas.base import Schema
from tendond.schemas.config.ranges import NotNegative, Positive


class LoopSection(Schema):
    """[loop]"""

    period: Annotated[float, Field(ge=0.001, le=0.1, description="of the cycle, and time step of the model [s]")] = 0.01
    priority: Annotated[
        int, Field(ge=0, le=98, description="first-in-first-out priority of the loop, where permitted; 0: none")
    ] = 50
    cpu: Annotated[int, Field(ge=0, le=4095)] | None = Field(
        None, description="to which the loop is bound; left out: any"
    )
    rehearse: bool = Field(True, description="work out each cycle just before its deadline; anew if more comes in")
    lock_memory: bool = Field(True, description="keep the process in memory, where permitted")


class ControlSection(Schema):
    """[control]: the law, what feeds it, and the laws' own parameters in tables of their names."""

    law: str = Field("backstepping", description="name of a registered law")
    feedback: Literal["observer", "direct"] = Field(
        "observer",
        description="observer: velocity and acceleration of the model; direct: differences of the measured tip",
    )
    plane: Literal["xz", "yz"] = Field("xz", description="in which the robot bends")
    agonist: Annotated[int, Field(ge=0, le=15, description="index of the tendon that bends towards +x (or +y)")] = 0
    antagonist: Annotated[int, Field(ge=0, le=15)] | None = Field(
        None, description="index of the opposing tendon; left out: the law pulls one tendon only"
    )
    sampled: bool = Field(
        True,
        description="no more tension than takes a velocity error away in one cycle; false: the law as it is written",
    )
    laws: dict[str, dict[str, float]] = Field(
        {}, description="parameters of laws: [control.laws.backstepping] alpha1, alpha2 and so on"
    )


class ObserverSection(Schema):
    """[observer]: how the model is held to the measured tip, and what is known of delays."""

    kind: Literal["force", "offset"] = Field(
        "force", description="force: what the model misses is a force on its tip; offset: it is added to its tip"
    )
    delay: Annotated[float, Field(ge=0.0, le=0.5, description="age of a pose when it arrives [s]")] = 0.0
    lag: Annotated[float, Field(ge=0.0, le=1.0, description="time constant of the actuators [s]")] = 0.0
    tip_mass_max: NotNegative | None = Field(
        None,
        description="on the tip, unknown to the model, that the gains must bear [kg]; none: by the rod's stiffness",
    )
    integral: Annotated[
        float, Field(ge=0.0, le=100.0, description="largest gain of the estimated force [1/s]; the margin lowers it")
    ] = 5.0
    proportional: Annotated[
        float, Field(ge=0.0, le=5.0, description="largest gain that pulls the model's motion [-]; lowered likewise")
    ] = 0.6
    derivative: Annotated[float, Field(ge=0.0, le=1.0, description="largest gain of the same [s]; likewise")] = 0.1
    quiet: Annotated[float, Field(gt=0.0, le=1.0)] | None = Field(
        None, description="a smaller mean innovation is held for noise [m]; none: 0.0018 of the rod's length"
    )
    quiet_time: Annotated[float, Field(gt=0.0, le=10.0, description="over which that mean is taken [s]")] = 0.07
    quiet_share: Annotated[float, Field(gt=0.0, le=1.0, description="of the gains that is left for noise [-]")] = 0.5
    force_max: Annotated[float, Field(gt=0.0, le=1000.0)] | None = Field(
        None, description="bound of the estimated force [N]; none: by the rod's stiffness and weight"
    )
    offset_gain: Annotated[float, Field(gt=0.0, le=1.0, description="low-pass of kind 'offset', per cycle [-]")] = 0.2


class LimitsSection(Schema):
    """[limits]: of every command; the servo driver checks its own again."""

    tension_min: NotNegative = Field(0.0, description="[N]")
    tension_max: Annotated[float, Field(gt=0.0, le=500.0, description="[N]")] = 60.0
    tension_rate: NotNegative = Field(
        0.0,
        description="[N/s]; 0: the robot's own, twice what its first natural frequency can follow",
    )
    displacement_min: Annotated[float, Field(le=0.0, ge=-1.0, description="[m]")] = -0.12
    displacement_max: Annotated[float, Field(ge=0.0, le=1.0, description="[m]")] = 0.12
    displacement_rate: NotNegative = Field(0.0, description="[m/s]; 0: the robot's own, as for tension_rate")
    input_gain_min: Annotated[float, Field(gt=0.0, le=1e3)] = Field(
        1.0, description="b_c vanishes as the rod straightens; below this it has no direction [m/s^2/N]"
    )
    slack: Annotated[float, Field(ge=0.0, le=0.05)] = Field(
        0.0, description="by which a tendon without tension is let out beyond the model's length [m]"
    )
    release_rate: Positive = Field(60.0, description="of the tension while it is released [N/s]")
    limit_time: Positive = Field(1.0, description="[s]; a command that stands at a limit for so long is a fault")

    @model_validator(mode="after")
    def _ordered(self) -> "LimitsSection":
        if self.tension_min >= self.tension_max:
            raise ValueError("tension_min must be below tension_max")
        return self


class PretensionSection(Schema):
    """[pretension]: what the agonist is brought to between arming and tracking."""

    tension: NotNegative = Field(0.5, description="[N]; a straight rod gives the laws nothing to pull with")
    antagonist: NotNegative = Field(
        0.0, description="least tension of both tendons of the pair while the law pulls, where there is a pair [N]"
    )
    least: NotNegative = Field(
        1.0, description="least tension of every tendon under a law that moves the tip in space [N]"
    )
    duration: Annotated[float, Field(ge=0.0, le=60.0, description="[s]")] = 0.2


class FaultsSection(Schema):
    """[faults]: how much is borne before the arm is released."""

    pose_timeout: Annotated[
        float, Field(gt=0.0, le=10.0, description="[s]; without a new pose for longer, the observer gives up")
    ] = 0.2
    rejected_time: Positive = Field(0.2, description="[s]; of poses that are all rejected")
    tip_speed_max: Positive = Field(
        20.0, description="a pose that implies more is a teleport; 10 N fling the paper's robot at 17 m/s [m/s]"
    )
    teleport_margin: NotNegative = Field(0.02, description="that a pose may jump beyond it [m]")
    teleport_time: Positive = Field(0.05, description="[s]; from the first to the newest of such poses in a row")
    solver_timeout: NotNegative = Field(0.05, description="[s]; that the last good model state is kept")
    overrun_time: Positive = Field(0.1, description="[s]; of deadlines missed in a row")
    tendon_timeout: Annotated[
        float, Field(gt=0.0, le=60.0, description="[s]; without a tendon state, once there has been one")
    ] = 0.5
    frozen_time: Positive = Field(0.2, description="[s]; of new poses that are all equal to the last bit")
    source_time: Positive = Field(
        1.0, description="[s]; another publisher or controller that is silent for longer is gone"
    )
    equal_way: Positive = Field(0.01, description="that the model's tip goes meanwhile, for them to be a fault [m]")
    mismatch: Annotated[
        float, Field(gt=0.0, description="distance of model and measured tip, as a part of the rod's length [-]")
    ] = 0.3
    mismatch_time: Positive = Field(1.0, description="[s]; at more than it is a fault")
    slack_part: Annotated[float, Field(ge=0.0, le=1.0)] = Field(
        0.2, description="of the model's tension; a tendon that reports less does not pull; 0: not watched [-]"
    )
    slack_tension: Positive = Field(5.0, description="of the model, from which on a tendon is watched for that [N]")
    slack_time: Positive = Field(0.2, description="[s]; of reports without pull that are a fault")
    tracking_error: Positive = Field(
        0.07, description="distance of the tip from a reference that rests, as a part of the rod's length [-]"
    )
    tracking_time: Positive = Field(1.5, description="[s]; at more than it is a fault")
    swing: Positive = Field(0.01, description="of the tip that does not die down, as a part of the rod's length [-]")
    tension_swing: Positive = Field(0.15, description="of a command that does not, as a part of limits.tension_max [-]")
    orientation: Positive = Field(
        0.8, description="between the measured tip and the model's in the same place [rad]; not with orientation 3.2"
    )
    orientation_time: Positive = Field(1.0, description="[s]; at more than it is a fault")
    jump: Positive = Field(0.02, description="of a resting tip between two poses, as a part of the rod's length [-]")
    load_margin: Positive = Field(
        0.25, description="of limits.tension_max, by which a report may be above it, or above twice the model's [-]"
    )
    report_time: Positive = Field(
        0.1, description="[s]; of reports beyond that, or far beyond the displacement's range"
    )
    pose_age: Positive = Field(0.05, description="[s]; by which a pose may be older than observer.delay, by its stamp")
    age_time: Positive = Field(0.2, description="[s]; of poses that are all older")
