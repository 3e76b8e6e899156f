"""The runs that are compared: names that tell them apart, metrics with units, and what to know about them."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from tendond.model.rod.static_curve import static_curve
from tendond.model.rods.selection import model_rod
from tendond.offline.files import as_text
from tendond.offline.logs.injections import recoveries
from tendond.offline.logs.log import LogFile
from tendond.offline.logs.metrics import SETTLED, Tracking, metrics, runs, tracking
from tendond.offline.logs.summary import LABELS

Metric = tuple[str, str, str]
"""Key, name for people, unit."""

AXES = "xyz"

MEASURED = (
    *("tpl_mm", "settling_iterations", "overshoot_percent", "rise_iterations", "steady_state_error_mm", "settling_s"),
    *("path_mm", "path_overshoot_percent", "iae_mm_s", "ripple_mm", *(f"final_tip_{one}_m" for one in AXES)),
)
"""Metrics of the measured tip, which in a log computed from the inputs of another one are those of that one."""


@dataclass(frozen=True)
class Compared:
    """One run: what to call it, its samples, its metrics by name.

    Attributes:
        name: told apart from the others by folder and number. group: name of its repeats, see `repeats.as_groups`.
        run: its samples.
        metrics: by key; none where a run has no such number.
        recording: name of the log whose tip it has, if it was computed from the inputs of another one.
    """

    name: str
    group: str
    run: Tracking
    metrics: dict[str, Any]
    recording: str = ""

    def as_json(self) -> dict[str, Any]:
        """Return the metrics, with the name of the recording that the tip's are of."""
        return {**self.metrics, **({"tip_metrics_of": self.recording} if self.recording else {})}


def compared(logs: Sequence[LogFile]) -> list[Compared]:
    """Select all runs of each log.

    Raises:
        LogError: a log has none with metrics, see `tracking`.
    """
    found = []
    for name, log in zip(names([log.path for log in logs]), logs, strict=True):
        parts = [run for run in runs(log) if run.has_metrics] or [tracking(log)]
        rod = model_rod(log.config)
        curve = static_curve(rod, log.config.control.agonist, log.config.limits.tension_max, parts[0].axes)
        for number, run in enumerate(parts, 1):
            ours = metrics(run, curve)
            values = asdict(ours)
            x, y, z = values.pop("final_tip_m")
            values |= {"final_tip_x_m": x, "final_tip_y_m": y, "final_tip_z_m": z}
            for count, one in enumerate(recoveries(run, SETTLED, ours.settling_iterations), 1):
                values[f"recovery_{count}_s"] = one.recovery_s
                values[f"recovery_{count}_deviation_mm"] = one.deviation_mm
            title = name if len(parts) == 1 else f"{name} run {number}"
            found.append(Compared(title, _group(log), run, values, log.same_inputs_as))
    return found


def names(paths: Sequence[Path]) -> list[str]:
    """Return names that tell the logs apart: each file's, with as many folders before it as are needed."""
    absolute = [path.resolve() for path in paths]
    depth = 1
    while depth < max(len(path.parts) for path in absolute):
        shown = [Path(*path.with_suffix("").parts[-depth:]) for path in absolute]
        if len(set(shown)) == len(set(absolute)):
            break
        depth += 1
    plain = [as_text(str(one)) for one in shown] if absolute else []
    counts = [plain[: i + 1].count(name) for i, name in enumerate(plain)]  # of a log that is given twice
    return [name if count == 1 else f"{name} ({count})" for name, count in zip(plain, counts, strict=True)]


def metric(key: str) -> Metric:
    """Return name and unit of a metric for people."""
    if key in LABELS:
        return key, *LABELS[key]
    if key.startswith("final_tip_"):
        return key, f"tip at the end, {key[len('final_tip_')]}", "m"
    _, number, *rest = key.split("_")
    return (key, f"recovery {number}", "s") if rest == ["s"] else (key, f"largest deviation after {number}", "mm")


def notes(found: Sequence[Compared]) -> list[str]:
    """Say which tips are those of recordings."""
    return [
        f"{one.name}: computed from the inputs of {one.recording}: the metrics of its tip are those of that recording, "
        "only tensions and displacements are its own"
        for one in found
        if one.recording
    ]


def _group(log: LogFile) -> str:
    """Describe what repeats have in common: the configuration, but for the random numbers, and how it was computed."""
    config = log.config.model_dump(mode="json", exclude={"rig": True, "bus": True, "log": True})
    config["simulator"].pop("seed", None)
    return f"{config} {log.metadata.get('replay', '')} {log.metadata.get('replay_changes', '')}"
