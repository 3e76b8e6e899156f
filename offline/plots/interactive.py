"""A run as one interactive page that needs no network: the library that draws it is in it. Needs plotly."""

from html import escape
from pathlib import Path
from typing import Any

import numpy as np

from tendond.daemon.errors import UsageError
from tendond.offline.files import write_whole
from tendond.offline.logs.events import KINDS, events, mode_spans
from tendond.offline.logs.log import LogFile
from tendond.offline.logs.paths import Array, RodShape, TipPath
from tendond.schemas.messages import Mode

BANDS = {
    Mode.PROBE: "#ffe3ad",
    Mode.PRETENSION: "#ffe3ad",
    Mode.TRACKING: "#cfe6cf",
    Mode.RELEASING: "#d8dcf2",
    Mode.FAULT: "#f5c6c1",
}
MAX_SHAPES = 80
AIR_MM = 25.0
"""Margin around all that is drawn; a plane has some depth [mm]."""

GAP = np.full((1, 3), np.nan)


def write_page(log: LogFile, path: Path) -> Path:
    """Write the page: tip and reference, displacements, tensions, error, events and loop timing on one time axis, and
    the run in space.

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
    figure.update_layout(height=1500, title=f"{log.name}: {log.config.control.law}", template="plotly_white")
    parts = [figure.to_html(full_html=False, include_plotlyjs=True, div_id="timeline")]
    if log.shapes:
        parts.append(_space(log, go).to_html(full_html=False, include_plotlyjs=False, auto_play=False, div_id="space"))
    head = f"<head><meta charset='utf-8'><title>{escape(log.name)}</title></head>"
    body = "\n".join(parts)
    write_whole(path, f"<!doctype html>\n<html lang='en'>{head}<body>\n{body}\n</body></html>\n")
    return path


def _space(log: LogFile, go: Any) -> Any:
    """Draw the run in space: the tip's path, and rod and tendons at the moment that a slider chooses."""
    run = TipPath.of(log)

    def line(points: Array, name: str, **look: Any) -> Any:
        x, y, z = (1e3 * points).T
        return go.Scatter3d(x=x, y=y, z=z, mode="lines", name=name, line=look)

    def rod(shape: RodShape) -> list[Any]:
        broken = [part for path in shape.tendons for part in (path, GAP)]  # one trace for all
        tendons = np.vstack(broken) if broken else GAP
        return [line(shape.points, "rod", color="black", width=8), line(tendons, "tendons", color="#888888", width=2)]

    fixed = [
        line(run.tip, "tip", color="#1f4e79", width=4),
        line(run.reference, "reference", color="#c55a11", width=2),
    ]
    if run.target is not None:
        (x, y, z), look = (1e3 * np.array(run.target)), {"symbol": "x", "color": "#c55a11", "size": 5}
        fixed.append(go.Scatter3d(x=[x], y=[y], z=[z], mode="markers", name="target", marker=look))
    shapes = [run.shapes[i] for i in run.chosen(MAX_SHAPES)]
    moving = [len(fixed), len(fixed) + 1]
    frames = [go.Frame(name=f"{shape.time:.2f}", data=rod(shape), traces=moving) for shape in shapes]
    steps = [
        {
            "label": frame.name,
            "method": "animate",
            "args": [[frame.name], {"mode": "immediate", "frame": {"duration": 0}}],
        }
        for frame in frames
    ]
    figure = go.Figure(data=[*fixed, *rod(shapes[-1])], frames=frames)
    elevation, azimuth = np.radians(run.view)
    eye = 1.9 * np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])
    points = 1e3 * run.points
    low, high = points.min(axis=0) - AIR_MM, points.max(axis=0) + AIR_MM
    scene = {f"{letter}axis": {"title": f"{letter} [mm]", "range": [low[i], high[i]]} for i, letter in enumerate("xyz")}
    camera = {"eye": dict(zip("xyz", eye.tolist(), strict=True)), "projection": {"type": "orthographic"}}
    figure.update_layout(
        height=800,
        title="in space",
        template="plotly_white",
        scene={**scene, "aspectmode": "data", "camera": camera},
        sliders=[{"active": len(steps) - 1, "steps": steps, "currentvalue": {"prefix": "rod at ", "suffix": " s"}}],
    )
    return figure
