"""The estimator's memory of the last cycles, in which a measurement is taken at its own time."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.kalman.factored import Factors

Array = NDArray[np.float64]
Index = NDArray[np.int64]


@dataclass(frozen=True)
class Expected:
    """A sensor's reading, as the model expects it at one cycle.

    Attributes:
        value: SI, shape (r,); of a pose its position. rotation: of a pose, body to world, shape (3, 3), else none.
        rows: derivatives by the errors, shape (r, N), of a pose (6, N): position, then a small rotation vector.
    """

    value: Array
    rows: Array
    rotation: Array | None = None


@dataclass(frozen=True)
class Taken:
    """A measurement that was taken at a cycle.

    Attributes:
        rows: as in `Expected`, of what was measured, shape (r, N). lack: measured minus expected, shape (r,).
        variance: of the noise, shape (r,). sensor: index of it; 0 is the tip's pose.
        labels: of markers; none: there are none to be exchanged.
    """

    rows: Array
    lack: Array
    variance: Array
    sensor: int = 0
    labels: "Labels | None" = None


@dataclass(frozen=True)
class Pushes:
    """What forces along the body do in the step after a cycle.

    Attributes:
        push: strains and rates after it, by forces on the stations [1/N], shape (2 k, 3 p).
        fed: forces by which the model was pushed [N], shape (p, 3). lack: what they are known to have lacked since.
        axial: directions of the backbone at the stations, shape (p, 3). tension: of the tendons [N], shape (m,).
    """

    push: Array
    fed: Array
    lack: Array
    axial: Array
    tension: Array


@dataclass(frozen=True)
class Labels:
    """Numbers of a reading, to tell whether two labels were exchanged.

    Attributes:
        numbers: of the sensor, that were measured, shape (r,). seen: what they read [m], shape (r,).
        places: what all of the sensor's are expected to read, where errors are zero [m].
    """

    numbers: Index
    seen: Array
    places: Array

    def of(self, rows: Index) -> "Labels":
        """Return those of some of the numbers."""
        return Labels(self.numbers[rows], self.seen[rows], self.places)


@dataclass(frozen=True)
class Moment:
    """One cycle in the memory.

    Attributes:
        tick: number of it, from the start of the estimator.
        expected: of each sensor.
        before: expected errors before the measurements of this cycle, shape (N,); after: with them.
        moved: errors by which the model was moved at this cycle, shape (N,): the cycles after it do not have them.
        columns, spread: factors of the covariance before these measurements; none where they have not been needed yet.
        top, noise: transition of the errors to the next cycle, see `factored.propagate`; none of the newest.
        taken: measurements of this cycle. jumped: before them, a load was taken to have come.
        pushes: what contacts do in the step to the next cycle; none of the newest, and where none is sought.
    """

    tick: int
    expected: tuple[Expected, ...]
    before: Array
    after: Array
    moved: Array
    columns: Array | None = None
    spread: Array | None = None
    top: Array | None = None
    noise: Array | None = None
    taken: tuple[Taken, ...] = field(default=())
    jumped: bool = False
    pushes: Pushes | None = None

    @property
    def factors(self) -> Factors:
        """Covariance before the measurements of this cycle."""
        assert self.columns is not None
        assert self.spread is not None
        return Factors(self.columns, self.spread)


class Reading(NamedTuple):
    """A sensor's reading.

    Attributes:
        sensor: index of it; 0 is the tip's pose.
        age: since it was taken, against the model [s].
        value: SI, shape (r,); nan where it is missing. rotation: of a pose, body to world, shape (3, 3), or none.
    """

    sensor: int
    age: float
    value: Array
    rotation: Array | None = None
