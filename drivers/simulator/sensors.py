"""Simulated sensors beside the camera: rows from the plant's truth, with noise, delay and a rate of their own."""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.drivers.simulator.cross_sections import cross_sections, tip_motion
from tendond.drivers.simulator.faults import Faults
from tendond.drivers.simulator.mocap import TOLERANCE
from tendond.drivers.simulator.rods import PlantRod
from tendond.drivers.simulator.rotations import turned
from tendond.schemas.base import Vector3
from tendond.schemas.config.sensors.section import SensorSection
from tendond.schemas.faults import Fault
from tendond.schemas.messages import SensorReading

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Truth:
    """The plant as its sensors measure it.

    Attributes:
        rod: of the plant. before, state: of it, a step apart, or the same at rest.
        pull: of the tendons at the servos' ends [N], shape (n,).
        gravity: base's frame [m/s^2].
    """

    rod: PlantRod
    before: Any
    state: Any
    pull: Array
    gravity: Vector3


def true_rows(sensor: SensorSection, truth: Truth) -> Array:
    """Return what the sensor would measure without errors, shape (rows, width); see `SensorSection`."""
    match sensor.kind:
        case "markers":
            found = cross_sections(truth.rod, truth.state, np.array(sensor.at))
            offsets = np.einsum("kij,kj->ki", found.rotation, np.array(sensor.offsets))
            return np.asarray(found.position + offsets)
        case "curvature":
            return cross_sections(truth.rod, truth.state, np.array(sensor.at)).curvature
        case "tension":
            return truth.pull[list(sensor.tendons)][:, None]
        case "imu":
            rate, acceleration = tip_motion(truth.rod, truth.before, truth.state)
            felt = truth.rod.tip(truth.state).rotation.T @ (acceleration - np.array(truth.gravity))
            return np.concatenate((rate, felt))[None]
        case "base":  # the plant's stands where it is configured
            return np.array([[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])


class SimulatedSensor:
    """One sensor of a simulated rig.

    Args:
        section: of [[sensors]].
        seed: of its random numbers.
        faults: faults that requests have caused.
    """

    def __init__(self, section: SensorSection, seed: Sequence[int], faults: Faults) -> None:
        self._section = section
        self._faults = faults
        self._random = np.random.default_rng(seed)
        self._next = -math.inf
        self._pending: deque[tuple[float, SensorReading]] = deque()
        self._seq = -1

    def read(self, truth: Truth, time: float, stamp_ns: int) -> SensorReading | None:
        """Measure if it is time to, and return the newest reading that arrives by `time` [s], if any.

        Args:
            truth: the plant now.
            time: simulated [s].
            stamp_ns: capture time to write into a reading measured now.
        """
        section = self._section
        if time >= self._next - TOLERANCE:
            period = 0.0 if section.rate is None else 1.0 / section.rate
            self._next = (self._next if self._next >= time - period else time) + period
            if self._faults.of_sensor(Fault.MUTE, section.name) is None:
                self._seq += 1
                rows = self._rows(truth)
                reading = SensorReading(seq=self._seq, stamp_ns=stamp_ns, rows=rows)
                self._pending.append((time + section.delay, reading))
        arrived = None
        while self._pending and self._pending[0][0] <= time + TOLERANCE:
            arrived = self._pending.popleft()[1]
        return arrived

    def _rows(self, truth: Truth) -> tuple[tuple[float, ...] | None, ...]:
        measured = self._with_noise(true_rows(self._section, truth))
        rows: list[tuple[float, ...] | None] = [tuple(row) for row in measured.tolist()]
        if (swapped := self._faults.of_sensor(Fault.SWAPPED, self._section.name)) is not None:
            one, other = swapped.rows or (0, 1)
            rows[one], rows[other] = rows[other], rows[one]
        if (lost := self._faults.of_sensor(Fault.UNSEEN, self._section.name)) is not None:
            for row in lost.rows or range(len(rows)):
                rows[row] = None
        return tuple(rows)

    def _with_noise(self, rows: Array) -> Array:
        """Return the rows with noise; that of a base's orientation is a rotation about its own axes."""
        deviations = np.array(self._section.deviations)
        noise = deviations * self._random.standard_normal((len(rows), len(deviations)))
        if self._section.kind != "base":
            return rows + noise
        return np.array(
            [
                [*(row[:3] + error[:3]), *turned((w, x, y, z), 0.5 * error[3:])]
                for row, error in zip(rows, noise, strict=True)
                for w, x, y, z in [row[3:].tolist()]
            ]
        )


class SimulatedSensors:
    """All sensors of a simulated rig.

    Args:
        sections: [[sensors]].
        seed: of the simulator's random numbers.
        faults: faults that requests have caused.
    """

    def __init__(self, sections: Sequence[SensorSection], seed: int, faults: Faults) -> None:
        self._sensors = {one.name: SimulatedSensor(one, [seed, 2, i], faults) for i, one in enumerate(sections)}

    def read(self, truth: Truth, time: float, stamp_ns: int) -> dict[str, SensorReading]:
        """Return the readings that arrive now, by the sensor's name; arguments as in `SimulatedSensor.read`."""
        found = {name: sensor.read(truth, time, stamp_ns) for name, sensor in self._sensors.items()}
        return {name: reading for name, reading in found.items() if reading is not None}
