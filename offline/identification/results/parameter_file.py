"""The parameter file: dated TOML that a rig's configuration can include, with errors beside the values."""

import json
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import Any

from tendond import __version__
from tendond.offline.correction.learned import as_section
from tendond.offline.identification.configured import section_with
from tendond.offline.identification.geometry import moved_base
from tendond.offline.identification.results.residual import Learned, summary
from tendond.offline.identification.results.result import Found, Identification
from tendond.schemas.config.rig import parse_config
from tendond.schemas.config.rod.bodies import RodBase

DIGITS = 6

VECTORS = ("tip_offset", "offset", "precurvature", "tendon_positions", "tendon_radius", "position", "orientation")
"""Keys of [rod] that several parameters make up."""

POSE = 'correct it in Tracker, or vicon.base_offset; with vicon.base = "" the keys of [rod.base] are'


def file_name(now: datetime) -> str:
    """Return the name of a file of that day."""
    return f"identified-{now:%Y-%m-%d}.toml"


def free_name(folder: Path, now: datetime) -> Path:
    """Find a name for a file of that day that does not exist yet: earlier results are kept."""
    path = folder / file_name(now)
    count = 1
    while path.exists():
        count += 1
        path = folder / f"{path.stem.rsplit('_', 1)[0]}_{count}{path.suffix}"
    return path


def parameter_file(result: Identification, now: datetime, learned: Learned | None = None) -> str:
    """Write the file's text, and check it as a configuration.

    Args:
        result: the identification.
        now: the date.
        learned: correction of what the fit leaves, if one was asked for.

    Raises:
        ConfigError: values that no configuration can have.
    """
    text = "\n".join([*_lines(result, now), *_residual(learned)]) + "\n"
    parse_config(text, "parameters found")
    return text


def _lines(result: Identification, now: datetime) -> Iterator[str]:
    used = [recorded for recorded in result.held_out if recorded.used]
    date = f"{now:%Y-%m-%d %H:%M} UTC"
    yield f"# Parameters of rig '{result.config.rig.name}', identified {date} by tendond {__version__}."
    yield f"# From {', '.join(recorded.name for recorded in used)}."
    yield f"# Residuals {result.rms * 1e3:.3f} mm in each coordinate; the poses' noise is {result.noise * 1e3:.3f} mm."
    yield f"# The scale of force is fixed by {_wrapped(result.scale)}."
    yield "# To include this file, add a line before a configuration's first table; its own keys take precedence:"
    yield f'#     include = ["{file_name(now)}"]'
    for section in ("rod", "rod.scale", "rod.tip", "rod.base", "observer", "servo"):
        here = [found for found in result.parameters if found.parameter.section == section]
        lines = [line for found in here for line in _value(result, found)]
        lines += _vectors(result, section, here)
        if any(not line.startswith("#") for line in lines):
            yield ""
            yield f"[{section}]"
            yield from lines
        elif lines:
            yield ""
            yield from lines
    nowhere = [line for found in result.parameters if not found.parameter.section for line in _value(result, found)]
    if nowhere or result.ratios:
        yield ""
    yield from nowhere
    for ratio in result.ratios:
        known = f"{ratio.value:.{DIGITS}g} +- {ratio.error:.2g}"
        yield f"# {ratio.name} = {known} (configuration: {ratio.nominal:.{DIGITS}g})"


def _residual(learned: Learned | None) -> Iterator[str]:
    """Write the learned correction as [observer.residual], to the last digit; after all other tables."""
    if learned is None:
        return
    yield ""
    yield f"# {summary(learned)}"
    if learned.residual is None:
        return
    section = as_section(learned.residual)
    yield "[observer.residual]"
    yield f"degree = {section.degree}"
    yield f"width = {section.width!r}"
    yield f"features = {json.dumps(section.features)}"
    yield "coefficients = ["
    yield from (
        f"  [{', '.join(map(repr, row))}],  # {name}"
        for name, row in zip(section.features, section.coefficients, strict=True)
    )
    yield "]"
    yield from (f"{name} = [{', '.join(map(repr, getattr(section, name)))}]" for name in ("low", "high"))
    yield f"bound = {section.bound!r}"


def _wrapped(text: str) -> str:
    return " ".join(text.split())


def _value(result: Identification, found: Found) -> Iterator[str]:
    """Write a parameter's line: the key, or why there is none."""
    parameter = found.parameter
    if not found.found:
        yield f"# {parameter.name} was not identified: {found.why}"
        return
    known = f"+- {found.error:.2g} {parameter.unit}"
    if parameter.name == "spool":
        servo = result.config.servo
        if servo is None:
            yield f"# spool: true displacement is {found.value:.5f} {known} of what is reported"
            return
        yield f"# {found.value:.5f} {known} of the configured radius; a file of servo calibrate takes precedence"
        yield f"{parameter.key} = {servo.spool_radius * found.value:.{DIGITS}g}"
        return
    if not parameter.key or parameter.key in VECTORS:
        yield f"# {parameter.name} = {found.value:.{DIGITS}g} {known}: {parameter.meaning}"
        return
    if parameter.key in ("bending_damping", "drag") and parameter.section == "rod":
        was = result.config.rod.bending_damping if parameter.name == "Bbt" else result.config.rod.drag
        entries = ", ".join(f"{found.value * (entry / was[0] if was[0] else 1.0):.{DIGITS}g}" for entry in was)
        yield f"{parameter.key} = [{entries}]  # {parameter.name} {known}"
        return
    value = 0.0 if abs(found.value) < 1e-9 else found.value
    yield f"{parameter.key} = {value:.{DIGITS}g}  # {parameter.name} {known}"


def _vectors(result: Identification, section: str, here: Sequence[Found]) -> Iterator[str]:
    """Write the keys of a table that several parameters make up, with what they have in the fitted configuration."""
    keys = dict.fromkeys(one.parameter.key for one in here if one.found and one.parameter.key in VECTORS)
    if not keys:
        return
    rod = section_with(result.config.rod, result.fit.values)
    if section == "rod.base":
        yield from _base(result)
        return
    tables = {"rod": rod, "rod.scale": rod.scale, "rod.tip": rod.tip}
    for key in keys:
        yield f"{key} = {_array(getattr(tables[section], key))}"


def _base(result: Identification) -> Iterator[str]:
    """Write the base's pose: keys where the driver takes it from them, comments where an object in Tracker has it."""
    vicon = result.config.vicon
    sign = "" if vicon is not None and not vicon.base else "# "
    if sign:
        yield f"# the camera sees the base as an object: {POSE}"
    base = moved_base(result.config.rod.base or RodBase(), result.fit.values)
    for key in ("position", "orientation", *(("down",) if base.down is not None else ())):
        yield f"{sign}{key} = {_array(getattr(base, key))}"


def _array(values: Iterable[Any]) -> str:
    parts = (_array(one) if isinstance(one, tuple) else f"{one:.{DIGITS}g}" for one in values)
    return f"[{', '.join(parts)}]"
