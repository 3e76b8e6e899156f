"""The paper's tables with ours beside them: Markdown, CSV, and results.json in the form in which the paper's exist."""

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tendond.offline.files import whole, write_whole
from tendond.offline.logs.metrics import Metrics
from tendond.offline.logs.published import Published
from tendond.offline.paper.published import EXPERIMENT, LAWS, SIMULATION
from tendond.offline.paper.run import PaperRun, Runs

Number = float | int | None


@dataclass(frozen=True)
class Criterion:
    """A line of the paper's tables.

    Attributes:
        field: field of `Metrics` and `Published`.
        key: key in results.json.
        label: label as in the paper.
        unit: its unit.
        digits: decimals to print.
    """

    field: str
    key: str
    label: str
    unit: str
    digits: int

    def text(self, value: Number, *, sign: bool = False) -> str:
        """Format a value or a difference."""
        return "never" if value is None else format(value, f"{'+' if sign else ''}.{self.digits}f")


CRITERIA = (
    Criterion("tpl_mm", "tpl_mm", "TPL", "mm", 1),
    Criterion("settling_iterations", "settling_iterations_5pct", "settling (5 %)", "iterations", 0),
    Criterion("overshoot_percent", "overshoot_pct", "overshoot", "%", 1),
    Criterion("rise_iterations", "rise_iterations_0_90", "rise (0-90 %)", "iterations", 0),
    Criterion("steady_state_error_mm", "steady_state_error_mm", "steady-state error", "mm", 2),
)


@dataclass(frozen=True)
class PaperBound:
    """Bound of a run: `field` of its metrics lies between `low` and `high`, bounds included."""

    scenario: str
    law: str
    criterion: Criterion
    low: float
    high: float

    def value(self, runs: Runs) -> Number:
        """Return the run's value."""
        return _value(runs[self.scenario, self.law].metrics, self.criterion)

    def met(self, runs: Runs) -> bool:
        """Check that the run's value is within the bounds."""
        value = self.value(runs)
        return value is not None and self.low <= value <= self.high


def bounds() -> list[PaperBound]:
    """Return the bounds around the paper's simulation: backstepping as it is, and the contrast at the edge."""
    same: dict[str, tuple[float, float]] = {
        "tpl_mm": (0.9, 0.0),
        "settling_iterations": (1.0, 2.0),
        "overshoot_percent": (1.0, 2.0),
        "rise_iterations": (1.0, 2.0),
        "steady_state_error_mm": (1.0, 0.05),
    }
    row = SIMULATION["backstepping"]
    held = []
    for criterion in CRITERIA:
        paper, (share, width) = getattr(row, criterion.field), same[criterion.field]
        low, high = paper * share - width, paper * (2.0 - share) + width
        held.append(PaperBound("normal", "backstepping", criterion, low, high))
    held += [
        PaperBound("normal_edge", "backstepping", one, 0.75 * paper, 1.25 * paper)
        for one in CRITERIA[:4]
        for paper in (getattr(row, one.field),)
    ]
    row = SIMULATION["sliding_mode"]
    tpl, settling = CRITERIA[:2]
    held.append(PaperBound("normal_edge", "sliding_mode", tpl, max(1000.0, 0.85 * row.tpl_mm), 1.15 * row.tpl_mm))
    settled = row.settling_iterations
    held.append(PaperBound("normal_edge", "sliding_mode", settling, settled - 6, settled + 6))
    return held


def comparison(paper: Mapping[str, Published], runs: Mapping[str, PaperRun]) -> list[list[str]]:
    """Return the lines of a table: criterion, then the paper's value, ours and the difference for each law."""
    lines = []
    for one in CRITERIA:
        line = [f"{one.label} [{one.unit}]"]
        for law in LAWS:
            theirs, ours = getattr(paper[law], one.field), _value(runs[law].metrics, one)
            line += [one.text(theirs), one.text(ours), _difference(one, theirs, ours)]
        lines.append(line)
    return lines


COMPARISON_HEAD = [
    "",
    *(f"{law.replace('_', ' ')}: {what}" for law in LAWS for what in ("paper", "ours", "difference")),
]


def compared(paper: Mapping[str, Published], runs: Runs, scenario: str) -> str:
    """Write the Markdown table of a scenario beside a table of the paper."""
    return markdown(COMPARISON_HEAD, comparison(paper, {law: runs[scenario, law] for law in LAWS}))


