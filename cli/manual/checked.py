"""`python -m tendond.cli.manual.checked LOG... -- FROM TO ...`: copy pictures to the documents, if their runs are good.

A picture in the documents shows a run in which no pose was lost, nothing failed and the tip settled. Otherwise this
fails, with a line for each thing that is wrong, and copies nothing.
"""

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


def main(arguments: list[str]) -> int:
    """Check the logs before `--`, then copy each file to the one behind it; return the exit status."""
    split = arguments.index("--")
    wrong = [line for name in arguments[:split] for line in faults_of(load(Path(name)))]
    for line in wrong:
        print(f"not a run to show: {line}", file=sys.stderr)
    if wrong:
        return 1
    files = arguments[split + 1 :]
    for source, target in zip(files[::2], files[1::2], strict=True):
        Path(target).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, target)
        print(target)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
