"""A section of the backbone: stiffness, mass, damping, precurvature, each constant or a table along it."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from tendond.model.errors import ParameterError
from tendond.model.strain.describe.profile import PropertyProfile, Rows, Values, combined, constant, tabulated

Array = NDArray[np.float64]
Triple = tuple[float, float, float]

WIDTHS = {
    "bending_stiffness": 2, "torsion_stiffness": 1, "axial_stiffness": 1, "shear_stiffness": 1, "mass_per_length": 1,
    "polar_inertia": 1, "bending_damping": 3, "axial_damping": 1, "shear_damping": 1, "drag": 3, "curvature": 3,
    "outer_radius": 1,
}  # fmt: skip
"""Properties of a section that may change along it, and how many numbers each has."""

POSITIVE = (
    "bending_stiffness", "torsion_stiffness", "axial_stiffness", "shear_stiffness", "mass_per_length", "polar_inertia",
)  # fmt: skip


@dataclass(frozen=True)
class Section:
    """One section of the backbone.

    Attributes:
        length: [m].
        bending_stiffness: EI about x and y [N m^2]. torsion_stiffness: GJ [N m^2]. axial_stiffness: EA [N].
        mass_per_length: backbone with whatever is spread along it [kg/m].
        polar_inertia: per length about the axis [kg m].
        bending_damping: Bbt about x, y, z [N m^2 s]; axial_damping: Bse along z [N s].
        drag: square-law drag per length, body frame [kg/m^2].
        curvature: precurvature u* [1/m], body frame; the last one is twist.
        bending_modes, torsion_modes, stretch_modes: Legendre polynomials of each strain; 0: that strain is rigid. A
            force across a bent rod twists it unevenly: one polynomial of torsion leaves the tip several percent off.
        shear_stiffness: GA with its shear factor [N]; shear_damping: Bse across [N s]; shear_modes: as the others.
        outer_radius: of the outermost fibre, for strain and stress [m]; 0: that of a round wire of this stiffness.
        tables: properties that change along the section, by name: rows (s from the section's base [m], values...), or
            a `PropertyProfile`; linear between the rows, constant beyond them. The property itself is then its middle
            value.
    """

    length: float
    bending_stiffness: tuple[float, float]
    torsion_stiffness: float
    axial_stiffness: float
    mass_per_length: float
    polar_inertia: float
    bending_damping: Triple = (0.0, 0.0, 0.0)
    axial_damping: float = 0.0
    drag: Triple = (0.0, 0.0, 0.0)
    curvature: Triple = (0.0, 0.0, 0.0)
    bending_modes: int = 4
    torsion_modes: int = 3
    stretch_modes: int = 1
    shear_stiffness: float = 0.0
    shear_damping: float = 0.0
    shear_modes: int = 0
    outer_radius: float = 0.0
    tables: Mapping[str, PropertyProfile | Rows] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not (math.isfinite(self.length) and self.length > 0.0):
            raise ParameterError(f"section: length = {self.length!r} must be finite and above 0")
        profiles = {}
        for name, table in self.tables.items():
            if name not in WIDTHS:
                raise ParameterError(f"section: {name} cannot be a table; these can: {', '.join(WIDTHS)}")
            width = WIDTHS[name]
            profile = table if isinstance(table, PropertyProfile) else tabulated(table, width, f"section: {name}")
            middle = profile(0.5 * self.length)
            profiles[name] = profile
            object.__setattr__(self, name, middle[0] if width == 1 else middle)
        object.__setattr__(self, "tables", profiles)
        needed = [name for name in POSITIVE if name != "shear_stiffness" or self.shear_modes > 0]
        for name in WIDTHS:
            self._check(name, positive=name in needed)
        if not 1 <= self.bending_modes <= 8:
            raise ParameterError(f"section: bending_modes = {self.bending_modes} must lie in 1..8")
        for name in ("torsion_modes", "stretch_modes", "shear_modes"):
            if not 0 <= getattr(self, name) <= 8:
                raise ParameterError(f"section: {name} = {getattr(self, name)} must lie in 0..8")

    def _check(self, name: str, *, positive: bool) -> None:
        profile = self.profile(name)
        for s in (0.0, *self.inner_knots(name), self.length):
            for value in profile(s):
                if not math.isfinite(value):
                    raise ParameterError(f"section: {name} = {value!r} must be finite")
                if positive and value <= 0.0:
                    raise ParameterError(f"section: {name} = {value!r} must be finite and above 0")
                if value < 0.0 and name != "curvature":
                    raise ParameterError(f"section: {name} = {value!r} must be finite and not negative")

    def profile(self, name: str) -> PropertyProfile:
        """Return a property along the section; s counts from the section's base [m]."""
        if name in self.tables:
            profile = self.tables[name]
            assert isinstance(profile, PropertyProfile)
            return profile
        value = getattr(self, name)
        return constant(*value) if isinstance(value, tuple) else constant(value)

    def at(self, name: str, s: float) -> Array:
        """Return the values of a property at s from the section's base [m], shape (1,), (2,) or (3,)."""
        return np.array(self.profile(name)(s))

    def inner_knots(self, name: str) -> Values:
        """Return where a property's table has points within the section [m]."""
        return tuple(s for s in self.profile(name).knots if 1e-9 * self.length < s < self.length * (1.0 - 1e-9))

    def fibre(self, s: float) -> float:
        """Return the distance of the outermost fibre from the axis at s from the section's base [m]."""
        known = float(self.at("outer_radius", s)[0])
        if known > 0.0:
            return known
        return 2.0 * math.sqrt(float(np.max(self.at("bending_stiffness", s)) / self.at("axial_stiffness", s)[0]))

    @staticmethod
    def round(
        length: float, radius: float, youngs_modulus: float, density: float, poisson_ratio: float = 0.3, **more: Any
    ) -> "Section":
        """Return a section of round wire: stiffness and inertia from radius [m], E [Pa] and density [kg/m^3]."""
        return Section.tapered(length, radius, youngs_modulus, density, poisson_ratio, **more)

    @staticmethod
    def tapered(
        length: float,
        radius: float | Rows,
        youngs_modulus: float | Rows,
        density: float | Rows,
        poisson_ratio: float = 0.3,
        inner_radius: float | Rows = 0.0,
        **more: Any,
    ) -> "Section":
        """Return a section of round wire or tube; each property is a number, or a table of rows (s [m], value).

        Args:
            length: [m].
            radius, inner_radius: [m]; the inner one is 0 for a wire.
            youngs_modulus: [Pa]. density: [kg/m^3]. poisson_ratio: [-].
            more: further properties of the section; what is given here counts before what follows from the radius.
        """
        given = {"radius": radius, "youngs_modulus": youngs_modulus, "density": density}
        parts = {name: _profile(value, name) for name, value in (*given.items(), ("inner_radius", inner_radius))}
        for name, profile in parts.items():
            for value in (profile(s)[0] for s in (0.0, *profile.knots)):
                if not (math.isfinite(value) and (value > 0.0 or (name == "inner_radius" and value == 0.0))):
                    raise ParameterError(f"section: {name} = {value!r} must be finite and above 0")
        knots = sorted({0.0, length, *parts["radius"].knots, *parts["inner_radius"].knots})
        if any(parts["inner_radius"](s)[0] >= parts["radius"](s)[0] for s in knots):
            raise ParameterError("section: inner_radius must be below radius")
        bore = (parts["radius"], parts["inner_radius"])
        found = {
            "bending_stiffness": combined(_bending, parts["youngs_modulus"], *bore),
            "torsion_stiffness": combined(_torsion, parts["youngs_modulus"], *bore, constant(poisson_ratio)),
            "axial_stiffness": combined(_per_area, parts["youngs_modulus"], *bore),
            "mass_per_length": combined(_per_area, parts["density"], *bore),
            "polar_inertia": combined(_polar, parts["density"], *bore),
        }
        tables = dict(more.pop("tables", {}))
        found["outer_radius"] = parts["radius"]
        for name, profile in found.items():
            values = profile(0.0)
            if profile.knots and name not in more:
                tables.setdefault(name, profile)
            more.setdefault(name, values[0] if len(values) == 1 else values)
        return Section(length, tables=tables, **more)


def _profile(value: float | Rows, name: str) -> PropertyProfile:
    return constant(float(value)) if isinstance(value, int | float) else tabulated(value, 1, f"section: {name}")


def _bending(modulus: float, radius: float, inner: float) -> Values:
    second = math.pi * (radius**4 - inner**4) / 4.0
    return modulus * second, modulus * second


def _torsion(modulus: float, radius: float, inner: float, poisson_ratio: float) -> Values:
    return (modulus / (1.0 + poisson_ratio) * math.pi * (radius**4 - inner**4) / 4.0,)


def _per_area(value: float, radius: float, inner: float) -> Values:
    return (value * math.pi * (radius**2 - inner**2),)


def _polar(density: float, radius: float, inner: float) -> Values:
    return (density * math.pi * (radius**4 - inner**4) / 2.0,)
