"""The configuration of a trial: the rig's own controller on the simulator, with a task that suits the robot."""

import math
from dataclasses import dataclass
from typing import Any

from tendond import TendondError
from tendond.daemon.control.laws import LAWS
from tendond.daemon.control.reference.planar import PLANES
from tendond.daemon.control.selection import Selection
from tendond.daemon.errors import UsageError
from tendond.model.rods.selection import model_rod
from tendond.offline.trying.first_target import RESERVE, FirstTarget, first_target
from tendond.schemas.config.machine import BusSection, RigSection
from tendond.schemas.config.reference import SPACE_KINDS, TARGETS, ReferenceSection
from tendond.schemas.config.rig import RigConfig, check_config
from tendond.schemas.config.simulator import SimulatorSection

RIG = "try"
"""Name of the rig on the bus: a driver of the real one does not hear its commands."""

IN_SPACE = "sensitivity"
"""Law for a target in space, where the configured one moves the tip in the bending plane."""

DURATION = 2.0
"""Duration of the way to a first target [s]: twice the default, for arms that swing. Chosen."""

PRETENSION = 0.1
"""Largest part of the first target's tension that a pretension takes where the file names none: 0.5 N and 1 N, the
defaults, bend a soft robot. Chosen."""

OWN_TASK = frozenset({*TARGETS, "samples", "file", "waypoints"})
"""Keys of [reference] that make it a task of its own."""


@dataclass(frozen=True)
class Trial:
    """A trial of a configuration.

    Attributes:
        config: what controller and simulator run. remarks: changes to the file's, for people.
    """

    config: RigConfig
    remarks: tuple[str, ...]


def trial(config: RigConfig, target: tuple[float, ...] | None) -> Trial:
    """Make the configuration of a trial.

    Args:
        config: of the rig. target: of the tip: x; x, z; or x, y, z [m]; none: its own, or a first one.

    Raises:
        TendondError: no target can be chosen, or the one given does not suit the configuration.
    """
    remarks: list[str] = []
    drivers = [f"[{name}]" for name in ("vicon", "mocap", "servo") if getattr(config, name) is not None]
    if drivers:
        remarks.append(
            f"{' and '.join(drivers)}: not used: the simulator takes the place of the rig's drivers, and no device or "
            "port of the rig is opened"
        )
    tables, simulated = _simulated(config)
    remarks += simulated
    if target is not None:
        tables["reference"] = _given(config, target)
        section = ReferenceSection.model_validate(config.reference.model_dump() | tables["reference"])
        law = LAWS.get(config.control.law)
        if law is not None and not law.task_space.follows(section):
            tables["control"] = {"law": IN_SPACE}
            remarks.append(f"control.law = '{IN_SPACE}' for this trial: {law.name} moves the tip in the bending plane")
    elif not has_own_task(config.reference):
        first = first_target(config)
        tables |= task_of(config, first)
        remarks.append(
            f"first target, chosen from the robot: {config.control.plane[0]} = {first.across * 1e3:g} mm, where "
            f"{first.tension:.2g} N turn the tip by {math.degrees(first.turn):.0f} degrees; --target names another"
        )
        if "limits" in tables:
            remarks.append(
                f"limits.tension_max = {first.tension_max():g} N for this trial: the file names none, and the default "
                f"is {config.limits.tension_max:g} N"
            )
    data = config.model_dump()
    changed = {name: {**data[name], **table} if isinstance(table, dict) else table for name, table in tables.items()}
    made = check_config({**data, **changed}, "the trial's configuration")
    if target is not None and not made.reference.in_space:
        made = _with_agonist(made, remarks)
    return Trial(made, tuple(remarks))


def _with_agonist(config: RigConfig, remarks: list[str]) -> RigConfig:
    """Return the configuration with the tendon as agonist that bends the robot to its planar target.

    That is the configured one, or where only that does, the one on the other side; a target beyond both is refused
    where it is planned.
    """
    control, positions = config.control, config.rod.tendon_positions
    axis, agonist = PLANES[control.plane][0], control.agonist
    side = positions[agonist][axis]
    other = min(range(len(positions)), key=lambda tendon: positions[tendon][axis] * side)
    if _reached(config) or positions[other][axis] * side >= 0.0:
        return config
    antagonist = None if control.antagonist is None else agonist
    swapped = {**control.model_dump(), "agonist": other, "antagonist": antagonist}
    changed = check_config({**config.model_dump(), "control": swapped}, "the trial's configuration")
    if not _reached(changed):
        return config
    remarks.append(f"control.agonist = {other} for this trial: tendon {agonist} bends the robot the other way")
    return changed


