"""A robot from [rod]: sections, tendons and bodies in the model's own terms."""

import math
import re
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from tendond.model.errors import ParameterError
from tendond.model.strain.describe.damping import with_damping_ratios
from tendond.model.strain.describe.profile import PropertyProfile, Rows, combined
from tendond.model.strain.describe.scaled import curved, scaled
from tendond.model.strain.describe.section import Section
from tendond.model.strain.robot import Body, Robot, Tendon
from tendond.schemas.config.control import LoopSection
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config, parse_config
from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.rod.presets import PRESETS
from tendond.schemas.config.rod.section import BackboneSection
from tendond.schemas.config.rod.table import Along, constant_of, rows_of
from tendond.schemas.config.rod.tendon import RodTendon

OWN = {
    "bending_stiffness": ("bending_stiffness", 2),
    "torsion_stiffness": ("torsion_stiffness", 1),
    "axial_stiffness": ("axial_stiffness", 1),
    "shear_stiffness": ("shear_stiffness", 1),
    "mass_per_length": ("mass_per_length", 1),
    "polar_inertia": ("polar_inertia", 1),
    "bending_damping": ("bending_damping", 3),
    "drag": ("drag", 3),
    "precurvature": ("curvature", 3),
    "radius": ("outer_radius", 1),
}
"""Keys of [[rod.section]] that are properties of a section as they are: the property, and its numbers at one place."""


def described(source: RigConfig | RodSection | str | Path) -> tuple[Robot, float]:
    """Return the robot in the world: of a configuration, its [rod], a file or a preset; and its loop's period [s].

    Raises:
        ConfigError: the file cannot be read or is invalid.
        ParameterError: a robot that cannot be.
    """
    if isinstance(source, RodSection):
        return in_world(source), LoopSection().period
    if not isinstance(source, RigConfig):
        source = _read(source)
    return in_world(source.rod), source.loop.period


def _read(source: str | Path) -> RigConfig:
    if source in PRESETS:
        return check_config({"rod": {"preset": source}}, f"preset '{source}'")
    path = Path(source)
    try:
        text = path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        names = f"; a preset is one of {', '.join(PRESETS)}" if not path.suffix else ""
        raise ConfigError(f"{path}: cannot be read: {getattr(error, 'strerror', None) or error}{names}") from error
    if re.search(r"^\s*include\s*=", text, re.MULTILINE):
        raise ConfigError(
            f"{path}: include: only the command line reads it; `tendond config show {path}` prints one file"
        )
    return parse_config(text, str(path))


AXES = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def in_world(rod: RodSection) -> Robot:
    """Return the robot in the world, its base where [rod.base] says; see `robot_from_section`.

    Raises:
        ParameterError: a robot that cannot be.
    """
    robot, base = robot_from_section(rod), rod.base
    if base is None:
        return robot
    axes = np.array([base.to_world(axis) for axis in AXES]).T
    return replace(robot, gravity=rod.world_gravity, base=axes, origin=base.position)


def robot_from_section(rod: RodSection) -> Robot:
    """Return the robot that [rod] or [simulator.rod] describes, in its base's frame, in which the bus and logs are.

    Damping ratios become damping by the robot's own first mode (`describe.damping`).

    Raises:
        ParameterError: a robot that cannot be.
    """
    if rod.section:
        sections = tuple(_section(one) for one in rod.section)
        ratios = [rod.damping_ratio if one.damping_ratio is None else one.damping_ratio for one in rod.section]
        wanted = [None if one.bending_damping is not None else r for one, r in zip(rod.section, ratios, strict=True)]
    else:
        sections, wanted = (_uniform(rod),), [rod.damping_ratio]
    if any(rod.precurvature):
        sections = tuple(curved(section, rod.precurvature) for section in sections)
    length = sum(section.length for section in sections)
    disks, tip = tuple(_disks(rod.section)), tuple(_tip(rod, length))
    robot = Robot(
        sections=sections,
        tendons=tuple(_tendons(rod, length, disks)),
        bodies=(*disks, *tip),
        gravity=rod.base_gravity,
    )
    robot = with_damping_ratios(robot, wanted)
    if rod.scale is None:
        return robot
    robot = scaled(replace(robot, bodies=disks), rod.scale)
    return replace(robot, bodies=(*robot.bodies, *tip))


