"""The rod that a configuration asks for: the shooting rod where it solves the robot, else the general one."""

from dataclasses import dataclass, replace
from typing import Literal

from tendond.model.errors import ParameterError
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.model.rods.general import GeneralRod
from tendond.model.rods.interface import ModelRod
from tendond.model.strain.describe.configured import robot_from_section
from tendond.schemas.config.rates import damping_ratio
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.rod.swing import DAMPING_MIN, sags

Solver = Literal["shooting", "general"]


@dataclass(frozen=True)
class RodSource:
    """Source of a rod: what it is made from; hashable.

    Attributes:
        section: [rod] or [simulator.rod], as JSON. time_step: [s]. solver: which rod.
    """

    section: str
    time_step: float
    solver: Solver

    def rod(self, compliance: float = 1.0) -> ModelRod:
        """Make the rod, its compliance multiplied by a factor [-].

        Raises:
            ParameterError: a robot that cannot be, or that this solver does not describe.
        """
        section = RodSection.model_validate_json(self.section)
        if self.solver == "general":
            return GeneralRod(robot_from_section(section), self.time_step, compliance)
        return rod_from_section(section, self.time_step, compliance)


def rod_from_section(section: RodSection, time_step: float, compliance: float = 1.0) -> Rod:
    """Make the shooting rod that [rod] or [simulator.rod] describes.

    Args:
        section: of a configuration. time_step: [s]. compliance: factor on the rod's [-].

    Raises:
        ParameterError: a robot that this rod does not describe.
    """
    if section.not_uniform:
        raise ParameterError(f"{section.not_uniform}: the shooting rod is one straight, uniform section")
    parameters = RodParameters(**section.parameters())
    if compliance != 1.0:
        parameters = replace(parameters, youngs_modulus=parameters.youngs_modulus / compliance)
    return Rod(parameters, section.space, section.nodes, time_step, section.alpha)


def solver_of(section: RodSection, wanted: Solver | None) -> Solver:
    """Return the solver: the one wanted, else the shooting rod where it describes the robot and its steps converge.

    The shooting rod has one tension for each tendon, and no friction of tendons.
    """
    if wanted is not None:
        return wanted
    if section.not_uniform or rubs(section) or damping_ratio(section) < DAMPING_MIN or sags(section):
        return "general"
    return "shooting"


def rubs(section: RodSection) -> bool:
    """Return whether a tendon has friction."""
    return any(one > 0.0 for one in section.frictions)


def source_of(config: RigConfig) -> RodSource:
    """Return what the controller's rod is made from."""
    solver = solver_of(config.rod, config.control.solver)
    return RodSource(config.rod.model_dump_json(), config.loop.period, solver)


def model_rod(config: RigConfig) -> ModelRod:
    """Make the controller's rod.

    Raises:
        ParameterError: a robot that cannot be, or that the named solver does not describe.
    """
    return source_of(config).rod()
