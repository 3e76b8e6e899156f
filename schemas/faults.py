"""Faults that a running simulator is asked for; what each takes beside its name."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Literal

from pydantic import Field, model_validator

from tendond.schemas.base import SCHEMA_VERSION, Schema, Vector3

Direction = Literal["x", "-x", "y", "-y", "z", "-z"]


class Fault(StrEnum):
    """What can be made to go wrong; `mend` ends it."""

    OCCLUSION = "occlusion"
    FROZEN = "frozen"
    TELEPORT = "teleport"
    DROPOUT = "dropout"
    NOISE = "noise"
    WEIGHT = "weight"
    IMPACT = "impact"
    SILENCE = "silence"
    OVERLOAD = "overload"
    STUCK = "stuck"
    CUT = "cut"
    SILENT = "silent"
    HOT = "hot"
    REBOOT = "reboot"
    BROWNOUT = "brownout"
    TURNED = "turned"
    CRC = "crc"
    LOSS = "loss"
    LATE = "late"
    UNPLUG = "unplug"
    PLUG = "plug"
    MEND = "mend"


@dataclass(frozen=True)
class FaultKind:
    """What a fault takes.

    Attributes:
        meaning: in words.
        seconds: that it lasts where nothing else is asked for [s]; none: until it is mended, or an event.
        timed: it can be asked to last.
        size: where nothing else is asked for, in `unit`; none: it has no size.
        most: largest size. unit: of it.
        directed: it has a direction.
        servo: it is a servo's.
        wires: only the rig on wires has it.
    """

    meaning: str
    seconds: float | None = None
    timed: bool = True
    size: float | None = None
    most: float = 0.0
    unit: str = ""
    directed: bool = False
    servo: bool = False
    wires: bool = False


FAULTS = {
    Fault.OCCLUSION: FaultKind("the tip's markers are hidden", 0.1),
    Fault.FROZEN: FaultKind("frames go on, the pose in them stands still", 1.0),
    Fault.TELEPORT: FaultKind(
        "the tip is seen elsewhere, so far away", 0.1, size=0.2, most=10.0, unit="m", directed=True
    ),
    Fault.DROPOUT: FaultKind("so large a part of the frames is lost", 0.1, size=1.0, most=1.0, unit="-"),
    Fault.NOISE: FaultKind("noise of the pose, standard deviation", 1.0, size=1e-3, most=0.05, unit="m"),
    Fault.WEIGHT: FaultKind("a weight on the tip", size=0.02, most=10.0, unit="kg"),
    Fault.IMPACT: FaultKind("a push", 0.05, size=2.0, most=1000.0, unit="N", directed=True),
    Fault.SILENCE: FaultKind("the simulator says nothing and hears nothing", 1.0),
    Fault.OVERLOAD: FaultKind("a servo reports a hardware error", timed=False, servo=True),
    Fault.STUCK: FaultKind("a servo stays where it is", servo=True),
    Fault.CUT: FaultKind("a servo's tendon is cut, or off its spool", servo=True),
    Fault.SILENT: FaultKind("a servo does not answer", timed=False, servo=True, wires=True),
    Fault.HOT: FaultKind("a servo is too hot", timed=False, servo=True, wires=True),
    Fault.REBOOT: FaultKind("a servo starts anew", timed=False, servo=True, wires=True),
    Fault.BROWNOUT: FaultKind("a servo's supply is too low, until it is mended", timed=False, servo=True, wires=True),
    Fault.TURNED: FaultKind(
        "a servo counts so many whole turns more",
        timed=False,
        size=3.0,
        most=500.0,
        unit="turns",
        servo=True,
        wires=True,
    ),
    Fault.CRC: FaultKind("the next answers are damaged", timed=False, wires=True),
    Fault.LOSS: FaultKind(
        "so large a part of the answers is damaged", timed=False, size=0.2, most=1.0, unit="-", wires=True
    ),
    Fault.LATE: FaultKind(
        "the adapter keeps every answer for so long", timed=False, size=0.016, most=1.0, unit="s", wires=True
    ),
    Fault.UNPLUG: FaultKind("the port is gone", timed=False, wires=True),
    Fault.PLUG: FaultKind("and there again", timed=False, wires=True),
    Fault.MEND: FaultKind("the end of all that lasts, or of one servo's faults", timed=False),
}


class FaultRequest(Schema):
    """A request to a running simulator. Without an option, its fault's own value in `FAULTS` counts.

    Attributes:
        fault: to cause.
        servo: id of the one that gets it: as the bus has them on wires, else 1 for the first tendon.
        seconds: simulated time that it lasts [s].
        size: of a teleport [m], a dropout [-], noise [m], a weight [kg], an impact [N], a loss [-], a delay [s], turns.
        direction: of a teleport or an impact, world frame.
        place: of an impact along the rod: 1 is the tip [-].
    """

    version: Literal[1] = SCHEMA_VERSION
    fault: Fault
    servo: int | None = None
    seconds: Annotated[float, Field(gt=0.0, le=3600.0)] | None = None
    size: Annotated[float, Field(ge=0.0)] | None = None
    direction: Direction | None = None
    place: Annotated[float, Field(ge=0.0, le=1.0)] | None = None

    @model_validator(mode="after")
    def _fits(self) -> "FaultRequest":
        kind = FAULTS[self.fault]
        takes = {
            "servo": kind.servo or self.fault is Fault.MEND,
            "seconds": kind.timed,
            "size": kind.size is not None,
            "direction": kind.directed,
            "place": self.fault is Fault.IMPACT,
        }
        for name, wanted in takes.items():
            if getattr(self, name) is not None and not wanted:
                raise ValueError(f"{self.fault.value} takes no {name}")
        if kind.servo and self.servo is None:
            raise ValueError(f"{self.fault.value} is a servo's: name it with servo, the first is 1")
        if self.size is not None and self.size > kind.most:
            raise ValueError(f"size = {self.size:g}: {self.fault.value} takes at most {kind.most:g} {kind.unit}")
        return self

    @property
    def duration(self) -> float | None:
        """[s]; none: until it is mended, or an event."""
        return FAULTS[self.fault].seconds if self.seconds is None else self.seconds

    @property
    def amount(self) -> float:
        """The size asked for, or the fault's own."""
        return (FAULTS[self.fault].size or 0.0) if self.size is None else self.size

    @property
    def vector(self) -> Vector3:
        """Size times direction; x without one."""
        wanted = self.direction or "x"
        size = -self.amount if wanted.startswith("-") else self.amount
        x, y, z = (size if axis == wanted[-1] else 0.0 for axis in "xyz")
        return x, y, z
