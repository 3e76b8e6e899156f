"""A table of metrics with their units: for the terminal, CSV, Markdown, LaTeX."""

import csv
import io
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from tendond.offline.comparison.repeats import CONFIDENCE, Group, Mean
from tendond.offline.comparison.runs import Compared, Metric, metric

NEVER = "never"
"""A time of something that did not happen."""

NONE = "-"
"""A metric that a run does not have."""

PIPE_WIDTH = 240
"""Characters of a line where the table does not go to a terminal."""

ESCAPES = {"\\": r"\textbackslash{}", "_": r"\_", "%": r"\%", "&": r"\&", "#": r"\#", "$": r"\$", "{": r"\{",
           "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}  # fmt: skip


@dataclass(frozen=True)
class Table:
    """Metrics of runs, or of groups of repeats.

    Attributes:
        columns: names of the runs. metrics: key, name and unit of each row.
        cells: values, a row per metric: a number, a `Mean`, or none.
        repeats: runs in each column; none where the columns are single runs.
        present: whether a run has the metric at all, so that none means never.
    """

    columns: list[str]
    metrics: list[Metric]
    cells: list[list[Any]]
    present: list[list[bool]]
    repeats: list[int] | None = None


def table_of(found: Sequence[Compared] | Sequence[Group]) -> Table:
    """Tabulate runs, or groups of them."""
    keys = list(dict.fromkeys(key for one in found for key in one.metrics))
    return Table(
        columns=[one.name for one in found],
        metrics=[metric(key) for key in keys],
        cells=[[one.metrics.get(key) for one in found] for key in keys],
        present=[[key in one.metrics for one in found] for key in keys],
        repeats=[len(one.members) for one in found if isinstance(one, Group)] or None,
    )


def on_terminal(table: Table, notes: Sequence[str]) -> None:
    """Print the table."""
    from rich.console import Console
    from rich.markup import escape
    from rich.table import Table as RichTable

    shown = RichTable(caption="\n".join(_remarks(table, ())) or None, caption_justify="left")
    shown.add_column("", overflow="fold")
    shown.add_column("unit", style="dim", no_wrap=True)
    for name in _headings(table):
        shown.add_column(escape(name), justify="right")
    for name, unit, cells in _rows(table):
        shown.add_row(name, unit, *cells)
    console = Console()
    if not console.is_terminal:
        console = Console(width=PIPE_WIDTH)
    console.print(shown)
    for line in notes:
        console.print(line, highlight=False, markup=False, soft_wrap=True)


def as_csv(table: Table, notes: Sequence[str]) -> str:
    """Write CSV: a line per metric; key, unit, and a column per run, or three of repeats: mean, half-width, count.

    The notes have no place in it.
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    parts = ("", " half-width of the 95 % interval", " n") if table.repeats else ("",)
    writer.writerow(["metric", "unit", *(name + part for name in table.columns for part in parts)])
    for (key, _, unit), row in zip(table.metrics, table.cells, strict=True):
        cells: list[Any] = []
        for cell in row:
            if table.repeats:
                cells += ["", "", 0] if cell is None else [cell.value, _blank(cell.half_width), cell.count]
            else:
                cells.append(_blank(cell))
        writer.writerow([key, unit, *cells])
    return stream.getvalue()


def as_markdown(table: Table, notes: Sequence[str]) -> str:
    """Write a table of Markdown."""
    heads = ["", "unit", *_headings(table)]
    lines = [
        heads,
        ["---", "---", *("---:" for _ in table.columns)],
        *([name, unit, *c] for name, unit, c in _rows(table)),
    ]
    text = "\n".join(f"| {' | '.join(cell.replace('|', chr(92) + '|') for cell in line)} |" for line in lines)
    return "\n\n".join([text, *_remarks(table, notes)]) + "\n"


def as_latex(table: Table, notes: Sequence[str]) -> str:
    """Write a tabular for LaTeX, with the rules of the package booktabs."""
    lines = [
        "% needs \\usepackage{booktabs}",
        f"\\begin{{tabular}}{{ll{'r' * len(table.columns)}}}",
        "  \\toprule",
        f"  & unit & {' & '.join(_escaped(name) for name in _headings(table))} \\\\",
        "  \\midrule",
    ]
    for name, unit, cells in _rows(table):
        values = (_escaped(cell).replace(" ± ", r" $\pm$ ").replace("-", r"$-$", cell[:1] == "-") for cell in cells)
        lines.append(f"  {_escaped(name)} & {_escaped(unit)} & {' & '.join(values)} \\\\")
    lines += ["  \\bottomrule", "\\end{tabular}", *(f"% {line}" for line in _remarks(table, notes))]
    return "\n".join(lines) + "\n"


@dataclass(frozen=True)
class Form:
    """A format of the table: ending of its file, and how it is written."""

    ending: str
    write: Callable[[Table, Sequence[str]], str]


FORMS = {"csv": Form("csv", as_csv), "markdown": Form("md", as_markdown), "latex": Form("tex", as_latex)}


def _headings(table: Table) -> list[str]:
    if table.repeats is None:
        return table.columns
    return [f"{name} (n = {count})" for name, count in zip(table.columns, table.repeats, strict=True)]


def _remarks(table: Table, notes: Sequence[str]) -> list[str]:
    """Say what the numbers of repeats are, and what `notes` say."""
    spread = f"mean ± half-width of the {100 * CONFIDENCE:.0f} % confidence interval (Student's t)"
    return [*([spread] if table.repeats else []), *notes]


def _rows(table: Table) -> list[tuple[str, str, list[str]]]:
    """Return name, unit and cells of each row, as texts."""
    return [
        (name, unit, [_text(*pair) for pair in zip(row, present, strict=True)])
        for (_, name, unit), row, present in zip(table.metrics, table.cells, table.present, strict=True)
    ]


def _text(cell: Any, present: bool) -> str:
    if cell is None:
        return NEVER if present else NONE
    if not isinstance(cell, Mean):
        return _number(cell)
    text = _number(cell.value) if cell.half_width is None else f"{_rounded(cell.value, cell.half_width)}"
    return text if cell.count == cell.runs else f"{text} ({cell.count} of {cell.runs})"


def _number(value: float) -> str:
    """Format a number with four digits; less than any unit here resolves (0.1 um) as zero."""
    return f"{0.0 if abs(value) < 1e-7 else value:.4g}"


def _rounded(value: float, half: float) -> str:
    """Format a mean with its half-width, which has two digits."""
    if half < 1e-9:
        return f"{_number(value)} ± 0"
    import math

    places = max(0, 1 - math.floor(math.log10(half)))
    return f"{value:.{places}f} ± {half:.{places}f}"


def _blank(value: Any) -> Any:
    return "" if value is None else value


def _escaped(text: str) -> str:
    return "".join(ESCAPES.get(letter, letter) for letter in text)
