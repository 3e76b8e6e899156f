"""`python -m tendond.cli.manual.pictures LOG SVG`: what `tendond watch` would have shown of a run, as a picture."""

import io
import re
import sys
from pathlib import Path

from rich._export_format import CONSOLE_SVG_FORMAT
from rich.console import Console

from tendond.cli.watch.bus_snapshot import FRAMES_PER_SECOND, BusSnapshot
from tendond.cli.watch.screen import frame
from tendond.daemon.recording.channels import CYCLE, STATUS
from tendond.offline.logs.run import open_run
from tendond.schemas.messages import Mode, Status
from tendond.schemas.record import CycleRecord

SIZE = (80, 24)
TRACKED_SECONDS = 1.2
"""Time at which the picture is taken: the arm has arrived, and its trail is still visible."""

FORMAT = re.sub(r"@font-face \{\{.*?\}\}\n", "", CONSOLE_SVG_FORMAT, flags=re.DOTALL).replace(
    "Fira Code,", "DejaVu Sans Mono, Menlo, Consolas,"
)
"""rich's, without the font that it would fetch."""


def watch_picture(log: Path) -> str:
    """Draw the live view as SVG, a moment after the log's run has begun to track.

    Raises:
        LogError: the log cannot be used.
    """
    run = open_run(log)
    snapshot, now, tracked, due = BusSnapshot(), 0.0, 0.0, 0.0
    for topic, message in run.messages((CYCLE.topic, STATUS.topic)):
        now = message.log_time / 1e9
        if topic == STATUS.topic:
            snapshot.add(run.decode(topic, Status, message.data), now)
            continue
        record = run.decode(topic, CycleRecord, message.data)
        for part in (record.inputs.pose, record.inputs.tendon_state, record.command):
            if part is not None:
                snapshot.add(part, now)
        tracked += run.config.loop.period if record.mode is Mode.TRACKING else 0.0
        if now >= due:
            snapshot.tick(now)
            due = now + 1.0 / FRAMES_PER_SECOND
        if tracked >= TRACKED_SECONDS:
            break
    width, height = SIZE
    console = Console(record=True, width=width, file=io.StringIO(), force_terminal=True, color_system="truecolor")
    console.print(frame(snapshot, run.config, now, width, height))
    return console.export_svg(title="tendond watch", code_format=FORMAT, unique_id="watch")


if __name__ == "__main__":
    Path(sys.argv[2]).write_text(watch_picture(Path(sys.argv[1])), encoding="utf-8")
