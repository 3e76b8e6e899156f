"""Repeated runs: mean and confidence interval of each metric."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.stats import t as student

from tendond.offline.comparison.runs import Compared

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Mean:
    """Mean of a metric over repeats.

    Attributes:
        value: the mean. half_width: half of the confidence interval, of Student's t; none of a single value.
        count: runs that have the metric. runs: all runs.
    """

    value: float
    half_width: float | None
    count: int
    runs: int


@dataclass(frozen=True)
class Group:
    """Runs with the same configuration, seeds apart, and their metrics."""

    name: str
    metrics: dict[str, Any]
    members: list[str] = field(default_factory=list)


def mean_of(values: Sequence[float | None]) -> Mean | None:
    """Return mean and confidence interval of the values that there are; none where there is none."""
    given = np.array([value for value in values if value is not None], dtype=float)
    count = len(given)
    if count == 0:
        return None
    half = None
    if count > 1:
        half = float(student.ppf(0.5 + 0.5 * CONFIDENCE, count - 1) * given.std(ddof=1) / np.sqrt(count))
    return Mean(float(given.mean()), half, count, len(values))


def as_groups(found: Sequence[Compared]) -> list[Group]:
    """Gather the runs that repeat each other, in the order of their first ones."""
    groups: dict[str, list[Compared]] = {}
    for one in found:
        groups.setdefault(one.group, []).append(one)
    result = []
    for members in groups.values():
        keys = list(dict.fromkeys(key for one in members for key in one.metrics))
        values = {key: mean_of([one.metrics.get(key) for one in members]) for key in keys}
        more = f" and {len(members) - 1} more" if len(members) > 1 else ""
        result.append(Group(f"{members[0].name}{more}", values, [one.name for one in members]))
    return result
