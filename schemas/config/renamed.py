"""Configuration keys that were renamed or removed: old names are still read, with a warning each."""

import warnings
from collections.abc import Mapping
from typing import Any

DEFAULT_PERIOD = 0.01
"""Period of the loop where a configuration names none [s], to convert a count of cycles."""

BRANCHES = {"far": "above_135", "near": "below_135"}
"""Old names of the branches, which logs and operators may still have, with the present ones."""

RENAMED = {
    ("loop", "rehearse"): "speculate",
    ("pretension", "least"): "tension_min",
    ("faults", "equal_way"): "frozen_distance",
    ("faults", "slack_part"): "slack_fraction",
    ("commissioning", "tension_part"): "tension_fraction",
    ("servo", "answer_timeout"): "reply_timeout",
}
"""New name by section and old name; value and unit are the same."""

IN_SECONDS = {
    ("faults", "pose_stale"): "pose_timeout",
    ("faults", "rejected_burst"): "rejected_time",
    ("faults", "teleports"): "teleport_time",
    ("faults", "solver_failures"): "solver_timeout",
    ("faults", "missed_ticks"): "overrun_time",
    ("faults", "tendon_stale"): "tendon_timeout",
    ("faults", "equal_poses"): "frozen_time",
    ("faults", "mismatches"): "mismatch_time",
    ("faults", "slack_cycles"): "slack_time",
    ("limits", "sustained"): "limit_time",
}
"""New name [s] by section and old name, of thresholds that were counted in cycles."""

RENAMED_VALUES = {("reference", "branch"): BRANCHES}
"""New value by section, key and old value."""

REMOVED = {
    ("observer", "delay_scale"): "the gains follow from the loop's margin at the configured delay",
    ("observer", "quiet"): "the noise floor is 0.0018 of the rod's length",
    ("observer", "quiet_time"): "the innovation is averaged over 0.07 s",
    ("observer", "quiet_share"): "half of the gains is left below the noise floor",
}
"""Reason by section and name, of keys that no longer have a meaning: they are ignored, with a warning each."""


class RenamedKeyWarning(UserWarning):
    """A configuration has an old key; the message names the new one."""


def present_branch(value: Any) -> Any:
    """Return the present name of a branch."""
    return BRANCHES.get(value, value) if isinstance(value, str) else value


def with_new_names(data: dict[str, Any], source: str) -> tuple[dict[str, Any], list[tuple[tuple[str, str], str]]]:
    """Convert old keys to the new ones, with a warning each.

    Args:
        data: nested tables of a configuration; not modified.
        source: name of the file, for the warnings.

    Returns:
        The tables with new keys only, and (path, objection) of each old key that cannot be converted.
    """
    objections: list[tuple[tuple[str, str], str]] = []
    new = dict(data)
    for (section, old), name in RENAMED.items():
        table = new.get(section)
        if not isinstance(table, Mapping) or old not in table:
            continue
        new[section] = {name if key == old else key: value for key, value in table.items()}
        if name in table:
            new[section][name] = table[name]
            objections.append(((section, old), f"was renamed to {section}.{name}, which is given too: remove {old}"))
        else:
            _warn(f"{source}: {section}.{old} was renamed to {section}.{name}: use that key")
    for (section, old), name in IN_SECONDS.items():
        table = new.get(section)
        if not isinstance(table, Mapping) or old not in table:
            continue
        rest = {key: value for key, value in table.items() if key != old}
        new[section], cycles = rest, table[old]
        if name in table:
            objections.append(((section, old), f"is now {section}.{name} [s], which is given too: remove {old}"))
        elif isinstance(cycles, bool) or not isinstance(cycles, int) or cycles < 0:
            objections.append(((section, old), f"was a number of cycles; give {section}.{name} [s] instead"))
        else:
            seconds = round(cycles * period_of(data), 9)
            rest[name] = seconds
            _warn(
                f"{source}: {section}.{old} = {cycles} (cycles) is read as {section}.{name} = {seconds:g} [s]: "
                "use that key"
            )
    for (section, key), values in RENAMED_VALUES.items():
        table = new.get(section)
        given = table.get(key) if isinstance(table, Mapping) else None
        if isinstance(table, Mapping) and isinstance(given, str) and given in values:
            new[section] = {**table, key: values[given]}
            _warn(f"{source}: {section}.{key} = '{given}' was renamed to '{values[given]}': use that value")
    for (section, old), why in REMOVED.items():
        table = new.get(section)
        if isinstance(table, Mapping) and old in table:
            new[section] = {key: value for key, value in table.items() if key != old}
            _warn(f"{source}: {section}.{old} is no longer used ({why}): remove it")
    return new, objections


def _warn(text: str) -> None:
    warnings.warn(text, RenamedKeyWarning, stacklevel=5)


def period_of(data: Mapping[str, Any]) -> float:
    """Return the period of the loop in nested tables, or the default one [s]."""
    loop = data.get("loop")
    period = loop.get("period") if isinstance(loop, Mapping) else None
    return float(period) if isinstance(period, int | float) and not isinstance(period, bool) else DEFAULT_PERIOD
