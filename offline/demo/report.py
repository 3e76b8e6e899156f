"""Report of a demo: figures, summary and table, from the log alone."""

import json
from dataclasses import asdict
from pathlib import Path

from rich.console import Console

from tendond.schemas.messages import ServoHealth


def report(out: Path, log_file: Path, console: Console) -> None:
    """Draw the figures, write `summary.json` and print the table."""
    from tendond.offline.logs.log import load
    from tendond.offline.logs.summary import summary, table, write_summary
    from tendond.offline.paper.published import published_for
    from tendond.offline.plots.figures import draw

    log = load(log_file)
    with console.status("drawing the figures from the log"):
        published = published_for(log)
        figures = draw(log, out, published=published)
    write_summary(log, out / "summary.json")
    console.print(table(summary(log), log.config.control.law, published))
    console.print(
        f"log      {log_file}\nsummary  {out / 'summary.json'}\nfigures  {', '.join(str(f) for f in figures)}"
    )


def report_wires(out: Path, log_file: Path, health: ServoHealth | None, console: Console) -> None:
    """Print what the servos were commanded and measured, and what the serial line lost; write `wires.json`."""
    from tendond.offline.logs.log import load
    from tendond.offline.plots.wires import pace, wires, wires_table

    log = load(log_file)
    tendons = wires(log)
    if not tendons:
        return
    console.print(wires_table(tendons, health))
    console.print(pace(log, tendons))
    line = None if health is None else health.model_dump()
    found = {"tendons": [asdict(one) for one in tendons], "serial_line": line, "pace": pace(log, tendons)}
    (out / "wires.json").write_text(json.dumps(found, indent=2) + "\n", encoding="utf-8")
