"""What an observer of kind 'kalman' knew in a run, and how far that was true. Import this module only to draw."""

from functools import partial

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from tendond.daemon.control.estimation.spread import ellipsoid
from tendond.offline.logs.arrays import Arrays
from tendond.offline.logs.arrays import load as load_arrays
from tendond.offline.logs.log import LogFile
from tendond.offline.plots.appearance import appearance
from tendond.offline.plots.contacts import draw_contacts, found_contacts
from tendond.offline.plots.output import Named
from tendond.offline.plots.style import OURS, PAPERS, REFERENCE, level, new_figure, style
from tendond.schemas.health import CONSISTENCY_MARKED

Array = NDArray[np.float64]

AXES = ("#1f4e79", "#4b8b3b", "#7b3f98")
"""Colours of x, y and z."""

SIZE, TOUCHED_SIZE = (10.0, 7.5), (10.0, 12.0)  # [inch]


def has_filter(log: LogFile) -> bool:
    """Return whether a log's observer has a filter."""
    return any(record.observer.filter is not None for record in log.records)


def filter_figure(log: LogFile) -> Figure:
    """Draw force on the tip with its band, bound of the tip, consistency, and contacts that were found, over time.

    Beside them, of a simulated robot, the true force and the error of the tip. `log` must have a filter.

    Raises:
        LogError: the log cannot be read again.
    """
    run = load_arrays(log.path)
    touched = bool(found_contacts(log.records))
    with style():
        figure = new_figure(*(TOUCHED_SIZE if touched else SIZE))
        ratios = (2, 2, 1, 2, 2) if touched else (2, 2, 1)
        rows = figure.subplots(len(ratios), 1, sharex=True, height_ratios=ratios)
        force, tip, consistency = rows[:3]
        _force(force, run)
        _tip(tip, run)
        _consistency(consistency, run)
        if touched:
            draw_contacts(rows[3], rows[4], log.records, AXES)
        rows[-1].set(xlabel="time [s]", xlim=(run["time"][0], max(run["time"][-1], run.config.loop.period)))
    return figure


def filter_figures(log: LogFile) -> list[Named]:
    """Return the figure; nothing where the log has no filter."""
    return [Named("filter", partial(filter_figure, log))] if has_filter(log) else []


def tip_error(run: Arrays) -> Array:
    """Distance of the model's tip from the true one [m], shape (cycles,), NaN where no truth is known.

    The record has the model after its cycle's step, a period and `observer.command_delay` ahead of the truth beside it.
    """
    ahead = 1 + round(run.config.observer.command_delay / run.config.loop.period)
    truth = np.full_like(run["model.position"], np.nan)
    if "truth.position" in run.names:
        truth[:-ahead] = run["truth.position"][ahead:]
    distance: Array = np.linalg.norm(run["model.position"] - truth, axis=1)
    return distance


def tip_bound(run: Arrays) -> Array:
    """Largest half axis of the ellipsoid that holds the tip with 95 % [m], shape (cycles,), NaN without a filter."""
    covariances = run["observer.filter.tip_covariance"].tolist()
    return np.array([np.nan if np.isnan(one[0]) else ellipsoid(tuple(one))[0][-1] for one in covariances])


def _force(axes: Axes, run: Arrays) -> None:
    time, force = run["time"], run["observer.force"]
    deviation = np.sqrt(run["observer.filter.force_covariance"][:, (0, 3, 5)])
    for i, colour in enumerate(AXES):
        axes.fill_between(time, *(force[:, i] + side * deviation[:, i] for side in (-2, 2)), color=colour, alpha=0.2)
        axes.plot(time, force[:, i], color=colour, label=f"{'xyz'[i]} ± 2σ")
        if "truth.tip_force" in run.names:
            axes.plot(time, run["truth.tip_force"][:, i], color=colour, lw=1.2, ls="--", label=f"true {'xyz'[i]}")
    # The band is as wide as the robot is straight along it: the axes follow the forces.
    known = np.concatenate([force, *([run["truth.tip_force"]] if "truth.tip_force" in run.names else [])])
    low, high = float(np.nanmin(known)), float(np.nanmax(known))
    margin = 0.3 * max(high - low, float(np.nanmin(deviation)))
    axes.set(ylabel="force [N]", title="Force on the tip", ylim=(low - margin, high + margin))
    axes.legend(loc="upper right", fontsize=appearance().points(9), ncols=3)


def _tip(axes: Axes, run: Arrays) -> None:
    bound, error = 1e3 * tip_bound(run), 1e3 * tip_error(run)
    axes.plot(run["time"], bound, color=REFERENCE, ls="--", label="95 % of the tip lie within")
    if np.isfinite(error).any():
        axes.plot(run["time"], error, color=OURS, label="error of the model's tip")
    axes.set(ylabel="tip [mm]", yscale="log", title="Tip", ylim=(0.01 * float(np.nanmin(bound)), None))
    axes.legend(loc="lower right", fontsize=appearance().points(9))


def _consistency(axes: Axes, run: Arrays) -> None:
    values = run["observer.filter.consistency"]
    axes.plot(run["time"], values, color=OURS)
    level(axes, 1.0, "as expected")
    if np.nanmax(values) > CONSISTENCY_MARKED:
        level(axes, CONSISTENCY_MARKED, "too far", PAPERS)
    axes.set(ylabel="consistency [-]", title="Consistency", ylim=(0.0, 1.2 * max(1.0, float(np.nanmax(values)))))
