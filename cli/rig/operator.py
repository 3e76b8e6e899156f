"""`tendond arm`, `stop`, `reset`, `status`, `law`, `reference`: an operator's requests."""

import tomllib
from pathlib import Path
from shlex import quote
from typing import Any

from pydantic import ValidationError
from rich.console import Console
from rich.table import Table

from tendond.bus.operator import request, status_in
from tendond.cli.common import load_config, read_rows
from tendond.daemon.errors import DaemonError, UsageError
from tendond.offline.progress import working
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.errors.explain import explain
from tendond.schemas.errors.keywords import keys_of
from tendond.schemas.messages import LARGEST_PAYLOAD, Mode, Status
from tendond.schemas.mistaken_units import unit_hint
from tendond.schemas.remedies import clearing, sentence
from tendond.schemas.requests import ControlAction, ControlRequest
from tendond.schemas.wire import encode

REACH = 2.0
"""Largest length in a reference, in lengths of the arm: a target has to be within one, a line has two ends."""

TILTS = ("start", "end", "center", "radius", "radius_end")
"""Keys that are angles with aim = "direction"."""


def operate(action: str, config_file: Path | None) -> None:
    """Send the request and print the reply.

    Raises:
        TendondError: no controller, or it refused.
    """
    send(config_file, ControlRequest(action=ControlAction(action)))


def select_law(name: str, config_file: Path | None) -> None:
    """Request another law.

    Raises:
        TendondError: no controller, or it refused.
    """
    send(config_file, ControlRequest(action=ControlAction.LAW, law=name[:64]))


def set_reference(settings: list[str], config_file: Path | None) -> None:
    """Request another reference; see `tendond rig reference --help`.

    Args:
        settings: keys of [reference] with their values, as KEY=VALUE.
        config_file: the rig's configuration file.

    Raises:
        UsageError: the settings are not a valid reference.
        TendondError: no controller, or it refused.
    """
    send(config_file, reference_request(settings, load_config(config_file)))


def reference_request(settings: list[str], config: RigConfig, *, files: bool = True) -> ControlRequest:
    """Build the request for another reference.

    Args:
        settings: keys of [reference] with their values, as KEY=VALUE.
        config: of the rig, for the length of the arm.
        files: read the file that a key names; false: refuse it.

    Raises:
        UsageError: the settings are not a valid reference.
    """
    table: dict[str, Any] = {}
    for setting in settings:
        name, sign, value = setting.partition("=")
        if not sign:
            raise UsageError(f"'{setting}': give KEY=VALUE, as in across=0.3")
        table[name.strip()] = _value(value.strip())
    check_lengths(table, config.rod.backbone_length)
    if table.get("file"):
        if not files:
            raise UsageError("reference: file: is read on the command line only: tendond rig reference file=...")
        table.setdefault("kind", "samples")
        file = Path(str(table.pop("file")))
        rows = read_rows(file, str(table["kind"]))
        check_rows(file, rows, config.rod.backbone_length)
        table |= rows
    try:
        wanted = ControlRequest(action=ControlAction.REFERENCE, reference=ReferenceSection.model_validate(table))
    except ValidationError as error:
        raise UsageError("\n".join(f"reference: {line}" for line in explain(error, ReferenceSection))) from error
    if len(encode(wanted)) > LARGEST_PAYLOAD:
        raise UsageError(f"the samples exceed {LARGEST_PAYLOAD} bytes: set reference.file in the configuration instead")
    return wanted


def check_lengths(table: dict[str, Any], length: float) -> None:
    """Refuse lengths of a reference that no arm of this length has: they may be in millimetres.

    Args:
        table: keys of [reference] with their values.
        length: of the backbone [m].

    Raises:
        UsageError: names the key, what is allowed and the unit.
    """
    keys = {key.name: key for key in keys_of(ReferenceSection)}
    for name, value in table.items():
        is_tilt = table.get("aim") == "direction" and name in TILTS
        if name not in keys or keys[name].unit != "m" or is_tilt:
            continue
        largest = length if name == "moved_max" else REACH * length
        for one in value if isinstance(value, list) else [value]:
            if isinstance(one, int | float) and abs(one) > largest:
                what = "longer than the arm" if name == "moved_max" else "out of the arm's reach"
                raise UsageError(
                    f"reference: {name} = {value}: {what}, which is {length:g} m long{unit_hint(one, largest, 'm')}"
                )