def _reached(config: RigConfig) -> bool:
    config = config.with_own_rates()
    try:
        Selection.from_config(config, model_rod(config))
    except TendondError:
        return False
    return True


def has_own_task(section: ReferenceSection) -> bool:
    """Return whether [reference] says where to go: the default is the paper's experiment, for its robot."""
    return bool(OWN_TASK & section.model_fields_set) or section.kind in SPACE_KINDS


def task_of(config: RigConfig, first: FirstTarget, reserve: float = RESERVE) -> dict[str, Any]:
    """Return the tables that a first target needs: [reference], and limits and pretension that nothing else names.

    Args:
        config: of the rig. first: the target. reserve: largest tension, by that of the target.
    """
    section = config.reference
    reference: dict[str, Any] = {"across": first.across}
    if "kind" not in section.model_fields_set:
        reference["kind"] = "minimum_jerk"
    if "duration" not in section.model_fields_set:
        reference["duration"] = DURATION
    tables: dict[str, Any] = {"reference": reference}
    tension_max = first.tension_max(reserve)
    if "tension_max" not in config.limits.model_fields_set and tension_max < config.limits.tension_max:
        tables["limits"] = {"tension_max": tension_max}
    own, part = config.pretension.model_fields_set, PRETENSION * first.tension
    pretension = {
        name: float(f"{part:.1g}")
        for name in ("tension", "tension_min")
        if name not in own and part < getattr(config.pretension, name)
    }
    return tables | ({"pretension": pretension} if pretension else {})


def _given(config: RigConfig, target: tuple[float, ...]) -> dict[str, Any]:
    """Return the keys of [reference] for a target that was given; those that name another are removed."""
    kept = {"kind": "minimum_jerk", "duration": DURATION, "samples": (), "file": "", "waypoints": ()}
    kept |= dict.fromkeys((*TARGETS, "orientation"))
    section = config.reference
    planar = not section.in_space and section.kind != "samples"
    if planar:
        kept |= {name: getattr(section, name) for name in ("kind", "duration") if name in section.model_fields_set}
    if len(target) == 1:
        return {**kept, "across": target[0]}
    if len(target) == 2:
        x, z = target
        return {**kept, "position": (x, 0.0, z) if config.control.plane == "xz" else (0.0, x, z)}
    if len(target) == 3:
        return {**kept, "kind": "point", "position": target}
    raise UsageError("--target: give x; x,z; or x,y,z, in metres")


def _simulated(config: RigConfig) -> tuple[dict[str, Any], list[str]]:
    """Return the tables for which a trial differs from the rig, and remarks.

    A simulator that the file says nothing of gets the delays and servos that the controller is configured for.
    """
    tables: dict[str, Any] = {"vicon": None, "mocap": None, "servo": None, "rig": RigSection(name=RIG).model_dump()}
    tables["bus"] = BusSection().model_dump()
    servo, observer = config.servo, config.observer
    plain = config.simulator == SimulatorSection(rod=config.simulator.rod, period=config.simulator.period)
    if servo is None or not plain:
        return tables, []
    changed: dict[str, Any] = {"mocap": {"latency": observer.delay}}
    said = [f"poses {observer.delay * 1e3:g} ms late (observer.delay)"]
    if config.rod.has_elastic_tendons:
        changed["drive"] = "displacement"
        changed["servo"] = {
            "rate": config.limits.displacement_rate,
            "acceleration": observer.servo_acceleration,
            "lag": observer.command_delay,
            "backlash": observer.backlash,
            "resolution": servo.motor.tick * servo.spool_radius,
        }
        said.append(f"servos with {config.limits.displacement_rate * 1e3:.3g} mm/s, and lag and play by [observer]")
    tables["simulator"] = changed
    return tables, [f"the file has no [simulator]: {'; '.join(said)}"]
