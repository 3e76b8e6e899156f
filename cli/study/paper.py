"""`tendond study paper`: the paper's simulations, tables and figures."""

from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, TextColumn, TimeElapsedColumn
from rich.table import Table

from tendond.cli.common import say
from tendond.daemon.errors import DaemonError
from tendond.model.numerics.announce import announce_compilation
from tendond.model.warm import warm_up
from tendond.offline.files import write_whole
from tendond.offline.paper.page import page
from tendond.offline.paper.published import LAWS, SIMULATION
from tendond.offline.paper.run import Runs, process_pool, run_all
from tendond.offline.paper.scenarios import paper_scenarios
from tendond.offline.paper.tables import comparison, write_tables
from tendond.offline.plots.appearance import Appearance, appearing
from tendond.offline.progress import bars

SCENARIOS = ("normal", "normal_edge")


def run_paper(out: Path, processes: int | None = None, look: Appearance | None = None) -> None:
    """Run the scenarios, draw the figures, write tables and page into `out`.

    Args:
        out: folder of the results. processes: of the pool.
        look: appearance of the figures; the page shows a PNG, or else an SVG.

    Raises:
        DaemonError: the folder cannot be written.
    """
    from tendond.offline.paper.draw import draw_all, figures

    look = look or Appearance(iterations=True)
    shown = next((form for form in ("png", "svg") if form in look.formats), look.formats[0])
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise _unusable(out, error) from error
    announce_compilation(say)
    warm_up()  # or every process of the pool would compile
    scenarios = paper_scenarios()
    console = Console()
    columns = (
        TextColumn("{task.description:<11}"),
        BarColumn(),
        MofNCompleteColumn(),
        TimeElapsedColumn(),
        TextColumn("{task.fields[newest]}"),
    )
    try:
        with (
            process_pool(processes) as pool,
            bars(*columns) as progress,
        ):
            running = progress.add_task("simulations", total=len(scenarios), newest="")
            drawing = progress.add_task("figures", total=len(figures()), newest="")
            runs = run_all(scenarios, pool, lambda name: progress.update(running, advance=1, newest=name))
            with appearing(look):
                draw_all(runs, out, pool, lambda name: progress.update(drawing, advance=1, newest=name))
        write_tables(runs, out, *SCENARIOS, "rig_normal")
        write_whole(out / "README.md", page(runs, shown))
    except BrokenProcessPool as error:
        raise DaemonError("a worker process was killed, perhaps for lack of memory; try --processes 1") from error
    except OSError as error:
        raise _unusable(out, error) from error
    for scenario in SCENARIOS:
        console.print(_table(runs, scenario))
    console.print(f"page     {out / 'README.md'}\nresults  {out / 'results.json'}", highlight=False)


def _unusable(out: Path, error: OSError) -> DaemonError:
    return DaemonError(f"{error.filename or out}: {error.strerror}; choose another folder with --out")


def _table(runs: Runs, scenario: str) -> Table:
    rows = {law: runs[scenario, law] for law in LAWS}
    table = Table(title=f"\n{rows[LAWS[0]].scenario.title}", title_justify="left")
    table.add_column("", no_wrap=True)
    for law in LAWS:
        table.add_column(f"{law.replace('_', ' ')}\npaper", justify="right", no_wrap=True)
        table.add_column("\nours", justify="right", no_wrap=True)
    for label, *cells in comparison(SIMULATION, rows):
        table.add_row(escape(label), cells[0], cells[1], cells[3], cells[4])
    return table
