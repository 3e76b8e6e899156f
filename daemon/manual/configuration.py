"""The page of the configuration's keys."""

import json
from typing import Any

from tendond.daemon.laws import LAWS
from tendond.daemon.manual.markdown import code, escaped, summary, table
from tendond.schemas.config import RigConfig
from tendond.schemas.keywords import Key, in_words, schema_of, tables

_HEAD = """\
# Configuration

One TOML file describes a rig. Every key has a default, so an empty file is the paper's robot; what is not known here is
refused by name. `tendond config show` prints this with the values in effect, `tendond config check` says all that is
wrong with a file, `tendond config schema` gives editors what they need ([how](../howto/configure.md)).

Units are SI. A key without a default is left out by default.
"""


def configuration_page() -> str:
    """Markdown: a section for each table of the file."""
    parts = [_HEAD]
    for one in tables(RigConfig):
        name = one.name.removesuffix("[]")
        header = f"[[{name}]]" if name != one.name else f"[{name}]"
        parts.append(f"## `{header}`\n")
        if one.meaning:
            parts.append(escaped(f"{one.meaning[0].upper()}{one.meaning[1:]}.\n"))
        if RigConfig.model_fields.get(name) is not None and RigConfig.model_fields[name].default is None:
            parts.append("May be left out; the driver that needs it wants it, and it may be empty.\n")
        keys = [key for key in one.keys if key.words != "a table"]
        parts.append(table(("key", "allowed", "unit", "default", "meaning"), [_row(key) for key in keys]) + "\n")
        if name == "control":
            parts += [_law(law) for law in LAWS]
    return "\n".join(parts)


def _row(key: Key) -> tuple[str, ...]:
    default = "must be given" if key.required else "" if key.default is None else code(_toml(key.default))
    return code(key.name), escaped(key.words), key.unit, default, escaped(key.meaning)


def _law(name: str) -> str:
    parameters = LAWS[name].parameters
    schema = schema_of(parameters)
    rows = [
        (code(key), escaped(in_words(schema, node)), code(_toml(node.get("default"))))
        for key, node in schema["properties"].items()
    ]
    keys = table(("key", "allowed", "default"), rows)
    return f"### `[control.laws.{name}]`\n\n{escaped(summary(parameters))}\n\n{keys}\n"


def _toml(value: Any) -> str:
    if isinstance(value, float) and abs(value) >= 1e6:
        return f"{value:g}"
    return json.dumps(value)
