"""Parameters of a tendon-driven rod, validated, in SI units."""

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.solver.problem import CONSTANTS
from tendond.schemas import paper_robot

Triple = tuple[float, float, float]


_SHAPES: dict[str, tuple[int | None, ...]] = {
    "shear_damping": (3,),
    "bending_damping": (3,),
    "drag": (3,),
    "gravity": (3,),
    "tendon_positions": (None, 2),
    "tip_inertia": (3,),
    "tip_offset": (3,),
}
_NAMES = {(): "a number", (3,): "three numbers", (None, 2): "pairs of numbers, one per tendon"}


@dataclass(frozen=True)
class RodParameters:
    """A straight rod of circular cross-section with tendons parallel to it.

    The defaults are the paper's robot (`schemas.paper_robot`); the paper leaves the tendons' stiffness open.

    Attributes:
        length: [m].
        radius: radius of the backbone [m].
        youngs_modulus: [Pa].
        poisson_ratio: [-].
        density: mass per length over the backbone's cross-section [kg/m^3].
        shear_damping: diagonal of Bse [N s].
        bending_damping: diagonal of Bbt [N m^2 s].
        drag: diagonal of C, square-law drag per length [kg/m^2].
        gravity: world frame [m/s^2]; the straight rod lies on +z, so gravity along -x lets it sag.
        tendon_positions: (x, y) of each tendon in the cross-section [m].
        tendon_stiffness: force per stretch of each tendon [N/m], EA of the tendon over its length.
        tip_mass: mass of a rigid body on the tip: a tool, a marker, a hung weight [kg].
        tip_inertia: diagonal of its inertia about its centre of mass, body frame [kg m^2].
        tip_offset: vector from the tip to its centre of mass, body frame [m].
    """

    length: float = paper_robot.LENGTH
    radius: float = paper_robot.RADIUS
    youngs_modulus: float = paper_robot.YOUNGS_MODULUS
    poisson_ratio: float = paper_robot.POISSON_RATIO
    density: float = paper_robot.DENSITY
    shear_damping: Triple = paper_robot.SHEAR_DAMPING
    bending_damping: Triple = paper_robot.BENDING_DAMPING
    drag: Triple = paper_robot.DRAG
    gravity: Triple = paper_robot.GRAVITY
    tendon_positions: tuple[tuple[float, float], ...] = paper_robot.TENDON_POSITIONS
    tendon_stiffness: float = 2.0e4
    tip_mass: float = 0.0
    tip_inertia: Triple = (0.0, 0.0, 0.0)
    tip_offset: Triple = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not self.tendon_positions:
            raise ParameterError("tendon_positions is empty: a tendon-driven rod has at least one tendon")
        for field in fields(self):
            wanted = _SHAPES.get(field.name, ())
            try:
                shape = np.shape(np.asarray(getattr(self, field.name), dtype=np.float64))
            except (TypeError, ValueError) as error:
                raise ParameterError(f"{field.name} = {getattr(self, field.name)!r} must be numeric") from error
            if len(shape) != len(wanted) or any(w is not None and s != w for s, w in zip(shape, wanted, strict=True)):
                raise ParameterError(f"{field.name} = {getattr(self, field.name)!r} must be {_NAMES[wanted]}")
            if not np.all(np.isfinite(np.asarray(getattr(self, field.name), dtype=np.float64))):
                raise ParameterError(f"{field.name} is not finite")
        for name in ("length", "radius", "youngs_modulus", "density", "tendon_stiffness"):
            if getattr(self, name) <= 0.0:
                raise ParameterError(f"{name} = {getattr(self, name)} must be above 0")
        if not -1.0 < self.poisson_ratio <= 0.5:
            raise ParameterError(f"poisson_ratio = {self.poisson_ratio} must lie in (-1, 0.5]")
        if self.tip_mass < 0.0:
            raise ParameterError(f"tip_mass = {self.tip_mass} must not be negative")
        for name in ("shear_damping", "bending_damping", "drag", "tip_inertia"):
            if min(getattr(self, name)) < 0.0:
                raise ParameterError(f"{name} = {getattr(self, name)} must not be negative")

    @property
    def area(self) -> float:
        """Cross-section area [m^2]."""
        return math.pi * self.radius**2

    @property
    def second_moment(self) -> float:
        """Second moment of area about a diameter [m^4]."""
        return math.pi * self.radius**4 / 4.0

    @property
    def bending_stiffness(self) -> float:
        """EI [N m^2]."""
        return self.youngs_modulus * self.second_moment

    @property
    def shear_modulus(self) -> float:
        """Shear modulus G [Pa]."""
        return self.youngs_modulus / (2.0 * (1.0 + self.poisson_ratio))

    @property
    def mass_per_length(self) -> float:
        """Mass per length rho A [kg/m]."""
        return self.density * self.area

    @property
    def tendon_count(self) -> int:
        """Number of tendons."""
        return len(self.tendon_positions)

    @property
    def force_scale(self) -> float:
        """Size by which forces on a rod are compared with those on another: EI/L^2, of the paper's robot's [-].

        The solver's tolerance, difference steps and first guesses were chosen on that robot and follow this.
        """
        return self.bending_stiffness / self.length**2 / (_PAPER.bending_stiffness / _PAPER.length**2)

    @property
    def moment_scale(self) -> float:
        """Size by which bending moments are compared: EI/L, of the paper's robot's [-]."""
        return self.bending_stiffness / self.length / (_PAPER.bending_stiffness / _PAPER.length)

    @property
    def tension_scale(self) -> float:
        """Size by which tensions are compared: EI/(L r), r the largest tendon offset, of the paper's robot's [-].

        Infinite where all tendons run along the axis.
        """
        own, paper = (max(math.hypot(x, y) for x, y in rod.tendon_positions) for rod in (self, _PAPER))
        return self.moment_scale * (paper / own) if own > 0.0 else math.inf

    def constants(self) -> NDArray[Any]:
        """The rod's constants as the kernels take them, shape (1,), dtype `CONSTANTS`."""
        EA, GA = self.youngs_modulus * self.area, self.shear_modulus * self.area
        EI, GJ = self.youngs_modulus * self.second_moment, self.shear_modulus * 2.0 * self.second_moment
        rho_I = self.density * self.second_moment
        record = np.zeros(1, dtype=CONSTANTS)
        record["Kse"] = (GA, GA, EA)
        record["Kbt"] = (EI, EI, GJ)
        record["Bse"] = self.shear_damping
        record["Bbt"] = self.bending_damping
        record["rhoJ"] = (rho_I, rho_I, 2.0 * rho_I)
        record["C"] = self.drag
        record["rhoA"] = self.mass_per_length
        record["tip_mass"], record["tip_inertia"] = self.tip_mass, self.tip_inertia
        record["tip_offset"], record["gravity"] = self.tip_offset, self.gravity
        return record


_PAPER = RodParameters()
