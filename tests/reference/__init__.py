"""A plain reference implementation of the Cosserat rod, to compare the compiled model with. See README.md."""

from tests.reference.converged import ConvergedShape, converged_static
from tests.reference.displacement import solve_static_displacements, step_displacements
from tests.reference.equations import Loads
from tests.reference.rod import ReferenceRod
from tests.reference.schemes import CLASSICAL_RK4, EULER, MIDPOINT, Scheme, Tableau, euler, runge_kutta
from tests.reference.solution import Solution, Tip
from tests.reference.solver import ReferenceModel

__all__ = [
    "CLASSICAL_RK4",
    "EULER",
    "MIDPOINT",
    "ConvergedShape",
    "Loads",
    "ReferenceModel",
    "ReferenceRod",
    "Scheme",
    "Solution",
    "Tableau",
    "Tip",
    "converged_static",
    "euler",
    "runge_kutta",
    "solve_static_displacements",
    "step_displacements",
]
