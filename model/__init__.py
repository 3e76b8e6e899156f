"""The rod: parameters, equations, discretisation, statics, dynamics, tip. Pure numerics: no I/O, no clock."""

from tendond.model.errors import ConvergenceError, ModelError, ParameterError
from tendond.model.parameters import RodParameters
from tendond.model.rod import Rod
from tendond.model.rod_state import RodState
from tendond.model.sensitivity import Sensitivity
from tendond.model.tip import Tip

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
