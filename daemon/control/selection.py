"""Law and reference in use: the configuration's, until an operator selects others while the arm is idle."""

from dataclasses import dataclass, replace
from typing import Any, Protocol

from tendond.daemon.control.gains import rate_objection
from tendond.daemon.control.laws import LAWS, Law, select_law
from tendond.daemon.control.pose.plan import follows_poses, plan_poses
from tendond.daemon.control.reference.planar import PlanarReference, plan_in_plane
from tendond.daemon.control.reference.reference import Reference
from tendond.daemon.control.reference.spatial import plan_in_space
from tendond.daemon.control.tasks.space import tendon_allocation
from tendond.daemon.control.tasks.task import Task
from tendond.daemon.errors import LawError
from tendond.model.errors import ParameterError
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.static_curve import StaticCurve
from tendond.model.rods.interface import ModelRod
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig


class SelectionSetup(Protocol):
    """Setup of the cycle, as far as a selection is made from it again."""

    @property
    def config(self) -> RigConfig:
        """Configuration of the rig."""

    @property
    def rod(self) -> ModelRod:
        """Model of the rod."""

    @property
    def selection(self) -> "Selection":
        """Selection that the configuration names."""


class PlanCache:
    """The reference planned last, beside the cycle: what `Selection.with_reference` would plan, which takes long.

    A plan is the same whoever makes it, so the cache changes how long a cycle takes, not its result.
    """

    def __init__(self) -> None:
        self._plan: tuple[str, ReferenceSection, Reference] | None = None

    def keep(self, law: str, section: ReferenceSection, reference: Reference) -> None:
        """Remember the plan for a law and a [reference]."""
        self._plan = (law, section, reference)

    def find(self, law: str, section: ReferenceSection) -> Reference | None:
        """Return the plan for a law and a [reference], if it is the one in the cache."""
        return self._plan[2] if self._plan is not None and self._plan[:2] == (law, section) else None


@dataclass(frozen=True)
class Selection:
    """The law and the reference selected, as data, and what follows from them.

    Attributes:
        law_name, section: name of the law, and [reference]; with the configuration these make the rest.
        law, parameters: the law of that name, and its parameters.
        task: the task of following the reference.
    """

    law_name: str
    section: ReferenceSection
    law: Law
    parameters: Any
    task: Task

    @property
    def reference(self) -> Reference:
        """Trajectory to follow, checked against what the rod can reach."""
        return self.task.reference

    @staticmethod
    def from_config(config: RigConfig, rod: ModelRod) -> "Selection":
        """Make the selection of a configuration.

        Raises:
            LawError: an unknown law or parameter, or a law that does not suit reference or tendons.
            TargetError: a reference that the rod cannot reach.
            ConvergenceError: the rod has no equilibrium.
        """
        return select(config, rod, config.control.law, config.reference)

    def to_snapshot(self) -> dict[str, Any]:
        """Return the data of it; the rest is made again from the configuration."""
        return {"law": self.law_name, "reference": self.section.model_dump(mode="json")}

    @classmethod
    def from_snapshot(cls, data: dict[str, Any], setup: SelectionSetup) -> "Selection":
        """Make the selection that `to_snapshot` wrote."""
        section = ReferenceSection.model_validate(data["reference"])
        present = setup.selection
        if section == present.section:
            return present.with_law(setup.config, setup.rod, data["law"])
        return select(setup.config, setup.rod, data["law"], section, present.curve)

    @property
    def curve(self) -> StaticCurve | None:
        """Tips of the resting rod in the bending plane, where they are known."""
        reference = self.reference
        return reference.curve if isinstance(reference, PlanarReference) else None

    def with_law(self, config: RigConfig, rod: ModelRod, name: str) -> "Selection":
        """Select another law, with the configuration's parameters, for the same reference.

        Raises:
            LawError: an unknown law, or one that does not suit reference, tendons or the observer's gains.
        """
        if objection := rate_objection(config, rod.parameters, name):
            raise LawError(objection)
        law, parameters = select_law(name, config.control.laws)
        _check(law, self.section)
        task = _task(config, rod, law, self.section, self.reference)
        return replace(self, law_name=name, law=law, parameters=parameters, task=task)

    def with_reference(
        self, config: RigConfig, rod: ModelRod, section: ReferenceSection, plans: PlanCache | None = None
    ) -> "Selection":
        """Select another reference, planned here unless `plans` has it.

        Raises:
            LawError: the law does not follow such references.
            TargetError: the rod cannot reach it.
        """
        _check(self.law, section)
        planned = None if plans is None else plans.find(self.law_name, section)
        if planned is None:
            planned = _plan(config, rod, self.law, section, self.curve)
        return replace(self, section=section, task=_task(config, rod, self.law, section, planned))


