"""Sensors beside the pose: what is configured of them, what is known of each between cycles, and admitted readings."""

from dataclasses import dataclass

from tendond.daemon.control.thresholds import cycles
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.sensors.section import SensorSection

Row = tuple[float, ...] | None
"""Numbers of one place, SI; none where it was not seen."""

PREFIX = "sensor "


@dataclass(frozen=True)
class Sensor:
    """A configured sensor, and its timeout in cycles."""

    section: SensorSection
    timeout: int


@dataclass(frozen=True)
class SensorTrack:
    """What is known of a sensor between two cycles.

    Attributes:
        source: identity of the publisher in use; none before the first reading.
        seq: count of the newest admitted reading.
        age: cycles since it arrived; none before the first.
        interval: mean number of cycles between readings, of the last dozen; zero before the second.
        objection: reason against the newest reading; empty where it was admitted.
    """

    source: str | None = None
    seq: int = -1
    age: int | None = None
    interval: float = 0.0
    objection: str = ""

    def is_silent(self, timeout: int) -> bool:
        """True if no reading has come for more than `timeout` cycles, or ever."""
        return self.age is None or self.age > timeout


UNHEARD = SensorTrack()


@dataclass(frozen=True)
class Reading:
    """A reading that was admitted in this cycle.

    Attributes:
        name: of its sensor.
        rows: as `SensorSection` describes them, in its order.
        age: [s], by `delay` of the sensor, or with `observer.stamps` by its stamp; without `observer.command_delay`.
    """

    name: str
    rows: tuple[Row, ...]
    age: float


def configured_sensors(config: RigConfig) -> dict[str, Sensor]:
    """Return the configured sensors by name."""
    period = config.loop.period
    return {one.name: Sensor(one, cycles(one.timeout, period)) for one in config.sensors}


def sensor_reason(name: str, reason: str) -> str:
    """Return the reason against a sensor's reading under which it is counted."""
    return f"{PREFIX}{name}: {reason}"


def is_sensors(reason: str) -> bool:
    """True if the reason is one against a sensor's reading, not against a pose or a tendon state."""
    return reason.startswith(PREFIX)


def silent_sensor(sensors: dict[str, Sensor], tracks: dict[str, SensorTrack]) -> str | None:
    """Return the name of a required sensor that is silent; none if there is none."""
    for name, sensor in sensors.items():
        if sensor.section.required and tracks[name].is_silent(sensor.timeout):
            return name
    return None
