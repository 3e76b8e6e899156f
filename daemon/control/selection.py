"""Law and reference in use: the configuration's, until an operator chooses others while the arm is idle."""

import math
from dataclasses import dataclass, replace
from typing import Any, Protocol

from tendond.daemon.control.laws import LAWS, Law, LawParameters, select_law
from tendond.daemon.control.reference.feasibility import feasibility
from tendond.daemon.control.reference.planar import Reference, build_reference
from tendond.daemon.control.reference.spatial import Course, build_course
from tendond.daemon.errors import LawError
from tendond.model.errors import ParameterError
from tendond.model.estimation.margin import EARTH
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.model.rod.static_curve import StaticCurve
from tendond.model.tendons.allocation import Allocation
from tendond.schemas.config.control import LimitsSection
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig

Planned = Reference | Course

AHEAD_TIP_LOAD = 0.2
"""Largest P L^2/EI of the model's own tip body under a law that looks ahead: 12 g on the paper's robot. Such a law asks
for a tip that is moved within a cycle, and its agility does not suffice for a heavy one: it then swings the arm. From
runs with plant = model at 100 Hz: they settle at 0.22 to 0.25 and swing at 0.33 to 0.35, with E -30 %, as it is, and
+50 %. The tests hold both sides."""

AHEAD_PERIODS = 15.0
"""Cycles in sqrt(rho A L^4/EI), below which the bound falls with the third power of their number: from the same runs at
50, 70, 100 and 250 Hz, which swing with 2, 10, 20 and 30 g and settle with none, 5, 15 and 25 g."""


class SetupOfCycle(Protocol):
    """Setup of the cycle, as far as a selection is made from it again."""

    @property
    def config(self) -> RigConfig:
        """Configuration of the rig."""

    @property
    def rod(self) -> Rod:
        """Model of the rod."""

    @property
    def selection(self) -> "Selection":
        """Selection that the configuration names."""


class Plans:
    """References that were planned beforehand: what `Selection.with_reference` would make, which takes long to compute.

    It holds the newest one only. A plan is the same whoever makes it, so it changes what a cycle takes, not what it
    gives.
    """

    def __init__(self) -> None:
        self._plan: tuple[str, ReferenceSection, Planned, str] | None = None

    def keep(self, law: str, section: ReferenceSection, reference: Planned, remark: str) -> None:
        """Remember a plan for a law and a [reference], and what `feasibility` says of it."""
        self._plan = (law, section, reference, remark)

    def find(self, law: str, section: ReferenceSection) -> Planned | None:
        """The plan for a law and a [reference], if that is the one here."""
        return self._plan[2] if self._plan is not None and self._plan[:2] == (law, section) else None

    def remark(self, reference: Planned, limits: LimitsSection) -> str:
        """What `feasibility` says of a reference, reckoned here where it was not planned."""
        planned = self._plan is not None and self._plan[2] is reference
        return self._plan[3] if planned and self._plan is not None else feasibility(reference, limits)


