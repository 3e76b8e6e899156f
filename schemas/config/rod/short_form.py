"""Keys of [rod] in its short form, as the paper's rod and the controller run it: one straight, uniform section."""

import math
from collections.abc import Sequence
from typing import Any

from tendond.schemas.config.rod.section import BackboneSection
from tendond.schemas.config.rod.table import Along, constant_of
from tendond.schemas.config.rod.tendon import RodTendon

SAME = 1e-6
"""Largest relative difference of values that count as equal."""

VARYING = {
    "radius": 1, "inner_radius": 1, "youngs_modulus": 1, "density": 1, "bending_stiffness": 2, "torsion_stiffness": 1,
    "axial_stiffness": 1, "shear_stiffness": 1, "mass_per_length": 1, "polar_inertia": 1, "precurvature": 3,
    "bending_damping": 3, "drag": 3,
}  # fmt: skip
"""Keys of a section that may be tables, and their numbers at one place."""


class NotShortError(ValueError):
    """A robot has no short form: the key, and what only the general rod does."""

    def __init__(self, key: str, why: str) -> None:
        super().__init__(f"rod.{key}: {why}")


def backbone_keys(section: BackboneSection) -> dict[str, Any]:
    """Return the keys of the wire with the same stiffness and mass.

    Raises:
        NotShortError: there is none.
    """
    constants: dict[str, tuple[float, ...]] = {}
    for name, width in VARYING.items():
        value: Along | None = getattr(section, name)
        if value is None:
            continue
        constant = constant_of(value, width)
        if constant is None:
            raise NotShortError(f"section[0].{name}", "a property that changes along the section")
        constants[name] = constant
    if any(constants["precurvature"]):
        raise NotShortError("section[0].precurvature", "a rod that is curved without load")
    if section.disk_number:
        raise NotShortError(
            "section[0].disk_number", "disks as bodies (spread along the section they count in mass_per_length)"
        )
    EI, GJ, EA, mass = stiffness_and_mass(section, constants)
    if not math.isclose(*EI, rel_tol=SAME):
        raise NotShortError("section[0].bending_stiffness", "a stiffness that differs between x and y")
    poisson_ratio = EI[0] / GJ - 1.0
    if not -SAME <= poisson_ratio <= 0.5 + SAME:
        raise NotShortError("section[0].torsion_stiffness", "a GJ that is not that of a round section, EI / 1.5 to EI")
    radius = 2.0 * math.sqrt(EI[0] / EA)
    area = math.pi * radius**2
    polar = mass * radius**2 / 2.0
    if "polar_inertia" in constants and not math.isclose(constants["polar_inertia"][0], polar, rel_tol=SAME):
        raise NotShortError("section[0].polar_inertia", "an inertia about the axis that is not that of a round section")
    GA = EA / (2.0 * (1.0 + poisson_ratio))
    if "shear_stiffness" in constants and not math.isclose(constants["shear_stiffness"][0], GA, rel_tol=SAME):
        raise NotShortError("section[0].shear_stiffness", "a GA that is not E A / (2 (1 + nu))")
    found = {
        "length": section.length,
        "radius": radius,
        "youngs_modulus": EA / area,
        "poisson_ratio": min(max(poisson_ratio, 0.0), 0.5),
        "density": mass / area,
        "shear_damping": section.shear_damping,
        "bending_damping": constants.get("bending_damping", (0.0, 0.0, 0.0)),
        "drag": constants["drag"],
    }
    if "radius" in constants:
        found["outer_radius"] = constants["radius"][0]
        if math.isclose(radius, constants["radius"][0], rel_tol=1e-9):  # a plain wire: its own numbers, unrounded
            found |= {"radius": constants["radius"][0], "outer_radius": None}
            if section.bending_stiffness is section.axial_stiffness is section.torsion_stiffness is None:
                found |= {"youngs_modulus": constants["youngs_modulus"][0], "poisson_ratio": section.poisson_ratio}
            if section.mass_per_length is None:
                found["density"] = constants["density"][0]
    return found


