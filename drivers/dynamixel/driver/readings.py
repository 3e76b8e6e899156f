"""Readings of a rig's servos as displacements, speeds and tensions of the tendons. Reads no clock."""

from collections.abc import Iterable
from dataclasses import dataclass

from tendond.drivers.dynamixel.driver.motors import MotorBus, MotorGroup
from tendond.drivers.dynamixel.serial import table
from tendond.drivers.dynamixel.serial.reading import ServoReading
from tendond.drivers.dynamixel.turns import TURN_MARGIN, Located


@dataclass(frozen=True)
class BusHealth:
    """State of the serial bus; fields as in `ServoHealth`."""

    reads: int
    lost: int
    late: int
    late_by: float
    round_trip: float
    round_trip_max: float
    load: tuple[float, ...]


class TendonReadings:
    """Newest readings of the servos.

    Args:
        servos: set up.
        places: last known displacement of each tendon, by servo id [m]; kept up to date here.

    Raises:
        ServoError: the servos do not reply.

    Attributes:
        servo: newest reading of each servo.
        displacement: displacement of the tendons [m]. tension: as the servos estimate it [N].
        speed: size of the tendons' speed between the two newest readings [m/s].
        rise: increase of each servo's load between the two newest readings, as a fraction of its stall torque [-].
    """

    def __init__(self, servos: MotorGroup, places: dict[int, float]) -> None:
        self._servos = servos
        self._places = places
        self._time: float | None = None
        self.servo: tuple[ServoReading, ...] = servos.read_again()
        self.displacement: tuple[float, ...] = servos.displacements(self.servo)
        self.tension: tuple[float, ...] = servos.tensions(self.servo)
        self.speed: tuple[float, ...] = (0.0,) * len(self.servo)
        self.rise: tuple[float, ...] = (0.0,) * len(self.servo)
        for one, place in zip(servos.located, self.displacement, strict=True):
            if one.certain:
                places[one.spool.calibration.servo] = place

    @property
    def loads(self) -> list[float]:
        """Size of each servo's load, as a fraction of its stall torque [-]."""
        return [abs(one.load) * table.LOAD_UNIT for one in self.servo]

    def read(self, now: float, *, relocate: bool) -> None:
        """Read all servos.

        Args:
            now: [s].
            relocate: determine the turns again where a tendon has jumped: without torque, a servo may be rebooted.

        Raises:
            ServoError: not all of them replied; nothing has changed.
        """
        loads = self.loads
        readings = self._servos.read()
        before, since = self.displacement, None if self._time is None else now - self._time
        self._time = now
        self._take(readings, relocate=relocate)
        if since:
            self.speed = tuple(abs(b - a) / since for a, b in zip(before, self.displacement, strict=True))
        self.rise = tuple(b - a for a, b in zip(loads, self.loads, strict=True))

    def read_again(self) -> None:
        """Read all servos, again where a reply is lost.

        Raises:
            ServoError: not all of them replied, several times.
        """
        self._take(self._servos.read_again(), relocate=False)

    def reset_speed(self) -> None:
        """Assume that all tendons stand still, under steady loads."""
        self.speed = self.rise = (0.0,) * len(self.servo)

    def _take(self, readings: tuple[ServoReading, ...], *, relocate: bool) -> None:
        """Accept readings; a displacement that no tendon can have reached in a cycle is not kept as its place."""
        self.servo = readings
        displacement = self._servos.displacements(readings)
        if relocate and any(self._jumped(one, place) for one, place in self._located(displacement)):
            self._servos.locate(readings, self._places)  # a rebooted servo has lost its turns
            displacement = self._servos.displacements(readings)
        self.displacement = displacement
        self.tension = self._servos.tensions(readings)
        for one, place in self._located(displacement):
            if one.certain and not self._jumped(one, place):
                self._places[one.spool.calibration.servo] = place

    def _located(self, displacement: tuple[float, ...]) -> Iterable[tuple[Located, float]]:
        return zip(self._servos.located, displacement, strict=True)

    def _jumped(self, one: Located, place: float) -> bool:
        """Return true where a tendon is further from its last place than it can have moved."""
        last = self._places.get(one.spool.calibration.servo, place)
        return abs(place - last) > TURN_MARGIN * one.turn


def bus_health(bus: MotorBus, lost: int, readings: TendonReadings) -> BusHealth:
    """Summarise the serial bus; round trips are those since the last call.

    Args:
        bus: bus of the servos.
        lost: reads without a reply so far.
        readings: newest.
    """
    trips = sorted(bus.round_trips)
    bus.round_trips.clear()
    return BusHealth(
        reads=bus.reads,
        lost=lost,
        late=bus.transport.late.count,
        late_by=bus.transport.late.by,
        round_trip=trips[len(trips) // 2] if trips else 0.0,
        round_trip_max=trips[-1] if trips else 0.0,
        load=tuple(one.load * table.LOAD_UNIT for one in readings.servo),
    )