def select(
    config: RigConfig, rod: ModelRod, name: str, section: ReferenceSection, curve: StaticCurve | None = None
) -> Selection:
    """Select a law and plan a reference for it.

    Args:
        config: configuration of the rig.
        rod: the controller's model.
        name: name of the law.
        section: [reference].
        curve: tips of the resting rod in the bending plane, where they are known already.

    Raises:
        LawError: an unknown law or parameter, or a law that does not suit reference or tendons.
        TargetError: a reference that the rod cannot reach.
        ConvergenceError: the rod has no equilibrium.
    """
    law, parameters = select_law(name, config.control.laws)
    _check(law, section)
    planned = _plan(config, rod, law, section, curve)
    return Selection(name, section, law, parameters, _task(config, rod, law, section, planned))


def _plan(
    config: RigConfig, rod: ModelRod, law: Law, section: ReferenceSection, curve: StaticCurve | None
) -> Reference:
    config = config.model_copy(update={"reference": section})
    if not section.in_space:
        return plan_in_plane(config, rod, curve)
    try:
        if follows_poses(config, section):
            return plan_poses(config, rod)
        allocation = tendon_allocation(config, rod.parameters)
    except ParameterError as error:
        raise _unsuitable(law, error) from error
    return plan_in_space(config, rod, allocation)


def tip_objection(config: RigConfig, rod: RodParameters, law: Law) -> str:
    """Say that the body on the model's tip makes a law unstable; empty if it does not."""
    mass, mass_max = rod.tip_mass, law.task_space.tip_mass_max(config, rod)
    if mass <= mass_max:
        return ""
    able = " or ".join(name for name, one in LAWS.items() if mass <= one.task_space.tip_mass_max(config, rod))
    borne = f"of which it bears 0 to {mass_max:.2g} kg at {1.0 / config.loop.period:g} Hz"
    return (
        f"control.law: {law.name} swings the arm with {mass:g} kg on the tip of its model, {borne} on the shooting "
        f'rod: set control.solver = "general", where it moves the arm along its rests and bears any, or select {able}'
    )


def _task(config: RigConfig, rod: ModelRod, law: Law, section: ReferenceSection, reference: Reference) -> Task:
    config = config.model_copy(update={"reference": section})
    if objection := tip_objection(config, rod.parameters, law):
        raise LawError(objection)
    try:
        return law.task_space.task(config, rod.parameters, reference)
    except ParameterError as error:
        raise _unsuitable(law, error) from error


def _unsuitable(law: Law, error: ParameterError) -> LawError:
    return LawError(f"the law {law.name} bends the rod to every side: {error}")


def _check(law: Law, section: ReferenceSection) -> None:
    """Refuse a trajectory in space for a law that moves the tip in the bending plane only."""
    if not law.task_space.follows(section):
        able = ", ".join(name for name, one in LAWS.items() if one.task_space.follows(section))
        raise LawError(
            f"the law {law.name} moves the tip in the bending plane, and reference.kind = '{section.kind}' is in "
            f"space: select the law {able} for it, or another reference"
        )
