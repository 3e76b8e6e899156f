"""Two rods beside each other: the keys in which a simulated robot is not the controller's model."""

import math
from collections.abc import Iterator, Mapping
from typing import Any

from tendond.schemas.config.robot import RodSection

SCHEME = frozenset({"preset", "space", "nodes", "alpha", "yield_strain"})
"""Keys that do not describe the robot's motion: a name, how it is computed, what it bears."""

SAME = 1e-6
"""Largest relative difference of numbers that count as equal."""

SHOWN = 4
"""Keys that are named; of more, their number."""


def figures(section: RodSection) -> dict[str, Any]:
    """Return the keys of [rod] that describe the robot, with JSON's types."""
    return {key: value for key, value in section.model_dump(mode="json").items() if key not in SCHEME}


def differences(plant: Mapping[str, Any], model: Mapping[str, Any]) -> list[str]:
    """Return the keys that differ, with both values: 'youngs_modulus = 1.7e+11, not 1.9e+11'.

    Args:
        plant: figures of the simulated robot. model: of the controller's.
    """
    ours, theirs = dict(_leaves("", model)), dict(_leaves("", plant))
    keys = dict.fromkeys((*ours, *theirs))
    return [
        f"{key} = {_short(theirs.get(key))}, not {_short(ours.get(key))}"
        for key in keys
        if not _same(theirs.get(key), ours.get(key))
    ]


def difference_remark(plant: Mapping[str, Any], model: Mapping[str, Any]) -> str:
    """Say in which keys the simulated robot is not the controller's model; empty if it is."""
    found = differences(plant, model)
    if not found:
        return ""
    more = f"; and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return f"the simulated rod is not the controller's: simulator.rod has {'; '.join(found[:SHOWN])}{more}"


def _leaves(path: str, value: Any) -> Iterator[tuple[str, Any]]:
    """Yield the values that are no tables, with dotted keys; a list of tables by index; none where there is nothing."""
    if isinstance(value, Mapping):
        for key, inner in value.items():
            yield from _leaves(f"{path}.{key}" if path else str(key), inner)
    elif isinstance(value, list) and value and all(isinstance(one, Mapping) for one in value):
        for index, inner in enumerate(value):
            yield from _leaves(f"{path}[{index}]", inner)
    elif value is not None and value != []:
        yield path, value


def _same(one: Any, other: Any) -> bool:
    if isinstance(one, list) and isinstance(other, list):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, int | float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=SAME, abs_tol=1e-12)
    return bool(one == other)


def _short(value: Any) -> str:
    if value is None:
        return "none"
    if isinstance(value, list):
        return f"[{', '.join(map(_short, value))}]"
    return f"{value:.6g}" if isinstance(value, float) else str(value)
