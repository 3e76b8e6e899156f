"""[rig], [bus], [log]: what the rig is called, where it listens, what is kept of its runs."""

from ipaddress import ip_address
from typing import Annotated

from pydantic import Field, field_validator

from tendond.schemas.base import Schema
from tendond.schemas.keys import RIG_NAME


class RigSection(Schema):
    """[rig]"""

    name: str = Field("paper", description="first part of every Zenoh key")

    @field_validator("name")
    @classmethod
    def _plain(cls, value: str) -> str:
        if not RIG_NAME.fullmatch(value):
            raise ValueError("use 1 to 32 of a-z, 0-9, '-' and '_', starting with a letter or digit")
        return value


class BusSection(Schema):
    """[bus]"""

    endpoint: str = Field("tcp/127.0.0.1:7447", description="Zenoh endpoint on which the controller listens")
    unguarded: bool = Field(False, description="listen beyond this machine without an access list; see deploy/bus")

    @field_validator("endpoint")
    @classmethod
    def _form(cls, value: str) -> str:
        protocol, _, address = value.partition("/")
        host, _, port = address.rpartition(":")
        if protocol not in {"tcp", "tls", "quic"} or not host or not port.isdigit() or not 0 < int(port) < 65536:
            raise ValueError("has the form tcp/HOST:PORT, for instance tcp/127.0.0.1:7447")
        return value

    @property
    def is_loopback(self) -> bool:
        """Whether only processes of this machine can reach it."""
        host = self.endpoint.partition("/")[2].rpartition(":")[0].strip("[]")
        if host == "localhost":
            return True
        try:
            return ip_address(host).is_loopback
        except ValueError:
            return False


class LogSection(Schema):
    """[log]"""

    queue: Annotated[int, Field(ge=10, description="entries between the loop and the recorder")] = 4000
    shape_period: Annotated[int, Field(ge=1, description="cycles between two rod shapes in the log")] = 5
    split_size: Annotated[
        float, Field(ge=0.1, le=1e6, description="of a file, from which on the run goes on in another one [MB]")
    ] = 1000.0
    split_time: Annotated[float, Field(ge=1.0, le=1e7, description="the same, by the file's age [s]")] = 3600.0
    idle_period: Annotated[
        float, Field(ge=0.0, le=3600.0, description="[s]; while idle, a tenth of a second in so many is logged; 0: all")
    ] = 60.0
    keep_size: Annotated[float, Field(ge=0.0, le=1e6)] | None = Field(
        None,
        description="[GB] of logs of this rig, the oldest are removed; 0: no bound; left out: 20 or a tenth of the disk"
        " for a service, no bound by hand",
    )
    keep_days: Annotated[float, Field(ge=0.0, le=1e5)] | None = Field(
        None, description="[days] that they are kept; 0: no bound; left out: 90 for a service, no bound by hand"
    )
