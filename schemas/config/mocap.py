"""[mocap]: the camera system that measures the tip, by name."""

from typing import Annotated, Literal

from pydantic import Field, field_validator, model_validator

from tendond.schemas.config.apriltag import AprilTagSection
from tendond.schemas.config.vicon import Reader, ViconSection

System = Literal["vicon", "optitrack", "qualisys", "vrpn", "apriltag"]

STATIONS: dict[System, str] = {
    "vicon": "Tracker",
    "optitrack": "Motive",
    "qualisys": "QTM",
    "vrpn": "the VRPN server",
    "apriltag": "the camera",
}
"""What sends the frames, by system."""

PORTS: dict[System, int] = {"vicon": 801, "optitrack": 1510, "qualisys": 22222, "vrpn": 3883}
"""Default ports of the servers: DataStream, NatNet's command port, QTM's base port, VRPN."""

OF_VICON = ("source", "address", "multicast", "port", "sender", "euler_order")
"""Keys of Tracker's own stream."""


class MocapSection(ViconSection):
    """[mocap]: the camera system that measures the tip; its objects on the robot, their alignment, and the stream.

    One line is enough where base and tip have the names `base` and `tip`: the system, and the address of its server.
    """

    system: System = Field(
        "vicon",
        description="camera system; optitrack: Motive's NatNet; qualisys: QTM's RT protocol; vrpn: any VRPN server;"
        " apriltag: printed tags and a webcam, extra [apriltag]; all but the UDP stream of vicon and apriltag: extra"
        " [vicon-sdk]",
    )
    server: str = Field(
        "127.0.0.1",
        min_length=1,
        description="address of the system's server, HOST or HOST:PORT; default ports: vicon 801, with source ="
        " 'datastream'; optitrack 1510; qualisys 22222; vrpn 3883",
    )
    interface: str = Field(
        "0.0.0.0", description="address of the network card on which Motive's multicast arrives; of optitrack"
    )
    hold: Annotated[float, Field(gt=0.0, le=1.0)] = Field(
        0.1, description="time after which a body without a new measurement is occluded [s]; of optitrack and vrpn"
    )
    apriltag: AprilTagSection = AprilTagSection()

    @field_validator("interface")
    @classmethod
    def _interface(cls, value: str) -> str:
        return cls._card(value)

    @field_validator("server")
    @classmethod
    def _host_and_port(cls, value: str) -> str:  # Tracker's needs both
        host, colon, port = value.rpartition(":")
        if colon and not (host and port.isdigit() and 0 < int(port) < 65536):
            raise ValueError("has the form HOST or HOST:PORT, for instance 192.168.10.1")
        return value

    @model_validator(mode="after")
    def _fits(self) -> "MocapSection":
        given = {name for name, one in type(self).model_fields.items() if getattr(self, name) != one.default}
        if self.system == "vicon":
            self._names_fit()
        elif wrong := [name for name in OF_VICON if name in given]:
            raise ValueError(f"{', '.join(wrong)}: of Tracker's stream, but system = '{self.system}': remove it")
        if "interface" in given and self.system != "optitrack":
            raise ValueError(f"interface: of optitrack, but system = '{self.system}': remove it")
        if self.system == "apriltag":
            if self.apriltag.tag_size is None:
                raise ValueError("apriltag.tag_size is missing: the side of the tag's black square [m]")
        elif "apriltag" in given:
            raise ValueError(f"[mocap.apriltag] is of system = 'apriltag', and this is '{self.system}': remove it")
        return self

    @property
    def key(self) -> str:
        """Name of this section, for messages."""
        return "mocap"

    @property
    def station(self) -> str:
        """What sends the frames, for messages."""
        return STATIONS[self.system]

    @property
    def reader(self) -> Reader:
        """How frames are read."""
        if self.system == "vicon":
            return super().reader
        return "apriltag" if self.system == "apriltag" else "sdk"

    @property
    def host_and_port(self) -> tuple[str, int]:
        """Address of the server."""
        host, colon, port = self.server.rpartition(":")
        return (host, int(port)) if colon else (self.server, PORTS[self.system])

    @property
    def connection(self) -> tuple[str, dict[str, str]]:
        """Arguments of `motioncapture.connect`: type and settings."""
        if self.system == "apriltag":
            return "apriltag", {}
        host, port = self.host_and_port
        if self.system == "optitrack":
            return "optitrack", {"hostname": host, "interface_ip": self.interface, "port_command": str(port)}
        if self.system == "qualisys":
            return "qualisys", {"hostname": host, "port": str(port)}
        return self.system, {"hostname": f"{host}:{port}"}

    @property
    def polled_for(self) -> float | None:
        """Time after which a body without a new measurement is occluded [s]; none where each frame is a new one."""
        return self.hold if self.system in ("optitrack", "vrpn") else None

    @property
    def knows_up(self) -> bool:
        """Whether the cameras' world has a known direction up: a webcam's only where it was given."""
        return self.system != "apriltag" or "up" in self.model_fields_set
