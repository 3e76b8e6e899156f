"""What sensors are expected to read, and its derivatives by the errors."""

from typing import Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.estimation.kalman.errors import ErrorLayout
from tendond.model.estimation.kalman.memory import Expected
from tendond.model.rods.general import GeneralRod, GeneralState

Array = NDArray[np.float64]


class Sensor(Protocol):
    """A sensor on the robot.

    Attributes:
        deviation: standard deviation of each number that it reads, shape (r,), of a pose (6,).
        group: numbers that are believed or refused together.
    """

    deviation: Array
    group: int

    def expect(self, rod: GeneralRod, errors: ErrorLayout, state: GeneralState) -> Expected:
        """Return the expected reading at a state."""


class TipPose:
    """Pose of the tip: position [m], and orientation if its noise is given.

    Args:
        position: standard deviation of each coordinate [m]. orientation: about each axis [rad]; 0: it is not read.
    """

    def __init__(self, position: float, orientation: float) -> None:
        self.deviation = np.array([position] * 3 + [orientation] * 3)[: 6 if orientation > 0.0 else 3]
        self.group = len(self.deviation)

    def expect(self, rod: GeneralRod, errors: ErrorLayout, state: GeneralState) -> Expected:
        """Return the expected pose; see `Sensor`."""
        shape = rod.strain_rod.shape(state.strain)
        twist, place = shape.twist[-1][:, errors.kept], shape.position[-1]
        rows = np.zeros((self.group, errors.size))
        rows[:3, errors.strain] = moved(twist, place)
        rows[3:, errors.strain] = twist[: self.group - 3]
        return Expected(place.copy(), rows, shape.rotation[-1].reshape(3, 3).copy())


class Markers:
    """Markers on cross-sections, [m] in the world frame.

    Args:
        at: arc lengths [m]. offset: from the backbone, in each cross-section's frame [m], shape (p, 3).
        deviation: standard deviation of each coordinate [m], shape (3 p,).
    """

    group = 3

    def __init__(self, at: ArrayLike, offset: ArrayLike, deviation: Array) -> None:
        self._at = np.atleast_1d(np.asarray(at, dtype=np.float64))
        self._offset = np.broadcast_to(np.asarray(offset, dtype=np.float64), (len(self._at), 3))
        self.deviation = deviation

    def expect(self, rod: GeneralRod, errors: ErrorLayout, state: GeneralState) -> Expected:
        """Return the expected positions; see `Sensor`."""
        places, turns, twists = rod.backbone.frames(state.strain, self._at)
        points = places + np.einsum("pij,pj->pi", turns, self._offset)
        rows = np.zeros((len(points), 3, errors.size))
        for row, twist, point in zip(rows, twists, points, strict=True):
            row[:, errors.strain] = moved(twist[:, errors.kept], point)
        return Expected(points.reshape(-1), rows.reshape(-1, errors.size))


class Curvature:
    """Bending strains about the cross-section's own axes, by fibre gratings [1/m].

    Args:
        at: arc lengths [m]. deviation: standard deviation of each number [1/m], shape (2 p,).
    """

    group = 2

    def __init__(self, at: ArrayLike, deviation: Array) -> None:
        self._at = np.atleast_1d(np.asarray(at, dtype=np.float64))
        self.deviation = deviation

    def expect(self, rod: GeneralRod, errors: ErrorLayout, state: GeneralState) -> Expected:
        """Return the expected strains; see `Sensor`."""
        values, reference = rod.backbone.bending(self._at)
        rows = np.zeros((len(self.deviation), errors.size))
        rows[:, errors.strain] = values[:, errors.kept]
        return Expected(reference + values @ state.strain.strain, rows)


class Tension:
    """Tensions at the servos' ends, by load cells [N].

    Args:
        tendons: indices of them. deviation: standard deviation of each [N], shape (p,).
    """

    group = 1

    def __init__(self, tendons: ArrayLike, deviation: Array) -> None:
        self._tendons = np.asarray(tendons, dtype=np.int64)
        self.deviation = deviation

    def expect(self, rod: GeneralRod, errors: ErrorLayout, state: GeneralState) -> Expected:
        """Return the expected tensions; see `Sensor`."""
        rows = np.zeros((len(self._tendons), errors.size))
        rows[np.arange(len(rows)), errors.tension.start + self._tendons] = 1.0
        return Expected(state.tensions[self._tendons], rows)


ACCELERATION_ERROR = 1.0
"""Standard deviation of the model's acceleration of the tip [m/s^2]: gravity's direction to 6 degrees."""


class Imu:
    """Rates, and acceleration minus gravity, of the tip in its own frame [rad/s, m/s^2].

    Args:
        deviation: standard deviation of each number, shape (6,).
    """

    group = 3

    def __init__(self, deviation: Array) -> None:
        self.deviation = np.hypot(deviation, [0.0] * 3 + [ACCELERATION_ERROR] * 3)

    def expect(self, rod: GeneralRod, errors: ErrorLayout, state: GeneralState) -> Expected:
        """Return the expected reading; see `Sensor`."""
        strain, shape = state.strain, rod.strain_rod.shape(state.strain)
        turn, twist = shape.rotation[-1].reshape(3, 3), shape.twist[-1, :3, : rod.strain_rod.modes]
        before = strain.rate if strain.earlier is None else strain.earlier[0]
        gained = rod.strain_rod.tip_jacobian(strain) @ (strain.rate - before) / rod.time_step
        force = gained - np.array(rod.robot.gravity)
        rows = np.zeros((6, errors.size))
        rows[:3, errors.rate] = turn.T @ twist[:, errors.kept]
        rows[3:, errors.strain] = turn.T @ np.cross(force, twist[:, errors.kept], axisb=0, axisc=0)
        return Expected(np.concatenate((turn.T @ twist @ strain.rate, turn.T @ force)), rows)


def moved(twist: Array, point: Array) -> Array:
    """Return the motion of a point [m] by spatial twists, shape (6, k); shape (3, k)."""
    return np.asarray(np.cross(twist[:3], point, axisa=0, axisc=0) + twist[3:])
