"""`tendond config has`: a separate module without the model, since units run it at each start."""

from pathlib import Path

from tendond.cli.common import say
from tendond.cli.include import sections
from tendond.schemas.config.rig import ConfigError

NEWER = {"vicon": ("mocap",)}
"""Newer names of a section, by the one that units ask for."""


def run_has(section: str, file: Path, *, or_unreadable: bool) -> None:
    """Test whether a configuration has a section; see `tendond config has --help`.

    Raises:
        ConfigError: the file cannot be read, and `or_unreadable` is not set.
        SystemExit: with 1, it does not.
    """
    try:
        found = not {section, *NEWER.get(section, ())}.isdisjoint(sections(file))
    except ConfigError as error:
        if not or_unreadable:
            raise
        say(str(error))
        return
    print(f"{file}: {'has' if found else 'has no'} [{section}]")
    if not found:
        raise SystemExit(1)
