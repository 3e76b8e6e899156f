"""`tendond config`: check, show, schema."""

import json
from pathlib import Path

from tendond.cli.common import chosen_config, say
from tendond.cli.manual.config_text import config_schema, config_toml
from tendond.offline.config_check import (
    control_of,
    law_objections,
    located,
    remarks,
    resolution_remarks,
    start_objections,
)
from tendond.schemas.config.rig import ConfigError, RigConfig
from tendond.schemas.errors.explain import Objection, dotted, in_file

INCOMPLETE = "cross-key checks run after these are fixed"


def run_check(file: Path | None, profile: str | None, *, as_json: bool, model: bool = True) -> None:
    """Print every error; see `tendond config check --help`.

    Args:
        file: rig configuration, TOML.
        profile: built-in configuration to check instead.
        as_json: print JSON.
        model: check with the rod model as well; its kernels may have to be compiled.

    Raises:
        ConfigError: there are errors, and text is wanted.
        SystemExit: with 2, there are errors, and JSON is wanted.
    """
    notes: list[str] = []
    try:
        config, source = chosen_config(file, profile)
    except ConfigError as error:
        wrong, source, text = list(error.objections), str(file or profile), str(error)
        if wrong:
            wrong += located(law_objections(control_of(file)), file)
            wrong.sort(key=lambda one: one.line or 0)
            text = "\n".join(in_file(one, source) for one in wrong)
            notes.append(INCOMPLETE)
        else:
            wrong = [Objection("", "", text)]
    else:
        wrong = located([*law_objections(config.control), *(start_objections(config, say) if model else ())], file)
        text = "\n".join(in_file(one, source) for one in wrong)
        notes += remarks(config, file)
        if model and not wrong:
            notes += resolution_remarks(config)
    if as_json:
        found = [
            {"line": one.line, "key": one.key or dotted(one.path), "value": one.value, "message": one.message}
            for one in wrong
        ]
        print(json.dumps({"source": source, "ok": not wrong, "errors": found, "notes": notes}, indent=2))
        if wrong:
            raise SystemExit(2)
        return
    if wrong:
        raise ConfigError("\n".join([text, *(f"note: {note}" for note in notes)]), wrong)
    print(f"{source}: OK; {_summary(config)}")
    for note in notes:
        print(f"note: {note}")


def _summary(config: RigConfig) -> str:
    drivers = [name for name in ("vicon", "servo") if getattr(config, name) is not None]
    return (
        f"rig '{config.rig.name}', law {config.control.law}, {1.0 / config.loop.period:g} Hz, "
        f"{len(config.rod.tendon_positions)} tendons up to {config.limits.tension_max:g} N, "
        f"drivers {' and '.join(drivers) or 'none'}"
    )


def run_show(file: Path | None, profile: str | None, *, changed: bool, comments: bool, as_json: bool) -> None:
    """Print the effective configuration; see `tendond config show --help`.

    Raises:
        ConfigError: it cannot be used.
    """
    config, _ = chosen_config(file, profile)
    if as_json:
        print(json.dumps(config.model_dump(mode="json", exclude_defaults=changed), indent=2))
    else:
        print(config_toml(config, changed=changed, comments=comments), end="")


def run_schema() -> None:
    """Print the JSON Schema."""
    print(json.dumps(config_schema(), indent=2))
