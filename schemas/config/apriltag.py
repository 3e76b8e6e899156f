"""[mocap.apriltag]: printed tags on the robot, seen by one calibrated camera."""

from typing import Annotated, Literal

from pydantic import Field, model_validator

from tendond.schemas.base import Schema
from tendond.schemas.config.ranges import Positive

TagFamily = Literal["16h5", "25h9", "36h10", "36h11"]
TagId = Annotated[int, Field(ge=0, le=2319)]  # of 36h10, the family with the most tags


class AprilTagSection(Schema):
    """[mocap.apriltag]: a tag on the tip, another on the base, and the camera that sees both.

    A tag's frame: origin in its centre, x to the right and y up in the plane as it is printed, z out of the paper.
    """

    video: str = Field(
        "/dev/video0",
        min_length=1,
        description="camera: its device, such as /dev/video0; or a video file, a named pipe or a URL",
    )
    calibration: str = Field(
        "camera.toml",
        min_length=1,
        description="intrinsics of the camera, as `tendond mocap calibrate` writes them; relative to this file",
    )
    family: TagFamily = Field("36h11", description="family of the tags")
    tip_tag: TagId = Field(0, description="id of the tag at the tip")
    base_tag: TagId = Field(1, description="id of the tag at the base, not looked for where mocap.base is empty")
    tag_size: Annotated[
        float | None,
        Field(gt=0.0, le=1.0, description="side of the tip tag's black square, as measured on the print [m]"),
    ] = None
    base_size: Annotated[
        float | None, Field(gt=0.0, le=1.0, description="the same of the base's tag [m]; default: tag_size")
    ] = None
    width: Annotated[int, Field(ge=0, le=16384)] = Field(
        0, description="width of the picture that a device is asked for [px]; 0: that of the calibration"
    )
    height: Annotated[int, Field(ge=0, le=16384)] = Field(
        0, description="height of it [px]; 0: that of the calibration"
    )
    rate: Annotated[float, Field(ge=0.0, le=1000.0)] = Field(
        0.0, description="pictures per second that a device is asked for [Hz]; 0: its own default"
    )
    error_max: Positive = Field(
        2.0, description="largest reprojection error, root mean square over a tag's corners, of a valid pose [px]"
    )

    @model_validator(mode="after")
    def _two_tags(self) -> "AprilTagSection":
        if self.tip_tag == self.base_tag:
            raise ValueError(f"tip_tag and base_tag are both {self.tip_tag}: the tags need different ids")
        return self
