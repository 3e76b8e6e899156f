"""Parameters in a configuration: their values, their keys, and the robot with other values.

A straight, uniform section has Young's modulus, density, damping and drag as keys of [rod]. Of any other robot factors
on the whole of it are fitted, [rod.scale]: how its sections differ is taken from its description.
"""

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Any

from tendond.daemon.errors import UsageError
from tendond.model.rod.parameters import RodParameters
from tendond.model.strain.describe.configured import robot_from_section
from tendond.model.strain.describe.scaled import has
from tendond.offline.identification.geometry import geometry_of, nominal_geometry, with_geometry
from tendond.offline.identification.parameter import Parameter
from tendond.offline.identification.parameters import FROM
from tendond.schemas.assumed_rig import TENDON_STIFFNESS
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.rod.scale import RodScale

SCALE = {"E": "stiffness", "rho": "mass", "Bbt": "damping", "C": "drag", "tendon_stiffness": "tendon_stiffness"}
"""Parameters that are keys of [rod.scale] for a robot that is not one straight, uniform section."""

ABSENT = "the configuration has none, and a factor on it has no effect: describe a first guess"
"""Reason for which a factor cannot be fitted."""

OWN_FRICTION = "each tendon has its own friction in the configuration: remove the friction of [[rod.tendon]]"
NO_TIP = "the configuration has no body on the tip: set rod.tip_mass, or fit tip_mass too"


def parameters_of(rod: RodSection, parameters: Iterable[Parameter]) -> tuple[Parameter, ...]:
    """Return the parameters with the units and keys that they have for this robot."""
    found = []
    for parameter in parameters:
        if rod.not_uniform and parameter.name in SCALE:
            key = SCALE[parameter.name]
            meaning = RodScale.model_fields[key].description or ""
            parameter = replace(parameter, unit="-", meaning=meaning, section="rod.scale", key=key)
        elif parameter.name == "tip_mass" and rod.tip is not None:
            parameter = replace(parameter, section="rod.tip", key="mass")
        elif (placed := geometry_of(rod, parameter)) is None:
            continue
        else:
            parameter = placed
        found.append(parameter)
    return tuple(found)


def nominal(config: RigConfig) -> dict[str, float]:
    """Return the configured values by name; of diagonals the first entry, to which the others keep their ratio.

    A factor is zero where the robot has nothing that it multiplies.
    """
    rod, observer = config.rod, config.observer
    values = {
        "tip_mass": rod.tip_mass if rod.tip is None else rod.tip.mass,
        "spool": 1.0,
        "backlash": 0.0,
        "delay": observer.delay,
        "lag": observer.lag,
        "zero": 0.0,
        **nominal_geometry(rod),
    }
    if rod.not_uniform:
        robot, scale = robot_from_section(rod), rod.scale or RodScale()
        factors = {name: getattr(scale, key) if has(robot, key) else 0.0 for name, key in SCALE.items()}
        return factors | values
    keys = {
        "E": rod.youngs_modulus,
        "rho": rod.density,
        "Bbt": rod.bending_damping[0],
        "C": rod.drag[0],
        "tendon_stiffness": rod.tendon_stiffness or TENDON_STIFFNESS,  # a displacement-driven rod needs elastic tendons
    }
    return keys | values


def absent(config: RigConfig, parameters: Iterable[Parameter]) -> dict[str, str]:
    """Return the parameters of what the robot does not have, with the reason for which they are not fitted."""
    values, rod = nominal(config), config.rod
    names = {one.name for one in parameters}
    found = {one.name: ABSENT for one in parameters if one.section == "rod.scale" and values[one.name] == 0.0}
    if "mu" in names and rod.tendon and all(one.friction is not None for one in rod.tendon):
        found["mu"] = OWN_FRICTION
    if values["tip_mass"] == 0.0 and "tip_mass" not in names:
        found |= {one.name: NO_TIP for one in parameters if one.group == "tip_offset"}
    return found


def starts(config: RigConfig, parameters: Iterable[Parameter]) -> dict[str, float]:
    """Return the start of a fit by name: the configured values, moved off bounds where they are to be fitted.

    Raises:
        UsageError: a value of zero, which has no logarithm.
    """
    values = nominal(config)
    for parameter in parameters:
        if parameter.logarithmic and values[parameter.name] <= 0.0:
            raise UsageError(f"{parameter.section}.{parameter.key} = 0 is no start for a fit: set a first guess")
        values[parameter.name] = max(values[parameter.name], FROM.get(parameter.name, -math.inf))
    return values


def section_with(rod: RodSection, values: Mapping[str, float]) -> RodSection:
    """Return [rod] with other values, by name; those that are not given stay."""
    changed: dict[str, Any] = {}
    not_uniform = rod.not_uniform
    rod = with_geometry(rod, values)
    if "tip_mass" in values:
        mass = values["tip_mass"]
        changed |= {"tip_mass": mass} if rod.tip is None else {"tip": rod.tip.model_copy(update={"mass": mass})}
    if not_uniform:
        known = {key: values[name] for name, key in SCALE.items() if values.get(name, 0.0) > 0.0}
        changed["scale"] = (rod.scale or RodScale()).model_copy(update=known)
        return rod.model_copy(update=changed)
    for name, key in (("E", "youngs_modulus"), ("rho", "density"), ("tendon_stiffness", "tendon_stiffness")):
        if name in values:
            changed[key] = values[name]
    for name, key in (("Bbt", "bending_damping"), ("C", "drag")):
        if name in values:
            changed[key] = _diagonal(getattr(rod, key), values[name])
    return rod.model_copy(update=changed)


def rod_parameters(config: RigConfig, values: Mapping[str, float]) -> RodParameters:
    """Build the shooting rod of a configuration with other values, by name.

    Raises:
        ParameterError: invalid values.
    """
    return RodParameters(**section_with(config.rod, values).parameters())


def with_values(config: RigConfig, values: Mapping[str, float]) -> RigConfig:
    """Return the configuration with these values; others keep the configured one."""
    observer = {name: values[name] for name in ("delay", "lag") if name in values}
    return config.model_copy(
        update={
            "rod": section_with(config.rod, values),
            "observer": config.observer.model_copy(update=observer),
        }
    )


def _diagonal(entries: tuple[float, ...], first: float) -> tuple[float, float, float]:
    """Scale `entries` so that the first is `first`."""
    if entries[0] == 0.0:
        return (first, first, first)
    a, b, c = (first * entry / entries[0] for entry in entries)
    return a, b, c