def _uniform(rod: RodSection) -> Section:
    """The section of the short form."""
    return Section.round(
        rod.length,
        rod.radius,
        rod.youngs_modulus,
        rod.density,
        rod.poisson_ratio,
        bending_damping=rod.bending_damping,
        axial_damping=rod.shear_damping[2],
        outer_radius=rod.outer_radius or rod.radius,
        drag=rod.drag,
    )


def _section(section: BackboneSection) -> Section:
    constants: dict[str, float | tuple[float, ...]] = {"axial_damping": section.shear_damping[2]}
    tables: dict[str, PropertyProfile | Rows] = {}
    for key, (name, width) in OWN.items():
        value: Along | None = getattr(section, key)
        if value is None:
            continue
        constant = constant_of(value, width)
        if constant is None:
            tables[name] = rows_of(value, width)
        else:
            constants[name] = constant[0] if width == 1 else constant
    if section.radius is None:
        constants["outer_radius"] = 0.0
    if section.shear_stiffness is not None:
        constants |= {"shear_modes": 1, "shear_damping": section.shear_damping[0]}
    found = Section.tapered(  # what has no radius or material here is given by itself
        section.length,
        _material(section.radius),
        _material(section.youngs_modulus),
        _material(section.density),
        section.poisson_ratio,
        0.0 if section.radius is None else _material(section.inner_radius),
        tables=tables,
        **constants,
    )
    if section.polar_inertia is not None:
        return found
    parts = [found.profile(name) for name in ("mass_per_length", "bending_stiffness", "axial_stiffness")]
    polar = combined(_polar, *parts)
    if polar.knots:
        return replace(found, tables={**found.tables, "polar_inertia": polar})
    return replace(found, polar_inertia=polar(0.0)[0])


def _polar(mass: float, about_x: float, about_y: float, axial: float) -> tuple[float]:
    """Inertia per length about the axis of a section of one material, rho (Ix + Iy) [kg m]."""
    return (mass * (about_x + about_y) / axial,)


def _material(value: Along | None) -> float | Rows:
    if value is None:
        return 1.0
    constant = constant_of(value, 1)
    return rows_of(value, 1) if constant is None else constant[0]


def _tendons(rod: RodSection, length: float, disks: Sequence[Body]) -> Iterator[Tendon]:
    """Tendons of [rod], those that disks guide with their holes.

    Raises:
        ParameterError: there are no disks.
    """
    frictions = rod.frictions
    for place, mu in () if rod.tendon else zip(rod.tendon_positions, frictions, strict=True):
        yield Tendon(length, place, rod.tendon_stiffness, mu)
    for index, one in enumerate(rod.tendon):
        if one.guides == "disks" and not disks:
            raise ParameterError(
                f"rod.tendon[{index}].guides = 'disks': no section has disks: set rod.section.disk_number"
            )
        holes = tuple(body.at for body in disks) if one.guides == "disks" else ()
        yield replace(_tendon(one, frictions[index], length), holes=holes)


def _tendon(tendon: RodTendon, mu: float, length: float) -> Tendon:
    end = length if tendon.end is None else tendon.end
    k = tendon.stiffness
    x, y = tendon.at_base
    if tendon.route is not None and constant_of(tendon.route, 2) is None:
        return Tendon.tabulated(end, rows_of(tendon.route, 2), k, mu)
    if tendon.end_position is not None:
        return Tendon.converging(end, (x, y), tendon.end_position, k, mu)
    if tendon.turns is not None:
        return Tendon.helical(end, math.hypot(x, y), tendon.turns, math.atan2(y, x), k, mu)
    return Tendon(end, (x, y), k, mu)


def _disks(sections: Sequence[BackboneSection]) -> Iterator[Body]:
    """Disks evenly along each section, the last one at its end."""
    begin = 0.0
    for section in sections:
        for index in range(section.disk_number):
            at = begin + section.length * (index + 1) / section.disk_number
            yield Body(at, section.disk_mass, section.one_disk_inertia)
        begin += section.length


def _tip(rod: RodSection, length: float) -> Iterator[Body]:
    if rod.tip is not None:
        yield Body(length, rod.tip.mass, rod.tip.inertia, rod.tip.offset)
    elif rod.tip_mass > 0.0:
        yield Body(length, rod.tip_mass, rod.tip_inertia, rod.tip_offset)
