"""A configuration file rewritten to the present version: comments, order and layout stay as they are."""

import re
import tomllib
import warnings
from dataclasses import dataclass, field
from typing import Any

from tendond import TendondError
from tendond.schemas.config.migration.version import CONFIG_VERSION, KEY, version_objection, without_version
from tendond.schemas.config.renamed import (
    IN_SECONDS,
    REMOVED,
    RENAMED,
    RENAMED_VALUES,
    RenamedKeyWarning,
    period_of,
    with_new_names,
)
from tendond.schemas.errors.toml_lines import key_lines, not_toml

_SIGNIFICANT = re.compile(r"\s*[^\s#]")
INCLUDE = "include"


class MigrationError(TendondError):
    """A file that cannot be rewritten: which, why, what to do."""


@dataclass
class Migration:
    """A file before and after.

    Attributes:
        old, new: texts.
        before: version of the old text; 1 where it names none.
        changes: what was changed, a line each.
    """

    old: str
    new: str
    before: int
    changes: list[str] = field(default_factory=list)


def migrate(text: str, source: str) -> Migration:
    """Rewrite a configuration to the present names, and set its version.

    The new text is parsed and compared with what the old one is read as; a file in which a key is spelled so that this
    editor does not find it is refused as a whole.

    Args:
        text: TOML.
        source: name of the file, for messages.

    Raises:
        MigrationError: not TOML, of a newer version, or to be changed by hand.
    """
    try:
        data = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise MigrationError(f"{source}: {not_toml(text, error)}") from error
    if objection := version_objection(data):
        raise MigrationError(f"{source}: {objection}")
    expected = _read(data, source)
    found = Migration(text, text, data.get(KEY, 1))
    editor = _Editor(text, found.changes)
    for (section, old), name in RENAMED.items():
        if _has(data, section, old):
            editor.rename(section, old, name)
    for (section, old), name in IN_SECONDS.items():
        if _has(data, section, old):
            _refuse_unknown_period(data, source, section, old)
            editor.to_seconds(section, old, name, data[section][old], period_of(data))
    for (section, key), values in RENAMED_VALUES.items():
        if _has(data, section, key) and isinstance(given := data[section][key], str) and given in values:
            editor.replace_value(section, key, given, values[given])
    for (section, old), why in REMOVED.items():
        if _has(data, section, old):
            editor.comment_out(section, old, why)
    editor.set_version(data.get(KEY))
    found.new = editor.text
    _verify(found, expected, source)
    return found


def _read(data: dict[str, Any], source: str) -> dict[str, Any]:
    """Return the tables under the present names."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RenamedKeyWarning)
        expected, objections = with_new_names(without_version(data), source)
    if objections:
        raise MigrationError("\n".join(f"{source}: {'.'.join(path)}: {message}" for path, message in objections))
    return expected


def _verify(found: Migration, expected: dict[str, Any], source: str) -> None:
    """Check that the new text says what the old one is read as."""
    try:
        tables = tomllib.loads(found.new)
    except tomllib.TOMLDecodeError:
        tables = {}
    for section, _ in REMOVED:  # may have had no other key
        expected = {key: value for key, value in expected.items() if key != section or value}
        tables = {key: value for key, value in tables.items() if key != section or value}
    if tables.get(KEY) != CONFIG_VERSION or without_version(tables) != expected:
        raise MigrationError(
            f"{source}: cannot be rewritten, for its layout: change the keys that 'tendond config check {source}' "
            f"names, and write {KEY} = {CONFIG_VERSION} before the first table"
        )


def _has(data: dict[str, Any], section: str, key: str) -> bool:
    return isinstance(table := data.get(section), dict) and key in table


def _refuse_unknown_period(data: dict[str, Any], source: str, section: str, old: str) -> None:
    """Refuse a count of cycles of a period that another file may set."""
    if INCLUDE in data and not _has(data, "loop", "period"):
        raise MigrationError(
            f"{source}: {section}.{old} counts cycles of loop.period, which an included file may set: "
            f"write loop.period into this file, then migrate it"
        )


class _Editor:
    """Edits of lines of a TOML text, each with a line in `changes`."""

    def __init__(self, text: str, changes: list[str]) -> None:
        self._lines = text.splitlines(keepends=True)
        self._places = key_lines(text)
        self._changes = changes

    @property
    def text(self) -> str:
        return "".join(self._lines)

    def rename(self, section: str, old: str, name: str) -> None:
        """Give a key another name."""
        if self._replace(section, old, rf"{_key(old)}(?=\s*=)", name):
            self._changes.append(f"{section}.{old} is now {section}.{name}")

    def to_seconds(self, section: str, old: str, name: str, cycles: int, period: float) -> None:
        """Turn a count of cycles into seconds."""
        seconds = round(cycles * period, 9)
        if self._replace(section, old, rf"{_key(old)}(\s*=\s*)[+\d_xob]+", rf"{name}\g<2>{seconds!r}"):
            words = f"{section}.{old} = {cycles} cycles of {period:g} s is now {section}.{name} = {seconds:g} s"
            self._changes.append(words)

    def replace_value(self, section: str, key: str, old: str, new: str) -> None:
        """Give a text another value."""
        if self._replace(section, key, rf"{_key(key)}(\s*=\s*)([\"']){re.escape(old)}\3", rf'{key}\g<2>"{new}"'):
            self._changes.append(f"{section}.{key} = '{old}' is now '{new}'")

    def comment_out(self, section: str, key: str, why: str) -> None:
        """Turn a line that no longer has a meaning into a comment, with the reason above it."""
        number = self._places.get((section, key))
        if number is None:
            return
        line = self._lines[number - 1]
        self._lines[number - 1] = f"# No longer used, {why}:\n# {line.lstrip()}"
        self._changes.append(f"{section}.{key} is no longer used ({why}): it is a comment now")

    def set_version(self, before: int | None) -> None:
        """Write the version, in its line or before the first key or table, and before its comment."""
        if before == CONFIG_VERSION:
            return
        self._changes.append(f"{KEY} = {CONFIG_VERSION}")
        if before is not None:
            number = self._places.get((KEY,), 1)
            self._lines[number - 1] = re.sub(r"=\s*\d+", f"= {CONFIG_VERSION}", self._lines[number - 1], count=1)
            return
        first = next((i for i, line in enumerate(self._lines) if _SIGNIFICANT.match(line)), len(self._lines))
        place = first
        while place > 0 and self._lines[place - 1].lstrip().startswith("#"):
            place -= 1
        if place == 0:  # the comment at the top is the file's
            place = first
        if place and not self._lines[place - 1].endswith("\n"):
            self._lines[place - 1] += "\n"
        self._lines.insert(place, f"{KEY} = {CONFIG_VERSION}\n" + ("\n" if place < len(self._lines) else ""))

    def _replace(self, section: str, key: str, pattern: str, new: str) -> bool:
        """Replace the first match in the line of a key, or in that of its inline table."""
        number = self._places.get((section, key)) or self._places.get((section,))
        if number is None:
            return False
        self._lines[number - 1], count = re.subn(pattern, new, self._lines[number - 1], count=1)
        return count == 1


def _key(name: str) -> str:
    """Return a pattern of a key, quoted or not; its quote is the first group."""
    return rf"(?<![\w-])([\"']?){name}\1(?![\w-])"
