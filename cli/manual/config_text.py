"""A configuration as TOML, with what each key is; and as JSON Schema, for editors."""

import json
from collections.abc import Mapping
from copy import deepcopy
from typing import Any

from tendond.daemon.control.laws import LAWS
from tendond.schemas.config.migration.version import CONFIG_VERSION, KEY
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.errors.keywords import Key, Node, schema_of, tables

Values = Mapping[str, Any]
VERSION_MEANING = "version of the keys' names; tendond config migrate sets it"
FILE_KEYS: Node = {
    KEY: {"type": "integer", "minimum": 1, "maximum": CONFIG_VERSION, "description": VERSION_MEANING},
    "include": {"type": "array", "items": {"type": "string"}, "description": "files whose keys this one's override"},
}
"""Keys of a file that are no settings."""

OPTIONAL = {name for name, field in RigConfig.model_fields.items() if field.default is None}
"""Sections that need not be there; an empty one means something."""


def config_toml(config: RigConfig, *, changed: bool = False, comments: bool = True) -> str:
    """Write the configuration as TOML that reads as the same configuration.

    Args:
        config: the rig's configuration.
        changed: only what differs from the defaults.
        comments: unit, range and meaning behind each key; keys that are not set stand as comments too.
    """
    data = config.model_dump(mode="json")
    if data["reference"]["file"]:
        data["reference"]["samples"] = []  # the file has them
    blocks = []
    for table in tables(RigConfig):
        name = table.name.removesuffix("[]")
        each = name != table.name
        if changed and name.startswith("simulator.rod.") and data["simulator"]["rod"] == data["rod"]:
            continue  # inherited with its tables
        for values in tables_at(data, name, each=each):
            rows = [(key, values[key.name]) for key in table.keys if key.name in values]
            if changed:
                inherited = data["rod"] if name == "simulator.rod" else {}
                rows = [
                    (key, value) for key, value in rows if key.required or value != inherited.get(key.name, key.default)
                ]
            plain = [(key, value) for key, value in rows if not isinstance(value, dict)]
            if plain or not changed or each or name in OPTIONAL:
                header = f"[[{name}]]" if each else f"[{name}]"
                meaning = f"  # {table.meaning}" if comments and table.meaning else ""
                blocks.append("\n".join([header + meaning, *_lines(plain, comments)]))
            blocks += [
                "\n".join([f"[{key.path}.{law}]", *(f"{one} = {to_toml(number)}" for one, number in part.items())])
                for key, value in rows
                if isinstance(value, dict)
                for law, part in value.items()
            ]
    return "\n\n".join(blocks or ["# nothing differs from the defaults"]) + "\n"


def tables_at(data: Values, name: str, *, each: bool) -> list[Values]:
    """Return the tables of a name in a configuration: none, one, or each of a list."""
    found: Any = data
    for part in name.split("."):
        found = found.get(part)
        if found is None:
            return []
    return list(found) if each else [found]


def _lines(rows: list[tuple[Key, Any]], comments: bool) -> list[str]:
    rows = [(key, value) for key, value in rows if comments or value is not None]
    written = [f"# {key.name} =" if value is None else f"{key.name} = {to_toml(value)}" for key, value in rows]
    if not comments:
        return written
    width = min(30, max((len(line) for line in written), default=0))
    return [f"{line:<{width}}  # {comment_of(key)}" for line, (key, _) in zip(written, rows, strict=True)]


def comment_of(key: Key) -> str:
    """Describe a key's values, unit and meaning: 'a number > 0 [m]; of the backbone'."""
    unit = f" [{key.unit}]" if key.unit else ""
    return f"{key.words}{unit}{'; ' if key.meaning else ''}{key.meaning}"


def to_toml(value: Any) -> str:
    """Write a value as TOML."""
    if isinstance(value, str | bool | int):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, float):
        return f"{value:g}" if abs(value) >= 1e6 and float(f"{value:g}") == value else repr(value)
    return "[" + ", ".join(to_toml(one) for one in value) + "]"


def config_schema() -> Node:
    """JSON Schema of a configuration file, with the laws' own parameters in it."""
    schema = deepcopy(schema_of(RigConfig))
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "Configuration of a rig for tendond"
    schema["properties"] = {**FILE_KEYS, **schema["properties"]}
    control = schema["$defs"]["ControlSection"]["properties"]
    control["law"] = {**control["law"], "enum": list(LAWS)}
    kinds: dict[str, Any] = {name: law.parameters for name, law in LAWS.items()}
    parameters = {name: deepcopy(schema_of(kind)) for name, kind in kinds.items()}
    control["laws"] = {
        **control["laws"],
        "additionalProperties": False,
        "properties": {name: {**part, "title": name} for name, part in parameters.items()},
    }
    return schema
