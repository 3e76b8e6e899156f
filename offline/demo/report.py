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

    log = load(log_file)
    published = published_for(log)
    try:
        with console.status("drawing the figures from the log"):
            from tendond.offline.plots.figures import draw

            figures = ", ".join(str(figure) for figure in draw(log, out, published=published))
    except ModuleNotFoundError as error:
        figures = without_figures(error, log_file)
    write_summary(log, out / "summary.json")
    console.print(table(summary(log), log.config.control.law, published))
    files = f"log      {log_file}\nsummary  {out / 'summary.json'}\nfigures  {figures}"
    console.print(files, markup=False, soft_wrap=True)


def without_figures(error: ModuleNotFoundError, log_file: Path) -> str:
    """Return the words in the place of figures where matplotlib is not installed: the demo itself needs no extra.

    Raises:
        ModuleNotFoundError: it is another library.
    """
    if error.name is None or error.name.partition(".")[0] != "matplotlib":
        raise error
    return f"none, matplotlib is not installed: pip install 'tendond[plot]', then tendond plot {log_file}"


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
