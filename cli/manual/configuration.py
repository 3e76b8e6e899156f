"""The page of the configuration's keys."""

from collections.abc import Iterable

from tendond.cli.manual.config_text import to_toml
from tendond.cli.manual.markdown import code, escaped, summary, table
from tendond.daemon.control.laws import LAWS
from tendond.schemas.config.migration.version import CONFIG_VERSION
from tendond.schemas.config.rig import RigConfig
from tendond.schemas.errors.keywords import Key, keys_of, tables

_HEAD = """\
# Configuration

One TOML file describes a rig. Every key has a default, so an empty file is the paper's robot; what is not known here is
refused by name. `tendond config show` prints this with the values in effect, `tendond config check` says all that is
wrong with a file, `tendond config schema` gives editors what they need ([how](../howto/configure.md)).

Units are SI. Keys without a default are optional.

Before the first table, `version = {version}` names the version of the keys' names, and `include` files whose keys this
one's override ([how](../howto/configure.md)). A file without a version is read under old and present names; one of a
newer version is refused.
"""


def configuration_page() -> str:
    """Write the page of all keys, a section per table, in Markdown."""
    parts = [_HEAD.replace("{version}", str(CONFIG_VERSION))]
    for one in tables(RigConfig):
        name = one.name.removesuffix("[]")
        header = f"[[{name}]]" if name != one.name else f"[{name}]"
        parts.append(f"## `{header}`\n")
        if one.meaning:
            parts.append(escaped(f"{one.meaning[0].upper()}{one.meaning[1:]}.\n"))
        if RigConfig.model_fields.get(name) is not None and RigConfig.model_fields[name].default is None:
            parts.append("Optional, except for the driver that needs it; it may be empty.\n")
        parts.append(_keys(one.keys))
        if name == "control":
            parts += [_law(law) for law in LAWS]
    return "\n".join(parts)


def _keys(keys: Iterable[Key]) -> str:
    rows = [_row(key) for key in keys if key.words != "a table"]
    return table(("key", "allowed", "unit", "default", "meaning"), rows) + "\n"


def _row(key: Key) -> tuple[str, ...]:
    default = "must be given" if key.required else "" if key.default is None else code(to_toml(key.default))
    return code(key.name), escaped(key.words), key.unit, default, escaped(key.meaning)


def _law(name: str) -> str:
    parameters = LAWS[name].parameters
    return f"### `[control.laws.{name}]`\n\n{escaped(summary(parameters))}\n\n{_keys(keys_of(parameters))}"
