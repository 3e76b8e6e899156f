"""Stretches of a log in which the arm is driven: what the model was given in each period, and what was measured."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.estimation.estimator import other_readings, pose_reading
from tendond.daemon.control.phases.monitors import ONE_CLOCK
from tendond.daemon.control.sensors import Reading as Admitted
from tendond.daemon.control.sensors import sensor_reason
from tendond.model.estimation.kalman.memory import Reading
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Mode
from tendond.schemas.record import CycleRecord

Array = NDArray[np.float64]

BEFORE = 0.5
"""Time at rest before the arm is driven that belongs to a stretch [s]: it shows how it hangs. Chosen."""

DRIVEN = (Mode.PRETENSION, Mode.TRACKING, Mode.RELEASING)


@dataclass(frozen=True)
class Instant:
    """A period of the loop: the model rests in the state before it, is corrected, and makes a step.

    Attributes:
        tick: of its cycle; none of a period that the loop missed.
        time: since the first cycle of the log, with the periods that were missed [s].
        tensions: that the actuators are estimated to apply during it [N], shape (m,).
        readings: with ages against the model.
    """

    tick: int | None
    time: float
    tensions: Array
    readings: tuple[Reading, ...]


@dataclass(frozen=True)
class Stretch:
    """Periods in a row, and tensions before the first of them [N], shape (m,)."""

    instants: tuple[Instant, ...]
    before: Array

    @property
    def poses(self) -> int:
        """Number of poses."""
        return sum(reading.sensor == 0 for one in self.instants for reading in one.readings)


def stretches(config: RigConfig, records: Sequence[CycleRecord]) -> list[Stretch]:
    """Return the stretches of a log in which tendons pull, each with a little rest before it.

    A cycle that is not in the log ends one; periods that the loop missed do not.
    """
    rests = math.ceil(BEFORE / config.loop.period)
    missed = np.cumsum([one.inputs.missed_ticks for one in records])
    found = []
    for driven, last in _driven(records):
        first = driven
        while first > max(0, driven - rests) and _rests(records, first - 1):
            first -= 1
        found.append(_stretch(config, records, first, last, missed))
    return found


def _driven(records: Sequence[CycleRecord]) -> Iterator[tuple[int, int]]:
    """Yield the first and the last place of each run of cycles in which the arm is driven."""
    first: int | None = None
    for i, record in enumerate(records):
        driven = record.mode in DRIVEN or (record.mode is Mode.FAULT and max(record.tension_estimate) > 0.0)
        if first is not None and (not driven or record.tick != records[i - 1].tick + 1):
            yield first, i - 1
            first = None
        if driven and first is None:
            first = i
    if first is not None:
        yield first, len(records) - 1


def _rests(records: Sequence[CycleRecord], i: int) -> bool:
    """True if the arm rests in a cycle, and the next one in the log follows it."""
    record = records[i]
    slack = record.mode in (Mode.IDLE, Mode.STARTING) and max(record.tension_estimate) == 0.0
    return slack and records[i + 1].tick == record.tick + 1


def _stretch(config: RigConfig, records: Sequence[CycleRecord], first: int, last: int, missed: Array) -> Stretch:
    period, instants = config.loop.period, []
    continued = first > 0 and records[first].tick == records[first - 1].tick + 1
    before = np.array(records[first - 1 if continued else first].tension_estimate)
    held = before
    fastest = min((lag for one in records[first : last + 1] if (lag := one.inputs.pose_lag) is not None), default=0.0)
    for i in range(first, last + 1):
        record = records[i]
        time = record.time + period * float(missed[i])
        if i > first:
            for late in range(record.inputs.missed_ticks, 0, -1):
                instants.append(Instant(None, time - late * period, held, ()))
        held = np.array(record.tension_estimate)
        instants.append(Instant(record.tick, time, held, tuple(_readings(config, record, fastest))))
    return Stretch(tuple(instants), before)


def _readings(config: RigConfig, record: CycleRecord, fastest: float) -> Iterator[Reading]:
    """Yield what was measured and admitted in a cycle; `fastest`: least lag of a pose in the stretch [s]."""
    section, inputs = config.observer, record.inputs
    if inputs.pose is not None and record.pose_age == 0:
        lag, age = inputs.pose_lag, section.delay
        if section.stamps and lag is not None:
            age = lag if 0.0 <= lag < ONE_CLOCK else lag - fastest
        yield pose_reading(np.array(inputs.pose.position), inputs.pose.orientation, age + section.command_delay)
    admitted = []
    for sensor in config.sensors:
        reading, lag = inputs.readings.get(sensor.name), inputs.reading_lags.get(sensor.name)
        refused = any(one.startswith(sensor_reason(sensor.name, "")) for one in record.rejected)
        if reading is not None and not refused:
            stamped = section.stamps and lag is not None and 0.0 <= lag < ONE_CLOCK
            admitted.append(Admitted(sensor.name, reading.rows, lag if stamped and lag is not None else sensor.delay))
    yield from other_readings(config, tuple(admitted))
