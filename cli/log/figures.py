"""`tendond log plot` and `log compare`."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from tendond.cli.common import say
from tendond.daemon.errors import DaemonError
from tendond.offline.plots.appearance import Appearance, appearing

COMPARED = Path("out/compare")

PAGE = "html"
"""Format of the interactive page."""


def run_plot(file: Path, out: Path | None, look: Appearance, *, page: bool, panels: bool, force: bool) -> None:
    """Plot a log.

    Args:
        file: the log. out: folder for the figures.
        look: their appearance; none is drawn where it has no format.
        page: write the interactive page as well. panels: draw each panel as a figure of its own as well.
        force: replace files.

    Raises:
        LogError: the log cannot be used. DaemonError: a file exists, or cannot be written.
    """
    from tendond.offline.logs.log import load
    from tendond.offline.progress import working

    paths = []
    try:
        with working(f"plotting {file.name}"):
            log = load(file)
            out = out or file.with_name(f"{file.stem}-plots")
            if log.cut:
                say(log.cut)
            if page:
                paths.append(_write_page(log, out / f"{file.stem}.html", force))
            if look.formats:
                with appearing(look):
                    paths += _draw(log, out, force, panels)
    except OSError as error:
        raise not_writable(out or file, error) from error
    for path in paths:
        print(path)


def _write_page(log: Any, path: Path, force: bool) -> Path:
    from tendond.offline.plots.interactive import write_page

    if not force and path.exists():
        raise DaemonError(f"{path}: exists already; --force replaces it, --out takes another place")
    path.parent.mkdir(parents=True, exist_ok=True)
    return write_page(log, path)


def _draw(log: Any, out: Path, force: bool, panels: bool) -> list[Path]:
    from tendond.offline.logs.container import LogError
    from tendond.offline.logs.metrics import runs
    from tendond.offline.paper.published import published_for
    from tendond.offline.plots.figures import NAMES, PANELS, run_figures, run_prefixes
    from tendond.offline.plots.filter import filter_figures
    from tendond.offline.plots.output import Named, Output
    from tendond.offline.plots.spatial import space_figures
    from tendond.offline.plots.timeline import time_figures

    output = Output(out, f"{log.stem}-", force)
    figures: list[Named] = []
    try:
        prefixes = run_prefixes(len(runs(log)))
        output.check([f"{prefix}{name}" for prefix in prefixes for name in (*NAMES, *(PANELS if panels else ()))])
    except LogError as error:
        say(f"the figures of runs are omitted: {error}")
    else:
        figures += run_figures(log, published_for(log), panels=panels)
    return output.draw([*figures, *space_figures(log), *filter_figures(log), *time_figures(log)])


def run_compare(
    files: list[Path],
    out: Path | None,
    look: Appearance,
    form: str | None,
    *,
    repeats: bool,
    as_json: bool,
    force: bool,
) -> None:
    """Print the table, then write it and draw the curves.

    Args:
        files: the logs. look: appearance of the figure.
        out: folder for table and figure; default: `COMPARED`, or where that is taken the same with a number.
        form: of the table, see `FORMS`; none: for the terminal.
        repeats: mean and confidence interval of runs with the same configuration.
        as_json: print JSON. force: replace files.

    Raises:
        LogError: a log cannot be used. DaemonError: a file exists, or cannot be written.
    """
    from tendond.offline.comparison.repeats import as_groups
    from tendond.offline.comparison.runs import compared, notes
    from tendond.offline.comparison.table import FORMS, on_terminal, table_of
    from tendond.offline.files import free_folder, write_whole
    from tendond.offline.logs.log import load
    from tendond.offline.plots.compare import overlay
    from tendond.offline.plots.output import Output, check_new
    from tendond.offline.progress import working

    with working("comparing", quiet=as_json) as work:
        logs = []
        for file in files:
            work.update(f"reading {file.name}")
            logs.append(load(file))
        for log in logs:
            if log.cut:
                say(log.cut)
        found = compared(logs)
    table = table_of(as_groups(found) if repeats else found)
    if as_json:
        print(json.dumps({one.name: one.as_json() for one in found}, indent=2))
    elif form is None:
        on_terminal(table, notes(found))
    else:
        print(FORMS[form].write(table, notes(found)), end="")
    out = out or (COMPARED if force else free_folder(COMPARED))
    kind = FORMS[form or "csv"]
    written = out / f"metrics.{kind.ending}"
    with appearing(look):
        output = Output(out, force=force)
        check_new([written, *output.paths("compare")], force=force)
        try:
            out.mkdir(parents=True, exist_ok=True)
            write_whole(written, kind.write(table, notes(found)))
            figures = output.save(overlay(found), "compare")
        except OSError as error:
            raise not_writable(out, error) from error
    show: Callable[[str], None] = print if form is None else say
    if not as_json:
        show(f"table    {written}")
        for path in figures:
            show(f"figure   {path}")


def not_writable(out: Path, error: OSError) -> DaemonError:
    """Return the error of a folder or a file that cannot be written."""
    return DaemonError(f"{error.filename or out}: {error.strerror}; choose another path with --out")
