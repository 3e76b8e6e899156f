"""The protocol of references: what the cycle and the tasks ask of one, in the bending plane or in space."""

from typing import Protocol

from tendond.daemon.control.reference.goal import Goal
from tendond.daemon.control.reference.load_offset import LoadOffset
from tendond.schemas.base import Vector3
from tendond.schemas.record import ReferencePoint


class Reference(Protocol):
    """Trajectory of the tip as a function of the time since tracking began."""

    @property
    def target(self) -> Vector3:
        """Final position of the tip [m]."""

    @property
    def aim(self) -> str:
        """'position' or 'direction': the quantity of the goal."""

    @property
    def arrival(self) -> float:
        """Time from which on the reference rests at its target, or nearly [s]."""

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks for the operator: how it was changed, and what will keep the tip from it."""

    @property
    def load_offset(self) -> LoadOffset | None:
        """Rule by which it yields to a load; none where every component was asked for."""

    def at(self, time: float) -> ReferencePoint:
        """Evaluate the trajectory at `time` [s], without load."""

    def goal(self, time: float) -> Goal:
        """Evaluate the goal of a law in space at `time` [s], without load."""
