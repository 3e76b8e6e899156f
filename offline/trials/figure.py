"""A figure of a trial: the tip in three projections, its error, the tensions. Import only to draw."""

from pathlib import Path

from tendond.offline.plots.appearance import appearance
from tendond.offline.plots.style import OURS, REFERENCE, headline, legend_above, line_look, new_figure, save, style
from tendond.offline.trials.measure import TrialOutcome
from tendond.offline.trials.paths import Trial

VIEWS = (("x", "y", 0, 1), ("x", "z", 0, 2), ("y", "z", 1, 2))


def draw(trial: Trial, outcome: TrialOutcome, path: Path, plant: str = "") -> Path:
    """Draw it into a PNG file; `plant`: in words, by default the trial's."""
    with style():
        figure = new_figure(12.0, 6.4)
        grid = figure.add_gridspec(2, 6, height_ratios=(1.3, 1.0))
        tip, reference = 1e3 * outcome.tip, 1e3 * outcome.reference
        for index, (across, up, i, j) in enumerate(VIEWS):
            axes = figure.add_subplot(grid[0, 2 * index : 2 * index + 2])
            axes.plot(reference[:, i], reference[:, j], color=REFERENCE, lw=3.0, alpha=0.5, label="reference")
            axes.plot(tip[:, i], tip[:, j], color=OURS, lw=1.0, label="tip (simulated)")
            axes.set(xlabel=f"{across} [mm]", ylabel=f"{up} [mm]", aspect="equal")
            axes.set_adjustable("datalim")
            if index == 0:
                legend_above(axes)
        error = figure.add_subplot(grid[1, :3])
        distance = ((tip - reference) ** 2).sum(axis=1) ** 0.5
        error.plot(outcome.time, distance, color=OURS)
        error.axvline(outcome.approach_time, color=REFERENCE, lw=0.8)
        error.set(xlabel="time since tracking began [s]", ylabel="tip to reference [mm]", ylim=(0.0, None))
        error.set_title(
            f"RMS {outcome.rms_mm:.2f} mm from the trajectory's beginning on", fontsize=appearance().points(9)
        )
        tensions = figure.add_subplot(grid[1, 3:])
        for index, column in enumerate(outcome.tension.T):
            look = line_look(index, length=len(outcome.time))
            tensions.plot(outcome.time, column, lw=1.2, label=f"tendon {index}", **look)
        tensions.set(xlabel="time since tracking began [s]", ylabel="tension [N]", ylim=(0.0, None))
        legend_above(tensions)
        headline(figure, f"{trial.name}; plant: {plant or trial.plant}")
        return save(figure, path)
