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
from tendond.schemas.config.reference import ReferenceSection
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.errors.explain import explain
from tendond.schemas.messages import LARGEST_PAYLOAD, Mode, Status
from tendond.schemas.remedies import clearing, sentence
from tendond.schemas.requests import ControlAction, ControlRequest
from tendond.schemas.wire import encode


def operate(action: str, config_file: Path | None) -> None:
    """Send the request and print the reply.

    Raises:
        TendondError: no controller, or it refused.
    """
    _request(config_file, ControlRequest(action=ControlAction(action)))


def select_law(name: str, config_file: Path | None) -> None:
    """Request another law.

    Raises:
        TendondError: no controller, or it refused.
    """
    _request(config_file, ControlRequest(action=ControlAction.LAW, law=name[:64]))


def set_reference(settings: list[str], config_file: Path | None) -> None:
    """Request another reference; see `tendond rig reference --help`.

    Args:
        settings: keys of [reference] with their values, as KEY=VALUE.
        config_file: the rig's configuration file.

    Raises:
        UsageError: the settings are not a valid reference.
        TendondError: no controller, or it refused.
    """
    table: dict[str, Any] = {}
    for setting in settings:
        name, sign, value = setting.partition("=")
        if not sign:
            raise UsageError(f"'{setting}': give KEY=VALUE, as in across=0.3")
        table[name.strip()] = _value(value.strip())
    if table.get("file"):
        table.setdefault("kind", "samples")
        table |= read_rows(Path(str(table.pop("file"))), str(table["kind"]))
    try:
        wanted = ControlRequest(action=ControlAction.REFERENCE, reference=ReferenceSection.model_validate(table))
    except ValidationError as error:
        raise UsageError("\n".join(f"reference: {line}" for line in explain(error, ReferenceSection))) from error
    if len(encode(wanted)) > LARGEST_PAYLOAD:
        raise UsageError(f"the samples exceed {LARGEST_PAYLOAD} bytes: set reference.file in the configuration instead")
    _request(config_file, wanted)


def _value(text: str) -> Any:
    """Parse as TOML; a bare word is a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text


def _request(config_file: Path | None, wanted: ControlRequest) -> None:
    config = load_config(config_file)
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
        "log": status.loop.log_error or f"{status.loop.log_dropped} entries dropped{_days(status.loop.log_days_left)}",
    }
    for name, value in rows.items():
        table.add_row(name, value)
    return table


def _sensors(status: Status) -> list[str]:
    return [f"{name} {health.in_words}" for name, health in status.sensors.items()]


def _days(left: float | None) -> str:
    return "" if left is None else f", space for {left:.1f} more days"


def _millimetres(values: tuple[float, ...]) -> str:
    return " ".join(f"{value * 1e3:.1f}" for value in values) + " mm"
