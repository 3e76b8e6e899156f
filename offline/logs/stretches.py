"""The stretches of a log that track, each with the numbers that tell how it went; as text and for a notebook."""

from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from tendond.offline.logs.arrays import Arrays

Array = NDArray[np.float64]

END_SAMPLES = 20
"""Cycles at the end of a stretch whose mean is its error at the end, as for the steady-state error of the metrics."""

SPARKLINE, POINTS = (180, 32), 90
"""Width and height of a curve in a table [px], and its largest number of points."""

HEAD = ("start [s]", "duration [s]", "law", "reference", "largest error [mm]", "at the end [mm]", "error, log. scale")

STYLE = "font-variant-numeric:tabular-nums"


@dataclass(frozen=True)
class Stretch:
    """Consecutive cycles that track.

    Attributes:
        start: time of its first cycle since the first of the run [s]. duration: of the cycles [s].
        law: name of the law at its end. reference: kind of the configured reference.
        error: distance of the measured tip from its reference [m], NaN where no tip was measured, shape (cycles,).
    """

    start: float
    duration: float
    law: str
    reference: str
    error: Array

    @property
    def largest(self) -> float:
        """Largest error [m]; NaN without a measured tip."""
        return float(np.nanmax(self.error)) if np.isfinite(self.error).any() else np.nan

    @property
    def at_end(self) -> float:
        """Mean error of the last cycles [m]; NaN without a measured tip."""
        last = self.error[-END_SAMPLES:]
        return float(np.nanmean(last)) if np.isfinite(last).any() else np.nan


def stretches(run: "Arrays") -> list[Stretch]:
    """Find the stretches of a log that track, in their order; none where the controller was never armed."""
    period, ticks = run.config.loop.period, run["tick"]
    tracks = np.flatnonzero(run["mode"] == "tracking")
    if not tracks.size:
        return []
    error = np.full(len(run), np.nan)
    if "measured" in run.names:
        error = np.linalg.norm(run["measured"] - run["reference.position"], axis=1)
    found = []
    for part in np.split(tracks, np.flatnonzero(np.diff(ticks[tracks]) > 1) + 1):
        law = str(run["law"][part[-1]]) if "law" in run.names else ""
        found.append(
            Stretch(
                start=float(run["time"][part[0]]),
                duration=float(ticks[part[-1]] - ticks[part[0]] + 1) * period,
                law=law or run.config.control.law,
                reference=run.config.reference.kind,
                error=error[part],
            )
        )
    return found


def heading(run: "Arrays") -> str:
    """Say in a line what a log is: file, rig, cycles and time."""
    duration = float(run["time"][-1] - run["time"][0]) + run.config.loop.period
    return f"{run.path.name}: rig '{run.config.rig.name}', {len(run)} cycles, {duration:.2f} s"


def text(run: "Arrays") -> str:
    """Describe a log in a few lines: the heading, and a line for each stretch that tracks."""
    lines = [heading(run), *(f"  tracking: {', '.join(_told(one))}" for one in stretches(run))]
    return "\n".join(lines if len(lines) > 1 else [*lines, "  never tracking"])


def html(run: "Arrays") -> str:
    """Describe a log as HTML for a notebook: the heading, and a table of its stretches with a curve of their error."""
    found = stretches(run)
    head = "".join(f"<th>{escape(cell)}</th>" for cell in HEAD)
    rows = "".join(_row((*_cells(one), sparkline(one))) for one in found)
    table = f'<table style="{STYLE}"><thead><tr>{head}</tr></thead><tbody>{rows}</tbody></table>'
    count = f"{len(run.names)} arrays, by <code>run[name]</code>; their names are in <code>run.names</code>"
    return (
        f"<div><p><strong>{escape(heading(run))}</strong></p>"
        f"{table if found else '<p>The controller never tracked.</p>'}<p>{count}</p></div>"
    )


def sparkline(one: Stretch) -> str:
    """Draw the error of a stretch over time as SVG, on a logarithmic scale."""
    width, height = SPARKLINE
    known = one.error[np.isfinite(one.error) & (one.error > 0.0)]
    if known.size < 2:
        return ""
    low, high = np.log10(known.min()), np.log10(known.max())
    columns = np.array_split(one.error, min(POINTS, len(one.error)))
    points = []
    for i, column in enumerate(columns):
        above = column[column > 0.0]  # not NaN either
        if above.size:
            x = 1 + (width - 2) * i / max(1, len(columns) - 1)
            y = 2 + (height - 4) * (high - np.log10(above.max())) / max(high - low, 1e-9)
            points.append(f"{x:.1f},{y:.1f}")
    told = f"error from {1e3 * one.largest:.4g} mm down to {1e3 * known.min():.2g} mm, over {one.duration:.2f} s"
    line = f'<polyline points="{" ".join(points)}" fill="none" stroke="#1f4e79" stroke-width="1.5"/>'
    box = f'width="{width}" height="{height}" viewBox="0 0 {width} {height}"'
    return f'<svg {box} role="img"><title>{told}</title>{line}</svg>'


def _row(cells: tuple[str, ...]) -> str:
    return f"<tr>{''.join(f'<td>{cell}</td>' for cell in cells)}</tr>"


def _cells(one: Stretch) -> tuple[str, ...]:
    return (
        f"{one.start:.2f}",
        f"{one.duration:.2f}",
        escape(one.law.replace("_", " ")),
        escape(one.reference.replace("_", " ")),
        _millimetres(one.largest),
        _millimetres(one.at_end),
    )


def _told(one: Stretch) -> tuple[str, ...]:
    return (
        f"from {one.start:.2f} s for {one.duration:.2f} s",
        f"law {one.law}",
        f"reference {one.reference}",
        f"error at the end {_millimetres(one.at_end)} mm",
    )


def _millimetres(length: float) -> str:
    return f"{1e3 * length:.2f}" if np.isfinite(length) else "-"
