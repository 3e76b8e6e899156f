"""Unknown parameters of a measured robot, each with a prior, in groups that are fitted or left together."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from tendond.offline.validation.rods.design import Design

Array = NDArray[np.float64]

BASIC = ("pose", "length", "radius", "zeros")
"""Groups that are always fitted."""


@dataclass(frozen=True)
class Parameter:
    """An unknown number with its prior.

    Attributes:
        name, group, unit: of it. centre: of the prior. sigma: of it; relative where `relative`.
        relative: a positive number, whose logarithm is normal.
    """

    name: str
    group: str
    unit: str
    centre: float
    sigma: float
    relative: bool = False

    def value(self, z: float) -> float:
        """Return the number that lies z sigmas off the centre."""
        return self.centre * math.exp(self.sigma * z) if self.relative else self.centre + self.sigma * z

    def sigmas(self, value: float) -> float:
        """Return how many sigmas a number lies off the centre."""
        return math.log(value / self.centre) / self.sigma if self.relative else (value - self.centre) / self.sigma


def parameters_of(design: Design) -> list[Parameter]:
    """Return every parameter that a robot of this design has."""
    length, radius, sections = design.length, design.radius, len(design.lengths)
    found = [Parameter(f"base_turn_{axis}", "pose", "rad", 0.0, 0.5) for axis in "xyz"]
    found += [
        Parameter(f"base_{axis}", "pose", "m", value, 0.3 * length)
        for axis, value in zip("xyz", design.origin, strict=True)
    ]
    found += [
        Parameter(f"length_{i}", "length", "m", one, design.spread[0], True) for i, one in enumerate(design.lengths)
    ]
    found.append(Parameter("radius", "radius", "m", radius, design.spread[1], True))
    for i in range(len(design.angles)):
        found += [
            Parameter(f"zero_{i}", "zeros", "m", 0.0, 0.02 * length),
            Parameter(f"angle_{i}", "angles", "rad", 0.0, 0.1),
            Parameter(f"radius_{i}", "radii", "-", 1.0, 0.1, True),
        ]
    found.append(Parameter("spool", "spool", "-", 1.0, 0.3, True))
    found.append(Parameter("tendon_stiffness", "tendon_stiffness", "-", design.tendon_stiffness, 1.5, True))
    found += [
        Parameter(f"tendon_stiffness_{i}", "section_stiffness", "-", 1.0, 0.7, True)
        for i in range(sections if sections > 1 else 0)
    ]
    found.append(Parameter("axial_stiffness", "axial_stiffness", "-", design.axial_stiffness, 1.5, True))
    found += [Parameter(f"weight_{axis}", "weight", "-", 0.0, 0.5) for axis in "xyz"]
    found.append(Parameter("tip_weight", "tip_weight", "-", 0.1, 1.5, True))
    found += [
        Parameter(f"curvature_{axis}_{i}", "precurvature", "1/m", 0.0, 0.2 / design.lengths[i])
        for i in range(sections)
        for axis in "xy"
    ]
    found += [
        Parameter(f"marker_{axis}", "marker", "m", design.marker if axis == "z" else 0.0, 0.05 * length)
        for axis in "xyz"
    ]
    found += [
        Parameter("anisotropy", "anisotropy", "-", 1.0, 0.1, True),
        Parameter("torsion", "torsion", "-", 0.77, 1.0, True),
        Parameter("backlash", "backlash", "m", 0.001 * length, 1.0, True),
        Parameter("friction", "friction", "-", 0.1, 1.0, True),
        Parameter("yielding", "yielding", "-", 0.5, 1.0, True),
        Parameter("yield_curvature", "yielding", "1/m", 0.2 / length, 1.0, True),
    ]
    found += [Parameter(f"stiffening_{i}", "stiffening", "-", 1.0, 0.3, True) for i in range(1, sections)]
    return found


ABSENT = {"tip_weight": 0.0, "backlash": 0.0, "friction": 0.0, "yielding": 0.0}
"""Values of parameters whose group is not fitted, where it is not the centre of the prior."""


def defaults(parameters: list[Parameter]) -> dict[str, float]:
    """Return the values of all parameters where none is fitted."""
    return {one.name: ABSENT.get(one.name, one.centre) for one in parameters}
