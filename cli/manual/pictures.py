"""`python -m tendond.cli.manual.pictures LOG FILE`: what `watch` (.svg) or `dashboard` (.png) would show of a run."""

import io
import json
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from rich._export_format import CONSOLE_SVG_FORMAT
from rich.console import Console

from tendond.cli.dashboard.files import still
from tendond.cli.dashboard.frame import frame as dashboard_frame
from tendond.cli.dashboard.ghost import Ghost
from tendond.cli.dashboard.run import welcome
from tendond.cli.watch.bus_snapshot import FRAMES_PER_SECOND, BusSnapshot
from tendond.cli.watch.screen import frame
from tendond.daemon.recording.channels import CYCLE, ROD_SHAPE, STATUS
from tendond.model.rods.selection import model_rod
from tendond.offline.logs.run import Run, open_run
from tendond.schemas.messages import Mode, Status
from tendond.schemas.record import CycleRecord

SIZE = (80, 24)
PAGE_SIZE = (1200, 1000)
"""Of the terminal in characters, of the browser's window in pixels."""

TRACKED_SECONDS = 1.2
"""Time at which the picture is taken: the arm has arrived, and its trail is still visible."""

FORMAT = re.sub(r"@font-face \{\{.*?\}\}\n", "", CONSOLE_SVG_FORMAT, flags=re.DOTALL).replace(
    "Fira Code,", "DejaVu Sans Mono, Menlo, Consolas,"
)
"""rich's, without the font that it would fetch."""


def moments(run: Run) -> Iterator[tuple[BusSnapshot, float, str]]:
    """Yield the bus's snapshot, its time [s] and the scene as JSON, frame by frame, until the arm has arrived."""
    snapshot, now, tracked, due, scene = BusSnapshot(), 0.0, 0.0, 0.0, "null"
    for topic, message in run.messages((CYCLE.topic, STATUS.topic, ROD_SHAPE.topic)):
        now = message.log_time / 1e9
        if topic == ROD_SHAPE.topic:
            scene = message.data.decode()
            continue
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
            yield snapshot, now, scene
        if tracked >= TRACKED_SECONDS:
            break
    yield snapshot, now, scene


def watch_picture(log: Path) -> str:
    """Draw the live view as SVG, a moment after the log's run has begun to track.

    Raises:
        LogError: the log cannot be used.
    """
    run = open_run(log)
    *_, (snapshot, now, _) = moments(run)
    width, height = SIZE
    console = Console(record=True, width=width, file=io.StringIO(), force_terminal=True, color_system="truecolor")
    console.print(frame(snapshot, run.config, now, width, height))
    return console.export_svg(title="tendond watch", code_format=FORMAT, unique_id="watch")


def dashboard_page(log: Path) -> str:
    """Return the page of `tendond dashboard` as one HTML file, at the same moment.

    Raises:
        LogError: the log cannot be used.
    """
    run = open_run(log)
    rod = model_rod(run.config)
    ghost = Ghost(rod, run.config)
    frames = []
    for snapshot, now, scene in moments(run):
        shown = dashboard_frame(snapshot, run.config, now)
        if snapshot.status is not None:
            shown["ghost"] = ghost.shape(snapshot.status.target)
            frames.append(f'{json.dumps(shown)[:-1]}, "scene": {scene}}}')
    return still(welcome(run.config), frames)


def write_png(page: str, file: Path) -> None:
    """Draw a page with Chromium, without a screen and without a network."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        raise SystemExit("the picture of the dashboard needs Chromium: apt install chromium")
    with tempfile.TemporaryDirectory() as folder:
        html = Path(folder) / "page.html"
        html.write_text(page, encoding="utf-8")
        options = ("--headless=new", "--no-sandbox", "--disable-gpu", "--hide-scrollbars", f"--user-data-dir={folder}")
        size = f"--window-size={PAGE_SIZE[0]},{PAGE_SIZE[1]}"
        network = "--host-resolver-rules=MAP * ~NOTFOUND"
        command = [browser, *options, network, size, f"--screenshot={file.absolute()}", html.as_uri()]
        subprocess.run(command, check=True, timeout=120, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


if __name__ == "__main__":
    source, picture = Path(sys.argv[1]), Path(sys.argv[2])
    if picture.suffix == ".png":
        write_png(dashboard_page(source), picture)
    else:
        picture.write_text(watch_picture(source), encoding="utf-8")
