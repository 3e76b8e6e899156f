"""`tendond config migrate`."""

import difflib
import os
import shutil
from pathlib import Path

from tendond.cli.common import say
from tendond.cli.include import read_text
from tendond.daemon.errors import UsageError
from tendond.schemas.config.migration.migrate import Migration, MigrationError, migrate
from tendond.schemas.config.migration.version import CONFIG_VERSION
from tendond.schemas.config.rig import ConfigError


def run_migrate(file: Path, *, write: bool) -> None:
    """Print the changes that a file needs, or make them; see `tendond config migrate --help`.

    Raises:
        ConfigError: it cannot be read, or not be rewritten. UsageError: it cannot be written.
    """
    text = read_text(file)
    try:
        found = migrate(text, str(file))
    except MigrationError as error:
        raise ConfigError(str(error)) from error
    if found.new == found.old:
        print(f"{file}: version {CONFIG_VERSION}, nothing to change")
        return
    if not write:
        before, after = found.old.splitlines(keepends=True), found.new.splitlines(keepends=True)
        print("".join(_whole(line) for line in difflib.unified_diff(before, after, str(file), str(file))), end="")
        say(f"{file}: not changed: write this with 'tendond config migrate {file} --write'")
        return
    try:
        kept = _write(file, found)
    except OSError as error:
        raise UsageError(f"{error.filename or file}: {error.strerror}: run it as the owner of the file") from error
    for change in found.changes:
        print(f"{file}: {change}")
    print(f"{file}: version {CONFIG_VERSION}; the file before: {kept}")


def _whole(line: str) -> str:
    """Return a line of a difference with its end, which the last one of a file may lack."""
    return line if line.endswith("\n") else f"{line}\n"


def _write(file: Path, found: Migration) -> Path:
    """Replace the file, with its mode and owner, and keep the old one beside it; return the old one's path."""
    file = file.resolve()  # a link stays one
    kept = file.with_name(f"{file.name}.v{found.before}")
    draft = file.with_name(f"{file.name}.part")
    if not kept.exists():  # the oldest one is the one to go back to
        _copy(file, kept)
    _copy(file, draft)
    draft.write_text(found.new, encoding="utf-8", newline="")
    os.replace(draft, file)
    return kept


def _copy(file: Path, copy: Path) -> None:
    """Copy a file with its mode and owner."""
    shutil.copy2(file, copy)
    status = file.stat()
    if (status.st_uid, status.st_gid) != (copy.stat().st_uid, copy.stat().st_gid):
        os.chown(copy, status.st_uid, status.st_gid)
