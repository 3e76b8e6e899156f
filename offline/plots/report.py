"""Report of a run, one self-contained printable page: numbers, figures, faults, configuration, versions."""

import base64
from collections.abc import Callable, Sequence
from contextlib import suppress
from functools import partial
from html import escape
from io import BytesIO
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from tendond import __version__
from tendond.offline.files import write_whole
from tendond.offline.logs.container import LogError
from tendond.offline.logs.events import FAULT, MODE, REQUEST, Event, events, tallies
from tendond.offline.logs.info import info
from tendond.offline.logs.log import LogFile, load
from tendond.offline.logs.metrics import runs
from tendond.offline.logs.paths import TipPath
from tendond.offline.logs.published import Published
from tendond.offline.logs.summary import LABELS, recovered, summary
from tendond.offline.parallel import in_parallel
from tendond.offline.plots.contacts import COLUMNS, found_contacts
from tendond.offline.plots.figures import overview, shapes_figure
from tendond.offline.plots.filter import filter_figure, has_filter
from tendond.offline.plots.spatial import space_figure
from tendond.offline.plots.style import place_parts, style
from tendond.offline.plots.timeline import loop_timing, timeline
from tendond.schemas.config.rig import RigConfig

MAX_EVENTS = 200
MAX_ROWS = 20  # of a list in the configuration; of a longer one, the first and the last

HEADLINES = ("settling_s", "overshoot_percent", "steady_state_error_mm", "path_mm", "peak_tension_n", "cycle_ms_p99")

CSS = """
body { font: 10.5pt/1.5 system-ui, "Segoe UI", "Helvetica Neue", sans-serif; color: #1c1f24; max-width: 64rem;
  margin: 2.5rem auto; padding: 0 1.25rem }
h1 { font-size: 1.7rem; line-height: 1.2; margin: 0 } header p { color: #555; margin: .3rem 0 1.2rem }
h2 { font-size: 1.15rem; margin: 2.2rem 0 .6rem; padding-bottom: .2rem; border-bottom: 2px solid #1f4e79;
  break-after: avoid }
.cards { display: grid; grid-template-columns: repeat(6, 1fr); gap: .6rem; margin: 0 0 1rem }
.cards div { border: 1px solid #d5dae1; border-radius: 6px; padding: .5rem .7rem; break-inside: avoid }
.cards b { display: block; font-size: 1.35rem; font-weight: 600; color: #1f4e79; font-variant-numeric: tabular-nums }
.cards small { font-weight: 400; font-size: .8rem } .cards span { font-size: .8rem; line-height: 1.25; color: #555 }
.columns { column-width: 26rem; column-gap: 2.5rem } .columns table { width: 100% }
table { border-collapse: collapse; font-variant-numeric: tabular-nums } td, th { padding: .15rem 1rem .15rem 0 }
th { text-align: left; font-weight: 600; border-bottom: 1px solid #888 } td { border-bottom: 1px solid #e6e8eb }
td.n, th.n { text-align: right } td { vertical-align: top } tr { break-inside: avoid } thead { break-after: avoid }
.bad { color: #a32015; font-weight: 600 } .good { color: #2c6e2f; font-weight: 600 } .dim td { color: #555 }
.dim { font-size: .85rem } figure { margin: 0; break-inside: avoid } img { max-width: 100%; height: auto }
td:last-child { overflow-wrap: break-word }
@page { size: A4; margin: 14mm }
@media (max-width: 50rem) { .cards { grid-template-columns: repeat(3, 1fr) } }
@media print { body { margin: 0; padding: 0; max-width: none; font-size: 9pt } h2 { margin-top: 1.4rem }
  .columns { column-width: 18rem } .dim { font-size: 7pt } }
"""


def write_report(file: Path, out: Path, published_for: Callable[[LogFile], Published | None] | None = None) -> Path:
    """Write the page of a log.

    Args:
        file: the log. out: the file to write.
        published_for: finds a paper's figures of a run, to be drawn next to its own.

    Raises:
        LogError: see `load`.
        OSError: the page cannot be written.
    """
    write_whole(out, page(load(file), info(file), published_for))
    return out


