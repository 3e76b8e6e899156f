"""Differences between the run that wrote a log and this one: versions, processor, the configuration's keys."""

import json
import tomllib
from typing import Any

from tendond.daemon.errors import UsageError
from tendond.daemon.recording.run_metadata import run_metadata
from tendond.offline.logs.run import Run
from tendond.offline.replay.difference import MISSING, compare
from tendond.schemas.config.control import ControlSection
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config


def version_changes(run: Run) -> list[str]:
    """List the differing versions, one line each: name, in the log, here."""
    here = run_metadata(run.config)
    names = {"revision": "revision of tendond", "cpu": "processor"}
    return [
        f"{names.get(name, name)} is {here[name]} here, {run.metadata.get(name, 'not named')} in the log"
        for name in here
        if run.metadata.get(name) != here[name]
    ]


def parameter_changes(run: Run) -> list[str]:
    """Keys of the configuration that this version of tendond reads otherwise than they stand in the log."""
    lines = []
    for field in compare(run.attachment, run.config.model_dump_json()):
        if field.logged == MISSING:
            lines.append(f"{field.path} is not in the log's configuration: taken as {json.dumps(field.replayed)}")
        elif repr(field.logged) != repr(field.replayed):
            lines.append(
                f"{field.path} = {json.dumps(field.logged)} in the log is read as {json.dumps(field.replayed)}"
            )
    return lines


def with_changes(config: RigConfig, law: str | None, changes: list[str]) -> RigConfig:
    """Return the configuration with another law and other values.

    Args:
        config: the log's configuration.
        law: value for control.law.
        changes: 'key=value', the key with dots, the value as in TOML; control.NAME is a parameter of the law in use
            where [control] has no such key.

    Raises:
        UsageError: no key and value, or a configuration that cannot be.
    """
    tables: dict[str, Any] = config.model_dump()
    if law is not None:
        tables["control"]["law"] = law
    for change in changes:
        key, equals, text = change.partition("=")
        *sections, name = [part.strip() for part in key.split(".")]
        if not equals or not sections or not name:
            raise UsageError(f"--set {change}: give it as section.key=value, for instance limits.tension_max=40")
        table = tables
        for section in sections:
            inner = table.setdefault(section, {})
            if not isinstance(inner, dict):
                raise UsageError(f"--set {change}: '{section}' is no section")
            table = inner
        if sections == ["control"] and name not in ControlSection.model_fields:
            table = table["laws"].setdefault(table["law"], {})
        table[name] = _value(text.strip())
    try:
        return check_config(tables, "--set" if changes else "--law")
    except ConfigError as error:
        raise UsageError(str(error)) from error


def _value(text: str) -> Any:
    """Parse a TOML value; a bare word is a string."""
    try:
        return tomllib.loads(f"value = {text}")["value"]
    except tomllib.TOMLDecodeError:
        return text
