"""A run on one page: numbers, figures, faults, configuration, versions. Everything is in the file; it prints."""

import base64
from collections.abc import Sequence
from html import escape
from io import BytesIO
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from tendond import __version__
from tendond.daemon.analysis.course import loop_timing, timeline
from tendond.daemon.analysis.drawing import style
from tendond.daemon.analysis.events import FAULT, MODE, REQUEST, Event, events
from tendond.daemon.analysis.figures import overview, shapes_figure
from tendond.daemon.analysis.info import info
from tendond.daemon.analysis.log import Log, LogError, load
from tendond.daemon.analysis.summary import summary
from tendond.schemas.config import RigConfig

MOST_EVENTS = 200

CSS = """
body { font: 10.5pt/1.45 system-ui, sans-serif; color: #222; max-width: 62rem; margin: 2rem auto; padding: 0 1rem }
h1 { font-size: 1.6rem; margin-bottom: 0 } h2 { font-size: 1.15rem; margin: 1.6rem 0 .5rem }
table { border-collapse: collapse; font-variant-numeric: tabular-nums } td, th { padding: .15rem .9rem .15rem 0 }
th { text-align: left; font-weight: 600; border-bottom: 1px solid #999 } td { border-bottom: 1px solid #e3e3e3 }
td.n { text-align: right } td { vertical-align: top } .bad { color: #a32015; font-weight: 600 }
figure { margin: 0 0 1rem; break-inside: avoid } img { max-width: 100%; height: auto } h2 { break-after: avoid }
tr { break-inside: avoid } @page { size: A4; margin: 15mm }
@media print { body { margin: 0; max-width: none; font-size: 9pt } }
"""


def write_report(file: Path, out: Path) -> Path:
    """Write the page of a log.

    Raises:
        LogError: as `load`.
        OSError: the page cannot be written.
    """
    out.write_text(page(load(file), info(file)), encoding="utf-8")
    return out


def page(log: Log, facts: dict[str, Any]) -> str:
    """The page as text; `facts` as of `info`."""
    found = events(log.records)
    try:
        numbers = _table(("metric", "value"), [(name, _number(value)) for name, value in summary(log).items()])
        figures = [("Tracking", overview(log)), ("Rod shapes", shapes_figure(log))]
    except LogError as error:
        numbers, figures = f"<p>{escape(str(error))}</p>", []
    figures.append(("Modes and events", timeline(log)))
    if log.timings:
        figures.append(("Loop timing", loop_timing(log)))
    title = f"{log.path.name}: {log.config.control.law.replace('_', ' ')} on rig '{log.config.rig.name}'"
    parts = [
        f"<h1>{escape(title)}</h1>",
        f"<p>{escape(facts['started'])}, {facts['duration_s']:.2f} s, {facts['cycles']} cycles</p>",
        "<h2>Health</h2>",
        _health(facts),
        "<h2>Numbers</h2>",
        numbers,
        *(f"<h2>{name}</h2>{_image(figure, name)}" for name, figure in figures),
        "<h2>Requests, modes, faults</h2>",
        _events([event for event in found if event.kind in (REQUEST, MODE, FAULT)]),
        "<h2>Everything else out of the ordinary</h2>",
        _events([event for event in found if event.kind not in (REQUEST, MODE, FAULT)]),
        "<h2>Configuration</h2>",
        _configuration(log.config),
        *_calibration(log),
        "<h2>Versions</h2>",
        _table(("", "version"), [*log.metadata.items(), ("report by tendond", __version__)]),
    ]
    head = f'<meta charset="utf-8"><title>{escape(title)}</title><style>{CSS}</style>'
    return f'<!doctype html>\n<html lang="en"><head>{head}</head><body>\n' + "\n".join(parts) + "\n</body></html>\n"


def _health(facts: dict[str, Any]) -> str:
    rejected = ", ".join(f"{count} {reason}" for reason, count in facts["rejected"].items()) or "none"
    faults = "; ".join(f"cycle {fault['tick']}: {fault['reason']}" for fault in facts["faults"]) or "none"
    whole = facts["complete"] and not facts["damage"]
    rows = [
        ("log", "whole" if whole else "not finished: its end is missing", not whole),
        ("faults", faults, bool(facts["faults"])),
        ("inputs rejected", rejected, False),
        ("deadlines missed", str(facts["missed_deadlines"]), False),
        ("cycles not in the log", str(facts["missing_ticks"]), facts["missing_ticks"] > 0),
    ]
    cells = (f"<tr><td>{name}</td><td{' class=bad' * bad}>{escape(text)}</td></tr>" for name, text, bad in rows)
    return f"<table>{''.join(cells)}</table>"


def _events(found: list[Event]) -> str:
    if not found:
        return "<p>none</p>"
    rows = [(str(event.tick), f"{event.time:.3f}", event.kind, event.text) for event in found[:MOST_EVENTS]]
    more = f"<p>and {len(found) - MOST_EVENTS} more</p>" if len(found) > MOST_EVENTS else ""
    return _table(("cycle", "time [s]", "what", ""), rows) + more


def _configuration(config: RigConfig) -> str:
    """Every key; those that are not the default stand out."""
    default = dict(_keys("", RigConfig().model_dump(mode="json")))
    rows = "".join(
        f"<tr><td>{escape(key)}</td><td{'' if default.get(key) == value else ' class=bad'}>{escape(value)}</td></tr>"
        for key, value in _keys("", config.model_dump(mode="json"))
    )
    return f"<p>Values other than the defaults stand out.</p><table>{rows}</table>"


def _calibration(log: Log) -> list[str]:
    if log.calibration is None:
        return []
    rows = [
        (str(i), str(one.servo), str(one.zero), f"{one.sign:+d}", _number(1e3 * one.spool_radius))
        for i, one in enumerate(log.calibration.tendons)
    ]
    head = ("tendon", "servo", "zero [ticks]", "sign", "spool radius [mm]")
    return ["<h2>Calibration</h2>", f"<p>{escape(log.calibration.date)}</p>", _table(head, rows)]


def _keys(path: str, value: Any) -> list[tuple[str, str]]:
    if isinstance(value, dict) and value:
        return [item for key, inner in value.items() for item in _keys(f"{path}.{key}" if path else key, inner)]
    text = str(value)
    return [(path, text if len(text) <= 200 else text[:197] + "...")]


def _table(head: tuple[str, ...], rows: Sequence[tuple[str, ...]]) -> str:
    top = "".join(f"<th>{escape(cell)}</th>" for cell in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(cell)}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{top}</tr></thead><tbody>{body}</tbody></table>"


def _number(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(_number(item) for item in value)
    if value is None:
        return "never, or not known"
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _image(figure: Figure, name: str) -> str:
    """The figure as SVG within the page."""
    data = BytesIO()
    with style():
        figure.savefig(data, format="svg", metadata={"Date": None})
    code = base64.b64encode(data.getvalue()).decode()
    return f'<figure><img alt="{escape(name)}" src="data:image/svg+xml;base64,{code}"></figure>'
