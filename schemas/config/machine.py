"""[rig], [bus], [log]: name, bus endpoint and logs of a rig."""

from ipaddress import ip_address
from typing import Annotated

from pydantic import Field, field_validator

from tendond.schemas.base import Schema
from tendond.schemas.keys import RIG_NAME


class RigSection(Schema):
    """[rig]: identity of the rig."""

    name: str = Field("paper", description="name of the rig, the first part of every Zenoh key")

    @field_validator("name")
    @classmethod
    def _plain(cls, value: str) -> str:
        if not RIG_NAME.fullmatch(value):
            raise ValueError("use 1 to 32 of a-z, 0-9, '-' and '_', starting with a letter or digit")
        return value


class BusSection(Schema):
    """[bus]: the Zenoh bus."""

    endpoint: str = Field(
        "tcp/127.0.0.1:7460",
        description="Zenoh endpoint on which the controller listens; port 7447 is left to ROS 2 (rmw_zenohd)",
    )
    unguarded: bool = Field(False, description="listen on the network without an access list; see deploy/bus")

    @field_validator("endpoint")
    @classmethod
    def _form(cls, value: str) -> str:
        protocol, _, address = value.partition("/")
        host, _, port = address.rpartition(":")
        if protocol not in {"tcp", "tls", "quic"} or not host or not port.isdigit() or not 0 < int(port) < 65536:
            raise ValueError("has the form tcp/HOST:PORT, PORT from 1 to 65535, for instance tcp/127.0.0.1:7460")
        return value

    @property
    def is_loopback(self) -> bool:
        """True where only processes of this machine can reach the endpoint."""
        host = self.endpoint.partition("/")[2].rpartition(":")[0].strip("[]")
        if host == "localhost":
            return True
        try:
            return ip_address(host).is_loopback
        except ValueError:
            return False


class LogSection(Schema):
    """[log]: recording of runs."""

    queue: Annotated[int, Field(ge=10, description="capacity of the queue between loop and recorder, in entries")] = (
        4000
    )
    shape_period: Annotated[int, Field(ge=1, description="cycles between two rod shapes in the log")] = 5
    split_size: Annotated[float, Field(ge=0.1, le=1e6, description="file size at which the log is split [MB]")] = 1000.0
    split_time: Annotated[float, Field(ge=1.0, le=1e7, description="age of a file at which the log is split [s]")] = (
        3600.0
    )
    idle_period: Annotated[
        float,
        Field(
            ge=0.0, le=3600.0, description="period at which 0.1 s are logged while idle [s]; 0: every cycle is logged"
        ),
    ] = 60.0
    keep_size: Annotated[float, Field(ge=0.0, le=1e6)] | None = Field(
        None,
        description="total size of this rig's logs above which the oldest without a tag are removed [GB]; 0: no limit;"
        " default: 20 or a tenth of the disk for a service, else no limit",
    )
    keep_days: Annotated[float, Field(ge=0.0, le=1e5)] | None = Field(
        None,
        description="age at which logs without a tag are removed [days]; 0: never; default: 90 for a service",
    )
