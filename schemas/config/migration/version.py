"""Version of a configuration file: which names its keys have. A file without one is read under all names."""

from typing import Any

KEY = "version"
"""Key of the version, before the first table."""

CONFIG_VERSION = 2
"""Version of the present names. Version 1: counts of cycles and the names in `schemas/config/renamed.py`.

Raised by a change that older versions of tendond would misread or refuse; `migrate.py` then converts from the one
before.
"""


def version_objection(data: dict[str, Any]) -> str:
    """Return why a file's version cannot be read, in one line without the file's name; empty if it can, or has none."""
    if KEY not in data:
        return ""
    version = data[KEY]
    if isinstance(version, bool) or not isinstance(version, int) or version < 1:
        return f"{KEY} = {version!r}: must be a whole number from 1 to {CONFIG_VERSION}"
    if version > CONFIG_VERSION:
        return (
            f"{KEY} = {version}: this tendond reads versions up to {CONFIG_VERSION}: upgrade tendond, "
            f"or use the file from before the migration (FILE.v{CONFIG_VERSION})"
        )
    return ""


def without_version(data: dict[str, Any]) -> dict[str, Any]:
    """Return the tables of a file without its version, which is not a setting."""
    return {key: value for key, value in data.items() if key != KEY}
