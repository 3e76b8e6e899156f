"""Admit readings: select those of the configured sensors that can be used, and give the reason against each other."""

import math
from dataclasses import dataclass

from tendond.daemon.control.phases.monitors import ONE_CLOCK
from tendond.daemon.control.sensors import PREFIX, UNHEARD, Reading, Sensor, SensorTrack, sensor_reason
from tendond.daemon.control.setup import CycleSetup
from tendond.daemon.control.state import CycleState, changed
from tendond.schemas.keys import sensor_topic
from tendond.schemas.messages import QUATERNION_TOLERANCE, SensorReading
from tendond.schemas.record import CycleInputs

AVERAGED = 12
"""Readings over which the interval between them is averaged. Chosen: an eighth of a second at 100 Hz."""


@dataclass(frozen=True)
class Readings:
    """What the sensors have brought in a cycle.

    Attributes:
        tracks: of each configured sensor, by name. admitted: readings to be used, in the configuration's order.
        rejected: reasons against the others.
    """

    tracks: dict[str, SensorTrack]
    admitted: tuple[Reading, ...]
    rejected: tuple[str, ...]


def admit_readings(setup: CycleSetup, state: CycleState, inputs: CycleInputs, *, pulling: bool) -> Readings:
    """Take over the readings that can be used, and age the sensors.

    Args:
        setup: setup of the cycle. state: after the last one. inputs: of the cycle.
        pulling: tendons are pulled, or being released: no other source is taken up.
    """
    if not (setup.sensors or inputs.readings):
        return Readings(state.sensors, (), ())
    rejected = [f"{PREFIX}of an unknown name" for name in inputs.readings if name not in setup.sensors]
    tracks, admitted = {}, []
    for name, sensor in setup.sensors.items():
        track = state.sensors.get(name, UNHEARD)
        cycles = None if track.age is None else track.age + 1 + inputs.missed_ticks
        reading = inputs.readings.get(name)
        objection = None if reading is None else _objection(sensor, track, cycles, reading, pulling=pulling)
        if reading is not None and objection is None:
            track = SensorTrack(reading.source, reading.seq, 0, _interval(track.interval, cycles))
            age = _age(setup, sensor, inputs.reading_lags.get(name))
            admitted.append(Reading(name, reading.rows, age))
        else:
            track = changed(track, age=cycles)
        refused = _unreadable(name, inputs) + ([] if objection is None else [objection])
        if sensor_topic(name) in inputs.others:
            refused.append("another source")
        if refused:
            track = changed(track, objection=refused[0])
            rejected += [sensor_reason(name, one) for one in refused]
        tracks[name] = track
    return Readings(tracks, tuple(admitted), tuple(rejected))


def _unreadable(name: str, inputs: CycleInputs) -> list[str]:
    """Return the reasons against payloads of a sensor that were no readings."""
    prefix = sensor_reason(name, "")
    of_it = {reason.removeprefix(prefix): n for reason, n in inputs.unreadable.items() if reason.startswith(prefix)}
    return [reason for reason, count in sorted(of_it.items()) for _ in range(count)]


def _objection(
    sensor: Sensor, track: SensorTrack, cycles: int | None, reading: SensorReading, *, pulling: bool
) -> str | None:
    """Return the reason against a reading, if there is one; `cycles` since the last one that was admitted."""
    section = sensor.section
    rows = [row for row in reading.rows if row is not None]
    if len(reading.rows) != section.rows:
        return f"{len(reading.rows)} rows, where {section.rows} are configured"
    if any(len(row) != section.width for row in rows):
        return f"rows that have not {section.width} numbers, as those of kind '{section.kind}' do"
    if not all(math.isfinite(number) for row in rows for number in row):
        return "not finite"
    if section.kind == "base" and any(abs(math.hypot(*row[3:]) - 1.0) > QUATERNION_TOLERANCE for row in rows):
        return "bad quaternion"
    silent = cycles is None or cycles > sensor.timeout
    if reading.source != track.source and track.source is not None:
        return None if silent and not pulling else "another source"
    if silent or reading.seq > track.seq:
        return None
    return "duplicate" if reading.seq == track.seq else "out of order"


def _interval(mean: float, cycles: int | None) -> float:
    """Return the mean number of cycles between readings, with one more of them."""
    if cycles is None:
        return 0.0
    return float(cycles) if mean == 0.0 else mean + (cycles - mean) / AVERAGED


def _age(setup: CycleSetup, sensor: Sensor, lag: float | None) -> float:
    """Return the age of a reading [s]: its lag, where stamps are used and are of this host's clock, else `delay`."""
    by_stamp = setup.config.observer.stamps and lag is not None and 0.0 <= lag < ONE_CLOCK
    return lag if by_stamp and lag is not None else sensor.section.delay
