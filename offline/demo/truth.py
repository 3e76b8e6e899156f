"""Truth of a simulator at the times of the controller's cycles: it comes whenever the simulator has run."""

import numpy as np
from numpy.typing import NDArray

from tendond.offline.logs.arrays import Arrays

Array = NDArray[np.float64]


def cycle_times(run: Arrays, part: slice) -> Array:
    """Return the time of each cycle on the clock of the stamps [s], shape (k,): its pose's stamp and age.

    Between poses it follows from the number of the cycle; cycles of a log without poses have no time, NaN.
    """
    stamps = np.asarray(run["inputs.pose.stamp_ns"][part], dtype=np.float64)
    times: Array = stamps * 1e-9 + np.asarray(run["inputs.pose_lag"][part], dtype=np.float64)
    ticks = np.asarray(run["tick"][part], dtype=np.float64)
    known = ~np.isnan(times)
    if not known.any():
        return times
    late = times[known] - run.config.loop.period * ticks[known]
    return np.asarray(run.config.loop.period * ticks + np.interp(ticks, ticks[known], late))


def true_tips(run: Arrays, part: slice) -> Array:
    """Return the simulator's tip at the time of each cycle of `part` [m], shape (k, 3); NaN where none is known.

    A cycle's newest truth is up to a period old, and older where the simulator was late: at 0.4 m/s, 10 ms are 4 mm.
    Truths are interpolated by their stamps, which are of the same computer's clock as the poses'.
    """
    stamps = np.asarray(run["truth.stamp_ns"], dtype=np.float64) * 1e-9
    positions = np.asarray(run["truth.position"], dtype=np.float64)
    known = ~np.isnan(stamps)
    order, first = np.unique(stamps[known], return_index=True)
    times = cycle_times(run, part)
    within = (times >= order[0]) & (times <= order[-1]) if len(order) else np.zeros(len(times), dtype=bool)
    tips = np.full((len(times), 3), np.nan)
    for axis in range(3):
        tips[within, axis] = np.interp(times[within], order, positions[known][first, axis])
    return tips
