"""The parameter file: dated TOML that a rig's configuration can include, with errors beside the values."""

from collections.abc import Iterator
from datetime import datetime
from pathlib import Path

from tendond import __version__
from tendond.offline.identification.results.result import Found, Identification
from tendond.schemas.config.rig import parse_config

DIGITS = 6


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


def parameter_file(result: Identification, now: datetime) -> str:
    """Write the file's text, and check it as a configuration.

    Args:
        result: the identification.
        now: the date.

    Raises:
        ConfigError: values that no configuration can have.
    """
    text = "\n".join(_lines(result, now)) + "\n"
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
    for section in ("rod", "rod.scale", "rod.tip", "observer", "servo"):
        lines = [
            line for found in result.parameters if found.parameter.section == section for line in _value(result, found)
        ]
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
    if not parameter.key:
        yield f"# {parameter.name} = {found.value:.{DIGITS}g} {known}: {parameter.meaning}"
        return
    if parameter.key in ("bending_damping", "drag") and parameter.section == "rod":
        was = result.config.rod.bending_damping if parameter.name == "Bbt" else result.config.rod.drag
        entries = ", ".join(f"{found.value * (entry / was[0] if was[0] else 1.0):.{DIGITS}g}" for entry in was)
        yield f"{parameter.key} = [{entries}]  # {parameter.name} {known}"
        return
    value = 0.0 if abs(found.value) < 1e-9 else found.value
    yield f"{parameter.key} = {value:.{DIGITS}g}  # {parameter.name} {known}"
