"""A parameter that can be identified: name, unit, key in the configuration, and coordinate in the fit."""

import math
from dataclasses import dataclass


@dataclass(frozen=True)
class Parameter:
    """A parameter that can be fitted.

    Attributes:
        name: name on the command line.
        unit: SI unit.
        meaning: meaning in words.
        section, key: section and key of the configuration; empty where there is none.
        scale: unit of the fit's coordinate; 0 for the logarithm of the value.
        lower, upper: bounds, factors of the start where the logarithm is fitted.
        force: true if it scales with force: the motion alone fixes only ratios of such parameters.
        max_error: error beyond which the value is not reported: a fraction of the value, or in its unit.
        group: name of the vector that it is a component of; empty where it is none.
    """

    name: str
    unit: str
    meaning: str
    section: str
    key: str
    scale: float
    lower: float
    upper: float
    force: bool = False
    max_error: float = 0.25
    group: str = ""

    @property
    def logarithmic(self) -> bool:
        """True if the fit's coordinate is the logarithm."""
        return self.scale == 0.0

    def coordinate(self, value: float, start: float) -> float:
        """Convert a value to the fit's coordinate, zero at the start."""
        return math.log(value / start) if self.logarithmic else (value - start) / self.scale

    def value(self, coordinate: float, start: float) -> float:
        """Convert a coordinate to the value."""
        return start * math.exp(coordinate) if self.logarithmic else start + self.scale * coordinate

    def error(self, value: float, deviation: float) -> float:
        """Convert the standard error of the coordinate to that of the value."""
        return deviation * (value if self.logarithmic else self.scale)

    @property
    def max_deviation(self) -> float:
        """Return `max_error` in the coordinate."""
        return self.max_error if self.logarithmic else self.max_error / self.scale


def bounds(parameter: Parameter, start: float) -> tuple[float, float]:
    """Return the bounds of the fit's coordinate."""
    if parameter.logarithmic:
        return math.log(parameter.lower), math.log(parameter.upper)
    return parameter.coordinate(parameter.lower, start), parameter.coordinate(parameter.upper, start)
