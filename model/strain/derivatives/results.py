"""Linear models of a rod: a step's, its outputs', the tip's, an equilibrium's."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.strain.state import StrainState

Array = NDArray[np.float64]


@dataclass(frozen=True)
class StepSensitivity:
    """One step, and its derivatives; x = (q, w) has 2 n numbers: strains, then rates.

    Attributes:
        state: after the step.
        a: by x before it, shape (2 n, 2 n).
        b: by the actuation: tension [1/N], or displacement command [1/m] of a tendon that is driven so, (2 n, m).
        by_force: by a dead force at the place, world frame, shape (2 n, 3).
        by_moment: by a dead moment there, world frame, shape (2 n, 3).
        analytic: false where the step had to be split, and was differenced.
    """

    state: StrainState
    a: Array
    b: Array
    by_force: Array
    by_moment: Array
    analytic: bool


@dataclass(frozen=True)
class InputSensitivity:
    """One step, and what the actuation during it does to tip and tendons, as `StepSensitivity` has it; world frame.

    Attributes:
        state: after the step.
        whole: rows of position and rotation of the tip and the tendons' displacements, by columns of the actuation,
            of a dead force and of a dead moment at the place, shape (6 + m, m + 6).
        analytic: false where the step had to be split, and was differenced.
    """

    state: StrainState
    whole: Array
    analytic: bool

    @property
    def position(self) -> Array:
        """Position of the tip by the actuation, shape (3, m)."""
        return self.whole[:3, :-6]

    @property
    def rotation(self) -> Array:
        """Rotation of the tip by the actuation, as a small rotation vector, shape (3, m)."""
        return self.whole[3:6, :-6]

    @property
    def displacement(self) -> Array:
        """Displacements of the tendons by the actuation, shape (m, m)."""
        return self.whole[6:, :-6]

    @property
    def by_force(self) -> Array:
        """Position of the tip by the force [m/N], shape (3, 3)."""
        return self.whole[:3, -6:-3]


@dataclass(frozen=True)
class Outputs:
    """Measured quantities, by x = (q, w); the tip's in the world frame.

    Attributes:
        position: of the tip [m], shape (3, 2 n).
        rotation: of the tip, as a small rotation vector [rad], shape (3, 2 n).
        velocity: of the tip [m/s], shape (3, 2 n).
        displacement: of the tendons [m], shape (m, 2 n).
    """

    position: Array
    rotation: Array
    velocity: Array
    displacement: Array

    @property
    def c(self) -> Array:
        """All of them, one below the other, shape (9 + m, 2 n)."""
        return np.concatenate((self.position, self.rotation, self.velocity, self.displacement))


@dataclass(frozen=True)
class TipDynamics:
    """Motion of the tip at a state, world frame: acceleration = drift + input_gain @ tension.

    Attributes:
        acceleration: [m/s^2], shape (3,). drift: a_c [m/s^2], shape (3,).
        input_gain: b_c [m/s^2/N], shape (3, m). tension: now applied [N], shape (m,).
    """

    acceleration: Array
    drift: Array
    input_gain: Array
    tension: Array


@dataclass(frozen=True)
class Rest:
    """Derivatives of an equilibrium.

    Attributes:
        strain: by the actuation, as in `StepSensitivity`, shape (n, m).
        position: of the tip by the actuation, shape (3, m); rotation: of the tip, as a rotation vector, shape (3, m).
        by_force: of the tip's position by a dead force at the place [m/N], shape (3, 3).
        by_moment: by a dead moment there [1/N], shape (3, 3).
    """

    strain: Array
    position: Array
    rotation: Array
    by_force: Array
    by_moment: Array
