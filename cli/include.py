"""`include` in a rig's configuration: other files, whose keys the file's own override."""

import re
import tomllib
from pathlib import Path
from typing import Any

from tendond.schemas.config.migration.version import version_objection, without_version
from tendond.schemas.config.rig import ConfigError, RigConfig, check_config, parse_config
from tendond.schemas.errors.toml_lines import not_toml

INCLUDE = "include"
Tables = dict[str, Any]


def read_text(path: Path) -> str:
    """Read a configuration's text.

    Raises:
        ConfigError: it cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8-sig")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise ConfigError(f"{path}: is not text in UTF-8") from error


def parse_with_includes(text: str, path: Path) -> RigConfig:
    """Parse a configuration over the files that it includes.

    `include = ["identified-2026-11-24.toml"]`, before the first table, names files beside this one. Later ones override
    earlier ones, and the file's own keys override all. A list counts as one value.

    Raises:
        ConfigError: see `parse_config`; or an included file is invalid. The message names the file of a wrong key.
    """
    try:
        own: Tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError:
        return parse_config(text, str(path))
    if INCLUDE not in own:
        return parse_config(text, str(path))
    files = _included(own.pop(INCLUDE), path)
    merged = _merged(own, files)
    try:
        return check_config(merged, str(path))
    except ConfigError as error:
        lines = [_renamed(line, path, own, files) for line in str(error).splitlines()]
        raise ConfigError("\n".join(lines)) from error


def sections(path: Path) -> set[str]:
    """Return the names of the sections in a configuration and its includes; keys and values are not checked.

    Raises:
        ConfigError: a file cannot be read, or is not valid TOML.
    """
    text = read_text(path)
    try:
        own: Tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: {not_toml(text, error)}") from error
    files = _included(own.pop(INCLUDE), path) if INCLUDE in own else {}
    return {name for name, value in _merged(own, files).items() if isinstance(value, dict)}


def _included(names: Any, path: Path) -> dict[Path, Tables]:
    """Read the tables of the included files, by path."""
    if not isinstance(names, list) or not all(isinstance(name, str) for name in names):
        raise ConfigError(f'{path}: {INCLUDE}: must be a list of file names, for instance ["identified.toml"]')
    return {path.parent / name: _tables(path.parent / name) for name in names}


def _merged(own: Tables, files: dict[Path, Tables]) -> Tables:
    merged: Tables = {}
    for tables in (*files.values(), own):
        merged = _over(merged, tables)
    return merged


def _tables(path: Path) -> Tables:
    text = read_text(path)
    try:
        tables = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise ConfigError(f"{path}: {not_toml(text, error)}") from error
    if objection := version_objection(tables):
        raise ConfigError(f"{path}: {objection}")
    if INCLUDE in tables:
        raise ConfigError(
            f"{path}: {INCLUDE}: an included file must not include others: name them all in the first file"
        )
    return without_version(tables)


def _over(below: Tables, above: Tables) -> Tables:
    """Merge two nested tables; values of `above` override those of `below`."""
    merged = dict(below)
    for key, value in above.items():
        both = isinstance(value, dict) and isinstance(merged.get(key), dict)
        merged[key] = _over(merged[key], value) if both else value
    return merged


def _renamed(line: str, path: Path, own: Tables, files: dict[Path, Tables]) -> str:
    """Name the included file in a message about a key that comes from it."""
    match = re.match(rf"{re.escape(str(path))}(?::\d+)?: ([A-Za-z_][\w.\[\]-]*)", line)
    if match is None:
        return line
    keys = re.split(r"[.\[]", match[1])
    if _has(own, keys):
        return line
    for file, tables in reversed(files.items()):
        if _has(tables, keys):
            return f"{file}: {line[match.start(1) :]}"
    return line


def _has(tables: Any, keys: list[str]) -> bool:
    """Check that tables have a key, given by its parts; an index within a list counts as the list."""
    for key in keys:
        if not isinstance(tables, dict):
            return True
        if key not in tables:
            return False
        tables = tables[key]
    return True
