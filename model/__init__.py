"""The rod: parameters, equations, discretisation, statics, dynamics, tip. Pure numerics: no I/O, no clock."""

from tendond.model.errors import ConvergenceError, ModelError, ParameterError
from tendond.model.rod.parameters import RodParameters
from tendond.model.rod.rod import Rod
from tendond.model.rod.sensitivity import Sensitivity
from tendond.model.rod.state import RodState
from tendond.model.rod.tip import Tip

__all__ = [
    "ConvergenceError",
    "ModelError",
    "ParameterError",
    "Rod",
    "RodParameters",
    "RodState",
    "Sensitivity",
    "Tip",
]
