"""A run as one interactive page that needs no network: the library that draws it is in it. Needs plotly."""

from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from tendond.daemon.analysis.events import KINDS, events, mode_spans
from tendond.daemon.analysis.log import Log
from tendond.daemon.errors import UsageError
from tendond.schemas.messages import Mode

BANDS = {Mode.PRETENSION: "#ffe3ad", Mode.TRACKING: "#cfe6cf", Mode.RELEASING: "#d8dcf2", Mode.FAULT: "#f5c6c1"}
MOST_SHAPES = 60


def write_page(log: Log, path: Path) -> Path:
    """Write the page: tip and reference, displacements, tensions, error, events and loop timing on one time axis, and
    the rod's shapes.

    Raises:
        UsageError: plotly is not installed.
    """
    try:
        import plotly.graph_objects as go
        from plotly.subplots import make_subplots
    except ImportError as error:
        raise UsageError("an interactive page needs plotly: pip install 'tendond[plot]', or choose png") from error
    titles = ("tip [mm]", "displacement [mm]", "tension [N]", "|reference - tip| [mm]", "events", "loop timing [ms]")
    figure = make_subplots(rows=6, cols=1, shared_xaxes=True, subplot_titles=titles, vertical_spacing=0.035)
    time = [record.time for record in log.records]
    tip = np.array([record.measured or (np.nan,) * 3 for record in log.records]) * 1000.0
    reference = np.array([record.reference.position for record in log.records]) * 1000.0
    displacement = np.array([record.command.displacement for record in log.records]) * 1000.0
    tension = np.array([record.command.tension for record in log.records])

    def line(row: int, name: str, x: object, y: object, *, dash: str = "solid") -> None:
        figure.add_trace(go.Scatter(x=x, y=y, name=name, mode="lines", line={"dash": dash}), row=row, col=1)

    for i, letter in enumerate("xyz"):
        line(1, f"tip {letter}", time, tip[:, i])
        line(1, f"reference {letter}", time, reference[:, i], dash="dot")
    for i in range(displacement.shape[1]):
        line(2, f"displacement {i}", time, displacement[:, i])
        line(3, f"tension {i}", time, tension[:, i])
    tracks = np.array([record.mode is Mode.TRACKING for record in log.records])
    line(4, "error", time, np.where(tracks, np.linalg.norm(reference - tip, axis=1), np.nan))
    found = events(log.records)
    for kind in KINDS:
        of_kind = [event for event in found if event.kind == kind]
        texts = [f"cycle {event.tick}: {event.text}" for event in of_kind]
        marks = go.Scatter(
            x=[event.time for event in of_kind], y=[kind] * len(of_kind), text=texts, name=kind, mode="markers"
        )
        figure.add_trace(marks, row=5, col=1)
    period = log.config.loop.period
    at = [timing.tick * period for timing in log.timings]
    line(6, "work", at, [timing.work_us / 1000.0 for timing in log.timings])
    line(6, "lateness", at, [timing.lateness_us / 1000.0 for timing in log.timings])
    for start, end, mode in mode_spans(log.records):
        if mode in BANDS:
            figure.add_vrect(x0=start, x1=end, fillcolor=BANDS[mode], opacity=0.45, line_width=0, layer="below")
    figure.update_xaxes(title_text="time [s]", row=6, col=1)
    figure.update_layout(height=1500, title=f"{log.path.name}: {log.config.control.law}", template="plotly_white")
    parts = [figure.to_html(full_html=False, include_plotlyjs=True, div_id="course")]
    if log.shapes:
        parts.append(_shapes(log, go).to_html(full_html=False, include_plotlyjs=False, div_id="shapes"))
    head = f"<head><meta charset='utf-8'><title>{escape(log.path.name)}</title></head>"
    body = "\n".join(parts)
    path.write_text(f"<!doctype html>\n<html lang='en'>{head}<body>\n{body}\n</body></html>\n", encoding="utf-8")
    return path


def _shapes(log: Log, go: Any) -> Any:
    """The rod in space, a shape every so many cycles."""
    every = max(1, -(-len(log.shapes) // MOST_SHAPES))
    figure = go.Figure()
    for tick, points in log.shapes[::every]:
        x, y, z = (1000.0 * points).T
        figure.add_trace(go.Scatter3d(x=x, y=y, z=z, mode="lines", name=f"cycle {tick}"))
    figure.update_layout(height=800, title="rod shapes [mm]", scene={"aspectmode": "data"}, template="plotly_white")
    return figure
