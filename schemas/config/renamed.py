"""Keys of a configuration that have a new name and unit: the old ones are still read, with a warning each."""

import warnings
from collections.abc import Mapping
from typing import Any

DEFAULT_PERIOD = 0.01
"""[s] of the loop, where a configuration names none: what a count of cycles meant."""

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
"""Thresholds that were counted in cycles, by section and old name; the new name, in seconds."""


REMOVED = {
    ("observer", "delay_scale"): "the gains follow from the loop's margin at the configured delay",
}
"""Keys that mean nothing any more, by section and name, and why: they are left aside, with a warning each."""


class RenamedKeyWarning(UserWarning):
    """An old name of a key was used; the message names the new one."""


def with_new_names(data: dict[str, Any], source: str) -> tuple[dict[str, Any], list[tuple[tuple[str, str], str]]]:
    """Convert old keys to the new ones, warning of each.

    Args:
        data: nested tables of a configuration; they stay as they are.
        source: name of the file, for the warnings.

    Returns:
        The tables with new keys only, and (path, objection) of each old key that cannot be converted.
    """
    objections: list[tuple[tuple[str, str], str]] = []
    new = dict(data)
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
            seconds = round(cycles * _period(data), 9)
            rest[name] = seconds
            warnings.warn(
                f"{source}: {section}.{old} = {cycles} (cycles) is read as {section}.{name} = {seconds:g} [s]: "
                "use that key",
                RenamedKeyWarning,
                stacklevel=4,
            )
    for (section, old), why in REMOVED.items():
        table = new.get(section)
        if isinstance(table, Mapping) and old in table:
            new[section] = {key: value for key, value in table.items() if key != old}
            warnings.warn(
                f"{source}: {section}.{old} is no longer used ({why}): remove it", RenamedKeyWarning, stacklevel=4
            )
    return new, objections


def _period(data: Mapping[str, Any]) -> float:
    loop = data.get("loop")
    period = loop.get("period") if isinstance(loop, Mapping) else None
    return float(period) if isinstance(period, int | float) and not isinstance(period, bool) else DEFAULT_PERIOD
