"""`tendond log info`, `recover`, `export`, `compare`, `plot`, `report`."""

import json
from pathlib import Path

from tendond.cli.common import say
from tendond.daemon.errors import DaemonError


def run_info(file: Path, *, as_json: bool) -> None:
    """Print contents and health.

    Raises:
        LogError: the log cannot be used.
    """
    from tendond.offline.logs.info import info
    from tendond.offline.progress import working

    with working(f"reading {file.name}", quiet=as_json):
        found = info(file)
    if as_json:
        print(json.dumps(found, indent=2))
        return
    meta = found["metadata"]
    print(f"{', '.join(found['files'])}: {found['bytes'] / 1e6:.2f} MB, {_health(found['complete'], found['damage'])}")
    print(f"rig      {meta.get('rig', 'not named')}, started {found['started']}, {found['duration_s']:.2f} s")
    if calibration := found["calibration"]:
        spools = ", ".join(f"servo {one['servo']} zero {one['zero']}" for one in calibration["tendons"])
        print(f"servos   calibrated {calibration['date']}: {spools}")
    print(
        f"cycles   {found['cycles']}, ticks {found['first_tick']} to {found['last_tick']}, "
        f"{found['left_out']} omitted while idle, {found['missing_ticks']} not in the log, "
        f"{found['missed_deadlines']} deadlines missed, "
        f"{found['snapshots']} states to replay from"
    )
    for change in found["modes"]:
        print(f"mode     {change['tick']:>8}  {change['mode']}: {change['reason']}")
    for fault in found["faults"]:
        print(f"fault    {fault['tick']:>8}  to clear it: {fault['to_clear']}")
    if readings := found["readings"]:
        print(f"sensors  {', '.join(f'{name} {count} readings' for name, count in readings.items())}")
    print(f"rejected {', '.join(f'{count} {reason}' for reason, count in found['rejected'].items()) or 'nothing'}")
    print(f"entries  {', '.join(f'{count} {topic}' for topic, count in found['messages'].items())}")
    print(f"versions {', '.join(f'{name} {value}' for name, value in meta.items() if name != 'rig')}")
    for line in found["damage"]:
        print(f"damage   {line}")


def _health(complete: bool, damage: list[str]) -> str:
    if complete and not damage:
        return "complete"
    return "finished, but damaged" if complete else "not finished (writer killed, or disk full)"


def run_recover(file: Path, out: Path | None) -> None:
    """Recover the intact part, and print what was lost.

    Raises:
        LogError: the log cannot be used. UsageError: the new file cannot be written.
    """
    from tendond.offline.logs.recover import recover
    from tendond.offline.logs.ticks import shown
    from tendond.offline.progress import working

    out = out or file.with_name(f"{file.stem}-recovered.mcap")
    with working(f"recovering {file.name}"):
        found = recover(file, out)
    kept = f"{found.messages} entries" + (
        f", {found.cycles} cycles, ticks {found.first} to {found.last}" if found.cycles else ""
    )
    print(f"{out}: {kept}")
    for damage in found.damage:
        print(f"lost: {damage}")
    for stretch in found.missing:
        print(f"missing: {shown(stretch)}")
    if not found.damage and not found.missing:
        print("lost: nothing" + ("" if found.complete else " but the end, which was never written"))


def run_export(file: Path, out: Path | None) -> None:
    """Export a table.

    Raises:
        LogError: the log cannot be used. UsageError: the table cannot be written.
    """
    from tendond.offline.logs.arrays import load
    from tendond.offline.logs.export import export
    from tendond.offline.progress import working

    out = out or file.with_suffix(".csv")
    with working(f"exporting {file.name}"):
        run = load(file)
        columns = export(run, out)
    print(f"{out}: {len(run)} cycles, {columns} columns")


def run_compare(files: list[Path], out: Path, *, as_json: bool) -> None:
    """Print the table and draw the curves.

    Raises:
        LogError: a log cannot be used. DaemonError: the folder cannot be written.
    """
    from rich.console import Console
    from rich.table import Table

    from tendond.offline.files import whole
    from tendond.offline.logs.log import load
    from tendond.offline.plots.compare import compared, overlay, write_table
    from tendond.offline.progress import working

    with working("comparing", quiet=as_json) as work:
        loaded = []
        for file in files:
            work.update(f"reading {file.name}")
            loaded.append(load(file))
        runs = compared(loaded)
        work.update("drawing")
        try:
            out.mkdir(parents=True, exist_ok=True)
            write_table(runs, out / "metrics.csv")
            with whole(out / "compare.png") as draft:
                overlay(runs).savefig(draft, dpi=150)
        except OSError as error:
            raise _not_writable(out, error) from error
    if as_json:
        print(json.dumps({run.name: run.metrics for run in runs}, indent=2))
        return
    table = Table()
    table.add_column("")
    for run in runs:
        table.add_column(run.name, justify="right")
    for name in runs[0].metrics:
        table.add_row(name, *("never" if run.metrics[name] is None else f"{run.metrics[name]:.4g}" for run in runs))
    Console().print(table)
    print(f"table    {out / 'metrics.csv'}\nfigure   {out / 'compare.png'}")


def run_plot(file: Path, out: Path | None, form: str) -> None:
    """Plot a run, and print the files.

    Raises:
        LogError: the log cannot be used. DaemonError: the folder cannot be written.
    """
    from tendond.offline.progress import working

    with working(f"plotting {file.name}"):
        paths = _plotted(file, out, form)
    for path in paths:
        print(path)


def _plotted(file: Path, out: Path | None, form: str) -> list[Path]:
    """Draw a run, and return the files."""
    from tendond.offline.logs.container import LogError
    from tendond.offline.logs.log import load

    log = load(file)
    out = out or file.with_name(f"{file.stem}-plots")
    try:
        if form == "html":
            from tendond.offline.plots.interactive import write_page

            out.mkdir(parents=True, exist_ok=True)
            return [write_page(log, out / f"{file.stem}.html")]
        from tendond.offline.paper.published import published_for
        from tendond.offline.plots.figures import draw
        from tendond.offline.plots.filter import draw_filter
        from tendond.offline.plots.spatial import draw_space
        from tendond.offline.plots.timeline import draw_timeline

        paths = draw_space(log, out, form) + draw_filter(log, out, form) + draw_timeline(log, out, form)
        try:
            paths = draw(log, out, form, published_for(log)) + paths
        except LogError as error:
            say(f"the tracking panels are omitted: {error}")
    except OSError as error:
        raise _not_writable(out, error) from error
    return paths


def run_report(file: Path, out: Path | None) -> None:
    """Write the report.

    Raises:
        LogError: the log cannot be used. DaemonError: the page cannot be written.
    """
    from tendond.offline.paper.published import published_for
    from tendond.offline.plots.report import write_report
    from tendond.offline.progress import working

    out = out or file.with_suffix(".html")
    try:
        with working(f"writing the report of {file.name}"):
            written = write_report(file, out, published_for)
    except OSError as error:
        raise _not_writable(out, error) from error
    print(written)


def _not_writable(out: Path, error: OSError) -> DaemonError:
    return DaemonError(f"{error.filename or out}: {error.strerror}; choose another path with --out")
