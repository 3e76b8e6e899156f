"""Law and reference in use: the configuration's, until an operator chooses others while the arm is idle."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from tendond.daemon.laws import Law, LawParameters, select_law
from tendond.daemon.reference import Reference, build_reference
from tendond.model.rod import Rod
from tendond.schemas.config import RigConfig
from tendond.schemas.config_reference import ReferenceSection

if TYPE_CHECKING:
    from tendond.daemon.state import CycleSetup


@dataclass(frozen=True)
class Choice:
    """What is chosen, as data, and what follows from it.

    Attributes:
        law_name: of the law. section: of the reference; these two and the configuration make the rest.
        law, parameters: of that name.
        reference: checked against what the rod can reach.
    """

    law_name: str
    section: ReferenceSection
    law: Law
    parameters: LawParameters
    reference: Reference

    @staticmethod
    def from_config(config: RigConfig, rod: Rod) -> "Choice":
        """What the configuration chooses.

        Raises:
            LawError: an unknown law or parameter.
            TargetError: a reference that the rod cannot reach.
            ConvergenceError: the rod has no equilibrium.
        """
        law, parameters = select_law(config.control.law, config.control.laws)
        return Choice(config.control.law, config.reference, law, parameters, build_reference(config, rod))

    def to_snapshot(self) -> dict[str, Any]:
        """What of it is data, as JSON has it."""
        return {"law": self.law_name, "reference": self.section.model_dump(mode="json")}

    @classmethod
    def from_snapshot(cls, data: dict[str, Any], setup: "CycleSetup") -> "Choice":
        """What was chosen when `to_snapshot` wrote it down."""
        section = ReferenceSection.model_validate(data["reference"])
        choice = setup.choice.with_law(setup.config, data["law"])
        return choice if section == choice.section else choice.with_reference(setup.config, setup.rod, section)

    def with_law(self, config: RigConfig, name: str) -> "Choice":
        """Another law, with the configuration's parameters.

        Raises:
            LawError: an unknown law.
        """
        law, parameters = select_law(name, config.control.laws)
        return replace(self, law_name=name, law=law, parameters=parameters)

    def with_reference(self, config: RigConfig, rod: Rod, section: ReferenceSection) -> "Choice":
        """Another reference; the curve of resting tips, which takes long to compute, stays.

        Raises:
            TargetError: the rod cannot reach it.
        """
        changed = config.model_copy(update={"reference": section})
        return replace(self, section=section, reference=build_reference(changed, rod, self.reference.curve))
