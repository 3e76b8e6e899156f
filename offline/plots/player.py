"""A run in space as an interactive figure that plays: rod and tendons at the time that a slider selects."""

from typing import Any

import numpy as np

from tendond.offline.logs.paths import Array, RodShape, TipPath

MAX_FRAMES = 300
"""Shapes that are played; of more, those nearest to equal steps of time."""

AIR_MM = 15.0
"""Margin about all that is drawn; a plane has some depth [mm]."""

BOX = 1.9
"""Diagonal of the box about all that is drawn, in the units of the viewer's camera, whose distance is `EYE`: from every
side the whole box is in view (`tests/unit/offline/test_interactive.py` looks)."""

EYE = 1.9
MAX_TICKS = 8
HEIGHT = 700
LEAST_MS = 20.0
"""Least time of a frame [ms]: a screen shows no more."""

TIP, REFERENCE, TARGET, ROD, TENDON = "#1f4e79", "#c55a11", "#c55a11", "black", "#888888"
GAP = np.full((1, 3), np.nan)


def player(run: TipPath, go: Any) -> Any:
    """Draw the run: paths of tip and reference, target, and rod and tendons, which move. `run` must have shapes.

    Args:
        run: paths and shapes.
        go: plotly's module of graph objects.

    Returns:
        plotly's Figure.
    """

    def line(points: Array, name: str, **look: Any) -> Any:
        x, y, z = (1e3 * points).T
        return go.Scatter3d(x=x, y=y, z=z, mode="lines", name=name, line=look, hoverinfo="skip")

    def rod(shape: RodShape) -> list[Any]:
        return [
            line(shape.points, "rod", color=ROD, width=8),
            line(_tendons(shape), "tendons", color=TENDON, width=2),
        ]

    fixed = [
        line(run.tip, "path of the tip", color=TIP, width=4),
        line(run.reference, "reference", color=REFERENCE, width=2),
    ]
    if run.target is not None:
        (x, y, z), look = (1e3 * np.array(run.target)), {"symbol": "x", "color": TARGET, "size": 5}
        fixed.append(go.Scatter3d(x=[x], y=[y], z=[z], mode="markers", name="target", marker=look))
    shapes = frames_of(run)
    moving = [len(fixed), len(fixed) + 1]
    frames = [go.Frame(name=f"{shape.time:.2f}", data=rod(shape), traces=moving) for shape in shapes]
    figure = go.Figure(data=[*fixed, *rod(shapes[0])], frames=frames)
    legend = {"x": 0.01, "xanchor": "left", "y": 0.99, "yanchor": "top", "bgcolor": "rgba(255,255,255,0.8)"}
    figure.update_layout(
        height=HEIGHT, template="plotly_white", scene=_scene(run), legend=legend,
        margin={"l": 10, "r": 10, "t": 10, "b": 10}, sliders=[_slider(frames)], updatemenus=[_buttons(shapes)],
    )  # fmt: skip
    return figure


def frames_of(run: TipPath) -> list[RodShape]:
    """Select the shapes that are played, at about equal steps of time, with the first and the last."""
    if len(run.shapes) <= MAX_FRAMES:
        return list(run.shapes)
    times = np.array([shape.time for shape in run.shapes])
    wanted = np.searchsorted(times, np.linspace(times[0], times[-1], MAX_FRAMES))
    return [run.shapes[i] for i in np.unique(wanted)]


def box(run: TipPath) -> tuple[Array, Array]:
    """Return lower and upper corner of all that is drawn at any time, with a margin [mm], shapes (3,)."""
    points = np.vstack([run.points, *(_tendons(shape) for shape in run.shapes)]) * 1e3
    return np.nanmin(points, axis=0) - AIR_MM, np.nanmax(points, axis=0) + AIR_MM


def _tendons(shape: RodShape) -> Array:
    """All tendons as one path with gaps, shape (k, 3)."""
    return np.vstack([part for path in shape.tendons for part in (path, GAP)] or [GAP])


def _scene(run: TipPath) -> dict[str, Any]:
    """Axes of one scale with everything in range, seen from the side that shows most."""
    low, high = box(run)
    size = high - low
    axes = {
        f"{letter}axis": {
            "title": f"{letter} [mm]",
            "range": [low[i], high[i]],
            "nticks": max(2, round(MAX_TICKS * float(size[i] / size.max()))),
        }
        for i, letter in enumerate("xyz")
    }
    ratio = BOX * size / np.linalg.norm(size)
    elevation, azimuth = np.radians(run.view)
    eye = EYE * np.array([np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)])

    def named(values: Array) -> dict[str, float]:
        return dict(zip("xyz", values.tolist(), strict=True))

    camera = {"eye": named(eye), "projection": {"type": "orthographic"}}
    return {**axes, "aspectmode": "manual", "aspectratio": named(ratio), "camera": camera}


def _slider(frames: list[Any]) -> dict[str, Any]:
    at_once = {"mode": "immediate", "frame": {"duration": 0, "redraw": True}, "transition": {"duration": 0}}
    steps = [{"label": frame.name, "method": "animate", "args": [[frame.name], at_once]} for frame in frames]
    return {
        "active": 0, "steps": steps, "x": 0.16, "len": 0.82, "y": 0.0, "pad": {"t": 10, "b": 10},
        "currentvalue": {"prefix": "rod at ", "suffix": " s"},
    }  # fmt: skip


def _buttons(shapes: list[RodShape]) -> dict[str, Any]:
    """Play in real time from the selected time, hold, and play from the start."""
    seconds = (shapes[-1].time - shapes[0].time) / max(1, len(shapes) - 1)
    frame = {"duration": max(LEAST_MS, 1e3 * seconds), "redraw": True}
    play = {"mode": "immediate", "frame": frame, "transition": {"duration": 0}}
    hold = {"mode": "immediate", "frame": {"duration": 0, "redraw": False}, "transition": {"duration": 0}}
    buttons = [
        {"label": "▶", "method": "animate", "args": [None, {**play, "fromcurrent": True}]},
        {"label": "❚❚", "method": "animate", "args": [[None], hold]},
        {"label": "|◀ ▶", "method": "animate", "args": [None, {**play, "fromcurrent": False}]},
    ]
    return {
        "type": "buttons", "direction": "left", "showactive": False, "buttons": buttons,
        "x": 0.01, "xanchor": "left", "y": 0.0, "yanchor": "top", "pad": {"t": 30},
    }  # fmt: skip
