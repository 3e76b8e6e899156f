"""The study's figure: error of place, time until found, and error of force, by the place. Import only to draw."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from tendond.offline.contact.report import FORCE, FOUND_TIME, PLACE
from tendond.offline.contact.run import Outcome
from tendond.offline.plots.style import OURS, REFERENCE, save, style


def draw(outcomes: Sequence[Outcome], path: Path) -> Path:
    """Draw the paper's robot's contacts into a file, resting above, moving below."""
    with style():
        figure = Figure((12.0, 6.4), layout="constrained")
        axes = figure.subplots(2, 3, sharex=True)
        for line, moving in zip(axes, (False, True), strict=True):
            some = [o for o in outcomes if o.case.robot == "paper" and o.case.moving == moving and o.case.force]
            some = [o for o in some if not o.case.markers and o.case.friction[1] > 0.0]
            for force, shade in zip(sorted({o.case.force for o in some}), (0.35, 0.65, 1.0), strict=False):
                these = [o for o in some if o.case.force == force]
                place = np.array([o.place for o in these])
                late = [o.samples[-1] for o in these]
                errors = np.array([np.nan if s is None else 100.0 * abs(s.place) for s in late])
                forces = np.array([np.nan if s is None else 100.0 * s.force for s in late])
                delays = np.array([1e3 * o.found for o in these])
                for axis, values in zip(line, (delays, errors, forces), strict=True):
                    axis.plot(place, values, "o", ms=4.0, color=OURS, alpha=shade, label=f"{force:g} N")
            goals = 1e3 * FOUND_TIME, 100.0 * PLACE, 100.0 * FORCE
            names = "found after [ms]", "error of place [% of length]", "error of force [%]"
            for axis, goal, name in zip(line, goals, names, strict=True):
                axis.axhline(goal, color=REFERENCE, lw=1.5)
                axis.set(ylabel=name, yscale="log")
            line[0].set_title("moving" if moving else "resting", loc="left")
            line[0].legend()
        for axis in axes[1]:
            axis.set_xlabel("place of the contact [-]")
        return save(figure, path)