def page(
    log: LogFile, facts: dict[str, Any], published_for: Callable[[LogFile], Published | None] | None = None
) -> str:
    """Return the page as text; `facts` as of `info`, `published_for` as of `write_report`."""
    found = events(log.records)
    figures: list[tuple[str, Callable[[], Figure]]] = []
    cards = ""
    try:
        numbers = summary(log)
        cards, table = _cards(numbers), _numbers(numbers)
    except LogError as error:
        table = f"<p>{escape(str(error))}</p>"
    with suppress(LogError):  # nothing tracks, as the numbers say
        runs(log)
        published = None if published_for is None else published_for(log)
        figures = [("Tracking", partial(overview, log, published)), ("Rod shapes", partial(shapes_figure, log))]
    if TipPath.of(log).points.size:
        figures.append(("In space", partial(space_figure, log)))
    if has_filter(log):
        figures.append(("Filter", partial(filter_figure, log)))
    figures.append(("Modes and events", partial(timeline, log)))
    if log.timings:
        figures.append(("Loop timing", partial(loop_timing, log)))
    images = in_parallel([partial(_image, draw, name) for name, draw in figures])
    title = f"{log.name}: {log.config.control.law.replace('_', ' ')} on rig '{log.config.rig.name}'"
    shown = [event for event in found if event.kind in (REQUEST, MODE, FAULT)]
    parts = [
        f"<header><h1>{escape(title)}</h1><p>{escape(_subtitle(log, facts))}</p></header>",
        cards,
        _health(facts),
        *(f"<h2>{name}</h2>{image}" for (name, _), image in zip(figures, images, strict=True)),
        "<h2>Numbers</h2>",
        table,
        *_contacts(log),
        "<h2>Requests, modes, faults</h2>",
        _events(shown),
        "<h2>Other events</h2>",
        _tallies(found),
        "<h2>Configuration</h2>",
        _configuration(log.config),
        *_calibration(log),
        "<h2>Versions</h2>",
        _table(("", ""), [(name, value) for name, value in log.metadata.items() if name != "part"]),
        f"<p>Written by tendond {__version__}. All of this is also in the log: <code>tendond log info</code>.</p>",
    ]
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{CSS}</style>'
    head += '<meta name="viewport" content="width=device-width">'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head><body>\n' + "\n".join(parts) + "\n</body></html>\n"


def _subtitle(log: LogFile, facts: dict[str, Any]) -> str:
    started = facts["started"].replace("T", " ").replace("+00:00", " UTC")
    rod = log.config.rod
    return (
        f"{started}, {facts['duration_s']:.2f} s, {facts['cycles']} cycles of {1e3 * log.config.loop.period:g} ms; "
        f"rod of {1e3 * rod.length:g} mm, {len(rod.tendon_positions)} tendons"
    )


def _cards(numbers: dict[str, Any]) -> str:
    cells = []
    for name in HEADLINES:
        label, unit = LABELS[name]
        value = numbers[name]
        shown = f"{_number(value, 3)} <small>{unit}</small>" if value is not None else "never" if unit == "s" else "-"
        cells.append(f"<div><b>{shown}</b><span>{escape(label)}</span></div>")
    return f'<div class="cards">{"".join(cells)}</div>'


def _numbers(numbers: dict[str, Any]) -> str:
    rows = [
        (label, "never" if numbers[name] is None else _number(numbers[name]), unit, name)
        for name, (label, unit) in LABELS.items()
        if numbers[name] is not None or name.endswith("iterations")
    ]
    rows += [(label, "never" if s is None else _number(s, 3), "s", "recoveries") for label, s in recovered(numbers)]
    return _table(("", "value", "unit", "in summary.json"), rows, numeric=(1,))


def _health(facts: dict[str, Any]) -> str:
    rejected = ", ".join(f"{count} {reason}" for reason, count in facts["rejected"].items()) or "none"
    faults = (
        "; ".join(f"cycle {fault['tick']}: {fault['reason']}; {fault['to_clear']}" for fault in facts["faults"])
        or "none"
    )
    whole = facts["complete"] and not facts["damage"]
    missing, missed = facts["missing_ticks"], facts["missed_deadlines"]
    rows = [
        ("log", "complete" if whole else "truncated: its end is missing", "good" if whole else "bad"),
        ("faults", faults, "bad" if facts["faults"] else "good"),
        ("inputs rejected", rejected, ""),
        ("deadlines missed", f"{missed} of {facts['cycles']}", ""),
        ("cycles not in the log", str(missing), "bad" if missing else ""),
    ]
    cells = (f"<tr><td>{name}</td><td class='{look}'>{escape(text)}</td></tr>" for name, text, look in rows)
    return f"<table>{''.join(cells)}</table>"


