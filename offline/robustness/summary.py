"""Summary of a campaign: how many points meet the goal, and the worst of each measure."""

from collections.abc import Iterable
from typing import Any

import numpy as np

from tendond.offline.robustness.alarms import FALSE, TRUE
from tendond.offline.robustness.evaluate import RIPPLE_GOAL_MM, SETTLING_GOAL, PointResult
from tendond.offline.robustness.points import Point
from tendond.offline.robustness.run import Rows

MEASURES = (
    "settling_iterations",
    "impact_settling_iterations",
    "ripple_mm",
    "overshoot_percent",
    "path_overshoot_percent",
    "tpl_mm",
    "rise_iterations",
    "steady_error_mm",
    "open_loop_error_mm",
    "peak_tension_n",
    "force_error_n",
)
"""Measures of which larger values are worse; of `min_tension_n`, smaller ones are."""

NEEDED = ("settling_iterations", "rise_iterations", "impact_settling_iterations")
"""None of these is worse than any number: it never settled."""

PARTS = ("settles", "smooth", "bounded", "recovers")

GOAL = (
    f"settles within {SETTLING_GOAL} iterations plus the cost of the rate limit, ripple below {RIPPLE_GOAL_MM} mm, "
    f"no tension below 0 nor above the limit, "
    f"settles again within {SETTLING_GOAL} iterations of an impact's end, no fault"
)

Groups = dict[tuple[str, str], Rows]


def groups(rows: Rows, *, misconfigured: bool = False) -> Groups:
    """Group by law and feedback: points with correctly configured delay and lag, or (`misconfigured`) the others."""
    found: Groups = {}
    for point, result in rows:
        if (point.configured != "exact") == misconfigured:
            found.setdefault((point.law, point.feedback), []).append((point, result))
    return found


def summary(rows: Rows, settings: dict[str, Any]) -> dict[str, Any]:
    """Summarise as in summary.json."""
    return {
        "settings": settings,
        "goal": GOAL,
        "points": len(rows),
        "known": [_group(key, part) for key, part in groups(rows).items()],
        "misinformed": [_group(key, part) for key, part in groups(rows, misconfigured=True).items()],
    }


def misses(result: PointResult) -> tuple[str, ...]:
    """List the parts of the goal that a point misses; only 'fault' where it ended in one."""
    if result.mode != "tracking":
        return ("fault",)
    return tuple(name for name in PARTS if not getattr(result, name))


def counts(rows: Rows) -> dict[str, int]:
    """Count all points, those that meet the goal, and those that miss each part of it."""
    found = {"points": len(rows), "meet": sum(result.meets for _, result in rows), "fault": 0}
    found |= dict.fromkeys(PARTS, 0)
    for _, result in rows:
        for name in misses(result):
            found[name] += 1
    return {("misses_" if name in PARTS else "") + name: value for name, value in found.items()}


def worst(rows: Rows, measure: str) -> tuple[Point, PointResult] | None:
    """Find the worst point in a measure; none where no point has it."""
    if measure == "impact_settling_iterations":
        rows = [(point, result) for point, result in rows if point.impact_n and result.mode]
    if measure in NEEDED:
        never = [row for row in rows if getattr(row[1], measure) is None]
        if never:
            return never[0]
    known = [row for row in rows if getattr(row[1], measure) is not None]
    sign = -1.0 if measure == "min_tension_n" else 1.0
    return max(known, key=lambda row: sign * float(getattr(row[1], measure)), default=None)


def removed(rows: Rows) -> dict[str, Any] | None:
    """Compare the tip's steady errors with and without feedback, of the points that track to the end [mm].

    Each a median, a 95th percentile and the worst, with the worst one's name; none where the open loop was not run.
    """
    both = [
        (str(point), result.open_loop_error_mm, result.steady_error_mm)
        for point, result in rows
        if None not in (result.open_loop_error_mm, result.steady_error_mm) and misses(result) != ("fault",)
    ]
    if not both:
        return None
    names, *errors = zip(*both, strict=True)
    found: dict[str, Any] = {"points": len(both)}
    for name, values in zip(("open_loop", "closed_loop"), errors, strict=True):
        median, high, largest = np.percentile(values, (50.0, 95.0, 100.0)).tolist()
        found[name] = {"median": median, "p95": high, "worst": largest, "at": names[int(np.argmax(values))]}
    return found


def _group(key: tuple[str, str], rows: Rows) -> dict[str, Any]:
    extremes: dict[str, Any] = {}
    for measure in (*MEASURES, "min_tension_n"):
        row = worst(rows, measure)
        if row is not None:
            extremes[measure] = {"value": getattr(row[1], measure), "at": str(row[0]), "part": row[0].part}
    return {
        "law": key[0],
        "feedback": key[1],
        "counts": counts(rows),
        "worst": extremes,
        "faults": _faults(rows),
        "alarms": alarms(rows),
        "feedback_removes": removed(rows),
    }


def alarms(rows: Iterable[tuple[Point, PointResult]]) -> dict[str, int]:
    """Faults by whether they were true alarms; see `alarms.judge_alarm`."""
    found = {TRUE: 0, FALSE: 0}
    for _, result in rows:
        if result.alarm:
            found[result.alarm] += 1
    return found


def _faults(rows: Iterable[tuple[Point, PointResult]]) -> dict[str, int]:
    found: dict[str, int] = {}
    for _, result in rows:
        if result.mode != "tracking":
            reason = result.reason.split(":")[0]
            found[reason] = found.get(reason, 0) + 1
    return found
