"""A run as one interactive page that needs no network: the library that draws it is in it. Needs plotly."""

from html import escape
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from tendond.daemon.errors import UsageError
from tendond.offline.files import write_whole
from tendond.offline.logs.events import KINDS, events, mode_spans
from tendond.offline.logs.log import LogFile
from tendond.offline.logs.paths import Array, TipPath
from tendond.offline.plots.player import player
from tendond.schemas.messages import Mode

BANDS = {
    Mode.PROBE: "#ffe3ad",
    Mode.PRETENSION: "#ffe3ad",
    Mode.TRACKING: "#cfe6cf",
    Mode.RELEASING: "#d8dcf2",
    Mode.FAULT: "#f5c6c1",
}
AXES = ("#1f4e79", "#4b8b3b", "#7b3f98")
"""Colours of x, y and z."""

TENDONS = ("#c55a11", "#1f4e79", "#b8860b", "#4b8b3b", "#8c1c13", "#7b3f98", "#2f8f8f", "#555555")
"""Colours of the tendons, again from the first after the last."""

HEIGHTS = (2.0, 1.3, 1.3, 1.3, 1.3, 1.3)
"""Heights of the rows, in proportion."""

TITLES = ("tip [mm]", "displacement [mm]", "tension [N]", "|reference - tip| [mm]", "events", "loop timing [ms]")
MAX_POINTS = 4000
"""Points of a curve: more than a screen has pixels."""

CSS = """
body { font: 15px/1.5 system-ui, "Segoe UI", "Helvetica Neue", sans-serif; color: #1c1f24; max-width: 80rem;
  margin: 1.5rem auto; padding: 0 1rem }
h1 { font-size: 1.4rem; margin: 0 } h2 { font-size: 1.1rem; margin: 1.5rem 0 .3rem; border-bottom: 2px solid #1f4e79 }
p { color: #555; margin: .2rem 0 0 }
"""


def write_page(log: LogFile, path: Path) -> Path:
    """Write the page: the run in space, played or at a chosen time; and on one time axis tip and reference,
    displacements, tensions, error, events and loop timing.

    Raises:
        UsageError: plotly is not installed.
    """
    try:
        import plotly.graph_objects as go
    except ImportError as error:
        raise UsageError("an interactive page needs plotly: pip install 'tendond[plot]', or choose png") from error
    figures = {"over time": ("timeline", _curves(log, go))}
    if log.shapes:
        figures = {"in space": ("space", player(TipPath.of(log), go)), **figures}
    parts = [f"<h1>{escape(log.name)}</h1><p>{escape(_subtitle(log))}</p>"]
    for number, (heading, (name, figure)) in enumerate(figures.items()):
        drawn = figure.to_html(
            full_html=False, include_plotlyjs=number == 0, auto_play=False, div_id=name, config={"responsive": True}
        )
        parts.append(f"<h2>{heading}</h2>{drawn}")
    head = f"<head><meta charset='utf-8'><title>{escape(log.name)}</title><style>{CSS}</style></head>"
    body = "\n".join(parts)
    write_whole(path, f"<!doctype html>\n<html lang='en'>{head}<body>\n{body}\n</body></html>\n")
    return path


def _subtitle(log: LogFile) -> str:
    law = log.config.control.law.replace("_", " ")
    seconds = len(log.records) * log.config.loop.period
    return f"{law} on rig '{log.config.rig.name}', {len(log.records)} cycles, {seconds:.2f} s"


