"""A run in a dozen numbers, beside the paper's."""

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from tendond.offline.files import write_whole
from tendond.offline.logs.injections import recoveries
from tendond.offline.logs.log import LogFile
from tendond.offline.logs.metrics import SETTLED, metrics, tracking
from tendond.offline.logs.published import Published

LABELS = {
    "settling_s": ("settled within 5 %", "s"),
    "settling_iterations": ("settled within 5 %", "iterations"),
    "rise_iterations": ("risen to 90 %", "iterations"),
    "overshoot_percent": ("overshoot", "%"),
    "path_overshoot_percent": ("overshoot along the curve of resting tips", "%"),
    "steady_state_error_mm": ("steady-state error", "mm"),
    "ripple_mm": ("ripple at the end", "mm"),
    "iae_mm_s": ("integral of the absolute error", "mm s"),
    "tpl_mm": ("total path length", "mm"),
    "path_mm": ("distance travelled by the tip", "mm"),
    "tendon_rate_mm_s": ("tendons' rate, root mean square", "mm/s"),
    "peak_tension_n": ("largest tension", "N"),
    "min_tension_n": ("smallest tension", "N"),
    "final_tip_m": ("tip at the end", "m"),
    "final_displacement_m": ("agonist's displacement at the end", "m"),
    "cycles": ("cycles", ""),
    "missed_ticks": ("missed deadlines", ""),
    "cycle_ms_median": ("wake-up to command, median", "ms"),
    "cycle_ms_p99": ("wake-up to command, 99th percentile", "ms"),
}
"""Name and unit for people of each number in a summary; defined in docs/metrics.md."""


def summary(log: LogFile) -> dict[str, Any]:
    """Metrics of the first run, its recovery from each injection, and how the loop did over the whole log.

    `cycle_ms_*` are from wake-up to command [ms], None without timings (a run in lockstep has none).

    Raises:
        LogError: see `tracking`.
    """
    run = tracking(log)
    work_ms = np.array([timing.work_us for timing in log.timings]) / 1000.0
    ours = metrics(run)
    return {
        **asdict(ours),
        "final_tip_m": list(ours.final_tip_m),
        "recoveries": [asdict(one) for one in recoveries(run, SETTLED, ours.settling_iterations)],
        "cycles": len(log.records),
        "missed_ticks": sum(timing.missed_ticks for timing in log.timings),
        "cycle_ms_median": float(np.median(work_ms)) if work_ms.size else None,
        "cycle_ms_p99": float(np.percentile(work_ms, 99)) if work_ms.size else None,
    }


def recovered(summary: dict[str, Any]) -> list[tuple[str, float | None]]:
    """Return a label and the time of recovery [s] for each injection of a summary; none where there was no recovery."""
    return [
        (f"recovery {number}, {one['what']} at {one['time_s']:.2f} s", one["recovery_s"])
        for number, one in enumerate(summary["recoveries"], 1)
    ]


def write_summary(log: LogFile, path: Path) -> dict[str, Any]:
    """`summary` as JSON at `path`, whose folder is made; returned as well."""
    values = summary(log)
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, json.dumps(values, indent=2) + "\n")
    return values


def table(summary: dict[str, Any], law: str, paper: Published | None = None) -> Table:
    """Tabulate the metrics of a run, with a paper's beside them where it has some."""
    rows = [
        ("total path length of x", "mm", summary["tpl_mm"], ".1f", "tpl_mm"),
        ("settling (5 %)", "iterations", summary["settling_iterations"], "d", "settling_iterations"),
        ("overshoot", "%", summary["overshoot_percent"], ".1f", "overshoot_percent"),
        ("rise (0-90 %)", "iterations", summary["rise_iterations"], "d", "rise_iterations"),
        ("steady-state error", "mm", summary["steady_state_error_mm"], ".2f", "steady_state_error_mm"),
        ("final displacement", "mm", 1000.0 * summary["final_displacement_m"], ".1f", "final_displacement_mm"),
    ]
    result = Table(title=law.replace("_", " "), caption=paper.source if paper else None)
    result.add_column("")
    result.add_column("unit", style="dim")
    result.add_column("tendond", justify="right")
    if paper:
        result.add_column("paper", justify="right")
    for name, unit, value, form, key in rows:
        theirs = [_cell(getattr(paper, key), form)] if paper else []
        result.add_row(name, unit, _cell(value, form, missing="never"), *theirs)
    for label, seconds in recovered(summary):
        result.add_row(label, "s", _cell(seconds, ".2f", "never"), *([""] if paper else []))
    result.add_section()
    for name, unit, value, form in (
        ("missed deadlines", f"of {summary['cycles']}", summary["missed_ticks"], "d"),
        ("wake-up to command, median", "ms", summary["cycle_ms_median"], ".2f"),
        ("wake-up to command, p99", "ms", summary["cycle_ms_p99"], ".2f"),
    ):
        result.add_row(name, unit, _cell(value, form), *([""] if paper else []))
    return result


def _cell(value: float | None, form: str, missing: str = "-") -> str:
    return missing if value is None else format(value, form)
