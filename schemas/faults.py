"""Faults that a running simulator can be asked for, and their options."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Literal

from pydantic import Field, model_validator

from tendond.schemas.base import SCHEMA_VERSION, Schema, Vector3
from tendond.schemas.mistaken_units import unit_hint

Direction = Literal["x", "-x", "y", "-y", "z", "-z"]


class Fault(StrEnum):
    """Name of a fault; `clear` ends those that last."""

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
    UNSEEN = "unseen"
    SWAPPED = "swapped"
    MUTE = "mute"
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
    CLEAR = "clear"

    @classmethod
    def _missing_(cls, value: object) -> "Fault | None":
        """Read 'mend', the former name of 'clear'."""
        return cls.CLEAR if value == "mend" else None


@dataclass(frozen=True)
class FaultKind:
    """Options of a fault.

    Attributes:
        meaning: description.
        seconds: default duration [s]; none: until it is cleared, or an event.
        timed: its duration can be given.
        size: default size, in `unit`; none: it has no size.
        size_max: largest size. unit: of the size.
        directed: it has a direction.
        servo: it applies to one servo. sensor: to one sensor. rows: to some rows of its readings.
        wires: it exists on the wired rig only.
    """

    meaning: str
    seconds: float | None = None
    timed: bool = True
    size: float | None = None
    size_max: float = 0.0
    unit: str = ""
    directed: bool = False
    servo: bool = False
    sensor: bool = False
    rows: bool = False
    wires: bool = False


FAULTS = {
    Fault.OCCLUSION: FaultKind("the tip's markers are hidden", 0.1),
    Fault.FROZEN: FaultKind("frames continue with a frozen pose", 1.0),
    Fault.TELEPORT: FaultKind(
        "the measured tip jumps by this distance", 0.1, size=0.2, size_max=10.0, unit="m", directed=True
    ),
    Fault.DROPOUT: FaultKind("this fraction of the frames is lost", 0.1, size=1.0, size_max=1.0, unit="-"),
    Fault.NOISE: FaultKind("noise of the pose, by its standard deviation", 1.0, size=1e-3, size_max=0.05, unit="m"),
    Fault.WEIGHT: FaultKind("a weight on the tip", size=0.02, size_max=10.0, unit="kg"),
    Fault.IMPACT: FaultKind("a push", 0.05, size=2.0, size_max=1000.0, unit="N", directed=True),
    Fault.SILENCE: FaultKind("the simulator sends and receives nothing", 1.0),
    Fault.OVERLOAD: FaultKind("a servo reports a hardware error", timed=False, servo=True),
    Fault.STUCK: FaultKind("a servo does not move", servo=True),
    Fault.CUT: FaultKind("a servo's tendon is cut, or off its spool", servo=True),
    Fault.UNSEEN: FaultKind("rows of a sensor are missing, such as hidden markers", 1.0, sensor=True, rows=True),
    Fault.SWAPPED: FaultKind("two rows of a sensor exchange their places, as labels do", 1.0, sensor=True, rows=True),
    Fault.MUTE: FaultKind("a sensor is silent", 1.0, sensor=True),
    Fault.SILENT: FaultKind("a servo does not reply", timed=False, servo=True, wires=True),
    Fault.HOT: FaultKind("a servo is too hot", timed=False, servo=True, wires=True),
    Fault.REBOOT: FaultKind("a servo reboots", timed=False, servo=True, wires=True),
    Fault.BROWNOUT: FaultKind(
        "a servo's supply voltage is too low, until it is cleared", timed=False, servo=True, wires=True
    ),
    Fault.TURNED: FaultKind(
        "a servo counts this many more turns",
        timed=False,
        size=3.0,
        size_max=500.0,
        unit="turns",
        servo=True,
        wires=True,
    ),
    Fault.CRC: FaultKind("the next replies are damaged", timed=False, wires=True),
    Fault.LOSS: FaultKind(
        "this fraction of the replies is damaged", timed=False, size=0.2, size_max=1.0, unit="-", wires=True
    ),
    Fault.LATE: FaultKind(
        "the adapter delays every reply by this time", timed=False, size=0.016, size_max=1.0, unit="s", wires=True
    ),
    Fault.UNPLUG: FaultKind("the adapter is unplugged", timed=False, wires=True),
    Fault.PLUG: FaultKind("the adapter is plugged in again", timed=False, wires=True),
    Fault.CLEAR: FaultKind("all faults end, or those of one servo", timed=False),
}


class FaultRequest(Schema):
    """A request to a running simulator; options that are not given have the fault's default in `FAULTS`.

    Attributes:
        fault: fault to cause.
        servo: id of the servo: as on the bus for the wired rig, else 1 for the first tendon.
        seconds: duration in simulated time [s].
        size: teleport [m], dropout [-], noise [m], weight [kg], impact [N], loss [-], delay [s], turns [-].
        direction: direction of a teleport or an impact, in the base's frame.
        place: place of an impact along the rod: 1 is the tip [-].
        sensor: name of the sensor. rows: of its readings, from 0; all, or the first two, where none are given.
    """

    version: Literal[1] = SCHEMA_VERSION
    fault: Fault
    servo: int | None = None
    seconds: Annotated[float, Field(gt=0.0, le=3600.0)] | None = None
    size: Annotated[float, Field(ge=0.0)] | None = None
    direction: Direction | None = None
    place: Annotated[float, Field(ge=0.0, le=1.0)] | None = None
    sensor: Annotated[str, Field(max_length=32)] | None = None
    rows: Annotated[tuple[Annotated[int, Field(ge=0)], ...], Field(max_length=64)] | None = None

    @model_validator(mode="after")
    def _fits(self) -> "FaultRequest":
        kind = FAULTS[self.fault]
        takes = {
            "servo": kind.servo or self.fault is Fault.CLEAR,
            "seconds": kind.timed,
            "size": kind.size is not None,
            "direction": kind.directed,
            "place": self.fault is Fault.IMPACT,
            "sensor": kind.sensor,
            "rows": kind.rows,
        }
        for name, wanted in takes.items():
            if getattr(self, name) is not None and not wanted:
                raise ValueError(f"{self.fault.value} takes no {name}")
        if kind.servo and self.servo is None:
            raise ValueError(f"{self.fault.value} needs a servo: give servo, 1 for the first")
        if kind.sensor and self.sensor is None:
            raise ValueError(f"{self.fault.value} needs a sensor: give its name")
        if self.fault is Fault.SWAPPED and self.rows is not None and len(set(self.rows)) != 2:
            raise ValueError("swapped: give two different rows")
        if self.size is not None and self.size > kind.size_max:
            hint = unit_hint(self.size, kind.size_max, kind.unit)
            most = f"{self.fault.value} takes at most {kind.size_max:g} {kind.unit}"
            raise ValueError(f"size = {self.size:g}: {most}{hint}")
        return self

    @property
    def duration(self) -> float | None:
        """Duration [s]; none: until it is cleared, or an event."""
        return FAULTS[self.fault].seconds if self.seconds is None else self.seconds

    @property
    def amount(self) -> float:
        """Size that is given, or the fault's default."""
        return (FAULTS[self.fault].size or 0.0) if self.size is None else self.size

    @property
    def vector(self) -> Vector3:
        """Size times direction; along x where no direction is given."""
        wanted = self.direction or "x"
        size = -self.amount if wanted.startswith("-") else self.amount
        x, y, z = (size if axis == wanted[-1] else 0.0 for axis in "xyz")
        return x, y, z