@dataclass(frozen=True)
class Selection:
    """What is chosen, as data, and what follows from it.

    Attributes:
        law_name: of the law. section: of the reference; these two and the configuration make the rest.
        law, parameters: of that name.
        allocation: of the tendons' tensions, for a law that looks ahead.
        reference: checked against what the rod can reach.
    """

    law_name: str
    section: ReferenceSection
    law: Law
    parameters: LawParameters
    allocation: Allocation | None
    reference: Planned

    @staticmethod
    def from_config(config: RigConfig, rod: Rod) -> "Selection":
        """What the configuration chooses.

        Raises:
            LawError: an unknown law or parameter.
            TargetError: a reference that the rod cannot reach.
            ConvergenceError: the rod has no equilibrium.
        """
        law, parameters = select_law(config.control.law, config.control.laws)
        _check(law, config.reference)
        allocation = _allocation(config, law)
        reference = _build(config, rod, None, allocation)
        return Selection(config.control.law, config.reference, law, parameters, allocation, reference)

    def to_snapshot(self) -> dict[str, Any]:
        """What of it is data, as JSON has it."""
        return {"law": self.law_name, "reference": self.section.model_dump(mode="json")}

    @classmethod
    def from_snapshot(cls, data: dict[str, Any], setup: SetupOfCycle) -> "Selection":
        """What was chosen when `to_snapshot` wrote it down."""
        section = ReferenceSection.model_validate(data["reference"])
        law, parameters = select_law(data["law"], setup.config.control.laws)
        selection = replace(
            setup.selection,
            law_name=data["law"],
            law=law,
            parameters=parameters,
            allocation=_allocation(setup.config, law),
        )
        return selection if section == selection.section else selection.with_reference(setup.config, setup.rod, section)

    def with_law(self, config: RigConfig, name: str, section: ReferenceSection | None = None) -> "Selection":
        """Another law, with the configuration's parameters.

        Args:
            config: of the rig.
            name: of the law.
            section: of the reference that it is to go with; left out: the present one.

        Raises:
            LawError: an unknown law, or one that does not go with the reference or the tendons.
        """
        law, parameters = select_law(name, config.control.laws)
        _check(law, section or self.section)
        return replace(self, law_name=name, law=law, parameters=parameters, allocation=_allocation(config, law))

    def with_reference(
        self, config: RigConfig, rod: Rod, section: ReferenceSection, plans: Plans | None = None
    ) -> "Selection":
        """Another reference, planned here where `plans` does not have it; the curve of resting tips stays.

        Raises:
            LawError: the law does not follow such references.
            TargetError: the rod cannot reach it.
        """
        _check(self.law, section)
        if plans is not None and (planned := plans.find(self.law_name, section)) is not None:
            return replace(self, section=section, reference=planned)
        changed = config.model_copy(update={"reference": section})
        curve = self.reference.curve if isinstance(self.reference, Reference) else None
        return replace(self, section=section, reference=_build(changed, rod, curve, self.allocation))


def _build(config: RigConfig, rod: Rod, curve: StaticCurve | None, allocation: Allocation | None) -> Planned:
    if allocation is not None and config.reference.in_space:
        return build_course(config, rod, allocation)
    return build_reference(config, rod, curve)


def _check(law: Law, section: ReferenceSection) -> None:
    """Refuse a course in space for a law that moves the tip in the bending plane only."""
    if section.in_space and not law.looks_ahead:
        able = ", ".join(name for name, one in LAWS.items() if one.looks_ahead)
        raise LawError(
            f"the law {law.name} moves the tip in the bending plane, and reference.kind = '{section.kind}' is in "
            f"space: select the law {able} for it, or another reference"
        )


def max_tip_mass(config: RigConfig, law: Law) -> float:
    """Largest rod.tip_mass that the law's own loop bears [kg]; infinite for a law that does not look ahead."""
    if not law.looks_ahead:
        return math.inf
    rod = RodParameters(**config.rod.model_dump(exclude={"space", "nodes", "alpha", "tendon_stiffness"}))
    mass = AHEAD_TIP_LOAD * rod.bending_stiffness / (EARTH * rod.length**2)
    rod_time = math.sqrt(rod.mass_per_length * rod.length**4 / rod.bending_stiffness)
    return mass * min(1.0, (rod_time / (AHEAD_PERIODS * config.loop.period)) ** 3)


def tip_objection(config: RigConfig, law: Law) -> str:
    """Why a law must not be used with the body on the model's tip, which makes it unstable; empty if it may."""
    mass, bound = config.rod.tip_mass, max_tip_mass(config, law)
    if mass <= bound:
        return ""
    able = " or ".join(name for name, one in LAWS.items() if not one.looks_ahead)
    return (
        f"control.law: {law.name} swings the arm with rod.tip_mass = {mass:g} kg in its model, of which it bears 0 to "
        f"{bound:.2g} kg at {1.0 / config.loop.period:g} Hz: set rod.tip_mass = 0.0, so that the observer carries it "
        f"as an unknown weight, or select {able}"
    )


def _allocation(config: RigConfig, law: Law) -> Allocation | None:
    """For a law that looks ahead; it keeps its scratch memory, and the setup its own."""
    if not law.looks_ahead:
        return None
    if objection := tip_objection(config, law):
        raise LawError(objection)
    try:
        return Allocation(config.rod.tendon_positions, config.pretension.tension_min, config.limits.tension_max)
    except ParameterError as error:
        raise LawError(f"the law {law.name} bends the rod to every side: {error}") from error