def overview(runs: Runs, scenarios: Sequence[str], paper: Mapping[str, Published] | None = None) -> str:
    """Write a Markdown table with a line per scenario and law; the paper's two lines first where it has any."""
    head = [
        "",
        "law",
        *(f"{one.label} [{one.unit}]" for one in CRITERIA),
        "end: x, z [mm]",
        "tendon [mm]",
        "ripple [mm]",
    ]
    lines = []
    for law in LAWS if paper else ():
        assert paper is not None
        row = paper[law]
        lines.append(["**paper**", _name(law), *(one.text(getattr(row, one.field)) for one in CRITERIA), "", "", ""])
    for scenario in scenarios:
        for law in LAWS:
            run = runs[scenario, law]
            found = run.metrics
            x, _, z = found.final_tip_m
            lines.append(
                [
                    run.scenario.title,
                    _name(law),
                    *(one.text(_value(found, one)) for one in CRITERIA),
                    f"{1e3 * x:.1f}, {1e3 * z:.1f}",
                    f"{1e3 * found.final_displacement_m:.1f}",
                    f"{found.ripple_mm:.2f}" if not run.ending else run.ending.split(":")[0],
                ]
            )
    return markdown(head, lines)


def markdown(head: Sequence[str], lines: Sequence[Sequence[str]], *, numbers: bool = True) -> str:
    """Write a table, without a final line end; all columns but the first are `numbers`, or words."""
    ruler = ["---", *["---:" if numbers else "---"] * (len(head) - 1)]
    return "\n".join("| " + " | ".join(line) + " |" for line in (head, ruler, *lines))


def results(runs: Runs, scenario: str, experiment: str) -> dict[str, Any]:
    """Return our results in the form of the paper's: these keys and no others."""
    backstepping = runs[scenario, "backstepping"]
    run, rig = backstepping.scenario.title, runs[experiment, "backstepping"].scenario.title
    return {
        "source": f"tendond, 'tendond study paper': simulation '{run}', experiment '{rig}'",
        "table_simulation_normal": {law: _as_json(runs[scenario, law].metrics) for law in LAWS},
        "table_experiment_normal": {law: _as_json(runs[experiment, law].metrics) for law in LAWS},
        "final_tendon_displacement_mm": 1e3 * backstepping.metrics.final_displacement_m,
        "final_tip_x_mm": 1e3 * backstepping.metrics.final_tip_m[0],
        "initial_tip_z_mm": 1e3 * float(backstepping.tip[0, 2]),
    }


def write_tables(runs: Runs, folder: Path, simulation: str, edge: str, experiment: str) -> None:
    """Write the CSV and JSON files of the page."""
    for name, paper, scenarios in (
        ("simulation", SIMULATION, (simulation, edge)),
        ("experiment", EXPERIMENT, (experiment, f"{experiment}_direct")),
    ):
        rows = [
            [runs[scenario, law].scenario.title, law, one.field, one.unit, theirs, ours, _minus(ours, theirs)]
            for scenario in scenarios
            for law in LAWS
            for one in CRITERIA
            for theirs, ours in ((getattr(paper[law], one.field), _value(runs[scenario, law].metrics, one)),)
        ]
        _write_csv(
            folder / f"{name}.csv", ["condition", "law", "criterion", "unit", "paper", "ours", "difference"], rows
        )
    fields = [name for name in asdict(next(iter(runs.values())).metrics) if name != "final_tip_m"]
    rows = [
        [name, run.scenario.title, law, *(getattr(run.metrics, field) for field in fields), *run.metrics.final_tip_m]
        for (name, law), run in runs.items()
    ]
    head = ["scenario", "title", "law", *fields, "final_x_m", "final_y_m", "final_z_m"]
    _write_csv(folder / "scenarios.csv", head, rows)
    for name, scenario in (("results", simulation), ("results_edge", edge)):
        text = json.dumps(results(runs, scenario, experiment), indent=2)
        write_whole(folder / f"{name}.json", text + "\n")


def _write_csv(path: Path, head: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    with whole(path) as draft, draft.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(head)
        writer.writerows(rows)


def _as_json(found: Metrics) -> dict[str, Number]:
    return {one.key: _value(found, one) for one in CRITERIA}


def _value(found: Metrics, criterion: Criterion) -> Number:
    value: Number = getattr(found, criterion.field)
    return value


def _minus(ours: Number, theirs: float) -> Number:
    return None if ours is None else ours - theirs


def _difference(criterion: Criterion, theirs: float, ours: Number) -> str:
    if ours is None:
        return "-"
    text = criterion.text(ours - theirs, sign=True)
    return f"{text} ({100.0 * (ours / theirs - 1.0):+.1f} %)" if criterion.field == "tpl_mm" else text


def _name(law: str) -> str:
    return law.replace("_", " ")
