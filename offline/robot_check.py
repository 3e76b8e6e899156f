"""Figures of a configured robot, to compare with the real one, and what in them is implausible."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from tendond.daemon.control.reference.strain import yield_strain
from tendond.model.rods.selection import solver_of
from tendond.model.strain import StrainRod
from tendond.model.strain.analysis.summary import Summary, summarise
from tendond.model.strain.describe.configured import robot_from_section
from tendond.model.strain.robot import Robot
from tendond.schemas.config.given import by_default
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.config.robot import RodSection
from tendond.schemas.config.rod.presets import PRESETS

DAMPING = ("bending_damping", "damping_ratio")

BEND_MAX = 2.0 * math.pi
"""Bend of the whole backbone beyond which tension_max is implausible [rad]: it would coil upon itself."""

SAG_MAX = 0.7
"""Sag under its own weight beyond which a robot is implausible, as a fraction of its length."""

RATIO_MIN = 1e-4
"""Damping ratio below which a mode is implausible: bare wires have 0.0005 and more."""

SLENDER = 10.0
"""Length over radius below which a backbone is no slender rod."""

DENSITY = (300.0, 5e5)
"""Mass per volume of backbone that is plausible [kg/m^3]: foamed polymer; a thin wire with all that hangs on it."""


@dataclass(frozen=True)
class RobotReport:
    """Figures of a robot.

    Attributes:
        lines: for people. notes: what is implausible, one line each. data: the figures, for JSON.
    """

    lines: tuple[str, ...]
    notes: tuple[str, ...]
    data: dict[str, Any]


def robot_report(config: RigConfig) -> RobotReport:
    """Describe the robot of [rod], at limits.tension_max.

    Raises:
        ModelError: a robot that cannot be, or that has no equilibrium.
    """
    robot = robot_from_section(config.rod)
    rod = StrainRod(robot, config.loop.period)
    found = summarise(rod, config.limits.tension_max)
    limit, material = yield_strain(config.rod)
    return RobotReport(
        tuple(_lines(robot, found, config, limit, material)),
        tuple(_notes(robot, found, config, limit, material)),
        _data(found),
    )


def _lines(robot: Robot, found: Summary, config: RigConfig, limit: float | None, material: str) -> Iterator[str]:
    sections, tendons = len(robot.sections), len(robot.tendons)
    yield (
        f"robot: {sections} section{'s' if sections > 1 else ''}, {found.length * 1e3:.4g} mm, "
        f"{found.mass * 1e3:.3g} g" + (f" ({found.bodies * 1e3:.3g} g of it bodies)" if found.bodies else "")
        + f", {tendons} tendon{'s' if tendons > 1 else ''}"
    )  # fmt: skip
    if any(config.rod.base_gravity):
        yield f"at rest: the tip sags {found.sag * 1e3:.3g} mm, {100.0 * found.sag / found.length:.2g} % of the length"
    else:
        preset = config.rod.preset
        source = f", by preset '{preset}'" if preset and not any(PRESETS[preset].get("gravity", (1.0,))) else ""
        yield (
            f"at rest: without gravity (rod.gravity is zero{source}), so that the tip does not sag: "
            "write rod.gravity for a robot on a bench"
        )
    modes = ", ".join(
        f"{frequency:.3g} Hz ({ratio:.2g})" if ratio > 0.0 else f"{frequency:.3g} Hz (0)"
        for frequency, ratio in _distinct(found)
    )
    yield f"natural frequencies (damping ratio): {modes}; time constant {_seconds(found.time_constant)}"
    if found.pulls:
        widest, strained = max(found.pulls, key=lambda one: one.bend), max(found.pulls, key=lambda one: one.strain)
        yield (
            f"at {config.limits.tension_max:g} N in one tendon: bends up to {math.degrees(widest.bend):.0f} degrees"
            f" (tendon {widest.tendon}, {widest.displacement * 1e3:.3g} mm), strain {100.0 * strained.strain:.2g} %"
            + ("" if limit is None else f" of {100.0 * limit:.2g} %{f' ({material} assumed)' if material else ''}")
        )  # fmt: skip


def _distinct(found: Summary) -> list[tuple[float, float]]:
    """Modes without their twins in the other plane, three of them."""
    kept: list[tuple[float, float]] = []
    for frequency, ratio in zip(found.frequency.tolist(), found.damping_ratio.tolist(), strict=True):
        if not kept or frequency > 1.02 * kept[-1][0]:
            kept.append((frequency, ratio))
    return kept[:3]


def _seconds(time: float) -> str:
    return "infinite" if math.isinf(time) else f"{time:.2g} s"


def _notes(robot: Robot, found: Summary, config: RigConfig, limit: float | None, material: str) -> Iterator[str]:
    tension = f"limits.tension_max = {config.limits.tension_max:g} N{by_default(config.limits, 'tension_max')}"
    damping = "rod.bending_damping" + (
        " (by default, the paper's robot's)" if by_default(config.rod, *DAMPING) and not config.rod.section else ""
    )
    if limit is not None:
        strain = max((one.strain for one in found.pulls), default=found.rest_strain)
        if strain > limit:
            given = f"{100.0 * limit:.2g} % ({material}; rod.yield_strain is not given)" if material else "yield_strain"
            yield (
                f"rod.yield_strain: at {tension} the backbone is strained by {100.0 * strain:.2g} %, more than {given}:"
                " it may keep a bend; write a lower limits.tension_max"
            )
    for pull in found.pulls:
        if pull.tension < config.limits.tension_max:
            yield f"tendon {pull.tendon}: no equilibrium was found beyond {pull.tension:.3g} N, below {tension}"
    widest = max((one.bend for one in found.pulls), default=0.0)
    if widest > BEND_MAX:
        yield f"{tension} bends the robot by {math.degrees(widest):.0f} degrees, more than a turn: write a lower one"
    if found.sag > SAG_MAX * found.length:
        yield (
            f"rod: sags by {100.0 * found.sag / found.length:.0f} % of its length under its own weight: check radius,"
            " youngs_modulus and density"
        )
    if found.stability <= 0.0:
        yield "rod: its rest under gravity is not stable"
    if not np.all(found.damping_ratio[:1] > RATIO_MIN):
        yield f"{damping}: the first mode has next to no damping: it will ring; write rod.damping_ratio"
    if found.damping_ratio[0] > 1.0:
        remedy = "write rod.damping_ratio" if by_default(config.rod, *DAMPING) else "check its unit"
        if config.rod.damping_ratio is not None:
            damping = f"rod.damping_ratio = {config.rod.damping_ratio:g}"
            remedy = f"if it is in %, write {config.rod.damping_ratio / 100.0:g}"
        yield f"{damping}: the first mode is overdamped ({found.damping_ratio[0]:.2g}): {remedy}"
    if found.frequency[0] * config.loop.period > 0.2:
        yield (
            f"rod: its first natural frequency, {found.frequency[0]:.3g} Hz, is too high for a loop of"
            f" {1.0 / config.loop.period:.4g} Hz: shorten loop.period"
        )
    yield from _geometry(robot, config)


def _geometry(robot: Robot, config: RigConfig) -> Iterator[str]:
    """Yield what dimensions no lab builds."""
    for number, section in enumerate(robot.sections):
        key = f"rod.section[{number}]" if config.rod.section else "rod"
        radius = section.fibre(0.5 * section.length)
        if section.length < SLENDER * radius:
            yield f"{key}: {section.length * 1e3:.3g} mm long with a radius of {radius * 1e3:.3g} mm: no slender rod"
        density = section.mass_per_length / (math.pi * radius**2)
        if not DENSITY[0] <= density <= DENSITY[1]:
            yield f"{key}: {density:.3g} kg per m^3 of backbone: check the units of radius, density and mass"
    for number, given in enumerate(config.rod.section):
        if any(given.shear_damping[:2]) and given.shear_stiffness is None:
            yield f"rod.section[{number}].shear_damping: has no effect across the section without shear_stiffness"
    if config.rod.not_uniform:
        for name in ("space", "nodes", "alpha"):
            if getattr(config.rod, name) != RodSection.model_fields[name].default:
                yield f"rod.{name}: is of the shooting rod, which is not this robot's"
    thinnest = min(section.fibre(0.0) for section in robot.sections)
    for index, tendon in enumerate(robot.tendons):
        arm = math.hypot(*tendon.at(0.0))
        if 0.0 < arm < thinnest:
            yield f"rod: tendon {index} runs inside the backbone, {arm * 1e3:.3g} mm from its axis: check its position"
        if arm > 0.5 * robot.length:
            yield f"rod: tendon {index} is {arm * 1e3:.3g} mm from the axis, more than half the length: metres wanted"
        if tendon.friction > 0.0 and solver_of(config.rod, config.control.solver) == "shooting":
            yield f"rod: the friction of tendon {index} has no effect on control.solver = shooting"


def _data(found: Summary) -> dict[str, Any]:
    return {
        "length_m": found.length,
        "mass_kg": found.mass,
        "bodies_kg": found.bodies,
        "sag_m": found.sag,
        "stability": found.stability,
        "frequency_hz": found.frequency.tolist(),
        "damping_ratio": found.damping_ratio.tolist(),
        "time_constant_s": found.time_constant if math.isfinite(found.time_constant) else None,
        "pulls": [
            {
                "tendon": one.tendon, "tension_n": one.tension, "bend_rad": one.bend, "strain": one.strain,
                "displacement_m": one.displacement, "tip_m": one.tip.tolist(),
            }
            for one in found.pulls
        ],
    }  # fmt: skip
