"""The protocol of tasks: a task turns what is known of the tip into a law's observation and runs the law on it."""

from collections.abc import Callable
from typing import Any, ClassVar, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from tendond.daemon.control.reference.reference import Reference
from tendond.daemon.control.tasks.decision import Decision
from tendond.model.estimation.kalman.state import EstimatorState
from tendond.model.estimation.observer import ObserverState
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.tip import Tip
from tendond.model.rods.interface import ModelRod, ModelState
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.record import ReferencePoint

Array = NDArray[np.float64]


class Situation(NamedTuple):
    """State of knowledge at the moment of a law's decision; vectors in the world frame.

    Attributes:
        rod: the model; model: its state; tip: its tip.
        tension: tension now applied [N], shape (n,). acting: with its estimated error, as the model has it [N].
        observer: state of the tip observer, or of the estimator in its place.
        position, velocity: motion of the tip, as `control.feedback` has it [m, m/s], shape (3,).
        reference: point of the reference now.
        elapsed: time since tracking began [s].
        offset: shift of the reference along the straight rod [m].
        command: tension commanded last [N], shape (n,). displacement: of the tendons, estimated [m], shape (n,).
    """

    rod: ModelRod
    model: ModelState
    tip: Tip
    tension: Array
    acting: Array
    observer: ObserverState | EstimatorState
    position: Array
    velocity: Array
    reference: ReferencePoint
    elapsed: float
    offset: float
    command: Array
    displacement: Array


class Ruling(NamedTuple):
    """A law's decision, and the tension [N] that the task makes of it, shape (n,); before any limit."""

    decision: Decision
    tension: Array


Decide = Callable[[Any], Decision]
"""A law with its parameters and its state: from an observation to a decision."""


class Task(Protocol):
    """A reference, and the tendons with which a law is to follow it: a dataclass, whose reference may be replaced."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def reference(self) -> Reference:
        """Trajectory to follow."""

    def pretension(self, fraction: float) -> Array:
        """Return the pretension [N], shape (n,), of which `fraction` is reached."""

    def rule(self, decide: Decide, situation: Situation) -> Ruling:
        """Run the law on what it may observe of the situation."""


class TaskSpace(Protocol):
    """The kind of task that a law is made for."""

    def follows(self, section: ReferenceSection) -> bool:
        """True if references of that kind can be followed in it."""

    def tip_mass_max(self, config: RigConfig, rod: RodParameters) -> float:
        """Largest rod.tip_mass that the loop of such a law bears [kg]."""

    def task(self, config: RigConfig, rod: RodParameters, reference: Reference) -> Task:
        """Make the task of following a reference.

        Raises:
            ParameterError: the tendons cannot do it.
        """
