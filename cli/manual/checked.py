"""`python -m tendond.cli.manual.checked LOG... -- FROM TO ...`: copy pictures to the documents, if their runs are good.

A picture in the documents shows a run in which no pose was lost, nothing failed and the tip settled. Otherwise this
fails, with a line for each thing that is wrong, and copies nothing.
"""

import json
import shutil
import sys
from pathlib import Path

from tendond.offline.logs.log import LogFile, load
from tendond.offline.logs.metrics import metrics, runs
from tendond.schemas.messages import Mode


def faults_of(log: LogFile) -> list[str]:
    """List what makes a run no good for a picture; nothing of a good one."""
    found = [log.cut] if log.cut else []
    tracked = [record for record in log.records if record.mode is Mode.TRACKING]
    if not tracked:
        return [*found, f"{log.name}: nothing tracks"]
    lost = sum(record.inputs.pose is None or bool(record.rejected) for record in tracked)
    if lost:
        found.append(f"{log.name}: {lost} of {len(tracked)} cycles of tracking have no pose")
    failed = sorted({record.reason for record in log.records if record.mode is Mode.FAULT})
    found += [f"{log.name}: fault: {reason}" for reason in failed]
    missed = sum(record.inputs.missed_ticks for record in tracked)
    if missed:
        found.append(f"{log.name}: {missed} deadlines missed while tracking")
    for number, run in enumerate(runs(log), 1):
        if not run.has_metrics or metrics(run).settling_iterations is None:
            found.append(f"{log.name}: run {number} did not settle")
    return found


def of_results(path: Path) -> list[str]:
    """List the runs in the paper's results under normal conditions that did not settle."""
    table = json.loads(path.read_text(encoding="utf-8"))["table_simulation_normal"]
    return [f"{path}: {law} did not settle" for law, row in table.items() if row["settling_iterations_5pct"] is None]


def main(arguments: list[str]) -> int:
    """Check logs, and results of `tendond study paper`, before `--`; copy each file to the next; return the status."""
    split = arguments.index("--")
    files = [Path(name) for name in arguments[:split]]
    wrong = [line for one in files for line in (of_results(one) if one.suffix == ".json" else faults_of(load(one)))]
    for line in wrong:
        print(f"not a run to show: {line}", file=sys.stderr)
    if wrong:
        return 1
    pairs = arguments[split + 1 :]
    for source, target in zip(pairs[::2], pairs[1::2], strict=True):
        Path(target).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)
        print(target)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
