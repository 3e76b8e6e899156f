"""[observer]: correction of the model by the measured tip, the drive's delays, and a learned correction."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from tendond.schemas.base import Schema, Vector3
from tendond.schemas.config.ranges import NotNegative, Voltage


class ResidualSection(Schema):
    """[observer.residual]: a learned correction of the model's tip; `tendond identify --residual` writes it."""

    degree: Annotated[int, Field(ge=1, le=4, description="of the products of displacements among the features")]
    width: Annotated[float, Field(gt=0.0, le=0.1, description="half-width of the play that decides on the sides [m]")]
    features: tuple[str, ...] = Field(description="names: 1, c0, c0*c1, ... of normalised displacements; side0, ...")
    coefficients: tuple[Vector3, ...] = Field(description="x, y, z of the correction for each feature [m]")
    low: tuple[float, ...] = Field(description="smallest displacement of each tendon that it was learned from [m]")
    high: tuple[float, ...] = Field(description="largest displacement likewise [m]; beyond, the correction fades out")
    bound: Annotated[float, Field(ge=0.0, le=0.1, description="largest length of the correction [m]")]

    @model_validator(mode="after")
    def _sizes(self) -> "ResidualSection":
        if len(self.features) != len(self.coefficients):
            raise ValueError(f"coefficients: {len(self.coefficients)} rows for {len(self.features)} features")
        if len(self.low) != len(self.high):
            raise ValueError(f"high: {len(self.high)} numbers, low has {len(self.low)}")
        return self


class ObserverSection(Schema):
    """[observer]: correction of the model by the measured tip, and the configured delays."""

    kind: Literal["force", "kalman", "offset"] = Field(
        "force",
        description="correction of the model; force: an estimated force on its tip, by fixed gains; kalman: a filter of"
        " the general rod's whole state, its load and its drive, by noise; offset: an estimated offset of its tip",
    )
    pose_noise: Annotated[
        float, Field(gt=0.0, le=0.1, description="standard deviation of each coordinate of a measured tip [m]; kalman")
    ] = 1e-4
    orientation_noise: Annotated[
        float,
        Field(
            ge=0.0,
            le=1.0,
            description="standard deviation of its orientation about each axis [rad], with what its marker body may be"
            " turned by; 0: it is not used; kalman",
        ),
    ] = 0.01
    tension_error: Annotated[
        float,
        Field(gt=0.0, le=1.0, description="standard deviation of a tendon's tension, of that in the model [-]; kalman"),
    ] = 0.1
    tension_error_time: Annotated[
        float, Field(gt=0.0, le=3600.0, description="time over which these errors change [s]; kalman")
    ] = 3.0
    stiffness_error: Annotated[
        float,
        Field(
            ge=0.0,
            le=0.5,
            description="standard deviation of the robot's stiffness, of that configured [-]; 0: known; kalman",
        ),
    ] = 0.1
    tip_mass_error: NotNegative = Field(
        0.0, description="standard deviation of the mass on the tip, of that configured [kg]; 0: known; kalman"
    )
    delay: Annotated[float, Field(ge=0.0, le=0.5, description="age of a pose when it arrives [s]")] = 0.0
    stamps: bool = Field(
        False,
        description="take a pose's age from its stamp, where that is of this host's clock: a late one is compared with"
        " the model of its own time; false: its age is delay",
    )
    lag: Annotated[float, Field(ge=0.0, le=1.0, description="time constant of the actuators [s]")] = 0.0
    command_delay: Annotated[
        float,
        Field(
            ge=0.0, le=0.2, description="dead time from a command to the motion of the actuators, and a short lag [s]"
        ),
    ] = 0.0
    servo_acceleration: NotNegative = Field(
        0.0,
        description="acceleration of the servos' profile, as that of a tendon [m/s^2]; 0: none; by [servo]:"
        " profile_acceleration times spool_radius",
    )
    backlash: Annotated[
        float, Field(ge=0.0, le=0.05, description="travel of a tendon that is lost when its servo reverses [m]")
    ] = 0.0
    servo_voltage: Voltage = Field(
        0.0,
        description="supply voltage of XL430 servos on servo.spool_radius: commands and references in space pull no"
        " faster than the tension leaves them speed [V]; 0: no load counts",
    )
    contact: bool = Field(
        False,
        description="search for contacts anywhere along the body: their place and force are recorded, and act on the"
        " model; kalman",
    )
    tip_mass_max: NotNegative | None = Field(
        None,
        description="largest unknown mass on the tip for which the gains are stable [kg]; default: from the rod's"
        " stiffness",
    )
    integral: Annotated[
        float,
        Field(
            ge=0.0,
            le=100.0,
            description="largest integral gain of the estimated force [1/s]; lowered to keep the stability margin",
        ),
    ] = 5.0
    proportional: Annotated[
        float,
        Field(ge=0.0, le=5.0, description="largest proportional gain on the model's motion [-]; lowered likewise"),
    ] = 0.6
    derivative: Annotated[
        float, Field(ge=0.0, le=1.0, description="largest derivative gain on the model's motion [s]; lowered likewise")
    ] = 0.1
    force_max: Annotated[float, Field(gt=0.0, le=1000.0)] | None = Field(
        None, description="largest estimated force [N]; default: from the rod's stiffness and weight"
    )
    offset_gain: Annotated[
        float, Field(gt=0.0, le=1.0, description="low-pass coefficient of kind 'offset', per cycle [-]")
    ] = 0.2
    residual: ResidualSection | None = None
