"""Make the golden logs anew where they no longer replay, and say what changed: `make golden`."""

import json
import sys
import tempfile
from pathlib import Path

from tendond.daemon.errors import DaemonError
from tendond.daemon.recording.channels import CYCLE
from tendond.offline.logs.run import open_run
from tendond.offline.replay.difference import compare
from tendond.offline.replay.rerun import rerun
from tests.golden.scripts import FOLDER, RUNS, record


def main() -> None:
    """Record again the logs that no longer replay; with --all, every one."""
    for name in RUNS:
        old = FOLDER / f"{name}.mcap"
        with tempfile.TemporaryDirectory() as folder:
            new = Path(folder) / old.name
            record(name, new)
            changes = what_changed(old, new)
            if not changes and "--all" not in sys.argv:
                print(f"{name}: unchanged")
                continue
            old.write_bytes(new.read_bytes())
        print(f"{name}: renewed, {old.stat().st_size / 1000:.0f} kB")
        for line in changes:
            print(f"  {line}")


def cycles_of(path: Path) -> dict[int, bytes]:
    """Each cycle as it stands in a log, by tick."""
    return {
        int(json.loads(message.data)["tick"]): message.data for _, message in open_run(path).messages((CYCLE.topic,))
    }


def what_changed(old: Path, new: Path) -> list[str]:
    """Replay of the old log, and where the new one differs from it."""
    if not old.exists():
        return ["was not there"]
    lines = []
    try:
        outcome = rerun(old, jobs=1)
        if outcome.first is not None:
            lines.append(f"replayed, {outcome.differing} of {outcome.compared} cycles of the old log differ")
            lines += [f"first at {outcome.first.tick}: {field}" for field in outcome.first.fields]
    except DaemonError as error:
        lines.append(f"the old log cannot be replayed: {error}")
    before, after = cycles_of(old), cycles_of(new)
    differing = [tick for tick in after if before.get(tick) != after[tick]]
    if differing:
        lines.append(f"{len(differing)} of {len(after)} cycles of the new log are not as in the old one")
        lines += [
            f"first at {differing[0]}: {field}"
            for field in compare(before.get(differing[0], b"{}"), after[differing[0]])
        ]
    return lines


if __name__ == "__main__":
    main()
