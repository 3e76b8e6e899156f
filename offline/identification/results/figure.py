"""Residuals as figures. Import this module only to draw: matplotlib takes a second."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from tendond.offline.identification.configured import nominal
from tendond.offline.identification.results.result import Identification
from tendond.offline.identification.simulation.simulated import Simulated
from tendond.offline.plots.style import OURS, PAPERS, REFERENCE, save, style

LAGS = 1.0
"""Maximum lag of the autocorrelation [s]."""

MIN_LAGS = 10
"""Number of lags that are shown at least: of rests."""


def draw(result: Identification, folder: Path) -> list[Path]:
    """Draw the residuals of all recordings, and their autocorrelation, into the existing `folder`."""
    with style():
        return [
            save(_residuals(result), folder / "residuals.png"),
            save(_whiteness(result), folder / "whiteness.png"),
        ]


def _residuals(result: Identification) -> Figure:
    """Draw each recording: the tip's path, and the distance of the configured and the fitted model from it."""
    simulations = [*result.simulations, *result.others]
    figure = Figure((10.0, 0.4 + 2.6 * len(simulations)), layout="constrained")
    grid = figure.subplots(len(simulations), 2, squeeze=False, width_ratios=(2, 3))
    start = nominal(result.config)
    for (panel, apart), simulation in zip(grid, simulations, strict=True):
        recording = simulation.recording
        time = recording.pose_times
        panel.plot(time, recording.position[:, 0] * 1e3, color=OURS, lw=1.0, label="x")
        panel.plot(time, recording.position[:, 2] * 1e3, color=PAPERS, lw=1.0, label="z")
        used = "" if simulation in result.simulations else ", not used"
        load = f", {recording.weight * 1e3:g} g" if recording.weight else ""
        panel.set(title=f"{recording.name}{load}{used}", ylabel="tip [mm]")
        for values, name, colour in ((start, "configuration", REFERENCE), (result.fit.values, "identified", OURS)):
            off = _apart(simulation, values)
            rms = float(np.sqrt(np.mean(off**2)))
            apart.semilogy(time, np.maximum(off, 1e-6) * 1e3, color=colour, lw=0.7, label=f"{name}, {rms * 1e3:.3f} mm")
        apart.set(title="model to measured tip, root mean square", ylabel="[mm]")
        apart.legend(loc="upper right", fontsize=8)
        panel.legend(loc="lower right", fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("time since the first rest [s]")
    return figure


def _apart(simulation: Simulated, values: dict[str, float]) -> "np.ndarray[tuple[int, ...], np.dtype[np.float64]]":
    predicted = simulation.predicted_poses(simulation.motion(values), values["delay"])
    return np.asarray(np.linalg.norm(predicted - simulation.recording.position, axis=1))


def _whiteness(result: Identification) -> Figure:
    """Draw the residuals' autocorrelation, and their distribution beside that of the noise."""
    figure = Figure((10.0, 3.2), layout="constrained")
    correlation, distribution = figure.subplots(1, 2)
    for simulation, blocks in zip(result.simulations, result.fit.residuals, strict=True):
        rows = blocks[0] - blocks[0].mean(axis=0)
        lags = np.arange(1, min(len(rows) - 1, max(MIN_LAGS, round(LAGS / simulation.recording.period))))
        size = float(np.sum(rows**2))
        values = [float(np.sum(rows[lag:] * rows[:-lag])) / size for lag in lags]
        correlation.plot(lags * simulation.recording.period, values, lw=1.0, label=simulation.recording.name)
    correlation.axhline(0.0, color=REFERENCE, lw=0.8)
    correlation.set(xlabel="lag [s]", title="Autocorrelation of the residuals", ylim=(-0.5, 1.0))
    correlation.legend(fontsize=8)
    rest = np.concatenate([blocks[0].ravel() for blocks in result.fit.residuals]) * 1e3
    edge = 5.0 * max(float(np.std(rest)), 1e-6)
    distribution.hist(rest, bins=81, range=(-edge, edge), density=True, color=OURS, alpha=0.6, label="residuals")
    at = np.linspace(-edge, edge, 200)
    sigma = result.noise * 1e3
    noise = np.exp(-0.5 * (at / sigma) ** 2) / (sigma * np.sqrt(2.0 * np.pi))
    distribution.plot(at, noise, color=PAPERS, label=f"noise of the poses, {sigma:.3f} mm")
    distribution.set(xlabel="[mm]", title="Distribution", yscale="log", ylim=(1e-3, None))
    distribution.legend(fontsize=8)
    return figure
