"""`tendond set`, `tendond rig get`: gains and limits of a running controller."""

import json
import math
from contextlib import suppress
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from tendond import TendondError
from tendond.bus.operator import request, status_in
from tendond.cli.common import load_config, say
from tendond.cli.rig.operator import option_of, send
from tendond.daemon.errors import UsageError
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.messages import Status
from tendond.schemas.requests import ControlAction, ControlRequest

CHECKED_BEND = 60.0
"""Bend at which the loop is looked at [degrees], as `tendond config check` does."""


def set_values(settings: list[str], config_file: Path | None, *, configured: bool, unchecked: bool) -> None:
    """Tune gains and limits; see `tendond set --help`.

    Args:
        settings: as KEY=VALUE; a key is complete, or what follows one of its dots where that is unique.
        config_file: the rig's configuration file.
        configured: go back to the configuration's values, of `settings` as KEY or of all that are tuned.
        unchecked: do not look at the loop beforehand.

    Raises:
        UsageError: a setting cannot be read, or is not tunable.
        TendondError: no controller, or it refused.
    """
    from tendond.daemon.control.tuning.keys import tunable_keys
    from tendond.daemon.control.tuning.request import check_key, with_values

    config = load_config(config_file).with_own_rates()
    keys = tunable_keys(config)
    values: dict[str, float] = {}
    if configured:
        tuned = status_in(request(config, ControlAction.STATUS)).tuned
        chosen = [full_key(one, list(keys), config.control.law) for one in settings] or list(tuned)
        values = {name: tuned[name].configured for name in chosen if name in tuned}
        if not values:
            print("all values are those of the configuration already")
            return
    else:
        for setting in settings:
            name, value = parsed(setting)
            values[full_key(name, list(keys), config.control.law)] = value
        for name, value in values.items():
            check_key(keys, name, value)
        changed = with_values(config, keys, values)
        law = f"control.laws.{config.control.law}."
        if not unchecked and any(name.startswith(law) for name in values) and (remark := loop_remark(changed)):
            say(remark)
    send(config_file, ControlRequest(action=ControlAction.SET, settings=values))


def parsed(setting: str) -> tuple[str, float]:
    """Divide KEY=VALUE.

    Raises:
        UsageError: it is not of that form, or the value is no finite number.
    """
    name, sign, text = setting.partition("=")
    with suppress(ValueError):
        if sign and math.isfinite(value := float(text)):
            return name.strip(), value
    raise UsageError(f"'{setting}': give KEY=VALUE with a number, as in limits.tension_max=40")


def full_key(name: str, keys: list[str], law: str) -> str:
    """Return the complete key of a shorter one, as far as it is unique; of the laws' keys, that of `law` in use.

    Raises:
        UsageError: it stands for several.
    """
    found = [key for key in keys if key == name] or [key for key in keys if key.endswith(f".{name}")]
    found = [key for key in found if key.startswith(f"control.laws.{law}.")] or found
    if len(found) > 1:
        raise UsageError(f"{name}: may be {' or '.join(found)}: give more of it")
    return found[0] if found else name


def loop_remark(config: RigConfig) -> str:
    """Say by how much motions about a rest grow in the loop with these values; empty where it is stable, or unknown."""
    from tendond.offline.progress import working
    from tendond.offline.stability.margins import own_loop

    with suppress(TendondError, TypeError), working("looking at the loop with these values"):
        found = own_loop(config, CHECKED_BEND)
        if not found.stable and math.isfinite(found.radius):
            return (
                f"remark: bent by {CHECKED_BEND:g} degrees the loop with these values is unstable: motions grow by a "
                f"factor of {found.radius:.4g} in each cycle; 'tendond set --configured' goes back"
            )
    return ""


def show_values(config_file: Path | None, *, as_json: bool) -> None:
    """Print the tunable keys with their values; see `tendond rig get --help`.

    Raises:
        TendondError: no controller.
    """
    config = load_config(config_file)
    status = status_in(request(config, ControlAction.STATUS))
    rows = tunable_rows(config.with_own_rates(), status)
    if as_json:
        print(json.dumps(rows, indent=2))
        return
    table = Table("key", "in use", "configured", "allowed", "changes")
    for key, row in rows.items():
        shown = f"{row['value']:g}" + ("" if row["value"] == row["wanted"] else f" -> {row['wanted']:g}")
        table.add_row(key, shown, f"{row['configured']:g}", escape(str(row["allowed"])), str(row["changes"]))
    Console(width=None if Console().is_terminal else 200).print(table)
    if status.tuned:
        print(f"'tendond set --configured{option_of(config_file)}' goes back to the configuration's values")


def tunable_rows(config: RigConfig, status: Status) -> dict[str, dict[str, float | str]]:
    """Return value, wanted value, configured value, what is allowed and how it changes, of each tunable key.

    Args:
        config: of the rig, with its own rates.
        status: of its controller.
    """
    from tendond.daemon.control.tuning.keys import tunable_keys

    rows: dict[str, dict[str, float | str]] = {}
    for name, key in tunable_keys(config).items():
        tuned = status.tuned.get(name)
        allowed = f"{key.allowed} and no more than configured" if key.lower_only else key.allowed
        rows[name] = {
            "value": key.configured if tuned is None else tuned.value,
            "wanted": key.configured if tuned is None else tuned.wanted,
            "configured": key.configured if tuned is None else tuned.configured,
            "allowed": f"{allowed} [{key.unit}]" if key.unit else allowed,
            "changes": "while idle" if key.rate is None else f"by {100.0 * key.rate:g} % a second",
        }
    return rows
