"""[vicon]: Vicon Tracker's objects on the robot, their alignment, and the stream."""

import math
from ipaddress import IPv4Address
from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from tendond.schemas.base import Schema, Vector3
from tendond.schemas.config.ranges import Axis, Port, Positive

Axes = tuple[Axis, Axis, Axis]
EulerOrder = Literal["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX", "xyz", "xzy", "yxz", "yzx", "zxy", "zyx"]
Reader = Literal["udp", "sdk", "apriltag"]
"""How frames are read: Tracker's UDP stream; the `motioncapture` package; tags in a camera's pictures."""

NAME_BYTES = 24
"""Bytes of an object's name in Tracker's UDP stream."""

_SIGNED = {"+": 1, "-": -1}


def axis_vector(axis: Axis) -> tuple[int, int, int]:
    """Return the unit vector of an axis: '-y' is (0, -1, 0)."""
    x, y, z = (_SIGNED[axis[0]] if axis[1] == letter else 0 for letter in "xyz")
    return x, y, z


def _is_ipv4(text: str) -> bool:
    try:
        IPv4Address(text)
    except ValueError:
        return False
    return True


class ViconSection(Schema):
    """[vicon]: Vicon Tracker's objects on the robot, their alignment, and the stream."""

    source: Literal["udp", "datastream"] = Field(
        "udp",
        description="source of the frames; udp: Tracker's UDP object stream; datastream: the DataStream SDK, extra"
        " [vicon-sdk]",
    )
    address: str = Field("0.0.0.0", description="address of the network card on which packets arrive")
    multicast: str = Field("", description="multicast group to join on that card, if Tracker sends to one")
    port: Port = Field(51001, description="UDP port to which Tracker sends")
    sender: str = Field(
        "", description="address of Tracker's computer, the only accepted sender; empty: the first that sends"
    )
    server: str = Field("127.0.0.1:801", description="address of the DataStream server, HOST:PORT")
    server_timeout: Annotated[
        float,
        Field(
            gt=0.0, le=600.0, description="time without a first frame after which the connection is opened again [s]"
        ),
    ] = 10.0
    tip: str = Field("tip", description="name of Tracker's object at the tip")
    base: str = Field(
        "base",
        description="name of Tracker's object at the base; empty: it is where rod.base has it in the Vicon"
        " world, by default its origin",
    )
    euler_order: EulerOrder = Field(
        "XYZ",
        description="order of the three angles; capitals: about the object's moving axes; small letters: about the"
        " fixed axes",
    )
    base_axes: Axes = Field(("+x", "+y", "+z"), description="axes of the base object along the rod frame's x, y and z")
    base_offset: Vector3 = Field((0.0, 0.0, 0.0), description="base of the rod, in the base object's frame [m]")
    tip_axes: Axes = Field(
        ("+x", "+y", "+z"), description="axes of the tip object along the rod's x, y and z at the tip"
    )
    tip_offset: Vector3 = Field((0.0, 0.0, 0.0), description="tip of the rod, in the tip object's frame [m]")
    up: Axis = Field("+z", description="axis of the Vicon world that points up; checked against rod.gravity")
    gravity_tolerance: Annotated[
        float,
        Field(
            gt=0.0,
            le=math.pi,
            description="largest angle between measured and configured gravity for a valid pose [rad]",
        ),
    ] = 0.17
    latency: Annotated[
        float,
        Field(ge=0.0, le=0.5, description="delay from exposure to the packet's arrival, subtracted from the stamp [s]"),
    ] = 0.0
    silence: Positive = Field(1.0, description="time without a packet after which the driver reports it [s]")

    @field_validator("address", "multicast", "sender")
    @classmethod
    def _ipv4(cls, value: str) -> str:
        if value and not _is_ipv4(value):
            raise ValueError("must be an IPv4 address, for instance 192.168.10.2")
        return value

    @field_validator("address")
    @classmethod
    def _card(cls, value: str) -> str:
        if not value:
            raise ValueError("must be an IPv4 address, for instance 192.168.10.2; 0.0.0.0 means all cards")
        if IPv4Address(value).is_multicast:
            raise ValueError("is a multicast group: set multicast to it, and address to the card's own address")
        return value

    @field_validator("multicast")
    @classmethod
    def _group(cls, value: str) -> str:
        if value and not IPv4Address(value).is_multicast:
            raise ValueError("must be a multicast group, 224.0.0.0 to 239.255.255.255")
        return value

    @field_validator("server")
    @classmethod
    def _host_and_port(cls, value: str) -> str:
        host, _, port = value.rpartition(":")
        if not host or not port.isdigit() or not 0 < int(port) < 65536:
            raise ValueError("has the form HOST:PORT, for instance 192.168.10.1:801")
        return value

    @model_validator(mode="after")
    def _fits(self) -> "ViconSection":
        self._names_fit()
        return self

    def _names_fit(self) -> None:
        if self.source == "udp":  # the DataStream SDK has no such limit
            for name in ("tip", "base"):
                size = len(getattr(self, name).encode())
                if size > NAME_BYTES:
                    raise ValueError(f"{name}: Tracker's UDP stream has {NAME_BYTES} bytes for a name, this has {size}")

    @field_validator("tip")
    @classmethod
    def _named(cls, value: str) -> str:
        if not value:
            raise ValueError("name Tracker's object at the tip")
        return value

    @field_validator("base_axes", "tip_axes")
    @classmethod
    def _right_handed(cls, value: Axes) -> Axes:
        (a, b, c), (d, e, f), (g, h, i) = (axis_vector(axis) for axis in value)
        if a * (e * i - f * h) - b * (d * i - f * g) + c * (d * h - e * g) != 1:
            raise ValueError("must be three different axes, right-handed, for instance ['+x', '+y', '+z']")
        return value

    @property
    def key(self) -> str:
        """Name of this section, for messages."""
        return "vicon"

    @property
    def station(self) -> str:
        """What sends the frames, for messages."""
        return "Tracker"

    @property
    def reader(self) -> Reader:
        """How frames are read."""
        return "udp" if self.source == "udp" else "sdk"

    @property
    def connection(self) -> tuple[str, dict[str, str]]:
        """Arguments of `motioncapture.connect`: type and settings."""
        return "vicon", {"hostname": self.server}

    @property
    def polled_for(self) -> float | None:
        """Time after which a body without a new measurement is occluded [s]; none where each frame is a new one."""
        return None

    @property
    def knows_up(self) -> bool:
        """Whether the cameras' world has a known direction up."""
        return True