def _contacts(log: LogFile) -> list[str]:
    rows = [contact.row for contact in found_contacts(log.records)]
    if not (rows or log.config.observer.contact):
        return []
    return ["<h2>Contacts</h2>", _table(COLUMNS, rows, numeric=(0, 1, 2)) if rows else "<p>none found</p>"]


def _events(found: list[Event]) -> str:
    if not found:
        return "<p>none</p>"
    rows = [(str(event.tick), f"{event.time:.3f}", event.kind, event.text) for event in found[:MAX_EVENTS]]
    more = f"<p>and {len(found) - MAX_EVENTS} more</p>" if len(found) > MAX_EVENTS else ""
    return _table(("cycle", "time [s]", "", ""), rows, numeric=(0, 1)) + more


def _tallies(found: list[Event]) -> str:
    rows = [
        (one.kind, one.text, str(one.cycles), str(one.longest), f"{one.first.time:.3f}", f"{one.last.time:.3f}")
        for one in tallies(found)
    ]
    head = ("", "", "cycles", "max. in a row", "first [s]", "last [s]")
    return _table(head, rows, numeric=(2, 3, 4, 5)) if rows else "<p>nothing</p>"


def _configuration(config: RigConfig) -> str:
    """Write every key; first those that differ from the default, with the default."""
    default = dict(_keys("", RigConfig().model_dump(mode="json")))
    keys = _keys("", config.model_dump(mode="json"))
    changed = [(key, value, default.get(key, "none")) for key, value in keys if default.get(key) != value]
    rows = "".join(f"<tr><td>{escape(key)}</td><td>{escape(value)}</td></tr>" for key, value in keys)
    head = _table(("differs from the default", "value", "default"), changed) if changed else "<p>All defaults.</p>"
    return f'{head}<p>All keys, in SI units:</p><div class="columns"><table class="dim">{rows}</table></div>'


def _calibration(log: LogFile) -> list[str]:
    if log.calibration is None:
        return []
    rows = [
        (str(i), str(one.servo), str(one.zero), f"{one.sign:+d}", _number(1e3 * one.spool_radius))
        for i, one in enumerate(log.calibration.tendons)
    ]
    head = ("tendon", "servo", "zero [ticks]", "sign", "spool radius [mm]")
    table = _table(head, rows, numeric=range(5))
    return ["<h2>Calibration</h2>", f"<p>Servo calibration of {escape(log.calibration.date)}.</p>", table]


def _keys(path: str, value: Any) -> list[tuple[str, str]]:
    """List a value by its keys; tables in a list by their numbers, a long list by its ends."""
    if isinstance(value, dict) and value:
        return [item for key, inner in value.items() for item in _keys(f"{path}.{key}" if path else key, inner)]
    if isinstance(value, list) and any(isinstance(inner, dict) for inner in value):
        return [item for number, inner in enumerate(value) for item in _keys(f"{path}[{number}]", inner)]
    short = not isinstance(value, list) or len(value) <= MAX_ROWS
    return [(path, str(value) if short else f"{len(value)} rows, from {value[0]} to {value[-1]}")]


def _table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]], numeric: Sequence[int] = ()) -> str:
    """Write a table; columns in `numeric` are aligned to the right."""

    def line(tag: str, cells: tuple[str, ...]) -> str:
        shown = (f"<{tag}{' class=n' * (i in numeric)}>{escape(cell)}</{tag}>" for i, cell in enumerate(cells))
        return f"<tr>{''.join(shown)}</tr>"

    top = f"<thead>{line('th', head)}</thead>" if any(head) else ""
    return f"<table>{top}<tbody>{''.join(line('td', row) for row in rows)}</tbody></table>"


def _number(value: Any, digits: int = 5) -> str:
    if isinstance(value, list):
        return ", ".join(_number(item, digits) for item in value)
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def _image(draw: Callable[[], Figure], name: str) -> str:
    """Draw a figure and embed it as SVG, without the title where the page's heading says the same."""
    data = BytesIO()
    with style(text_as_text=False):  # so that it looks the same where the fonts are others
        figure = draw()
        if figure.get_suptitle():
            figure.suptitle("")
        elif name in ("Modes and events", "Loop timing"):
            figure.axes[0].set_title("", loc="left")
        place_parts(figure)
        figure.savefig(data, format="svg", metadata={"Date": None})
    code = base64.b64encode(data.getvalue()).decode()
    return f'<figure><img alt="{escape(name)}" src="data:image/svg+xml;base64,{code}"></figure>'
