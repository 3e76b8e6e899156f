"""The interface of a rod to controller and studies; `model.rod.rod.Rod` and `rods.general.GeneralRod` have it."""

from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from tendond.model.rod.loads import ZERO
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.prediction import TipPrediction
from tendond.model.rod.state import RodState
from tendond.model.rod.tip import Tip
from tendond.model.rods.general import GeneralState

Array = NDArray[np.float64]

ModelState = RodState | GeneralState
"""State of either rod. A rod takes its own states only."""


class ModelRod(Protocol):
    """A rod that rests, steps, and says what a law needs to know of it."""

    time_step: float

    @property
    def parameters(self) -> RodParameters:
        """Its parameters, or those of the uniform rod that it is compared with (`rods.equivalent`): for scales."""

    @property
    def whole_steps(self) -> bool:
        """True if the tip's acceleration and input gain are those of the coming step, not of an instant."""

    @property
    def arm_stiffness(self) -> float:
        """Length over the compliance per length, L / int ds/EI [N m^2]: between nodes are equal parts of that."""

    def solve_static(self, tensions: ArrayLike | None = None, *, tip_force: ArrayLike = ZERO, start: Any = None) -> Any:
        """Find the equilibrium at rest.

        Args:
            tensions: [N], shape (n,). tip_force: world frame [N], shape (3,). start: a neighbouring equilibrium.

        Raises:
            ConvergenceError: none was found.
        """

    def step(self, state: Any, tensions: ArrayLike | None = None, *, tip_force: ArrayLike = ZERO) -> Any:
        """Compute the state one time step later; arguments as in `solve_static`.

        Raises:
            ConvergenceError: the step was not solved.
        """

    def tip(self, state: Any) -> Tip:
        """Return the tip."""

    def displacements(self, state: Any, *, elastic: bool = False) -> Array:
        """Return the tendons' displacements [m], shape (n,); `elastic`: with the tendons' own stretch."""

    def predict(self, state: Any, tensions: Array, inputs: Array, tip_force: Array) -> TipPrediction:
        """Predict the tip after the coming step, and its jacobian by combinations of tensions, shape (2, n).

        Raises:
            ConvergenceError: there is no such step.
        """

    def velocity_jacobian(self, state: Any, tendon: int) -> Array:
        """Return the derivative of the tip's velocity after a step by a tendon's tension [m/s/N], shape (3,).

        Of whole steps it is the input gain times the time step.
        """

    def node_positions(self, state: Any) -> Array:
        """Return points of the backbone with equal parts of the compliance between them [m], shape (nodes, 3)."""

    def curve(self, state: Any, points: int = 50) -> Array:
        """Return evenly spaced points of the backbone, for display [m], shape (points, 3)."""

    def tendon_paths(self, state: Any, points: int = 10) -> list[Array]:
        """Return points of each tendon, for display, world frame [m], shapes (k, 3), k up to `points`."""
