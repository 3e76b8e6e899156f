"""Factors on a robot's properties, all sections alike: what an identification finds of a robot of sections."""

from collections.abc import Iterable
from dataclasses import replace
from functools import partial
from typing import Any

from tendond.model.strain.describe.profile import Factor, Values, combined
from tendond.model.strain.describe.section import WIDTHS, Section
from tendond.model.strain.robot import Body, Robot, Route, Tendon
from tendond.schemas.config.rod.scale import RodScale

PROPERTIES = {
    "stiffness": ("bending_stiffness", "torsion_stiffness", "axial_stiffness", "shear_stiffness"),
    "mass": ("mass_per_length", "polar_inertia"),
    "damping": ("bending_damping", "axial_damping", "shear_damping"),
    "drag": ("drag",),
}
"""Factors of [rod.scale], and the properties of a section that each multiplies."""


def scaled(robot: Robot, scale: RodScale) -> Robot:
    """Return the robot with its sections, bodies and tendons multiplied; all bodies count as disks."""
    return replace(
        robot,
        sections=tuple(_section(one, scale) for one in robot.sections),
        bodies=tuple(_body(one, scale.mass) for one in robot.bodies),
        tendons=tuple(
            _tendon(one, scale.tendon_stiffness, radius)
            for one, radius in zip(robot.tendons, scale.tendon_radius or (1.0,) * len(robot.tendons), strict=True)
        ),
    )


def curved(section: Section, curvature: Values) -> Section:
    """Return the section with a precurvature [1/m], shape (3,), added to its own."""
    profile = combined(partial(_added, curvature), section.profile("curvature"))
    if "curvature" in section.tables:
        return replace(section, tables={**section.tables, "curvature": profile})
    x, y, z = profile(0.0)
    return replace(section, curvature=(x, y, z))


def has(robot: Robot, factor: str) -> bool:
    """Check for a property that is not zero, so that a factor of [rod.scale] changes the robot."""
    if factor == "tendon_stiffness":
        return any(one.stiffness is not None for one in robot.tendons)
    return any(
        value != 0.0
        for section in robot.sections
        for name in PROPERTIES[factor]
        for s in (0.0, *section.inner_knots(name), section.length)
        for value in section.at(name, s)
    )


def _section(section: Section, scale: RodScale) -> Section:
    changed: dict[str, Any] = {}
    tables = dict(section.tables)
    for factor, names in PROPERTIES.items():
        for name in names:
            profile = combined(Factor(getattr(scale, factor)), section.profile(name))
            if name in tables:
                tables[name] = profile
            else:
                values = profile(0.0)
                changed[name] = values[0] if WIDTHS[name] == 1 else values
    return replace(section, tables=tables, **changed)


def _body(body: Body, factor: float) -> Body:
    x, y, z = _times(factor, body.inertia)
    return replace(body, mass=factor * body.mass, inertia=(x, y, z))


def _tendon(tendon: Tendon, factor: float, radius: float) -> Tendon:
    stiffness = None if tendon.stiffness is None else factor * tendon.stiffness
    if radius == 1.0:
        return replace(tendon, stiffness=stiffness)
    if callable(tendon.route):
        return replace(tendon, stiffness=stiffness, route=partial(_route, radius, tendon.route))
    x, y = _times(radius, tendon.route)
    return replace(tendon, stiffness=stiffness, route=(x, y))


def _route(radius: float, route: Route, s: float) -> tuple[float, float]:
    x, y = route(s)
    return radius * x, radius * y


def _added(values: Values, *own: float) -> Values:
    return tuple(one + other for one, other in zip(values, own, strict=True))


def _times(factor: float, values: Iterable[float]) -> tuple[float, ...]:
    return tuple(factor * one for one in values)
