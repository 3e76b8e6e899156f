"""[simulator]: the simulated plant; the defaults are ideal."""

from typing import Annotated, Literal

from pydantic import Field

from tendond.schemas.base import Schema, Vector3
from tendond.schemas.config.ranges import Fraction, NotNegative, Voltage
from tendond.schemas.config.robot import RodSection


class SimulatedServos(Schema):
    """[simulator.servo]: dynamics between the command and the tendon's end."""

    rate: NotNegative = Field(0.0, description="largest rate [m/s]; 0: no limit; only with drive 'displacement'")
    acceleration: NotNegative = Field(
        0.0, description="largest acceleration [m/s^2]; 0: no limit; only with drive 'displacement'"
    )
    lag: Annotated[float, Field(ge=0.0, le=1.0, description="time constant behind the profile [s]")] = 0.0
    backlash: Annotated[float, Field(ge=0.0, le=0.05, description="backlash, lost when the direction changes [m]")] = (
        0.0
    )
    voltage: Voltage = Field(
        0.0,
        description="supply voltage of an XL430 on servo.spool_radius, which a load slows down and stalls [V]; 0:"
        " none does; only with drive 'displacement'",
    )
    resolution: Annotated[float, Field(ge=0.0, le=0.01, description="smallest step [m]; 0: continuous")] = 0.0
    friction: Annotated[
        float,
        Field(
            ge=0.0,
            le=1.0,
            description="coefficient of friction on their guides, of tendons to which simulator.rod gives none [-]",
        ),
    ] = 0.0


class SimulatedMocap(Schema):
    """[simulator.mocap]: errors between the tip and its published pose."""

    period: Annotated[
        float, Field(ge=0.0, le=0.1, description="period of the frames [s]; 0: one each simulator.period")
    ] = 0.0
    latency: Annotated[float, Field(ge=0.0, le=0.5, description="delay from exposure to publication [s]")] = 0.0
    jitter: Annotated[
        float, Field(ge=0.0, le=0.1, description="largest delay added to latency, uniform from zero [s]")
    ] = 0.0
    noise: Annotated[float, Field(ge=0.0, le=0.05, description="standard deviation of each coordinate [m]")] = 0.0
    rotation_noise: Annotated[
        float, Field(ge=0.0, le=0.5, description="standard deviation of the rotation about each axis [rad]")
    ] = 0.0
    dropout: Fraction = Field(0.0, description="probability that a frame is lost [-]")
    occlusion: Annotated[float, Field(ge=0.0, le=100.0, description="rate of occlusions of the tip [1/s]")] = 0.0
    occlusion_time: Annotated[float, Field(ge=0.0, le=10.0, description="mean duration of an occlusion [s]")] = 0.05


class Impact(Schema):
    """[[simulator.impacts]]: a push against the rod."""

    time: NotNegative = Field(description="simulated time at which it begins [s]")
    duration: Annotated[float, Field(gt=0.0, le=10.0, description="duration of the push [s]")] = 0.01
    force: Vector3 = Field(description="force in the base's frame [N]")
    place: Fraction = Field(
        1.0,
        description="position along the rod, as a fraction of its length [-]; 1: the tip; elsewhere the force is"
        " spread over a hand's"
        " width",
    )


class Weight(Schema):
    """[simulator.weight]: a weight on the tip, a rigid body with the inertia of a brass ball."""

    mass: Annotated[float, Field(ge=0.0, le=10.0, description="mass of the weight [kg]")] = 0.0
    string: Annotated[
        float, Field(ge=0.0, le=10.0, description="length of the string on which it swings [m]; 0: fixed to the tip")
    ] = 0.0
    force_only: bool = Field(False, description="apply its force along gravity without its inertia, an idealisation")
    time: NotNegative = Field(0.0, description="simulated time at which it is attached [s]")


class SimulatorSection(Schema):
    """[simulator]: the simulated plant; the defaults are ideal."""

    period: Annotated[
        float, Field(ge=0.0001, le=0.1, description="period of the poses, and time step of the plant [s]")
    ] = 0.01
    rod: RodSection = Field(RodSection(), description="the plant's own parameters")
    solver: Literal["shooting", "general", "mujoco"] | None = Field(
        None,
        description="rod of the plant; shooting: the paper's; general: sections, any routing, light damping,"
        " friction of tendons; mujoco: a chain of links in MuJoCo, which shares no mechanics with the controller's"
        " model (extra mujoco); default: shooting where it describes the robot, its damping ratio is 5 % or more,"
        " it hardly sags by its weight, and nothing rubs",
    )
    drive: Literal["tension", "displacement"] = Field(
        "tension",
        description="quantity that the servos impose; tension: ideal, as in the paper; displacement: of elastic"
        " tendons",
    )
    weight: Weight = Weight()
    impacts: tuple[Impact, ...] = Field((), description="pushes against the rod")
    seed: Annotated[int, Field(ge=0)] = Field(
        0, description="seed of the random numbers: the same seed gives the same run"
    )
    servo: SimulatedServos = SimulatedServos()
    mocap: SimulatedMocap = SimulatedMocap()