def check_rows(file: Path, rows: dict[str, list[tuple[float, ...]]], length: float) -> None:
    """Refuse a file of samples or waypoints whose places no arm of this length reaches.

    Raises:
        UsageError: names the file, the row and the unit.
    """
    for key, found in rows.items():
        for number, row in enumerate(found, 2):
            places = row[1:4] if key == "samples" else row[:3]
            if (farthest := max(places, key=abs)) and abs(farthest) > REACH * length:
                hint = unit_hint(farthest, REACH * length, "m")
                raise UsageError(
                    f"{file}:{number}: {farthest:g} m is out of the arm's reach, which is {length:g} m long{hint}"
                )


def _value(text: str) -> Any:
    """Parse as TOML; a bare word is a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def send(config_file: Path | None, wanted: ControlRequest) -> None:
    """Send a request and print the reply as a sentence.

    Raises:
        TendondError: no controller, or it refused.
    """
    config = load_config(config_file)
    changes = wanted.action in (ControlAction.LAW, ControlAction.REFERENCE)
    with working("waiting for the controller to plan it", quiet=not changes):
        reply = request(config, wanted)
    message = reply.message
    if (status := reply.status) is not None:
        message = sentence(message, status.mode, remedy(status, config, config_file), option_of(config_file))
    if not reply.done:
        raise DaemonError(message)
    print(message)


def show_status(config_file: Path | None, *, as_json: bool) -> None:
    """Print the status as a table, or as JSON.

    Raises:
        TendondError: no controller.
    """
    config = load_config(config_file)
    status = status_in(request(config, ControlAction.STATUS))
    if as_json:
        print(status.model_dump_json(indent=2))
    else:
        Console().print(status_table(status, remedy(status, config, config_file)))


def remedy(status: Status, config: RigConfig, config_file: Path | None) -> str:
    """Name the commands that clear a rig's fault, with the option that was given; empty without a fault."""
    if status.mode is not Mode.FAULT:
        return ""
    return clearing(status.reason, option_of(config_file), has_servos=config.servo is not None)


def option_of(config_file: Path | None) -> str:
    """Return the option that names the rig, for a command to copy."""
    return "" if config_file is None else f" --config {quote(str(config_file))}"


def status_table(status: Status, to_clear: str = "") -> Table:
    """Return the status as a table for people; `to_clear` says how a fault is cleared."""
    table = Table(title=f"rig {status.rig}", show_header=False)
    rows = {
        "mode": f"{status.mode.value} ({status.reason})",
        **({"to clear": to_clear} if to_clear else {}),
        "law": f"{status.law}, feedback {status.feedback}",
        "tip": "no pose yet" if status.tip is None else _millimetres(status.tip),
        "target": _millimetres(status.target),
        "tension": " ".join(f"{value:.2f}" for value in status.tension) + " N",
        **({"at tip": " ".join(f"{value:.2f}" for value in status.tip_tension) + " N"} if status.tip_tension else {}),
        "displacement": _millimetres(status.displacement),
        "cycles": f"{status.loop.cycles}, {status.loop.missed_ticks} deadlines missed",
        "phase": status.loop.phase_in_words,
        "wake-up to command": f"median {status.loop.cycle_ms_median:.2f} ms, p99 {status.loop.cycle_ms_p99:.2f} ms",
        "rejected": ", ".join(f"{count} {reason}" for reason, count in status.rejected.items()) or "nothing",
        **({"sensors": "; ".join(_sensors(status))} if status.sensors else {}),
        **({"filter": status.filter.in_words} if status.filter else {}),
        **({"safety": status.safety} if status.safety else {}),
        **({"refused": status.refused} if status.refused else {}),
        **({"tuned": "\n".join(_tuned(status))} if status.tuned else {}),
        "log": status.loop.log_error or f"{status.loop.log_dropped} entries dropped{_days(status.loop.log_days_left)}",
    }
    for name, value in rows.items():
        table.add_row(name, value)
    return table


def _tuned(status: Status) -> list[str]:
    return [f"{key} = {one.in_words}" for key, one in status.tuned.items()]


def _sensors(status: Status) -> list[str]:
    return [f"{name} {health.in_words}" for name, health in status.sensors.items()]


def _days(left: float | None) -> str:
    return "" if left is None else f", space for {left:.1f} more days"


def _millimetres(values: tuple[float, ...]) -> str:
    return " ".join(f"{value * 1e3:.1f}" for value in values) + " mm"
