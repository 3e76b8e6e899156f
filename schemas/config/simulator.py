"""[simulator]: the plant, and how it differs from an ideal one; the defaults are ideal."""

from typing import Annotated, Literal

from pydantic import Field

from tendond.schemas.base import Schema, Vector3
from tendond.schemas.config.ranges import Fraction, NotNegative
from tendond.schemas.config.robot import RodSection


class SimulatedServos(Schema):
    """[simulator.servo]: between the command and the tendon's end."""

    rate: NotNegative = Field(0.0, description="[m/s]; 0: no limit; only where displacement drives")
    acceleration: NotNegative = Field(0.0, description="[m/s^2]; 0: no limit; only where displacement drives")
    lag: Annotated[float, Field(ge=0.0, le=1.0, description="[s]; time constant behind the profile")] = 0.0
    backlash: Annotated[float, Field(ge=0.0, le=0.05, description="[m]; lost when the direction changes")] = 0.0
    resolution: Annotated[float, Field(ge=0.0, le=0.01, description="[m]; smallest step; 0: none")] = 0.0
    friction: Annotated[float, Field(ge=0.0, le=1.0, description="[-]; coefficient of the tendons on the disks")] = 0.0


class SimulatedMocap(Schema):
    """[simulator.mocap]: between the tip and its published pose."""

    period: Annotated[float, Field(ge=0.0, le=0.1, description="[s]; between frames; 0: one each simulator.period")] = (
        0.0
    )
    latency: Annotated[float, Field(ge=0.0, le=0.5, description="[s]; from exposure to publication")] = 0.0
    jitter: Annotated[float, Field(ge=0.0, le=0.1, description="[s]; added to it, uniform from zero to this")] = 0.0
    noise: Annotated[float, Field(ge=0.0, le=0.05, description="[m]; of each coordinate, standard deviation")] = 0.0
    rotation_noise: Annotated[float, Field(ge=0.0, le=0.5, description="[rad]; about each axis, the same")] = 0.0
    dropout: Fraction = Field(0.0, description="probability that a frame is lost [-]")
    occlusion: Annotated[float, Field(ge=0.0, le=100.0, description="[1/s]; how often the tip is hidden")] = 0.0
    occlusion_time: Annotated[float, Field(ge=0.0, le=10.0, description="[s]; how long, on average")] = 0.05


class Impact(Schema):
    """[[simulator.impacts]]: a push against the rod."""

    time: NotNegative = Field(description="of simulated time at which it begins [s]")
    duration: Annotated[float, Field(gt=0.0, le=10.0, description="[s]")] = 0.01
    force: Vector3 = Field(description="world frame [N]")
    place: Fraction = Field(1.0, description="along the rod: 1 is the tip; elsewhere it is spread like a hand [-]")


class Weight(Schema):
    """[simulator.weight]: hung on the tip; a rigid body with the inertia of a brass ball of its mass."""

    mass: Annotated[float, Field(ge=0.0, le=10.0, description="[kg]")] = 0.0
    string: Annotated[float, Field(ge=0.0, le=10.0, description="[m]; it swings on; 0: fixed to the tip")] = 0.0
    force_only: bool = Field(False, description="a force along gravity without inertia: an idealisation")
    time: NotNegative = Field(0.0, description="of simulated time at which it is hung on [s]")


class SimulatorSection(Schema):
    """[simulator]"""

    period: Annotated[float, Field(ge=0.0001, le=0.1, description="between poses, and time step of the plant [s]")] = (
        0.01
    )
    rod: RodSection = Field(RodSection(), description="the plant's own parameters")
    drive: Literal["tension", "displacement"] = Field(
        "tension",
        description="tension: ideal, as in the paper; displacement: tendons are elastic strings wound by servos",
    )
    weight: Weight = Weight()
    impacts: tuple[Impact, ...] = Field((), description="pushes against the rod")
    seed: Annotated[int, Field(ge=0)] = Field(0, description="of everything random: the same seed, the same run")
    servo: SimulatedServos = SimulatedServos()
    mocap: SimulatedMocap = SimulatedMocap()