def stiffness_and_mass(
    section: BackboneSection, constants: dict[str, tuple[float, ...]]
) -> tuple[tuple[float, float], float, float, float]:
    """Return EI about x and y [N m^2], GJ [N m^2], EA [N] and mass per length [kg/m] of a uniform section."""
    outer = constants["radius"][0] if "radius" in constants else 0.0
    inner = constants["inner_radius"][0] if outer else 0.0
    area, second = math.pi * (outer**2 - inner**2), math.pi * (outer**4 - inner**4) / 4.0
    E = constants["youngs_modulus"][0] if "youngs_modulus" in constants else 0.0
    EI = constants.get("bending_stiffness", (E * second, E * second))
    (GJ,) = constants.get("torsion_stiffness", (E * second / (1.0 + section.poisson_ratio),))
    (EA,) = constants.get("axial_stiffness", (E * area,))
    density = constants["density"][0] if "density" in constants else 0.0
    (mass,) = constants.get("mass_per_length", (density * area,))
    return (EI[0], EI[1]), GJ, EA, mass


def tendon_keys(tendons: Sequence[RodTendon], length: float) -> dict[str, Any]:
    """Return the keys of tendons that all run parallel to the backbone to its tip.

    Raises:
        NotShortError: one does not.
    """
    first = tendons[0]
    positions = []
    for index, tendon in enumerate(tendons):
        key = f"tendon[{index}]"
        if tendon.end is not None and not math.isclose(tendon.end, length, rel_tol=SAME):
            raise NotShortError(f"{key}.end", "a tendon that ends before the tip")
        for name in ("end_position", "turns"):
            if getattr(tendon, name) is not None:
                raise NotShortError(f"{key}.{name}", "a tendon that is not parallel to the backbone")
        position = tendon.position
        if tendon.route is not None:
            constant = constant_of(tendon.route, 2)
            if constant is None:
                raise NotShortError(f"{key}.route", "a tendon that is not parallel to the backbone")
            position = (constant[0], constant[1])
        if tendon.guides != "route":
            raise NotShortError(f"{key}.guides", "a tendon that rubs at disks only")
        for name in ("stiffness", "friction"):
            if getattr(tendon, name) != getattr(first, name):
                raise NotShortError(f"{key}.{name}", f"tendons whose {name} differs")
        positions.append(position)
    found = {"tendon_positions": tuple(positions), "tendon_stiffness": first.stiffness}
    return found if first.friction is None else found | {"tendon_friction": first.friction}


RITZ_ORDER = 8
"""Polynomials of the deflection: the first frequency is right to 1e-9 for a bare cantilever (Timoshenko)."""


def damping_of(ratio: float, rod: dict[str, Any]) -> tuple[float, float, float]:
    """Return Bbt [N m^2 s] of a round, uniform rod for a damping ratio of its first bending mode.

    Bbt = tau (EI, EI, GJ) damps each mode of bending with tau omega / 2, so tau = 2 ratio / omega_1. omega_1 is the
    straight cantilever's with the body on its tip, without gravity, by Ritz's method in powers of s.
    """
    import numpy as np

    EI = rod["youngs_modulus"] * math.pi * rod["radius"] ** 4 / 4.0
    mass = rod["density"] * math.pi * rod["radius"] ** 2
    length, tip_mass, arm = rod["length"], rod["tip_mass"], rod["tip_offset"][2] / rod["length"]
    powers = np.arange(2, 2 + RITZ_ORDER, dtype=float)
    sums = powers[:, None] + powers[None, :]
    product = powers * (powers - 1.0)
    stiff = np.outer(product, product) / (sums - 3.0) * EI / length**3
    at_body = 1.0 + arm * powers
    inertia = mass * length / (sums + 1.0) + tip_mass * np.outer(at_body, at_body)
    turning = mass * rod["radius"] ** 2 / 4.0 / length * np.outer(powers, powers) / (sums - 1.0)
    turning += rod["tip_inertia"][1] / length**2 * np.outer(powers, powers)
    lower = np.linalg.cholesky(inertia + turning)
    inner = np.linalg.solve(lower, np.linalg.solve(lower, stiff).T)
    omega = math.sqrt(float(np.linalg.eigvalsh(0.5 * (inner + inner.T))[0]))
    tau = 2.0 * ratio / omega
    return tau * EI, tau * EI, tau * EI / (1.0 + rod["poisson_ratio"])
