"""Parameters that can be identified: name, unit, key in the configuration, and coordinate in the fit."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

from tendond.daemon.errors import UsageError


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


def _factor(
    name: str, unit: str, meaning: str, section: str, key: str, *, force: bool = False, span: float = 20.0
) -> Parameter:
    return Parameter(name, unit, meaning, section, key, 0.0, 1.0 / span, span, force)


PARAMETERS: dict[str, Parameter] = {
    parameter.name: parameter
    for parameter in (
        _factor("E", "Pa", "Young's modulus", "rod", "youngs_modulus", force=True),
        _factor("rho", "kg/m^3", "density, with disks, glue and markers", "rod", "density", force=True),
        _factor("Bbt", "N m^2 s", "bending damping", "rod", "bending_damping", force=True, span=100.0),
        _factor("C", "kg/m^2", "square-law drag", "rod", "drag", force=True, span=100.0),
        _factor("tendon_stiffness", "N/m", "of each tendon", "rod", "tendon_stiffness", force=True, span=100.0),
        Parameter(
            "tip_mass",
            "kg",
            "of a body on the tip, beside a known weight",
            "rod",
            "tip_mass",
            0.01,
            0.0,
            1.0,
            force=True,
            max_error=0.001,
        ),
        _factor("spool", "-", "true over reported displacement", "servo", "spool_radius", span=2.0),
        Parameter("delay", "s", "age of a pose when it arrives", "observer", "delay", 0.01, 0.0, 0.3, max_error=0.005),
        Parameter("lag", "s", "time constant of the servos", "observer", "lag", 0.01, 1e-4, 0.5, max_error=0.01),
        Parameter("backlash", "m", "lost when a servo changes direction", "", "", 1e-4, 0.0, 0.005, max_error=1e-4),
        Parameter("zero", "m", "true displacement where zero is reported", "", "", 0.001, -0.02, 0.02, max_error=0.001),
    )
}
"""Parameters by name."""

DEFAULT = ("E", "rho", "Bbt", "C", "tendon_stiffness", "tip_mass", "delay", "lag", "spool", "backlash")

FROM = {"lag": 2e-3, "backlash": 2e-5, "tip_mass": 2e-3}
"""Minimum start of a fit [s, m, kg]: at zero derivatives vanish, or their steps do."""


def chosen(names: Iterable[str]) -> tuple[Parameter, ...]:
    """Select parameters by name, in the order of `PARAMETERS`.

    Raises:
        UsageError: an unknown name, or none.
    """
    wanted = [name.strip() for name in names if name.strip()]
    for name in wanted:
        if name not in PARAMETERS:
            raise UsageError(f"--parameters: '{name}': choose among {', '.join(PARAMETERS)}")
    if not wanted:
        raise UsageError(f"--parameters: choose among {', '.join(PARAMETERS)}")
    return tuple(parameter for parameter in PARAMETERS.values() if parameter.name in wanted)


def bounds(parameter: Parameter, start: float) -> tuple[float, float]:
    """Return the bounds of the fit's coordinate."""
    if parameter.logarithmic:
        return math.log(parameter.lower), math.log(parameter.upper)
    return parameter.coordinate(parameter.lower, start), parameter.coordinate(parameter.upper, start)
