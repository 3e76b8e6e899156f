"""What the shell completes: names, keys with their values, configurations and logs. Imports no kernel and no array.

Each function returns all candidates; typer keeps those that begin with the word so far. Without one the shell
completes names of files by itself.
"""

from collections.abc import MutableMapping
from importlib.metadata import entry_points
from pathlib import Path
from typing import Any

import typer

LAW_GROUP = "tendond.laws"
BUILT_IN_LAWS = ("backstepping", "sliding_mode", "sensitivity", "mpc")
LAW_GAINS = (
    *("backstepping.alpha1=1500.0", "backstepping.alpha2=12.5", "sliding_mode.c=2100.0", "sliding_mode.k=12.0"),
    *("sensitivity.rate=30.0", "sensitivity.smoothing=100.0", "sensitivity.agility=350.0", "mpc.rate=10.0"),
)
SCENARIOS = ("plane", "wired", "spatial")
PLANTS = ("shooting", "general", "mujoco")
"""Names that are defined beside code that imports the kernels; a test compares."""

Hints = list[tuple[str, str]]
"""Candidates with their help, which zsh and fish show."""

CHOICE = "one of "
LOG_FOLDER = "log"
"""Where `tendond run` writes its logs by default."""


def profiles() -> list[str]:
    """Return the names of the built-in configurations."""
    from tendond.schemas.config.presets import PROFILES

    return list(PROFILES)


def presets() -> list[str]:
    """Return the names of the robots for `rod.preset`."""
    from tendond.schemas.config.rod.presets import PRESETS

    return list(PRESETS)


def laws() -> list[str]:
    """Return the names of the control laws, those of installed packages included; none is imported."""
    return [*BUILT_IN_LAWS, *(entry.name for entry in entry_points(group=LAW_GROUP))]


def distributions() -> list[str]:
    """Return the distributions of ROS 2 that are supported."""
    from tendond.drivers.ros2.distributions import DISTRIBUTIONS

    return list(DISTRIBUTIONS)


def faults() -> list[str]:
    """Return the names of the simulator's faults."""
    from tendond.schemas.faults import Fault

    return list(Fault)


def scenarios() -> list[str]:
    """Return the names of the demo's scenarios."""
    return list(SCENARIOS)


def plants() -> list[str]:
    """Return the names of the simulated plants."""
    return list(PLANTS)


def sections() -> Hints:
    """Return the sections of a configuration."""
    return [(name, table.meaning) for name, table in _tables().items() if "." not in name]


def point_sets() -> list[str]:
    """Return the sets of plants of the robustness study."""
    from tendond.offline.robustness.points import POINT_SETS

    return [*POINT_SETS, "space"]


def feedbacks() -> list[str]:
    """Return the kinds of feedback."""
    from tendond.offline.robustness.points import FEEDBACKS

    return list(FEEDBACKS)


def datasets() -> list[str]:
    """Return the names of the public data sets."""
    from tendond.offline.validation.datasets.catalogue import names

    return names()


def configurations(incomplete: str) -> Hints:
    """Return the TOML files beside the word so far that name a rig, with its name."""
    return [(name, f"rig '{rig}'") for name in _files(incomplete, ".toml") if (rig := _rig_of(Path(name)))]


def logs(incomplete: str) -> list[str]:
    """Return the logs beside the word so far, and those in the folder of `tendond run`."""
    elsewhere = "" if "/" in incomplete else f"{LOG_FOLDER}/"
    return [*_files(incomplete, ".mcap"), *(_files(elsewhere, ".mcap") if elsewhere else ())]


def reference_settings(context: typer.Context, incomplete: str) -> list[str]:
    """Return keys of [reference] as KEY=VALUE, with their choices or defaults; behind `KEY =` the key's values."""
    given = list(context.params.get("settings") or ())
    keys = {key.name: key for key in _tables()["reference"].keys}
    if given[-1:] == ["="] and len(given) > 1:
        return _choices(keys.get(given[-2]))
    return [one for key in keys.values() for one in _settings(key.name, key)]


def configuration_settings() -> list[str]:
    """Return keys of a configuration as TABLE.KEY=VALUE, with their choices or defaults."""
    names = {key.path: key for table in _tables().values() for key in table.keys if "[]" not in key.path}
    found = [one for path, key in names.items() for one in _settings(path, key)]
    return [*(one for one in found if not one.startswith("control.law=")), *(f"control.law={law}" for law in laws())]


def tunable_settings() -> list[str]:
    """Return the tunable keys as KEY=VALUE with the defaults; of the laws the built-in ones."""
    from tendond.schemas.config.rig import RigConfig
    from tendond.schemas.config.tunable import MARK
    from tendond.schemas.errors.keywords import resolved, schema_of

    root = schema_of(RigConfig)
    sections = {name: resolved(root, node).get("properties", {}) for name, node in root["properties"].items()}
    found = [
        f"{section}.{name}={node.get('default', '')}"
        for section, keys in sections.items()
        for name, node in keys.items()
        if MARK in node
    ]
    return [*found, *(f"control.laws.{key}" for key in LAW_GAINS)]


def begin_a_word_behind_equals(environment: MutableMapping[str, str]) -> None:
    """Undo that bash ends a word at '=': behind the sign begins another, which is still empty.

    Args:
        environment: of the process, with what bash asks in it.
    """
    # typer's function for bash gives a word a line
    if environment.get("_TENDOND_COMPLETE") == "complete_bash" and environment.get("COMP_WORDS", "").endswith("\n="):
        environment["COMP_CWORD"] = str(int(environment["COMP_CWORD"]) + 1)


def _tables() -> dict[str, Any]:
    from tendond.schemas.config.rig import RigConfig
    from tendond.schemas.errors.keywords import tables

    return {table.name: table for table in tables(RigConfig)}


def _choices(key: Any) -> list[str]:
    """Return the values of a key that has a few."""
    if key is None or not key.words.startswith(CHOICE):
        return ["true", "false"] if key is not None and key.words == "true or false" else []
    return [word.strip('" ') for word in key.words.removeprefix(CHOICE).split(",")]


def _settings(name: str, key: Any) -> list[str]:
    """Return a key with each of its values; or with its default, to be changed; or alone."""
    if values := _choices(key):
        return [f"{name}={value}" for value in values]
    is_plain = isinstance(key.default, int | float) and not isinstance(key.default, bool)
    return [f"{name}={key.default if is_plain else ''}"]


def _files(incomplete: str, suffix: str) -> list[str]:
    """Return the files of a kind in the folder that the word so far names, as they would be typed."""
    folder = incomplete.rpartition("/")[0] + "/" if "/" in incomplete else ""
    try:
        names = sorted(one.name for one in Path(folder or ".").iterdir() if one.suffix == suffix and one.is_file())
    except OSError:
        return []
    return [f"{folder}{name}" for name in names]


def _rig_of(path: Path) -> str:
    """Return the name of a configuration's rig, without checking anything else; empty for another TOML file."""
    import tomllib

    try:
        tables = tomllib.loads(path.read_text(encoding="utf-8-sig"))
    except (OSError, ValueError):
        return ""
    known = set(_tables()) | {"include"}
    if not tables or not known & set(tables):
        return ""
    rig = tables.get("rig")
    return str(rig.get("name", "paper")) if isinstance(rig, dict) else "paper"
