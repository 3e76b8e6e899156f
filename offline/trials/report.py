"""Report of the paths in space: table, summary and page."""

import csv
import json
from pathlib import Path
from typing import Any

from tendond.offline.files import whole, write_whole
from tendond.offline.trials.measure import TrialOutcome
from tendond.offline.trials.paths import MATCHED_RMS_MM, UNLIKE_RMS_MM, Trial

COLUMNS = ("rms_mm", "worst_mm", "largest_change_n", "min_tension_n", "peak_tension_n", "limited", "mode", "reason")


def write(some: list[Trial], outcomes: list[TrialOutcome], planar: dict[str, Any], out: Path) -> None:
    """Write results.csv, summary.json and report.md.

    Args:
        some: trials.
        outcomes: the outcome of each.
        planar: metrics of the paper's task in the plane, by law.
        out: folder.

    Raises:
        OSError: a file cannot be written.
    """
    with whole(out / "results.csv") as draft, draft.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(("trajectory", "plant", *COLUMNS, "notes", "meets"))
        for trial, outcome in zip(some, outcomes, strict=True):
            cells = (getattr(outcome, name) for name in COLUMNS)
            writer.writerow((trial.name, trial.plant, *cells, "; ".join(outcome.notes), str(outcome.meets).lower()))
    trajectories = [
        {"trajectory": trial.name, "plant": trial.plant, "goal_mm": trial.goal_mm, "meets": outcome.meets}
        | {name: getattr(outcome, name) for name in COLUMNS}
        for trial, outcome in zip(some, outcomes, strict=True)
    ]
    values = {"trajectories": trajectories, "planar": planar}
    write_whole(out / "summary.json", json.dumps(values, indent=2) + "\n")
    write_whole(out / "report.md", _report(some, outcomes, planar))


def _report(some: list[Trial], outcomes: list[TrialOutcome], planar: dict[str, Any]) -> str:
    lines = [
        "# Trajectories in space, with the law 'sensitivity'",
        "",
        f"Goal: RMS of tip to reference below {MATCHED_RMS_MM:g} mm where the plant is the model, below "
        f"{UNLIKE_RMS_MM:g} mm where it is not. The tip is the simulated one, from the trajectory's beginning on.",
        "",
        "| trajectory | plant | RMS mm | worst mm | change of tension N/cycle | tensions N | meets |",
        "| --- | --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| [{trial.name}]({trial.file}.png) | {trial.plant} | {one.rms_mm:.2f} | {one.worst_mm:.2f} | "
        f"{one.largest_change_n:.2f} | {one.min_tension_n:.1f} to {one.peak_tension_n:.1f} | "
        f"{'yes' if one.meets else 'no: ' + (one.reason if one.mode != 'tracking' else 'RMS')} |"
        for trial, one in zip(some, outcomes, strict=True)
    ]
    lines += [
        "",
        "The paper's task in the plane, on the model itself:",
        "",
        "| law | settling | TPL mm | distance travelled mm | steady error mm | rate of the tensions N/s |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    lines += [
        f"| {law.replace('_', ' ')} | {values['settling_iterations']} | {values['tpl_mm']:.1f} | "
        f"{values['path_mm']:.1f} | {values['steady_error_mm']:.3f} | {values['tension_rate_n_s']:.0f} |"
        for law, values in planar.items()
    ]
    return "\n".join(lines) + "\n"
