"""Motors as the driver's session uses them: Dynamixel servos, or others that report themselves in their units."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from tendond.drivers.dynamixel.calibration import Calibration
from tendond.drivers.dynamixel.serial.late import LateReplies
from tendond.drivers.dynamixel.serial.reading import ServoReading
from tendond.drivers.dynamixel.spool import Spool
from tendond.drivers.dynamixel.turns import Located
from tendond.schemas.config.servo import ServoSection


class Transport(Protocol):
    """Counters of a bus."""

    late: LateReplies


class MotorBus(Protocol):
    """Open bus with motors; see `ServoBus`."""

    reads: int

    @property
    def transport(self) -> Transport:
        """Counters of the bus."""

    @property
    def round_trips(self) -> Any:
        """Durations of the newest reads, bounded and emptied by who uses them [s]."""

    def close(self) -> None:
        """Close the bus."""

    def read_seconds(self, servos: int) -> float:
        """Return the time that a read takes on the wire [s]."""

    def absent(self, identifiers: Sequence[int]) -> list[int]:
        """Return the motors that do not reply."""


class MotorGroup(Protocol):
    """Motors of a rig, in the order of the tendons; see `ServoGroup`, whose errors all of them raise."""

    ids: tuple[int, ...]
    located: tuple[Located, ...]
    spools: tuple[Spool, ...]
    watchdog: int
    limits: tuple[float, ...]

    def locate(self, readings: Sequence[ServoReading], last: Mapping[int, float]) -> None:
        """Find the turn of each motor."""

    def read(self) -> tuple[ServoReading, ...]:
        """Read all motors."""

    def read_again(self) -> tuple[ServoReading, ...]:
        """Read all motors, several times where a reply is lost."""

    def on(self, readings: Sequence[ServoReading]) -> None:
        """Switch the torque on at the present positions."""

    def bound(self, rates: Sequence[float], readings: Sequence[ServoReading]) -> None:
        """Limit the motors' output to the allowed load and rate [m/s]."""

    def wake(self, readings: Sequence[ServoReading]) -> None:
        """Take over motors that were stopped by their watchdog."""

    def drop(self, index: int) -> None:
        """Switch off the torque of one tendon."""

    def reboot(self, identifiers: Sequence[int]) -> None:
        """Clear the errors that motors report."""

    def go(self, goals: Sequence[float]) -> None:
        """Send the goal of each tendon [m]."""

    def off(self) -> None:
        """Switch the torque off, confirmed."""

    def displacements(self, readings: Sequence[ServoReading]) -> tuple[float, ...]:
        """Return the displacement of each tendon [m]."""

    def tensions(self, readings: Sequence[ServoReading]) -> tuple[float, ...]:
        """Return the tension of each tendon, as the motors estimate it [N]."""


GroupMaker = Callable[[ServoSection, Calibration, Any, Mapping[int, float], float], MotorGroup]
"""Makes the group of an open bus: of `section`, `calibration`, `bus`, `places` [m] and `limits.tension_max` [N]."""