def thinned(x: Array, y: Array, count: int = MAX_POINTS) -> tuple[Array, Array]:
    """Reduce a curve to about `count` points: the smallest and the largest of each part, so that no peak is lost."""
    if len(x) <= count:
        return x, y
    edges = np.linspace(0, len(x), count // 2 + 1).astype(int)
    kept = set()
    for start, end in pairwise(edges.tolist()):
        part = y[start:end]
        known, gaps = np.flatnonzero(np.isfinite(part)), np.flatnonzero(np.isnan(part))
        if gaps.size:
            kept.add(start + gaps[0])
        if known.size:
            kept |= {start + known[np.argmin(part[known])], start + known[np.argmax(part[known])]}
    chosen = np.array(sorted(kept))
    return x[chosen], y[chosen]


def _curves(log: LogFile, go: Any) -> Any:
    """Draw the rows over time, each with its legend beside it; a tendon's entry is for both of its curves."""
    from plotly.subplots import make_subplots

    figure = make_subplots(
        rows=len(TITLES), cols=1, shared_xaxes=True, subplot_titles=TITLES, vertical_spacing=0.035, row_heights=HEIGHTS
    )
    time = np.array([record.time for record in log.records])
    tip = np.array([record.measured or (np.nan,) * 3 for record in log.records]) * 1000.0
    reference = np.array([record.reference.position for record in log.records]) * 1000.0
    displacement = np.array([record.command.displacement for record in log.records]) * 1000.0
    tension = np.array([record.command.tension for record in log.records])
    tracks = np.array([record.mode is Mode.TRACKING for record in log.records])
    reference[~tracks] = np.nan

    def line(row: int, name: str, x: Array, y: Array, colour: str, **more: Any) -> None:
        """Add a curve, with an entry in its row's legend unless `more` says otherwise."""
        look = {"color": colour, "width": 1.6, "dash": more.pop("dash", "solid")}
        x, y = thinned(x, y)
        curve = go.Scatter(x=x, y=y, name=name, mode="lines", line=look, **{"legend": _legend(row), **more})
        figure.add_trace(curve, row=row, col=1)

    for i, letter in enumerate("xyz"):
        line(1, f"tip {letter}", time, tip[:, i], AXES[i])
        line(1, f"reference {letter}", time, reference[:, i], AXES[i], dash="dot")
    for i in range(displacement.shape[1]):
        colour, group = TENDONS[i % len(TENDONS)], f"tendon {i}"
        line(2, group, time, displacement[:, i], colour, legendgroup=group)
        line(3, group, time, tension[:, i], colour, legendgroup=group, legend=_legend(2), showlegend=False)
    distance = np.where(tracks, np.linalg.norm(reference - tip, axis=1), np.nan)
    line(4, "error", time, distance, AXES[0], showlegend=False)
    found = events(log.records)
    for kind in KINDS:
        of_kind = [event for event in found if event.kind == kind]
        texts = [f"cycle {event.tick}: {event.text}" for event in of_kind]
        marker = {"color": "#a32015" if kind == "fault" else AXES[0], "symbol": "line-ns-open", "size": 10}
        marks = go.Scatter(
            x=[event.time for event in of_kind], y=[kind] * len(of_kind), text=texts, name=kind, mode="markers",
            marker=marker, showlegend=False, hovertemplate="%{text}<extra></extra>",
        )  # fmt: skip
        figure.add_trace(marks, row=5, col=1)
    at = np.array([timing.tick for timing in log.timings]) * log.config.loop.period
    for name, colour in (("work", AXES[0]), ("lateness", TENDONS[0])):
        line(6, name, at, np.array([getattr(timing, f"{name}_us") for timing in log.timings]) / 1000.0, colour)
    for start, end, mode in mode_spans(log.records):
        if mode in BANDS:
            figure.add_vrect(x0=start, x1=end, fillcolor=BANDS[mode], opacity=0.45, line_width=0, layer="below")
    figure.update_xaxes(title_text="time [s]", row=len(TITLES), col=1)
    figure.update_annotations(x=0.0, xanchor="left", font_size=13)
    tops = {_legend(row): figure.layout[f"yaxis{row if row > 1 else ''}"].domain[1] for row in (1, 2, 6)}
    legends = {name: {"x": 1.01, "xanchor": "left", "y": top, "yanchor": "top"} for name, top in tops.items()}
    margin = {"l": 90, "r": 140, "t": 40, "b": 50}
    figure.update_layout(height=1250, template="plotly_white", margin=margin, hovermode="x", **legends)
    return figure


def _legend(row: int) -> str:
    return "legend" if row == 1 else f"legend{row}"
