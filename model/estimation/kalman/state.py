"""State of the estimator between two cycles."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.model.estimation.contact.state import Contact, ContactState
from tendond.model.estimation.kalman.memory import Moment

Array = NDArray[np.float64]


@dataclass(frozen=True)
class EstimatorState:
    """What the estimator knows beside the model's state, of which it is the error; vectors in the world frame.

    Attributes:
        moments: memory of the last cycles, the newest last. front: tick up to which measurements have been taken.
        force: on the tip, beside the rod's own weight [N], shape (3,).
        tension_error: of the tensions that act, beside those that the actuators are estimated to apply [N], (n,).
        bend_error: of the bending moments, see `ErrorLayout` [N m], (b,).
        stiffness_error: of the robot's stiffness, relative to it [-].
        innovation: of the newest tip pose, measured minus expected position [m], shape (3,).
        consistency: mean square of the innovations in units of their expected spread, over a second [-]: 1 is right.
        recent: of the last measurements, the newest last, shape (w,).
        jumped: tick at which a load was last taken to have come; -1: never.
        quiet: ticks after it until the next may be.
        contacts: the search for contacts; none: none is sought.
        tip_mass: on the tip beside the robot's own [kg].
    """

    moments: tuple[Moment, ...]
    front: int
    force: Array
    tension_error: Array
    bend_error: Array
    stiffness_error: float
    innovation: Array
    consistency: float
    recent: Array
    jumped: int = -1
    quiet: int = 0
    contacts: ContactState | None = None
    tip_mass: float = 0.0

    @property
    def contact(self) -> Contact | None:
        """Contact with the body, if one is known."""
        return None if self.contacts is None else self.contacts.contact

    @property
    def tip_force(self) -> Array:
        """Force on the model's tip in its next step [N], shape (3,)."""
        return self.force

    def acting(self, tensions: Array) -> Array:
        """Return tensions with their estimated errors [N], shape (m,); a slack tendon has none."""
        return np.where(tensions > 0.0, np.maximum(tensions + self.tension_error, 0.0), 0.0)

    @property
    def pull(self) -> Array:
        """Zero: the model's state is moved, not pulled."""
        return np.zeros(3)

    @property
    def offset(self) -> Array:
        """Zero: the model's tip is the estimate."""
        return np.zeros(3)
