"""The text of a new configuration: the keys that matter first, each with its unit and where its value comes from."""

import math
from collections.abc import Mapping
from typing import Any

from tendond.cli.config.answers import GRAVITY
from tendond.cli.manual.config_text import to_toml
from tendond.schemas.config.rod.presets import ABOUT

WIDTH = 30
"""Column of the comments."""


def rod_text(answers: Mapping[str, Any]) -> str:
    """Write [rod] of one uniform section."""
    radius, length, material = 0.5 * answers["diameter"], answers["length"], answers["material"]
    mass, volume = answers["mass"], math.pi * radius**2 * length
    density = float(f"{mass / volume:.6g}") if mass else material["density"]
    said = "mass / (pi radius^2 length), with all that hangs on it" if mass else "of the bare backbone"
    lines = [
        _line("length", length, "[m] from the clamp to the tip"),
        _line("radius", radius, "[m] half of the diameter"),
        _line("youngs_modulus", material["youngs_modulus"], f"[Pa] {material['source']}"),
    ]
    if "poisson_ratio" in material:
        lines.append(_line("poisson_ratio", material["poisson_ratio"], "[-]"))
        lines.append(_line("yield_strain", material["yield_strain"], "[-] without a permanent bend"))
    lines += [
        _line("density", density, f"[kg/m^3] {said}"),
        _line("damping_ratio", answers["damping_ratio"], "[-] of the first mode: pluck the arm and film it"),
        _line("drag", [0.0, 0.0, 0.0], "[kg/m^2] of the air: none"),
        _line("tip_mass", answers["tip_mass"], "[kg] of a tool"),
        tendons_text(answers),
        gravity_text(answers),
    ]
    if answers.get("tendon_stiffness"):
        lines.append(_line("tendon_stiffness", answers["tendon_stiffness"], "[N/m] of a whole tendon"))
    else:
        lines.append("# tendon_stiffness = 2e4      # [N/m] of a whole tendon; default: inextensible")
    return "[rod]\n" + "\n".join(lines) + "\n"


def like_text(preset: str, answers: Mapping[str, Any]) -> str:
    """Write [rod] from a preset, with the answers that were given over it."""
    about = ABOUT[preset]
    lines = [
        f"# {about.robot}; {about.source}; assumed: {about.assumed}",
        _line("preset", preset, f"`tendond config show --preset {preset}` prints its keys; those here override them"),
    ]
    if "length" in answers:
        lines.append(_line("length", answers["length"], "[m]"))
    if "diameter" in answers:
        lines.append(_line("radius", 0.5 * answers["diameter"], "[m]"))
    material = answers.get("material", {})
    lines += [_line(key, value, material["source"]) for key, value in material.items() if key != "source"]
    lines += [
        _line(key, answers[name], unit)
        for name, key, unit in (
            ("damping_ratio", "damping_ratio", "[-]"), ("tip_mass", "tip_mass", "[kg]"),
            ("tendon_stiffness", "tendon_stiffness", "[N/m]"),
        )
        if name in answers
    ]  # fmt: skip
    if "tendons" in answers:
        lines.append(tendons_text(answers))
    if "gravity" in answers:
        lines.append(gravity_text(answers))
    return "[rod]\n" + "\n".join(lines) + "\n"


def tendons_text(answers: Mapping[str, Any]) -> str:
    """Write the places of tendons evenly about the axis, the first one on +x."""
    count, radius = answers["tendons"], answers["tendon_radius"]
    angles = [2.0 * math.pi * index / count for index in range(count)]
    places = [[round(radius * math.cos(a), 9) + 0.0, round(radius * math.sin(a), 9) + 0.0] for a in angles]
    rows = "\n".join(f"    {to_toml(place)},  # tendon {index}" for index, place in enumerate(places))
    return f"tendon_positions = [           # [m] (x, y) in the cross-section, in the order of the motors\n{rows}\n]"


def gravity_text(answers: Mapping[str, Any]) -> str:
    """Write gravity in the base's axes."""
    said = {"-z": "the robot stands", "+z": "the robot hangs", "none": "none"}.get(answers["gravity"], "the robot lies")
    return _line("gravity", list(GRAVITY[answers["gravity"]]), f"[m/s^2] {said}; its straight shape is along +z")


def rig_text(name: str, answers: Mapping[str, Any]) -> str:
    """Write [rig], [loop], and the sections of camera and servos that there are."""
    period = round(1.0 / answers["rate"], 9)
    parts = [
        f"[rig]\n{_line('name', name, 'first part of every key on the bus')}\n",
        f"[loop]\n{_line('period', period, f'[s] {1.0 / period:.4g} Hz')}\n",
    ]
    if period != 0.01:
        parts.append(f"[simulator]\n{_line('period', period, '[s] of the simulated poses')}\n")
    if answers["camera"] == "vicon":
        parts.append(
            '[observer]\ndelay = 0.01                  # [s] age of a pose when it arrives\n\n[vicon]\n'
            '# address = "192.168.10.1"    # of the network card on which Tracker\'s packets arrive\n'
            '# tip = "tip"                 # name of Tracker\'s object at the tip\n'
            '# base = "base"               # and at the base\n'
        )  # fmt: skip
    if answers["servos"] == "dynamixel":
        parts.append(
            '[servo]\nport = "/dev/ttyUSB0"         # `tendond servo scan` finds the servos\n'
            "spool_radius = 0.015          # [m]\n"
        )  # fmt: skip
    return "\n".join(parts)


def task_text(tables: Mapping[str, Mapping[str, Any]]) -> str:
    """Write [reference], [limits] and [pretension] of a first target."""
    comments = {
        "across": "[m] first target of the tip across the straight robot; z follows",
        "kind": "smooth, at rest at both ends", "duration": "[s]",
        "tension_max": "[N] of any tendon", "tension": "[N] of the agonist before tracking",
        "tension_min": "[N] of every tendon under a law that pulls all of them",
    }  # fmt: skip
    return "\n".join(
        "\n".join([f"[{name}]", *(_line(key, value, comments[key]) for key, value in table.items())]) + "\n"
        for name, table in tables.items()
    )


def _line(key: str, value: Any, comment: str) -> str:
    return f"{f'{key} = {to_toml(value)}':<{WIDTH}}# {comment}" if len(f"{key} = {to_toml(value)}") < WIDTH else (
        f"{key} = {to_toml(value)}  # {comment}"
    )  # fmt: skip
